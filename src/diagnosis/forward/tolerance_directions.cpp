#include "diagnosis/forward/tolerance_directions.h"

#include <utility>

#include "diagnosis/forward/missing_forces.h"

namespace jaculus::diagnosis {
namespace {

using model::PlanarBody;
using model::PlanarModel;
using model::PlanarMotor;
using simulation::Controller;
using simulation::Plant;

using Directions = std::vector<ToleranceDirection>;

/// Nothing within tolerance is off by more than two deviations (model/tolerances.h).
constexpr Bounds kWithin{-2.0, 2.0};
constexpr Bounds kNotNegative{0.0, 2.0};

void add(Directions& directions, double deviation, const std::string& name,
         std::function<void(double, Plant&)> move, bool geometry = false) {
  if (deviation == 0.0) return;
  directions.push_back({name, kWithin, geometry,
                        [deviation, move = std::move(move)](double e, Plant& plant, Controller&) {
                          move(deviation * e, plant);
                        }});
}

/// Everything that is fixed to a body at a distance from its joint.
void stretch(double share, int body, PlanarModel& model) {
  const double factor = 1.0 + share;
  for (PlanarBody& child : model.bodies)
    if (child.parent == body) child.origin *= factor;
  for (model::PlanarLoop& loop : model.loops) {
    if (loop.body_a == body) loop.point_a *= factor;
    if (loop.body_b == body) loop.point_b *= factor;
  }
  for (model::PlanarPoint& foot : model.feet)
    if (foot.body == body) foot.position *= factor;
}

/// Whether anything hangs on a body that its length moves.
bool has_length(const PlanarModel& model, int body) {
  for (const PlanarBody& child : model.bodies)
    if (child.parent == body && child.origin.squaredNorm() > 0.0) return true;
  for (const model::PlanarLoop& loop : model.loops)
    if (loop.body_a == body || loop.body_b == body) return true;
  for (const model::PlanarPoint& foot : model.feet)
    if (foot.body == body) return true;
  return false;
}

void add_link(Directions& directions, const PlanarModel& model, int b, const model::Tolerances& t) {
  const PlanarBody& body = model.bodies[b];
  const bool base_held =
      b == 0 && !model.base_free[0] && !model.base_free[1] && !model.base_free[2];
  if (body.mass > 0.0 && !base_held) {
    add(directions, t.mass, "mass of " + body.name,
        [b](double d, Plant& plant) { plant.model.bodies[b].mass *= 1.0 + d; });
    add(directions, t.inertia, "inertia of " + body.name,
        [b](double d, Plant& plant) { plant.model.bodies[b].inertia *= 1.0 + d; });
    add(directions, t.com, "com x of " + body.name,
        [b](double d, Plant& plant) { plant.model.bodies[b].com.x() += d; });
    add(directions, t.com, "com z of " + body.name,
        [b](double d, Plant& plant) { plant.model.bodies[b].com.y() += d; });
  }
  if (!base_held && has_length(model, b))
    add(
        directions, t.length, "length of " + body.name,
        [b](double d, Plant& plant) { stretch(d, b, plant.model); }, true);
}

void add_motor(Directions& directions, const PlanarModel& model, int m, const model::Tolerances& t,
               double lever) {
  const PlanarMotor& motor = model.motors[m];
  const std::string& joint = motor.joint;
  add(directions, t.torque_constant, "torque constant of " + joint,
      [m, joint](double d, Plant& plant) {
        plant.model.motors[m].torque_constant *= 1.0 + d;
        plant.actuation.torque_scale.try_emplace(joint, 1.0).first->second *= 1.0 + d;
      });
  if (!motor.ideal())
    add(directions, t.resistance, "resistance of " + joint,
        [m](double d, Plant& plant) { plant.model.motors[m].resistance *= 1.0 + d; });
  const double friction = t.joint_friction * large_force(model, motor, lever);
  if (friction == 0.0) return;
  add(directions, friction, "friction of " + joint, [joint](double d, Plant& plant) {
    plant.friction.push_back({joint, d});
  });
  directions.back().range = kNotNegative;
}

/// What the loop reads and does at a motor of the controller's reference.
void add_loop(Directions& directions, const PlanarModel& model, const model::Tolerances& t) {
  for (const PlanarMotor& motor : model.motors) {
    const std::string joint = motor.joint;
    add(
        directions, t.encoder_zero, "encoder of " + joint,
        [joint](double d, Plant& plant) {
          plant.sensing.offset.try_emplace(joint, 0.0).first->second += d;
        },
        true);
    for (const bool derivative : {false, true}) {
      if (t.gain == 0.0) continue;
      const double deviation = t.gain;
      directions.push_back({std::string(derivative ? "kd of " : "kp of ") + joint, kWithin, false,
                            [=](double e, Plant&, Controller& controller) {
                              const int m = index_of(controller.reference.motors, joint);
                              Vector& gain = derivative ? controller.kd : controller.kp;
                              if (m >= 0 && m < gain.size()) gain[m] *= 1.0 + deviation * e;
                            }});
    }
  }
}

}  // namespace

std::vector<ToleranceDirection> tolerance_directions(const PlanarModel& model,
                                                     const model::Tolerances& tolerances,
                                                     bool measured_input, double lever) {
  Directions directions;
  for (int b = 0; b < count_of(model.bodies); ++b) add_link(directions, model, b, tolerances);
  for (int m = 0; m < count_of(model.motors); ++m)
    add_motor(directions, model, m, tolerances, lever);
  if (!measured_input) add_loop(directions, model, tolerances);
  if (!model.feet.empty() && model.base_free[1])
    add(directions, tolerances.floor_friction, "friction of the floor",
        [](double d, Plant& plant) { plant.ground.friction *= 1.0 + d; });
  return directions;
}

}  // namespace jaculus::diagnosis
