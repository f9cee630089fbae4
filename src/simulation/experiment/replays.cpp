// Replays under uncertain model values, and how near they come to their limits.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "jaculus/core/error.h"
#include "jaculus/model/values.h"
#include "simulation/experiment/figures.h"
#include "simulation/experiment/random.h"
#include "simulation/experiment/uncertain_values.h"

namespace jaculus::simulation {
namespace {

double friction_share(const Plant& plant, const Simulation& s, double end) {
  constexpr double kLeast = 1.0;
  double worst = kNaN;
  for (int row = 0; row < 2 * count_of(plant.model.feet); row += 2) {
    for (Eigen::Index k = 0; k < s.time.size() && s.time[k] <= end; ++k) {
      if (!(s.force(row + 1, k) > kLeast) || plant.ground.friction <= 0.0) continue;
      const double share =
          std::abs(s.force(row, k)) / (plant.ground.friction * s.force(row + 1, k));
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
    } else if (slid != since.end() &&
               (event.kind == EventKind::stick || event.kind == EventKind::lift)) {
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
  for (int i = 0; i < count_of(plant.model.motors); ++i) {
    const model::PlanarMotor& motor = plant.model.motors[i];
    for (Eigen::Index k = 0; k < s.time.size() && s.time[k] <= end; ++k) {
      if (!motor.ideal())
        m.voltage_share = larger(m.voltage_share, std::abs(s.voltage(i, k)) / s.bus_voltage[k]);
      const double torque = std::abs(s.torque(i, k)) / (motor.gear * motor.efficiency);
      if (std::isfinite(motor.torque_limit))
        m.torque_share = larger(m.torque_share, torque / motor.torque_limit);
      if (std::isfinite(motor.current_limit))
        m.current_share = larger(m.current_share, std::abs(s.current(i, k)) / motor.current_limit);
    }
  }

  const LeapState state = state_at(plant.model, s, end, experiment.touchdown_height);
  m.landing_pitch = state.landing_pitch;
  m.speed = state.speed;
  return m;
}

/// Values that an uncertainty names, by its pattern.
using UncertainValues = std::map<std::string, std::vector<model::ModelValue>>;

/// Nominal values of everything an uncertainty names: those that the experiment's robot has, with
/// its overrides.
UncertainValues uncertain_values(const Experiment& experiment) {
  const std::vector<model::ModelValue> all =
      model::model_values(overridden_robot(experiment.setup).planar);
  UncertainValues found;

  for (const auto& [pattern, spread] : experiment.uncertainties)
    found[pattern] = values_named(pattern, all, experiment.setup.robot,
                                  {.file = experiment.name, .key = "uncertainties"});
  return found;
}

/// Sets one draw as overrides and returns it: the values themselves, by their paths.
std::map<std::string, double> draw(const Experiment& experiment, const UncertainValues& values,
                                   std::uint64_t seed, trajectory::Dataset& setup) {
  std::map<std::string, double> drawn;
  Random random(seed);
  for (const auto& [pattern, spread] : experiment.uncertainties) {
    const double u = random.uniform(), w = random.uniform();
    const double normal =
        std::sqrt(-2.0 * std::log(1.0 - u)) * std::cos(2.0 * std::numbers::pi * w);
    for (const model::ModelValue& value : values.at(pattern)) {
      double to = spread.relative ? value.value * (1.0 + spread.deviation * normal)
                                  : value.value + spread.deviation * normal;
      if (spread.range) to = spread.range->lower + u * (spread.range->upper - spread.range->lower);
      setup.overrides.erase(value.alias);  // one override a value
      setup.overrides[value.path] = fmt::format("{}", to);
      setup.override_places.erase(value.path);  // what is drawn stands in no file
      drawn[value.path] = to;
    }
  }
  return drawn;
}

constexpr double Margins::*kMargins[] = {&Margins::friction_share, &Margins::slip_time,
                                         &Margins::voltage_share,  &Margins::torque_share,
                                         &Margins::current_share,  &Margins::landing_pitch,
                                         &Margins::speed};

/// Text that reads back exactly.
std::string to_text(const Margins& margins) {
  std::string text = fmt::format("{}", static_cast<int>(margins.status));
  for (const auto margin : kMargins) text += fmt::format(" {}", margins.*margin);
  return text;
}

Margins from_text(const std::string& text) {
  Margins margins;
  std::istringstream words(text);
  std::string word;
  words >> word;
  margins.status = static_cast<SimulationStatus>(std::stoi(word));
  for (const auto margin : kMargins) {
    words >> word;
    margins.*margin = std::stod(word);
  }
  return margins;
}

}  // namespace

std::vector<Replay> replays(const Experiment& experiment, int count, std::uint64_t seed,
                            const std::function<void(Plant&)>& apply, const TaskOptions& tasks) {
  const auto values = uncertain_values(experiment);
  const auto drawn = [&](int i, trajectory::Dataset& setup) {
    if (i == 0) return std::map<std::string, double>();
    return draw(experiment, values, task_seed(seed, i), setup);
  };

  const auto play = [&](int i) {
    Experiment one = experiment;
    one.scatter.clear();
    one.streams.clear();
    one.duration = command_duration(experiment.setup);
    drawn(i, one.setup);
    const model::PlanarModel model = dataset_robot(one.setup).planar;
    Plant plant = dataset_plant(one.setup, model);
    if (apply) apply(plant);
    const TrialRun run = run_trial(one, plant, experiment_controller(one, model), 0, 0);
    return to_text(margins_of(one, plant, run.truth));
  };

  const std::vector<TaskResult> results = run_tasks(count + 1, play, tasks);
  std::vector<Replay> out;
  for (int i = 0; i <= count; ++i) {
    if (results[i].state == TaskState::cancelled) break;
    if (results[i].state == TaskState::failed)
      throw InputError(fmt::format("{}: replay {}: {}", experiment.name, i, results[i].error));
    trajectory::Dataset setup = experiment.setup;
    out.push_back({drawn(i, setup), from_text(results[i].bytes)});
  }
  return out;
}

}  // namespace jaculus::simulation
