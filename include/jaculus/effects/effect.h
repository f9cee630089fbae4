#pragma once
// An effect: one physical thing that the nominal model leaves out, as a value. At nominal parameters it changes nothing, bit
// for bit; two tests walk the catalogue and prove that, and that data simulated with an effect give its parameters back.

#include <functional>
#include <string>
#include <vector>

#include "jaculus/simulation/plant.h"

namespace jaculus {

/// The part of the robot where an effect acts; the gap's shares are given over the same list.
enum class Component { tail_transmission, tail_aerodynamics, actuation, front_legs, rear_legs, contact, body, sensing };
const char* component_name(Component component);

/// One physical parameter of an effect.
struct EffectParameter {
  std::string name;      ///< "stiffness"
  std::string unit;      ///< SI, "N m/rad"
  double nominal = 0.0;  ///< changes nothing
  Bounds bounds;         ///< what is physically possible for this class of robot
  double scale = 1.0;    ///< standard deviation of the prior about nominal; a half-normal one where nominal is a bound
  std::string shown_as;  ///< "reciprocal" where users read 1/value (compliance as stiffness), else empty
  std::string shown_name;  ///< name and unit for users where shown_as is not empty
  std::string shown_unit;
};

struct Effect {
  std::string name;     ///< "tail_compliance"
  std::string caption;  ///< one line for users
  Component where = Component::body;
  std::vector<EffectParameter> parameters;
  std::vector<std::string> excited_by;  ///< experiments that show it: "leap", "self_righting", "tail_bench", "pendulum"
  /// Whether this robot can have it at all (a tail to flex, a battery to sag).
  std::function<bool(const PlanarModel&)> applies;
  /// Sets the effect's parameters `theta` (in the order of `parameters`) on a plant.
  std::function<void(const Vector& theta, Plant&)> apply;
  /// Model values by their paths in robot.yaml's terms where the optimiser can have the effect too; empty where it can't.
  std::function<std::vector<std::pair<std::string, double>>(const Vector& theta, const PlanarModel&)> overrides;
};

/// Every effect, in a fixed order.
const std::vector<Effect>& effect_catalogue();
/// By name; null where there is none.
const Effect* find_effect(const std::string& name);
/// Those which a robot can have.
std::vector<const Effect*> applicable_effects(const PlanarModel& model);

}  // namespace jaculus
