#include "diagnosis/forward/tolerance_directions.h"

#include <cmath>
#include <utility>

#include "diagnosis/forward/missing_forces.h"
#include "jaculus/simulation/experiment.h"

namespace jaculus::diagnosis {
namespace {

using model::PlanarBody;
using model::PlanarModel;
using model::PlanarMotor;
using simulation::Controller;
using simulation::Plant;

using Directions = std::vector<ToleranceDirection>;

constexpr Bounds kNotNegative{0.0, 2.0};

using Move = std::function<void(double, Plant&)>;
using Read = std::function<double(const Plant&)>;

using Reads = std::vector<Read>;

Reads in_deviations(Reads reads, double deviation) {
  for (Read& read : reads)
    read = [inner = std::move(read), deviation](const Plant& plant) {
      return inner(plant) / deviation;
    };
  return reads;
}

void add(Directions& directions, double deviation, const std::string& name, Move move, Reads reads,
         bool geometry = false) {
  if (deviation == 0.0) return;
  directions.push_back({name, kWithin, geometry,
                        [deviation, move = std::move(move)](double e, Plant& plant, Controller&) {
                          move(deviation * e, plant);
                        },
                        in_deviations(std::move(reads), deviation)});
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
    const double mass = body.mass, inertia = body.inertia;
    add(directions, t.mass, "mass of " + body.name,
        [b](double d, Plant& plant) { plant.model.bodies[b].mass *= 1.0 + d; },
        {[b, mass](const Plant& plant) { return plant.model.bodies[b].mass / mass; }});
    if (inertia > 0.0)
      add(directions, t.inertia, "inertia of " + body.name,
          [b](double d, Plant& plant) { plant.model.bodies[b].inertia *= 1.0 + d; },
          {[b, inertia](const Plant& plant) { return plant.model.bodies[b].inertia / inertia; }});
    add(directions, t.com, "com x of " + body.name,
        [b](double d, Plant& plant) { plant.model.bodies[b].com.x() += d; },
        {[b](const Plant& plant) { return plant.model.bodies[b].com.x(); }});
    add(directions, t.com, "com z of " + body.name,
        [b](double d, Plant& plant) { plant.model.bodies[b].com.y() += d; },
        {[b](const Plant& plant) { return plant.model.bodies[b].com.y(); }});
  }
  if (!base_held && has_length(model, b))
    add(
        directions, t.length, "length of " + body.name,
        [b](double d, Plant& plant) { stretch(d, b, plant.model); }, {}, true);
}

/// Dry friction at a joint, one way or the other [N m, N where it slides].
Read dry_friction(const std::string& joint, double simulation::JointFriction::*way) {
  return [joint, way](const Plant& plant) {
    double sum = 0.0;
    for (const simulation::JointFriction& f : plant.friction)
      if (f.joint == joint) sum += f.coulomb + f.*way;
    return sum;
  };
}

void add_motor(Directions& directions, const PlanarModel& model, int m, const model::Tolerances& t,
               double lever) {
  const PlanarMotor& motor = model.motors[m];
  const std::string& joint = motor.joint;
  add(directions, t.torque_constant, "torque constant of " + joint,
      [m, joint](double d, Plant& plant) {
        plant.model.motors[m].torque_constant *= 1.0 + d;
        plant.actuation.torque_scale.try_emplace(joint, 1.0).first->second *= 1.0 + d;
      },
      {[joint](const Plant& plant) {
        const auto scale = plant.actuation.torque_scale.find(joint);
        return scale == plant.actuation.torque_scale.end() ? 1.0 : scale->second;
      }});
  if (!motor.ideal()) {
    const double resistance = motor.resistance;
    add(directions, t.resistance, "resistance of " + joint,
        [m](double d, Plant& plant) { plant.model.motors[m].resistance *= 1.0 + d; },
        {[m, resistance](const Plant& plant) {
          return plant.model.motors[m].resistance / resistance;
        }});
  }
  const double friction = t.joint_friction * large_force(model, motor, lever);
  if (friction == 0.0) return;
  add(directions, friction, "friction of " + joint,
      [joint](double d, Plant& plant) {
        plant.friction.push_back({joint});
        plant.friction.back().coulomb = d;
      },
      {dry_friction(joint, &simulation::JointFriction::positive),
       dry_friction(joint, &simulation::JointFriction::negative)});
  directions.back().range = kNotNegative;
}

/// Zeros of encoders: where a loop or a log's window begins, they say where the joints are.
void add_encoders(Directions& directions, const PlanarModel& model, const model::Tolerances& t) {
  for (const PlanarMotor& motor : model.motors) {
    const std::string joint = motor.joint;
    add(
        directions, t.encoder_zero, "encoder of " + joint,
        [joint](double d, Plant& plant) {
          plant.sensing.offset.try_emplace(joint, 0.0).first->second += d;
        },
        {[joint](const Plant& plant) {
          const auto offset = plant.sensing.offset.find(joint);
          return offset == plant.sensing.offset.end() ? 0.0 : offset->second;
        }},
        true);
  }
}

/// What the loop does at a motor of the controller's reference.
void add_loop(Directions& directions, const PlanarModel& model, const model::Tolerances& t) {
  for (const PlanarMotor& motor : model.motors) {
    const std::string joint = motor.joint;
    for (const bool derivative : {false, true}) {
      if (t.gain == 0.0) continue;
      const double deviation = t.gain;
      directions.push_back({std::string(derivative ? "kd of " : "kp of ") + joint,
                            kWithin,
                            false,
                            [=](double e, Plant&, Controller& controller) {
                              const int m = index_of(controller.reference.motors, joint);
                              Vector& gain = derivative ? controller.kd : controller.kp;
                              if (m >= 0 && m < gain.size()) gain[m] *= 1.0 + deviation * e;
                            },
                            {}});
    }
  }
}

/// Whether a quantity is what a driver reports of its motor's current.
bool is_report(trajectory::Quantity quantity) {
  using enum trajectory::Quantity;
  return quantity == current || quantity == torque;
}

/// Drivers' ammeters, in logs that the model predicts: a scale each, and one low pass, for drivers
/// of one robot are alike.
void add_reports(Directions& directions, const ObservedDataset& observed,
                 const model::Tolerances& t) {
  std::vector<std::string> reports;
  for (const Channel& channel : observed.channels)
    if (is_report(trajectory::parse_channel(channel.name).quantity))
      reports.push_back(channel.name);

  for (const std::string& name : reports) {
    add(directions, t.current_scale, "scale of " + name,
        [name](double d, Plant& plant) {
          plant.sensing.scale.try_emplace(name, 1.0).first->second *= 1.0 + d;
        },
        {});
  }

  if (reports.empty() || t.current_filter == 0.0) return;
  add(directions, t.current_filter, "low pass of currents",
      [reports](double d, Plant& plant) {
        for (const std::string& name : reports) plant.sensing.filter[name] += d;
      },
      {});
  directions.back().range = kNotNegative;
}

}  // namespace

