#include "testbed/draws.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "jaculus/core/error.h"
#include "jaculus/model/robot.h"
#include "testbed/noise_floor.h"
#include "testbed/swings.h"

namespace jaculus::testbed {
namespace {

using trajectory::ExperimentKind;
using trajectory::Quantity;

double uniform(Random& random, double from, double to) {
  return std::uniform_real_distribution<double>(from, to)(random);
}

template <class Value>
Value one_of(Random& random, const std::vector<Value>& values) {
  return values[std::uniform_int_distribution<std::size_t>(0, values.size() - 1)(random)];
}

bool has_all_motors(const trajectory::Table& plan, const RobotFiles& robot) {
  return std::all_of(robot.planar_motors.begin(), robot.planar_motors.end(),
                     [&](const std::string& motor) { return plan.column(motor) >= 0; });
}

std::string names_of(const std::vector<RobotFiles>& robots) {
  std::vector<std::string> names;
  for (const RobotFiles& robot : robots) names.push_back(robot.name);
  return fmt::format("{}", fmt::join(names, ", "));
}

/// What a robot can do without a plan.
void add_bench_stages(const std::filesystem::path& folder, const RobotFiles& robot,
                      std::vector<Stage>& stages) {
  const auto add = [&](const std::string& what, const trajectory::Dataset& asked) {
    stages.push_back(make_stage(what + " " + robot.name, asked));
  };
  const std::vector<std::string> tail = robot.motors_of(Limb::tail);
  const bool stops = std::all_of(tail.begin(), tail.end(), [&](const std::string& joint) {
    const Bounds& range = robot.joint_of(joint).range;
    return std::isfinite(range.lower) && std::isfinite(range.upper);
  });

  const std::string drop = name_of(ExperimentKind::self_righting);
  const std::string bench = name_of(ExperimentKind::tail_bench);
  if (!tail.empty() && stops && robot.floating) add(drop, self_righting(folder));
  if (!tail.empty()) add(bench, tail_bench(folder));
  if (can_swing_legs(robot)) {
    add(drop, leg_drop(folder));
    add(bench, leg_bench(folder));
  }

  const std::string kind = name_of(ExperimentKind::pendulum);
  if (!robot.floating && robot.planar_motors.size() == 1 && tail.empty())
    add(kind, pendulum(folder));
  for (const std::string& name : swing_inputs().names()) {
    const SwingInput input = *swing_inputs().find(name);
    if (can_swing(robot, input)) add(kind + " " + name, swing(folder, input));
  }
}

/// Start and length of a push: within the commands, where its ranges allow that.
void draw_moment(const BenchEffect& effect, double end, Random& random,
                 std::vector<double>& values) {
  const BenchParameter &start = effect.parameters.at(1), &length = effect.parameters.at(2);
  const double longest = std::clamp(0.5 * end, length.lower, length.upper);
  values[2] = uniform(random, length.lower, longest);
  const double latest = std::clamp(end - values[2], start.lower, start.upper);
  values[1] = uniform(random, start.lower, latest);
}

/// Effects on what comes before the torques that a log of kind measured holds, or that move all of
/// the log in time: nothing that such a log shows.
const std::set<std::string>& before_the_log() {
  static const std::set<std::string> kNames = {
      "actuation_delay", "late_start",   "controller_gains", "torque_constant", "voltage_limit",
      "current_limit",   "battery_sag",  "winding_heating",  "sensor_latency",  "driver_dead_band",
      "coarse_commands", "command_slew", "lost_packets"};
  return kNames;
}

}  // namespace

Stage make_stage(const std::string& name, const trajectory::Dataset& asked) {
  Stage stage{name, asked, read_robot_files(model::find_robot(asked.robot, asked.folder)), {}};
  stage.effects = bench_effects(stage.robot);
  return stage;
}

std::vector<Stage> all_stages(const std::vector<std::filesystem::path>& plans,
                              const std::vector<std::filesystem::path>& robots) {
  std::vector<RobotFiles> files;
  for (const std::filesystem::path& robot : robots) files.push_back(read_robot_files(robot));

  std::vector<Stage> stages;
  for (const std::filesystem::path& plan : plans) {
    const trajectory::Table table = trajectory::read_csv(plan);
    const auto fits = [&](const RobotFiles& robot) { return has_all_motors(table, robot); };
    const auto found = std::find_if(files.begin(), files.end(), fits);
    if (found == files.end()) {
      throw InputError(
          fmt::format("{}: a plan of no robot given; allowed: a column for every motor of one of "
                      "{}",
                      plan.string(), names_of(files)));
    }
    const std::filesystem::path& robot = robots[found - files.begin()];
    for (const Quantity quantity : {Quantity::torque, Quantity::duty}) {
      stages.push_back(
          make_stage(fmt::format("leap {} {}", plan.filename().string(), name_of(quantity)),
                     leap(robot, plan, quantity)));
    }
  }

  for (int i = 0; i < count_of(robots); ++i) add_bench_stages(robots[i], files[i], stages);
  return stages;
}

double commands_end(const Stage& stage) {
  if (stage.asked.script) return stage.asked.script->time.tail<1>()[0];
  const trajectory::Table& plan = *stage.asked.plan;
  return plan.values(plan.values.rows() - 1, plan.column("time"));
}

const BenchEffect* acting_effect(const Stage& stage, const std::string& name) {
  const BenchEffect* effect = find_bench_effect(stage.effects, name);
  if (effect == nullptr) return nullptr;
  const bool measured = stage.asked.controller.kind == trajectory::ControllerKind::measured;
  if (measured && before_the_log().contains(name.substr(0, name.find('@')))) return nullptr;
  const auto& where = effect->experiments;
  return std::find(where.begin(), where.end(), stage.asked.experiment) == where.end() ? nullptr
                                                                                      : effect;
}

/// Noise of every kind that logs show, and a robot that is off its files.
void draw_clutter_of(Random& random, TrialSpec& spec) {
  SensorSpec& s = spec.sensors;
  spec.clutter_seed = random();
  s.shape.coloured = uniform(random, 0.1, 0.6);
  s.shape.correlation_time = one_of<double>(random, {5e-3, 2e-2, 5e-2});
  s.shape.tails = one_of<double>(random, {0.0, 4.0, 8.0});
  s.joints_lost = one_of<double>(random, {0.0, 0.0, 0.02});
  s.clock_drift = 1e-4;
  s.ammeter_step = one_of<double>(random, {0.0, 0.05, 0.2});
  s.ammeter_filter = one_of<double>(random, {0.0, 2e-3});
  s.torque_noise = one_of<double>(random, {0.005, 0.01, 0.02});
  s.torque_step = one_of<double>(random, {0.0, 0.002});
  s.encoder_step *= one_of<double>(random, {1.0, 4.0});
}

Dose draw_dose(const BenchEffect& effect, const Stage& stage, Random& random, double& end) {
  Dose dose{&effect, usual_values(effect)};
  const BenchParameter& first = effect.parameters.front();
  const bool both = first.lower < first.usual && first.usual < first.upper;
  const bool up = both ? uniform(random, 0.0, 1.0) < 0.5 : first.upper > first.usual;
  end = up ? first.upper : first.lower;

  if (effect.event) {
    draw_moment(effect, commands_end(stage), random, dose.values);
    return dose;
  }
  for (std::size_t i = 1; i < dose.values.size(); ++i) {
    const BenchParameter& p = effect.parameters[i];
    if (p.drawn) dose.values[i] = uniform(random, p.lower, p.upper);
  }
  return dose;
}

TrialSpec draw_trials(Random& random, const Stage& stage, bool clutter) {
  const bool held = stage.asked.experiment == ExperimentKind::tail_bench || !stage.robot.floating;
  TrialSpec spec;
  spec.trials = std::uniform_int_distribution<int>(3, 8)(random);
  SensorSpec& s = spec.sensors;
  s.mocap_rate_hz = one_of<double>(random, {120.0, 240.0, 360.0});
  const double quality = one_of<double>(random, {0.7, 1.0, 1.5});
  s.mocap_position *= quality;
  s.mocap_angle *= quality;
  s.mocap_lost = one_of<double>(random, {0.0, 0.0, 0.03});
  s.joints = held || uniform(random, 0.0, 1.0) < 0.8;
  s.joints_rate_hz = one_of<double>(random, {250.0, 500.0, 1000.0});
  s.rates = uniform(random, 0.0, 1.0) < 0.7;
  s.electric = uniform(random, 0.0, 1.0) < 0.5;
  s.imu = !held && uniform(random, 0.0, 1.0) < 0.3;
  s.torque = stage.asked.controller.kind == trajectory::ControllerKind::measured;
  spec.kp_place = uniform(random, 0.1, 0.9);
  spec.kd_place = uniform(random, 0.1, 0.9);
  spec.pose_scatter = one_of<double>(random, {1e-3, 2e-3, 4e-3});
  spec.seed = random();
  if (clutter) draw_clutter_of(random, spec);
  return spec;
}

std::optional<trajectory::Dataset> exact_run(const Stage& stage, const Changes& changes,
                                             const TrialSpec& spec) {
  TrialSpec exact = spec;
  exact.exact = true;
  exact.trials = 1;
  exact.after = 0.0;  // a gap counts where the robot is commanded, which is what a diagnosis sees
  try {
    return run_trials(stage.asked, changes, exact);
  } catch (const LostRobot&) {
    return std::nullopt;  // no such case
  } catch (const UnreachablePose&) {
    return std::nullopt;
  }
}

std::optional<Dose> find_dose(const BenchEffect& effect, const Stage& stage, const TrialSpec& spec,
                              const trajectory::Dataset& nominal, double target, Random& random,
                              double& reached) {
  double end = 0.0;
  Dose dose = draw_dose(effect, stage, random, end);
  const double usual = effect.parameters.front().usual;
  const double least = std::abs(effect.parameters.front().lower - usual) *
                       (end > usual && effect.parameters.front().lower > usual ? 1.0 : 0.0);
  const auto gap_at = [&](double share) {
    dose.values[0] = usual + share * (end - usual);
    Changes changes;
    effect.apply(dose.values, changes);
    const std::optional<trajectory::Dataset> run = exact_run(stage, changes, spec);
    return run ? gap(nominal, *run, spec.sensors, stage.robot) : kInfinity;
  };

  if (effect.parameters.front().lower == effect.parameters.front().upper) {
    reached = gap_at(1.0);
    return dose;
  }

  // Bisection on the logarithm of the share; the gap need not be proportional to it (limits,
  // slipping feet).
  double low = std::max(1e-3, std::abs(end - usual) > 0.0 ? least / std::abs(end - usual) : 1e-3),
         high = 1.0;
  double share = std::sqrt(low * high);
  for (int i = 0; i < 12; ++i) {
    reached = gap_at(share);
    if (std::abs(reached / target - 1.0) < 0.1) return dose;
    (reached > target ? high : low) = share;
    const double next = std::isfinite(reached) && reached > 0.0 ? share * target / reached : 0.0;
    share = next > low * 1.02 && next < high * 0.98 ? next : std::sqrt(low * high);
  }

  if (reached > target / 1.5 && reached < target * 1.5) return dose;
  return std::nullopt;
}

}  // namespace jaculus::testbed
