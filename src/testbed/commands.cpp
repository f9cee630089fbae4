#include "testbed/commands.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "jaculus/core/error.h"

namespace jaculus::testbed {

using trajectory::Quantity;

namespace {

Vector column(const trajectory::Table& plan, const std::string& name, const Dimension& dimension,
              const std::filesystem::path& file) {
  Vector values = quantity(plan, name, dimension, file);
  for (Eigen::Index k = 0; k < values.size(); ++k) {
    if (std::isfinite(values[k])) continue;
    throw InputError(fmt::format("{}:{}: column '{}': a gap; allowed in a plan: none",
                                 file.string(), k + 2, name));
  }
  return values;
}

double gear_of(const RobotFiles& files, const std::string& planar) {
  for (const Drive& drive : files.drives) {
    if (drive.planar == planar) return drive.motor.gear * drive.motor.efficiency;
  }
  return 1.0;
}

/// Whether the feed-forward stays over pairs of samples, as a plan's does that holds its inputs
/// over intervals with a middle node.
bool stays_over_pairs(const Commands& c) {
  int node = 0;
  for (Eigen::Index k = 1; k < c.time.size(); ++k) {
    node = c.time[k] == c.time[k - 1] ? 0 : node + 1;
    const double change = (c.feedforward.col(k) - c.feedforward.col(k - 1)).cwiseAbs().maxCoeff();
    const bool last = k + 1 == c.time.size() || c.time[k + 1] == c.time[k];
    if (node % 2 == 1 && !last && change > 1e-8) return false;
  }
  return true;
}

/// A joint's gain where a dataset states a number or a range.
double gain_at(const std::map<std::string, trajectory::StatedGain>& gains, const std::string& joint,
               double place) {
  auto found = gains.find(joint);
  if (found == gains.end()) found = gains.find("*");
  if (found == gains.end()) return 0.0;

  const Bounds& range = found->second.range;
  if (found->second.known()) return range.lower;
  if (range.lower > 0.0 && std::isfinite(range.upper))
    return range.lower * std::pow(range.upper / range.lower, place);
  throw InputError(fmt::format(
      "controller: gain of '{}': from {} to {} given; allowed on the testbed: a number, "
      "or a range above 0 with an end",
      joint, range.lower, range.upper));
}

PlanCommands script_commands(const trajectory::InputScript& script, const RobotFiles& files) {
  PlanCommands out;
  Commands& c = out.commands;
  c.quantity = script.quantity;
  c.motors = script.joints;
  c.time = script.time;
  c.feedforward = script.values;
  out.duration = script.time[script.time.size() - 1];

  for (int i = 0; i < count_of(c.motors); ++i) {
    const std::vector<std::string>& known = files.planar_motors;
    if (std::find(known.begin(), known.end(), c.motors[i]) == known.end()) {
      throw InputError(
          fmt::format("input: '{}' is no motor of the robot '{}'", c.motors[i], files.name));
    }
    if (script.quantity == Quantity::torque) c.feedforward.row(i) /= gear_of(files, c.motors[i]);
  }
  return out;
}

}  // namespace

PlanCommands plan_commands(const trajectory::Table& plan, const RobotFiles& files,
                           Quantity quantity, const std::filesystem::path& file) {
  PlanCommands out;
  Commands& c = out.commands;
  c.quantity = quantity;
  c.time = column(plan, "time", dimension::time, file);
  for (Eigen::Index k = 1; k < c.time.size(); ++k) {
    if (c.time[k] >= c.time[k - 1]) continue;
    throw InputError(fmt::format("{}:{}: time: {} s after {} s; allowed: time that does not fall",
                                 file.string(), k + 2, c.time[k], c.time[k - 1]));
  }
  c.motors = files.planar_motors;
  const auto rows = std::ssize(c.motors);
  for (Matrix* matrix : {&c.position, &c.velocity, &c.feedforward})
    matrix->resize(rows, c.time.size());
  for (Eigen::Index r = 0; r < rows; ++r) {
    const std::string& joint = c.motors[r];
    c.position.row(r) = column(plan, joint, dimension::angle, file).transpose();
    c.velocity.row(r) =
        column(plan, channel_name(joint, Quantity::velocity), dimension::angular_velocity, file)
            .transpose();

    c.feedforward.row(r) = column(plan, channel_name(joint, quantity),
                                  trajectory::dimensions_of(quantity).front(), file)
                               .transpose();
    if (quantity == Quantity::torque) c.feedforward.row(r) /= gear_of(files, joint);
    out.start[joint] = c.position(r, 0);
  }
  c.linear = !stays_over_pairs(c);
  for (const std::string name : {"x", "z", "pitch"}) {
    if (plan.column(name) < 0) continue;
    out.start[name] =
        column(plan, name, name == "pitch" ? dimension::angle : dimension::length, file)[0];
  }
  out.duration = c.time[c.time.size() - 1];
  return out;
}

PlanCommands dataset_commands(const trajectory::Dataset& asked, const RobotFiles& files,
                              const TrialSpec& spec) {
  PlanCommands out;
  const trajectory::StatedController& stated = asked.controller;

  if (asked.plan) {
    out = plan_commands(*asked.plan, files, stated.quantity, asked.folder / "plan.csv");
  } else {
    if (!asked.script)
      throw InputError("the experiment has neither plan nor input; allowed: one of the two");
    out = script_commands(*asked.script, files);
  }

  out.commands.rate_hz = stated.rate_hz;
  out.commands.relax_after_end = stated.after_end == trajectory::AfterEnd::relax;
  out.commands.repeat_after_end =
      stated.after_end == trajectory::AfterEnd::repeat || asked.script.has_value();
  for (const std::string& motor : out.commands.motors) {
    out.commands.kp[motor] = gain_at(stated.kp, motor, spec.kp_place);
    out.commands.kd[motor] = gain_at(stated.kd, motor, spec.kd_place);
  }

  for (const auto& [name, value] : asked.initial) out.start[name] = value;
  return out;
}

}  // namespace jaculus::testbed
