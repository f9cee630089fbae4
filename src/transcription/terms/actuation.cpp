// Terms of motors and joints.

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "jaculus/components/motor.h"
#include "transcription/terms/common.h"

namespace jaculus::transcription::terms {

namespace {

bool electrical(const model::PlanarMotor& motor) {
  return motor.resistance > 0.0 || motor.torque_constant > 0.0;
}

/// The instants [s], from the one at hand, at which a motor's voltage is looked at: this one alone,
/// or the ends of the sample of which it is the middle.
std::vector<double> instants(double sample_time) {
  if (sample_time == 0.0) return {0.0};
  return {-0.5 * sample_time, 0.5 * sample_time};
}

/// Voltage of one motor: R i(tau) + k_t G (omega + t alpha), omega the joint's rate, alpha its
/// acceleration, t each of the instants; linear in v and a. A controller that holds torques from
/// sample to sample plays the mean over a sample, which is the torque in its middle to second
/// order; between its ends the rate goes on. Where the joint rubs dry, tau is the input and all of
/// that friction, with it and against it.
PathTerm motor_voltage_term(const model::PlanarModel& model, int m, double limit,
                            double sample_time) {
  const model::PlanarMotor motor = model.motors[m];
  const Vector rate = model.joint_map.row(motor.body).transpose();
  const double dry = motor.dry_friction;
  const std::vector<double> sides = dry > 0.0 ? std::vector{-dry, dry} : std::vector{0.0};
  std::vector<std::array<double, 2>> when;  // instant [s], torque beside the input [N m]
  PathTerm term;
  term.name = motor.joint + " voltage";
  for (const double t : instants(sample_time)) {
    const char* at = t == 0.0 ? "" : t < 0.0 ? " where a sample begins" : " where a sample ends";
    for (const double side : sides) {
      when.push_back({t, side});
      const Bounds bounds{side > 0.0 ? -kInfinity : -limit, side < 0.0 ? kInfinity : limit};
      term.rows.push_back({term.name + at, "V", bounds, limit});
    }
  }
  term.reads.velocity = term.reads.input = true;
  term.reads.acceleration = sample_time > 0.0;

  term.evaluate = [motor, rate, when, m](const PointView& view, VectorRef values, Matrix* J,
                                         const ConstVectorRef* multipliers, Matrix* H) {
    for (int i = 0; i < count_of(when); ++i) {
      const auto [t, beside] = when[i];
      const double ahead = t == 0.0 ? 0.0 : t * rate.dot(view.point.a);
      const components::MotorVoltage voltage =
          components::motor_voltage(motor, view.u[m] + beside, rate.dot(view.point.v) + ahead);
      values[i] = voltage.value;

      const int u = view.u_at() + m;
      if (J) {
        J->row(i).segment(view.v_at(), view.n) += voltage.d_rate * rate.transpose();
        if (t != 0.0)
          J->row(i).segment(view.a_at(), view.n) += t * voltage.d_rate * rate.transpose();
        (*J)(i, u) += voltage.d_torque;
      }
      if (H) (*H)(u, u) += (*multipliers)[i] * voltage.d_torque2;
    }
  };
  term.sensitivity = {"voltage", "V",
                      [](int, double multiplier, const auto*) { return std::abs(multiplier); }};

  return term;
}

void add_voltage(const TermSpec& spec, TermContext& context) {
  std::vector<int> chosen = all_named(spec, "motors", context);
  const auto ideal = [&](int m) { return !electrical(context.model().motors[m]); };
  if (!spec.values.has("motors")) std::erase_if(chosen, ideal);
  const double sample_time = spec.values.number_or("sample_time", 0.0);
  if (chosen.empty()) throw spec.node.error("voltage: no motor of this robot has electrical data");

  for (const int m : chosen) {
    const model::PlanarMotor& motor = context.model().motors[m];
    const double limit = context.problem.voltage.value_or(motor.voltage);
    if (!electrical(motor) || !(limit > 0.0))
      throw spec.node.error(
          fmt::format("voltage: {} has no electrical data or no voltage; give them in robot.yaml",
                      motor.joint));
    for (int p : all_named(spec, "phases", context))
      context.path[p].push_back(motor_voltage_term(context.model(), m, limit, sample_time));
  }
}

/// Speed of one motor before its gear, G omega: linear in v.
PathTerm motor_speed_term(const model::PlanarModel& model, int m) {
  const model::PlanarMotor& motor = model.motors[m];
  const bool slides = model.slides(motor);
  const Vector rate = motor.gear * model.joint_map.row(motor.body).transpose();
  const double limit = motor.speed_limit;
  PathTerm term;
  term.name = motor.joint + " speed";
  term.rows.push_back({term.name, slides ? "m/s" : "rad/s", {-limit, limit}, limit});
  term.reads.velocity = true;
  term.linear = true;
  term.evaluate = [rate](const PointView& view, VectorRef values, Matrix* J, const ConstVectorRef*,
                         Matrix*) {
    values[0] = rate.dot(view.point.v);
    if (J) J->row(0).segment(view.v_at(), view.n) += rate.transpose();
  };
  term.sensitivity = {"motor speed", slides ? "m/s" : "rad/s",
                      [](int, double multiplier, const auto*) { return std::abs(multiplier); }};

  return term;
}

void add_motor_limits(const TermSpec& spec, TermContext& context) {
  const model::PlanarModel& model = context.model();
  const double sample_time = spec.values.number_or("sample_time", 0.0);
  bool any = false;
  for (int m = 0; m < count_of(model.motors); ++m) {
    const model::PlanarMotor& motor = model.motors[m];
    const double volts = context.problem.voltage.value_or(motor.voltage);
    for (int p : all_named(spec, "phases", context)) {
      if (electrical(motor) && std::isfinite(volts))
        context.path[p].push_back(motor_voltage_term(model, m, volts, sample_time));
      if (std::isfinite(motor.speed_limit)) context.path[p].push_back(motor_speed_term(model, m));
    }
    any = any || electrical(motor) || std::isfinite(motor.speed_limit);
  }

  if (!any)
    context.notes.push_back(
        "motor_limits adds no rows: no motor of this robot has electrical data or a speed_limit");
}

void add_joint_range(const TermSpec& spec, TermContext& context) {
  bool any = false;
  for (const model::JointRange& range : context.model().joint_ranges) {
    // Ranges on dependent joints are checked after the solve; the dyad's closed form keeps them on
    // their branch.
    const Vector row = context.model().joint_map.row(range.body).transpose();
    if (row.isZero()) continue;
    any = true;

    const double offset = context.model().joint_offset[range.body];
    PathTerm term;
    term.name = range.joint + " range";
    term.rows.push_back(
        {range.joint, "rad", {range.range.lower - offset, range.range.upper - offset}, 1.0});
    term.reads.position = true;
    term.linear = true;
    term.evaluate = [row](const PointView& view, VectorRef values, Matrix* J, const ConstVectorRef*,
                          Matrix*) {
      values[0] = row.dot(view.point.q);
      if (J) J->row(0).head(view.n) = row.transpose();
    };
    for (int p : all_named(spec, "phases", context)) context.path[p].push_back(term);
  }

  if (!any)
    context.notes.push_back(
        "joint_range adds no rows: this robot gives no range to a joint that is no coordinate");
}

void add_torque_squared(const TermSpec& spec, TermContext& context) {
  PathTerm term;
  const bool at_joint = spec.values.choice("at") == "joint";
  const double per = spec.values.number("per");
  term.name = "torque squared";
  term.rows.push_back({at_joint ? "sum of squared motor torques at the joint"
                                : "sum of squared motor torques, before the gear",
                       "N^2 m^2",
                       {},
                       1.0});
  term.reads.input = true;

  Vector factor(context.layout.n_u);
  for (int m = 0; m < context.layout.n_u; ++m) {
    const model::PlanarMotor& motor = context.model().motors[m];
    const double ratio = per * (at_joint ? 1.0 : motor.gear * motor.efficiency);
    factor[m] = motor.count / (ratio * ratio);
  }

  term.evaluate = [factor](const PointView& view, VectorRef values, Matrix* J,
                           const ConstVectorRef* multipliers, Matrix* H) {
    values[0] = factor.dot(view.u.cwiseAbs2());
    if (J)
      J->row(0).segment(view.u_at(), view.n_u) = (2.0 * factor.cwiseProduct(view.u)).transpose();
    if (H) H->diagonal().segment(view.u_at(), view.n_u) += 2.0 * (*multipliers)[0] * factor;
  };

  context.integral_costs.emplace_back(term, spec.weight);
}

void add_electrical_energy(const TermSpec& spec, TermContext& context) {
  const model::PlanarModel& model = context.model();
  PathTerm term;
  term.name = "electrical energy";
  term.rows.push_back({"electrical power of all motors", "W", {}, 1.0});
  term.reads.input = term.reads.velocity = true;

  const std::vector<model::PlanarMotor> motors = model.motors;
  Matrix rates(context.layout.n_u, model.size());
  for (int m = 0; m < context.layout.n_u; ++m) rates.row(m) = model.joint_map.row(motors[m].body);

  term.evaluate = [motors, rates](const PointView& view, VectorRef values, Matrix* J,
                                  const ConstVectorRef* multipliers, Matrix* H) {
    values[0] = 0.0;
    for (int m = 0; m < view.n_u; ++m) {
      const model::PlanarMotor& motor = motors[m];
      const double rate = rates.row(m).dot(view.point.v), count = motor.count;
      const components::MotorFriction dry = components::against_dry_friction(motor, rate);
      const components::MotorPower power =
          components::motor_power(motor, view.u[m] + dry.value, rate);
      values[0] += count * power.value;

      const int u = view.u_at() + m, v = view.v_at();
      if (J) {
        const double d_rate = power.d_rate + power.d_torque * dry.d_rate;
        J->row(0).segment(v, view.n) += count * d_rate * rates.row(m);
        (*J)(0, u) += count * power.d_torque;
      }
      if (H) {
        const double w = count * (*multipliers)[0];
        const double d_torque_rate = power.d_torque_rate + power.d_torque2 * dry.d_rate;
        const double d_rate2 =
            (d_torque_rate + power.d_torque_rate) * dry.d_rate + power.d_torque * dry.d_rate2;
        (*H)(u, u) += w * power.d_torque2;
        H->row(u).segment(v, view.n) += w * d_torque_rate * rates.row(m);
        H->col(u).segment(v, view.n) += w * d_torque_rate * rates.row(m).transpose();
        H->block(v, v, view.n, view.n) += w * d_rate2 * rates.row(m).transpose() * rates.row(m);
      }
    }
  };

  context.integral_costs.emplace_back(term, spec.weight);
}

/// `sample_time` of the controller that plays the plan.
Key sample_time_key() {
  return {"sample_time",
          key::Number{dimension::time, {0.0, 0.1}},
          "of a controller that holds torques from sample to sample, for which voltages hold too; "
          "0: torques as planned",
          {.value = "0"}};
}

}  // namespace

TermType voltage() {
  return {.name = "voltage",
          .meaning = "motor voltages within the bus voltage",
          .keys = {{"motors",
                    key::Names{key::Of::motor},
                    "list of motors",
                    {.words = "all electric ones"}},
                   sample_time_key(),
                   phases_key()},
          .example = "sample_time: 2 ms",
          .make = add_voltage};
}

TermType motor_limits() {
  return {.name = "motor_limits",
          .meaning =
              "every motor within its voltage (limits.voltage) and speed_limit, where it has "
              "them; torque and current always are",
          .keys = {sample_time_key(), phases_key()},
          .example = "sample_time: 2 ms",
          .make = add_motor_limits};
}

TermType joint_range() {
  return {.name = "joint_range",
          .meaning = "joints that are no coordinates within their ranges",
          .keys = {phases_key()},
          .make = add_joint_range};
}

TermType torque_squared() {
  return {.name = "torque_squared",
          .meaning =
              "integral of the squared motor torques, without what they give against dry friction, "
              "summed over motors",
          .cost = true,
          .unit = "N^2 m^2 s",
          .keys = {{"at",
                    key::Choice{{"motor", "joint"}},
                    "whether torques count before the gear or at the joint",
                    {.value = "motor"}},
                   {"per",
                    key::Number{dimension::torque, {1e-12, kInfinity}},
                    "torque that counts as one",
                    {.value = "1"}}},
          .make = add_torque_squared};
}

TermType electrical_energy() {
  return {.name = "electrical_energy",
          .meaning = "integral of voltage times current, summed over motors",
          .cost = true,
          .unit = "J",
          .make = add_electrical_energy};
}

}  // namespace jaculus::transcription::terms