std::vector<ToleranceDirection> tolerance_directions(const PlanarModel& model,
                                                     const model::Tolerances& tolerances,
                                                     bool measured_input, double lever) {
  Directions directions;
  for (int b = 0; b < count_of(model.bodies); ++b) add_link(directions, model, b, tolerances);
  for (int m = 0; m < count_of(model.motors); ++m)
    add_motor(directions, model, m, tolerances, lever);
  add_encoders(directions, model, tolerances);
  if (!measured_input) add_loop(directions, model, tolerances);
  if (!model.feet.empty() && model.base_free[1] && model.friction > 0.0)
    add(directions, tolerances.floor_friction, "friction of the floor",
        [](double d, Plant& plant) { plant.ground.friction *= 1.0 + d; },
        {[friction = model.friction](const Plant& plant) {
          return plant.ground.friction / friction;
        }});
  return directions;
}

std::vector<ToleranceDirection> tolerances_of(const ObservedDataset& observed,
                                              const Settings& settings) {
  model::Tolerances own = simulation::dataset_robot(observed.dataset).tolerances;
  // A torque that drives the model is what a driver made of its current: the ammeter's scale and
  // the torque constant are off by both.
  const trajectory::Quantity input = observed.dataset.controller.input;
  if (observed.measured_input && (is_report(input) || input == trajectory::Quantity::motor_torque))
    own.torque_constant = std::hypot(own.torque_constant, own.current_scale);
  Directions directions =
      tolerance_directions(observed.model, own, observed.measured_input, settings.lever);
  add_reports(directions, observed, own);
  if (observed.measured_input) directions.push_back(input_clock(settings.shift_deviation));
  return directions;
}

ToleranceDirection input_clock(double deviation) {
  return {
      "clock of the input",
      kWithin,
      false,
      [deviation](double e, Plant& plant, Controller&) { plant.actuation.delay += deviation * e; },
      {[deviation](const Plant& plant) { return plant.actuation.delay / deviation; }}};
}

}  // namespace jaculus::diagnosis
