// What a leap's trial amounts to, and how near a replay comes to its limits.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "jaculus/core/error.h"
#include "jaculus/core/tasks.h"
#include "jaculus/simulation/experiment.h"

namespace jaculus {
namespace {

/// Linear between samples; NaN outside of them.
double value_at(const Simulation& s, const Eigen::Ref<const Eigen::RowVectorXd>& values, double time) {
  for (Eigen::Index k = 0; k + 1 < s.time.size(); ++k) {
    if (time < s.time[k] || time > s.time[k + 1]) continue;
    const double share = (time - s.time[k]) / (s.time[k + 1] - s.time[k]);
    return (1.0 - share) * values[k] + share * values[k + 1];
  }
  return kNaN;
}

LeapState state_at(const PlanarModel& model, const Simulation& s, double time, const std::optional<double>& height) {
  const int x = model.coordinate_index("x"), z = model.coordinate_index("z"), pitch = model.coordinate_index("pitch");
  LeapState state;
  state.time = time;
  if (x >= 0) state.speed = value_at(s, s.v.row(x), time);
  if (pitch < 0) return state;
  state.pitch = value_at(s, s.q.row(pitch), time);
  if (z < 0 || !height) return state;
  // Free flight of the base with the legs and the pitch rate as they are: z + w t - g t^2/2 = height, on the way down.
  const double w = value_at(s, s.v.row(z), time), above = value_at(s, s.q.row(z), time) - *height;
  const double root = w * w + 2.0 * model.gravity * above;
  if (root >= 0.0)
    state.landing_pitch = state.pitch + value_at(s, s.v.row(pitch), time) * (w + std::sqrt(root)) / model.gravity;
  return state;
}

/// When the last of the feet left the floor; contacts at the start are those of all feet.
std::optional<double> lift_off_time(const PlanarModel& model, const Simulation& s) {
  std::set<std::string> standing;
  for (const PlanarPoint& foot : model.feet) standing.insert(foot.name);
  for (const Event& event : s.events) {
    if (event.kind == EventKind::lift) standing.erase(event.what);
    if (event.kind == EventKind::land) standing.insert(event.what);
    if (event.kind == EventKind::lift && standing.empty()) return event.time;
  }
  return std::nullopt;
}

double friction_share(const Plant& plant, const Simulation& s, double end) {
  constexpr double kLeast = 1.0;
  double worst = kNaN;
  for (std::size_t f = 0; f < plant.model.feet.size(); ++f) {
    const auto row = static_cast<Eigen::Index>(2 * f);
    for (Eigen::Index k = 0; k < s.time.size() && s.time[k] <= end; ++k) {
      if (!(s.force(row + 1, k) > kLeast) || plant.ground.friction <= 0.0) continue;
      const double share = std::abs(s.force(row, k)) / (plant.ground.friction * s.force(row + 1, k));
      worst = std::isnan(worst) ? share : std::max(worst, share);
    }
  }
  return worst;
}

/// Feet slid from a slip event to the next that ends it.
double slip_time(const Simulation& s, double end) {
  std::map<std::string, double> since;
  double total = 0.0;
  for (const Event& event : s.events) {
    if (event.time > end) break;
    const auto slid = since.find(event.what);
    if (event.kind == EventKind::slip && slid == since.end()) {
      since[event.what] = event.time;
    } else if (slid != since.end() && (event.kind == EventKind::stick || event.kind == EventKind::lift)) {
      total += event.time - slid->second;
      since.erase(slid);
    }
  }
  for (const auto& [foot, from] : since) total += end - from;
  return total;
}

Margins margins_of(const Experiment& experiment, const Plant& plant, const Simulation& s) {
  Margins m;
  m.status = s.status;
  if (s.time.size() == 0) return m;
  const double end = std::min(command_duration(experiment.setup), s.end_time);
  m.friction_share = friction_share(plant, s, end);
  m.slip_time = slip_time(s, end);
  const auto larger = [](double a, double b) { return std::isnan(a) ? b : std::max(a, b); };
  for (std::size_t i = 0; i < plant.model.motors.size(); ++i) {
    const PlanarMotor& motor = plant.model.motors[i];
    const auto row = static_cast<Eigen::Index>(i);
    for (Eigen::Index k = 0; k < s.time.size() && s.time[k] <= end; ++k) {
      if (!motor.ideal()) m.voltage_share = larger(m.voltage_share, std::abs(s.voltage(row, k)) / s.bus_voltage[k]);
      const double torque = std::abs(s.torque(row, k)) / (motor.gear * motor.efficiency);
      if (std::isfinite(motor.torque_limit)) m.torque_share = larger(m.torque_share, torque / motor.torque_limit);
      if (std::isfinite(motor.current_limit))
        m.current_share = larger(m.current_share, std::abs(s.current(row, k)) / motor.current_limit);
    }
  }
  const LeapState state = state_at(plant.model, s, end, experiment.touchdown_height);
  m.landing_pitch = state.landing_pitch;
  m.speed = state.speed;
  return m;
}

// Uncertainties ---------------------------------------------------------------------------------------------------------

struct ModelValue {
  std::string path;
  double value = 0.0;
  std::string unit;
};

/// Whether `path` is meant by `pattern`, in which "*" stands for one part between dots.
bool matches(const std::string& pattern, const std::string& path) {
  std::size_t i = 0, j = 0;
  while (i < pattern.size() && j < path.size()) {
    if (pattern[i] == '*') {
      ++i;
      while (j < path.size() && path[j] != '.') ++j;
    } else if (pattern[i++] != path[j++]) {
      return false;
    }
  }
  return i == pattern.size() && j == path.size();
}

/// The numbers among the model values, from their lines "path = 0.2 [ohm]".
std::vector<ModelValue> model_values(const std::filesystem::path& robot) {
  std::vector<ModelValue> values;
  for (const std::string& line : override_paths(robot)) {
    const std::size_t equals = line.find(" = ");
    if (equals == std::string::npos) continue;
    ModelValue value;
    value.path = line.substr(0, equals);
    char* end = nullptr;
    const std::string rest = line.substr(equals + 3);
    value.value = std::strtod(rest.c_str(), &end);
    const std::string unit = end;
    if (end == rest.c_str() || !unit.starts_with(" [") || unit.find(',') != std::string::npos ||
        !std::isfinite(value.value))
      continue;
    value.unit = unit.substr(2, unit.find(']') - 2);
    values.push_back(value);
  }
  return values;
}

/// Nominal values of everything an uncertainty names; those that the experiment overrides count as overridden.
std::map<std::string, std::vector<ModelValue>> uncertain_values(const Experiment& experiment) {
  const std::vector<ModelValue> all = model_values(find_robot(experiment.setup.robot, experiment.setup.folder));
  std::vector<std::string> names;
  for (const ModelValue& value : all) names.push_back(value.path);
  std::map<std::string, std::vector<ModelValue>> found;
  for (const auto& [pattern, spread] : experiment.uncertainties) {
    for (const ModelValue& value : all)
      if (matches(pattern, value.path)) found[pattern].push_back(value);
    if (!found[pattern].empty()) continue;
    const auto near = yaml::nearest_name(pattern, names);
    throw InputError(fmt::format("{}: uncertainties: '{}' is no model value of {}{}; allowed: {}", experiment.name,
                                 pattern, experiment.setup.robot,
                                 near ? fmt::format(", did you mean '{}'?", *near) : "", fmt::join(names, ", ")));
  }
  return found;
}

double nominal_of(const Experiment& experiment, const ModelValue& value) {
  const auto stated = experiment.setup.overrides.find(value.path);
  if (stated == experiment.setup.overrides.end()) return value.value;
  char* end = nullptr;
  const double number = std::strtod(stated->second.c_str(), &end);
  if (*end == '\0' && end != stated->second.c_str()) return number;
  throw InputError(
      fmt::format("{}: uncertainties: '{}' is overridden by '{}'; allowed: an override in plain SI numbers",
                  experiment.name, value.path, stated->second));
}

double uniform(std::uint64_t seed, std::uint64_t index) {
  return static_cast<double>(task_seed(seed, index) >> 11) * 0x1.0p-53;
}

/// Sets one draw as overrides and returns it by pattern (a factor where it is relative).
std::map<std::string, double> draw(const Experiment& experiment,
                                   const std::map<std::string, std::vector<ModelValue>>& values, std::uint64_t seed,
                                   Dataset& setup) {
  std::map<std::string, double> drawn;
  std::uint64_t index = 0;
  for (const auto& [pattern, spread] : experiment.uncertainties) {
    const double u = uniform(seed, ++index), w = uniform(seed, ++index);
    const double normal = std::sqrt(-2.0 * std::log(1.0 - u)) * std::cos(6.283185307179586 * w);
    for (const ModelValue& value : values.at(pattern)) {
      const double nominal = nominal_of(experiment, value);
      double to = spread.relative ? nominal * (1.0 + spread.deviation * normal) : nominal + spread.deviation * normal;
      if (spread.range) to = spread.range->lower + u * (spread.range->upper - spread.range->lower);
      setup.overrides[value.path] = fmt::format("{}", to);
      drawn[value.path] = to;
    }
  }
  return drawn;
}

}  // namespace

LeapFigures leap_figures(const Experiment& experiment, const PlanarModel& model, const TrialRun& run) {
  LeapFigures figures;
  figures.duration = command_duration(experiment.setup);
  if (const Stream* mocap = run.trial.stream("mocap"); mocap != nullptr && mocap->channel("x") >= 0) {
    figures.recipe =
        leap_speed(mocap->time, mocap->values.row(mocap->channel("x")).transpose(), Vector(), figures.duration);
    const int x = model.coordinate_index("x");
    Vector exact(mocap->time.size());
    for (Eigen::Index k = 0; k < exact.size(); ++k)
      exact[k] = value_at(run.truth, run.truth.q.row(x), std::max(0.0, mocap->time[k]));
    figures.recipe_exact = leap_speed(mocap->time, exact, Vector(), figures.duration);
  }
  figures.plan_end = state_at(model, run.truth, figures.duration, experiment.touchdown_height);
  if (const auto time = lift_off_time(model, run.truth))
    figures.lift_off = state_at(model, run.truth, *time, experiment.touchdown_height);
  return figures;
}

std::vector<Replay> replays(const Experiment& experiment, int count, std::uint64_t seed,
                            const std::function<void(Plant&)>& apply) {
  const auto values = uncertain_values(experiment);
  std::vector<Replay> out;
  for (int i = 0; i <= count; ++i) {
    Experiment one = experiment;
    one.scatter.clear();
    one.streams.clear();
    one.duration = command_duration(experiment.setup);
    Replay replay;
    if (i > 0) replay.values = draw(experiment, values, task_seed(seed, static_cast<std::uint64_t>(i)), one.setup);
    const PlanarModel model = dataset_robot(one.setup).planar;
    Plant plant = dataset_plant(one.setup, model);
    if (apply) apply(plant);
    const TrialRun run = run_trial(one, plant, experiment_controller(one, model), 0, 0);
    replay.margins = margins_of(one, plant, run.truth);
    out.push_back(std::move(replay));
  }
  return out;
}

}  // namespace jaculus
