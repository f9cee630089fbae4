// From the command to the torque: loop, driver, winding, battery.
//
// A torque constant of s times the stated one turns a current into s times the torque, and a speed
// into s times the back-EMF:
//   tau = s tau_stated(i),   V = R i + s k_t G w.
// On a plant that is torque_scale with the motor's k_t; as values of the model the saturation law
// i = a tau + c tau^3 takes a/s and c/s^3.

#include <cmath>

#include "effects/families.h"
#include "jaculus/components/motor.h"

namespace jaculus::effects {
namespace {

/// Copper's resistance and the magnets' strength against temperature above the stated one [1/K]; as
/// the plant's winding has it.
constexpr double kCopper = 0.0039, kMagnet = 0.001;

Effect on_actuation(const std::string& name, const std::string& caption) {
  Effect effect;
  effect.name = name;
  effect.caption = caption;
  effect.where = {Component::actuation};
  effect.excited_by = {ExperimentKind::leap, ExperimentKind::self_righting,
                       ExperimentKind::tail_bench, ExperimentKind::pendulum};
  effect.applies = [](const PlanarModel& model) { return !model.motors.empty(); };
  return effect;
}

bool any_electric(const PlanarModel& model) {
  return std::any_of(model.motors.begin(), model.motors.end(),
                     [](const PlanarMotor& motor) { return !motor.ideal(); });
}

using Overrides = std::vector<ModelOverride>;

/// Whether an effect is about a motor: about all where it names no joint.
bool is_meant(const std::string& joint, const PlanarMotor& motor) {
  return joint.empty() || motor.joint == joint;
}

/// Model values that an edit gives for every electric motor, or for that of one joint.
std::function<Overrides(const Vector&, const PlanarModel&)> of_motors(
    void (*add)(const Vector&, const PlanarMotor&, Overrides&), const std::string& joint = {}) {
  return [add, joint](const Vector& theta, const PlanarModel& model) {
    Overrides values;
    for (const PlanarMotor& motor : model.motors)
      if (!motor.ideal() && is_meant(joint, motor)) add(theta, motor, values);
    return values;
  };
}

void add_value(const PlanarMotor& motor, const std::string& key, double value, Overrides& values) {
  values.emplace_back("motors." + motor.joint + "." + key, text_of(value));
}

void add_torque_constant(const PlanarMotor& motor, double scale, Overrides& values) {
  add_value(motor, "torque_constant", motor.torque_constant * scale, values);
  add_value(motor, "saturation_linear", motor.saturation_linear / scale, values);
  add_value(motor, "saturation_cubic", motor.saturation_cubic / std::pow(scale, 3), values);
}

/// The largest current that a motor's other limits let it draw [A]: a limit above it would bind
/// nowhere.
double usable_current(const PlanarMotor& motor) {
  double at_torque = kInfinity;
  if (motor.torque_limit < kInfinity) {
    at_torque =
        components::motor_current(motor, motor.torque_limit * motor.gear * motor.efficiency);
  }
  return std::min({motor.current_limit, at_torque, motor.voltage / motor.resistance});
}

double limited_current(const PlanarMotor& motor, double shortfall) {
  return usable_current(motor) * (1.0 - shortfall);
}

Effect actuation_delay() {
  Effect effect = on_actuation("actuation_delay", "commands reach the motors late");
  effect.parameters = {{"delay", "s", 0.0, {0.0, 0.03}, 0.004, 0.002}};
  effect.apply = [](const Vector& theta, Plant& plant) { plant.actuation.delay += theta[0]; };
  return effect;
}

/// A current loop of bandwidth 1/T, or a winding's L/R: from some 0.1 ms to a few. Seen through
/// inertia it is a delay of T but for what changes faster.
Effect current_loop() {
  Effect effect = on_actuation("current_loop", "the motors' torque follows its command with a lag");
  effect.excited_by = {ExperimentKind::leap, ExperimentKind::tail_bench, ExperimentKind::pendulum};
  effect.parameters = {{.name = "time_constant",
                        .unit = "s",
                        .bounds = {0.0, 0.03},
                        .scale = 0.002,
                        .reciprocal = {{"bandwidth", "rad/s"}}}};
  effect.apply = [](const Vector& theta, Plant& plant) { plant.actuation.lag += theta[0]; };
  return effect;
}

/// Drivers lose a share of their bus voltage against the current: 0.5 to 2 us at 10 to 40 kHz are
/// 0.5 to 8 % for each of one or two half bridges in series, and what switches and diodes drop acts
/// like it. Where torque is told nothing shows it but the bus's end, as `voltage_limit` does.
Effect driver_dead_time() {
  Effect effect =
      on_actuation("driver_dead_time", "drivers lose voltage to dead time, against the current");
  effect.parameters = {{"share", "-", 0.0, {0.0, 0.2}, 0.03}};
  effect.applies = any_electric;
  effect.apply = [](const Vector& theta, Plant& plant) { plant.actuation.dead_time += theta[0]; };
  return effect;
}

/// Rates from encoders are differences, filtered over some samples.
Effect velocity_filter() {
  Effect effect = on_actuation("velocity_filter", "the controller reads rates through a low pass");
  effect.where = {Component::actuation, Component::sensing};
  effect.excited_by = {ExperimentKind::leap, ExperimentKind::pendulum};
  effect.parameters = {{.name = "time_constant",
                        .unit = "s",
                        .bounds = {0.0, 0.03},
                        .scale = 0.003,
                        .reciprocal = {{"bandwidth", "rad/s"}}}};
  effect.apply = [](const Vector& theta, Plant& plant) {
    plant.actuation.velocity_filter += theta[0];
  };
  return effect;
}

Effect late_start() {
  Effect effect = on_actuation("late_start", "the plan as a whole starts late");
  effect.where = {Component::actuation, Component::sensing};
  effect.parameters = {{"time", "s", 0.0, {0.0, 0.05}, 0.008, 0.002}};
  effect.of_plan = true;
  effect.apply = [](const Vector& theta, Plant& plant) { plant.actuation.late_start += theta[0]; };
  return effect;
}

Effect controller_gains() {
  Effect effect = on_actuation("controller_gains", "the controller's gains are other than stated");
  effect.excited_by = {ExperimentKind::leap, ExperimentKind::pendulum};
  effect.parameters = {{"proportional_scale", "-", 1.0, {0.0, 6.0}, 0.4},
                       {"derivative_scale", "-", 1.0, {0.0, 6.0}, 0.4}};
  effect.apply = [](const Vector& theta, Plant& plant) {
    plant.actuation.gain_scale_p *= theta[0];
    plant.actuation.gain_scale_d *= theta[1];
  };
  return effect;
}

/// `joint`: of its motor alone; all motors where it is empty.
Effect torque_constant_at(const std::string& joint) {
  Effect effect =
      joint.empty()
          ? on_actuation("torque_constant", "motors turn current into another torque than stated")
          : on_actuation(
                "torque_constant@" + joint,
                "joint " + joint + "'s motor turns current into another torque than stated");
  effect.parameters = {{"scale", "-", 1.0, {0.4, 1.6}, 0.1}};
  if (!joint.empty())
    effect.joints = [joint](const PlanarModel&) { return std::vector<std::string>{joint}; };

  effect.apply = [joint](const Vector& theta, Plant& plant) {
    for (PlanarMotor& motor : plant.model.motors) {
      if (!is_meant(joint, motor)) continue;
      motor.torque_constant *= theta[0];
      plant.actuation.torque_scale.try_emplace(motor.joint, 1.0).first->second *= theta[0];
    }
  };

  effect.overrides = of_motors(
      [](const Vector& theta, const PlanarMotor& motor, Overrides& values) {
        add_torque_constant(motor, theta[0], values);
        // A driver limits torque by the current that it believes to make it.
        if (motor.torque_limit < kInfinity)
          add_value(motor, "torque_limit", motor.torque_limit * theta[0], values);
      },
      joint);
  return guarded(effect);
}

/// All motors alike, as of one batch; on a robot of several each by itself as well.
Effect torque_constant() {
  Effect effect = torque_constant_at("");
  effect.sized = [](const PlanarModel& model, const JointRates&) {
    std::vector<Effect> effects{torque_constant_at("")};
    if (model.motors.size() < 2) return effects;
    for (const PlanarMotor& motor : model.motors)
      effects.push_back(torque_constant_at(motor.joint));
    return effects;
  };
  return effect;
}

Effect voltage_limit() {
  Effect effect = on_actuation("voltage_limit", "the bus has less voltage than stated");
  effect.parameters = {{"shortfall", "-", 0.0, {0.0, 0.75}, 0.15, 0.5}};
  effect.applies = any_electric;
  effect.apply = [](const Vector& theta, Plant& plant) {
    for (PlanarMotor& motor : plant.model.motors) motor.voltage *= 1.0 - theta[0];
  };
  effect.overrides =
      of_motors([](const Vector& theta, const PlanarMotor& motor, Overrides& values) {
        add_value(motor, "voltage", motor.voltage * (1.0 - theta[0]), values);
      });
  return effect;
}

Effect current_limit() {
  Effect effect = on_actuation("current_limit", "drivers cut the current below the stated limits");
  effect.parameters = {{"shortfall", "-", 0.0, {0.0, 0.9}, 0.3, 0.5}};
  effect.applies = any_electric;
  effect.apply = [](const Vector& theta, Plant& plant) {
    if (theta[0] == 0.0) return;

    for (PlanarMotor& motor : plant.model.motors)
      if (!motor.ideal()) motor.current_limit = limited_current(motor, theta[0]);
  };
  effect.overrides =
      of_motors([](const Vector& theta, const PlanarMotor& motor, Overrides& values) {
        add_value(motor, "current_limit", limited_current(motor, theta[0]), values);
      });
  return effect;
}

Effect battery_sag() {
  Effect effect = on_actuation("battery_sag", "the battery's voltage falls with the current drawn");
  effect.parameters = {{"resistance", "ohm", 0.0, {0.0, 0.2}, 0.02}};
  effect.applies = any_electric;
  effect.apply = [](const Vector& theta, Plant& plant) { plant.battery.resistance += theta[0]; };
  return effect;
}

Effect winding_heating() {
  Effect effect =
      on_actuation("winding_heating", "warm windings: more resistance, less torque for a current");
  effect.parameters = {{"temperature", "K", 0.0, {0.0, 150.0}, 30.0}};
  effect.applies = any_electric;
  effect.apply = [](const Vector& theta, Plant& plant) { plant.winding.initial += theta[0]; };
  effect.overrides =
      of_motors([](const Vector& theta, const PlanarMotor& motor, Overrides& values) {
        const double strength = 1.0 - kMagnet * theta[0];
        add_value(motor, "resistance", motor.resistance * (1.0 + kCopper * theta[0]), values);
        add_torque_constant(motor, strength, values);
        // A torque limit is one of the current in truth.
        if (theta[0] != 0.0 && std::isfinite(motor.torque_limit))
          add_value(motor, "torque_limit", motor.torque_limit * strength, values);
      });
  return effect;
}

/// A current sensor or amplifier that is not zero at zero: the driver regulates the current that it
/// sees, so that its log does not show the rest. It is the offset of the force balance
/// F = M a + F_v v + F_c sign(v) + F_o (Janot, Gautier and Brunot 2019, "Data set and reference
/// models of EMPS").
Effect torque_offset(const JointScope& scope) {
  const double scale = scope.usual.torque;
  Effect effect =
      effect_on_joints(scope, "torque_offset", "a constant torque that no log shows at");
  effect.parameters = {{"torque", "N m", 0.0, {-10.0 * scale, 10.0 * scale}, scale}};
  effect.apply = [select = scope.select](const Vector& theta, Plant& plant) {
    for (const std::string& joint : select(plant.model).joints)
      plant.actuation.torque_offset.try_emplace(joint, 0.0).first->second += theta[0];
  };
  return effect;
}

}  // namespace

std::vector<Row> actuation() {
  const JointScope &tail = tail_scope(), &legs = leg_scope(), &other = other_scope();
  return {
      {actuation_delay}, {current_loop},     {late_start},
      {velocity_filter}, {driver_dead_time}, {controller_gains},
      {torque_constant}, {voltage_limit},    {current_limit},
      {battery_sag},     {winding_heating},  {torque_offset, {tail, legs, other}},
  };
}

}  // namespace jaculus::effects
