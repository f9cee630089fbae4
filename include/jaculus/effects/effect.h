#pragma once
// An effect: one physical thing that the nominal model leaves out, as a value. At nominal parameters it changes nothing, bit
// for bit; two tests walk the catalogue and prove that, and that data simulated with an effect give its parameters back.
//
// To add one: a function that returns an Effect in the .cpp of its family, and its row in catalogue.cpp.

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "jaculus/simulation/plant.h"

namespace jaculus {

/// The part of the robot where an effect acts; the gap's shares are given over the same list.
enum class Component { tail_transmission, tail_aerodynamics, actuation, front_legs, rear_legs, contact, body, sensing };
inline constexpr int kComponentCount = 8;
const char* component_name(Component component);

/// One physical parameter of an effect.
struct EffectParameter {
  std::string name;      ///< "compliance"
  std::string unit;      ///< SI, "rad/(N m)"
  double nominal = 0.0;  ///< changes nothing
  Bounds bounds;         ///< what is physically possible for this class of robot
  double scale = 1.0;    ///< standard deviation of the prior about nominal; a half-normal one where nominal is a bound
  std::string shown_as;  ///< "reciprocal" where users read 1/value (compliance as stiffness), else empty
  std::string shown_name;  ///< name and unit for users where shown_as is not empty
  std::string shown_unit;
  /// A signed step from nominal, within the bounds, whose influence is plain in the experiments that excite the effect: where
  /// screening takes its sensitivity (a limit has no influence until it binds). NaN: one `scale`.
  double probe = kNaN;

  /// Whether the prior is half-normal: nominal lies on a bound.
  [[nodiscard]] bool one_sided() const { return nominal == bounds.lower || nominal == bounds.upper; }
  /// nominal plus the probing step; it goes down where nominal is the upper bound.
  [[nodiscard]] double probed() const;
};

/// A model value by its path in robot.yaml's terms, and the value as YAML text: {"bodies.base.com", "[0.01, 0]"}.
using ModelOverride = std::pair<std::string, std::string>;

struct Effect {
  std::string name;     ///< "tail_compliance"
  std::string caption;  ///< one line for users
  Component where = Component::body;
  std::vector<Component> also;  ///< further components where it acts (front and rear legs alike)
  std::vector<EffectParameter>
      parameters;                       ///< the first alone switches it on: at its nominal the others change nothing,
                                        ///< unless every one of them does something by itself
  std::vector<std::string> excited_by;  ///< experiments that show it: "leap", "self_righting", "tail_bench", "pendulum"
  /// Whether this robot can have it at all (a tail to flex, a battery to sag).
  std::function<bool(const PlanarModel&)> applies;
  /// Sets the effect's parameters `theta` (in the order of `parameters`) on a plant whose robot it applies to.
  std::function<void(const Vector& theta, Plant&)> apply;
  /// Model values where the optimiser can have the effect too, for a model without it; empty where it can't.
  std::function<std::vector<ModelOverride>(const Vector& theta, const PlanarModel&)> overrides;

  [[nodiscard]] Vector nominal() const;  ///< of every parameter
  [[nodiscard]] Vector probed() const;   ///< of every parameter
  [[nodiscard]] bool acts_in(Component component) const;
};

/// Every effect, in a fixed order.
const std::vector<Effect>& effect_catalogue();
/// By name; null where there is none.
const Effect* find_effect(const std::string& name);
/// Those which a robot can have.
std::vector<const Effect*> applicable_effects(const PlanarModel& model);
/// What is wrong with an entry, one sentence each ("leg_backlash: play: bounds [1, 0] are empty"); empty where it is sound.
std::vector<std::string> effect_faults(const Effect& effect);

}  // namespace jaculus
