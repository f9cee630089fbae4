#pragma once
// An effect: one physical thing that the nominal model leaves out, as a value. At nominal
// parameters it changes nothing, bit for bit; two tests walk the catalogue and prove that, and that
// data simulated with an effect give its parameters back.
//
// To add one: a function that returns an Effect in the .cpp of its family, and its row below it.
// An effect on joints is written once, for a scope of joints (effects/scope.h); its row says for
// which scopes it has an entry.

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "jaculus/simulation/plant.h"
#include "jaculus/trajectory/kinds.h"

namespace jaculus::effects {

/// The part of the robot where an effect acts; the gap's shares are given over the same list.
enum class Component {
  tail_transmission,
  tail_aerodynamics,
  actuation,
  front_legs,
  rear_legs,
  contact,
  body,
  sensing
};
inline constexpr int kComponentCount = 8;
const char* component_name(Component component);

/// How users read a parameter whose reciprocal they think in (compliance as stiffness).
struct Reciprocal {
  std::string name;  ///< "stiffness"
  std::string unit;  ///< "N m/rad"
};

/// One physical parameter of an effect.
struct EffectParameter {
  std::string name;      ///< "compliance"
  std::string unit;      ///< SI, "rad/(N m)"
  double nominal = 0.0;  ///< changes nothing
  Bounds bounds;         ///< what is physically possible for this class of robot
  /// Standard deviation of the prior about nominal; a half-normal one where nominal is a bound.
  double scale = 1.0;
  /// A signed step from nominal, within the bounds, whose influence is plain in the experiments
  /// that excite the effect: where screening takes its sensitivity (a limit has no influence until
  /// it binds). NaN: one `scale`.
  double probe = kNaN;
  std::optional<Reciprocal> reciprocal{};  ///< where users read 1/value

  /// Whether the prior is half-normal: nominal lies on a bound.
  [[nodiscard]] bool one_sided() const {
    return nominal == bounds.lower || nominal == bounds.upper;
  }
  /// nominal plus the probing step; it goes down where nominal is the upper bound.
  [[nodiscard]] double probed() const;
  /// As users read it: of the reciprocal where there is one.
  [[nodiscard]] const std::string& shown_name() const {
    return reciprocal ? reciprocal->name : name;
  }
  [[nodiscard]] const std::string& shown_unit() const {
    return reciprocal ? reciprocal->unit : unit;
  }
};

/// A model value by its path in robot.yaml's terms, and the value as YAML text:
/// {"bodies.base.com", "[0.01, 0]"}.
using ModelOverride = std::pair<std::string, std::string>;

/// Typical rates of joints by name, as data show them [rad/s, m/s where it slides].
using JointRates = std::map<std::string, double>;

struct Effect {
  std::string name;              ///< "tail_compliance"
  std::string caption;           ///< one line for users
  std::vector<Component> where;  ///< it acts there, in the first one mainly
  /// The first alone switches it on: at its nominal the others change nothing, unless every one of
  /// them does something by itself.
  std::vector<EffectParameter> parameters;
  std::vector<trajectory::ExperimentKind> excited_by;  ///< experiments that show it
  /// The joints that it acts at, or whose links it acts on; null where it acts elsewhere.
  std::function<std::vector<std::string>(const model::PlanarModel&)> joints;
  /// Whether this robot can have it at all (a tail to flex, a battery to sag).
  std::function<bool(const model::PlanarModel&)> applies;
  /// Sets the effect's parameters `theta` (in the order of `parameters`) on a plant whose robot it
  /// applies to.
  std::function<void(const Vector& theta, simulation::Plant&)> apply;
  /// Model values where the optimiser can have the effect too, for a model without it; empty where
  /// it can't.
  std::function<std::vector<ModelOverride>(const Vector& theta, const model::PlanarModel&)>
      overrides;
  /// Whether it is about when a plan or script starts: a logged input has no such time.
  bool of_plan = false;
  std::string file{};  ///< that a user wrote it in; empty: the library's
  /// Another effect that this one is with its parameters beyond the first at nominal, by name.
  std::string special_case{};
  bool event = false;    ///< something that happened once: told as an event, no property of a robot
  bool pattern = false;  ///< a force of some form, whatever makes it: told as what is left
  /// Where it acts in front and rear legs: the same effect in each of them alone, of the same
  /// parameters.
  std::vector<Effect> parts;
  /// The same effect with priors, bounds and units of a certain robot's joints, and of each joint
  /// by itself where several share it ("joint_coulomb_friction@elbow"); null where all robots have
  /// it alike.
  std::function<std::vector<Effect>(const model::PlanarModel&, const JointRates&)> sized;

  [[nodiscard]] Vector nominal() const;  ///< of every parameter
  [[nodiscard]] Vector probed() const;   ///< of every parameter
  [[nodiscard]] bool acts_in(Component component) const;
};

/// An effect's parts, or itself where it has none.
std::vector<const Effect*> in_parts(const Effect& effect);

/// An effect as it is on a robot: see Effect::sized. One that is already some robot's stays.
std::vector<Effect> sized_for(const Effect& effect, const model::PlanarModel& model,
                              const JointRates& rates);

using Catalogue = std::vector<Effect>;

/// Every effect of the library, in a fixed order. What takes a catalogue takes one with effects of
/// its user's as well (user_effect.h).
const Catalogue& effect_catalogue();
/// By name; null where there is none.
const Effect* find_effect(const std::string& name, const Catalogue& catalogue = effect_catalogue());
/// Those which a robot can have.
std::vector<const Effect*> applicable_effects(const model::PlanarModel& model,
                                              const Catalogue& catalogue = effect_catalogue());
/// What is wrong with an entry, one sentence each ("leg_backlash: play: bounds [1, 0] are empty");
/// empty where it is sound.
std::vector<std::string> effect_faults(const Effect& effect);

}  // namespace jaculus::effects
