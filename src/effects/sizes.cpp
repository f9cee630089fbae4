// Usual sizes of a robot's joints, and effects that go with them.

#include <algorithm>
#include <cmath>
#include <utility>

#include "effects/scope.h"
#include "jaculus/core/angle.h"
#include "jaculus/simulation/plant.h"

namespace jaculus::effects {
namespace {

using model::JointKind;
using model::PlanarModel;

constexpr double kInertiaShare = 1.0 / 30.0;  ///< of a joint's own inertia
constexpr double kSlideRate = 0.1;            ///< of axes on screws and belts, slow ones [m/s]

/// Mass of the links that a joint carries, its moment and inertia about the joint, each link where
/// the joints' zeros put it.
struct Carried {
  double mass = 0.0;     ///< [kg]
  double moment = 0.0;   ///< sum of mass times distance [kg m]
  double inertia = 0.0;  ///< [kg m^2]
};

Carried carried_by(const PlanarModel& model, int joint_body) {
  Carried sum;
  std::vector<Vec2> origin(model.bodies.size(), Vec2::Zero());
  std::vector<double> angle(model.bodies.size(), 0.0);
  std::vector<bool> beyond(model.bodies.size(), false);
  beyond[joint_body] = true;
  for (std::size_t b = joint_body; b < model.bodies.size(); ++b) {
    const model::PlanarBody& body = model.bodies[b];
    if (static_cast<int>(b) != joint_body) {
      if (body.parent < 0 || !beyond[body.parent]) continue;
      beyond[b] = true;
      angle[b] = angle[body.parent] + body.angle_offset;
      origin[b] = origin[body.parent] + turned(angle[body.parent], body.origin);
    }

    const double squared = (origin[b] + turned(angle[b], body.com)).squaredNorm();
    sum.mass += body.mass;
    sum.moment += body.mass * std::sqrt(squared);
    sum.inertia += body.inertia + body.mass * squared;
  }
  return sum;
}

bool slides(const PlanarModel& model, const std::string& joint) {
  const int body = model.body_of_joint(joint);
  return body >= 0 && model.bodies[body].kind == JointKind::prismatic;
}

/// What a joint accelerates by itself, before its gear [kg m^2, kg].
double own_inertia(const PlanarModel& model, const std::string& joint) {
  const model::PlanarMotor& motor = model.motors[model.motor_index(joint)];
  const Carried carried = carried_by(model, motor.body);
  const double own = slides(model, joint) ? carried.mass : carried.inertia;
  return own / (motor.gear * motor.gear);
}

/// Units of a joint that turns, and of one that slides.
const std::pair<const char*, const char*> kSliding[] = {
    {"N m", "N"},     {"N m s/rad", "N s/m"}, {"rad/(N m)", "m/N"}, {"rad", "m"},
    {"rad/s", "m/s"}, {"kg m^2", "kg"},       {"N m/rad", "N/m"}};

std::string sliding_unit(const std::string& unit) {
  for (const auto& [turning, sliding] : kSliding)
    if (unit == turning) return sliding;
  return unit;
}

}  // namespace

double joint_strength(const PlanarModel& model, const std::string& joint) {
  const model::PlanarMotor& motor = model.motors[model.motor_index(joint)];
  if (std::isfinite(motor.torque_limit)) return motor.torque_limit * motor.gear;
  const Carried carried = carried_by(model, motor.body);
  const double holding = slides(model, joint) ? carried.mass : carried.moment;
  return kGravity * holding;
}

bool all_slide(const JointScope& scope, const PlanarModel& model) {
  const std::vector<std::string> joints = scope.select(model).joints;
  return !joints.empty() && std::all_of(joints.begin(), joints.end(),
                                        [&](const std::string& j) { return slides(model, j); });
}

JointScope sized_scope(const JointScope& scope, const PlanarModel& model, const JointRates& rates) {
  JointScope out = scope;
  const std::vector<std::string> joints = scope.select(model).joints;
  if (joints.empty()) return out;

  double strength = 0.0, inertia = 0.0, rate = 0.0;
  const auto count = static_cast<double>(joints.size());
  for (const std::string& joint : joints) {
    strength += joint_strength(model, joint) / count;
    inertia += own_inertia(model, joint) / count;
    const auto stated = rates.find(joint);
    const double usual = slides(model, joint) ? kSlideRate : scope.usual.rate;
    rate += (stated == rates.end() ? usual : stated->second) / count;
  }

  UsualSizes& usual = out.usual;
  if (strength > 0.0) usual.torque_ratio = strength / scope.usual.strength;
  if (rate > 0.0) usual.rate_ratio = rate / scope.usual.rate;
  usual.strength = strength;
  usual.torque *= usual.torque_ratio;
  usual.rate *= usual.rate_ratio;
  const bool links_matter = scope.prefix == other_scope().prefix && inertia > 0.0;
  usual.inertia = links_matter ? kInertiaShare * inertia : usual.inertia * usual.torque_ratio;
  for (JointScope& part : out.parts) part.usual = usual;
  return out;
}

double rest_rate(const PlanarModel& model, const std::string& joint, const JointRates& rates) {
  const double usual = simulation::JointFriction{}.smoothing_rate;
  for (const JointScope* scope : {&tail_scope(), &leg_scope(), &other_scope()}) {
    const std::vector<std::string> joints = scope->select(model).joints;
    if (std::find(joints.begin(), joints.end(), joint) == joints.end()) continue;
    return usual *
           std::min(1.0, sized_scope(one_joint(*scope, joint), model, rates).usual.rate_ratio);
  }
  return usual;
}

void use_sliding_units(Effect& effect) {
  for (EffectParameter& p : effect.parameters) {
    p.unit = sliding_unit(p.unit);
    if (p.reciprocal) p.reciprocal->unit = sliding_unit(p.reciprocal->unit);
  }
}

}  // namespace jaculus::effects
