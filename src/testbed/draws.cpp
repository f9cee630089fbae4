#include "testbed/draws.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "jaculus/model/robot.h"

namespace jaculus::testbed {
namespace {

double uniform(Random& random, double from, double to) {
  return std::uniform_real_distribution<double>(from, to)(random);
}

template <class Value>
Value one_of(Random& random, const std::vector<Value>& values) {
  return values[std::uniform_int_distribution<std::size_t>(0, values.size() - 1)(random)];
}

/// Numbers beside the strength, and the side of a strength that may go both ways.
Dose draw_dose(const BenchEffect& effect, Random& random, double& end) {
  Dose dose{&effect, usual_values(effect)};
  const BenchParameter& first = effect.parameters.front();
  const bool both = first.lower < first.usual && first.usual < first.upper;
  const bool up = both ? uniform(random, 0.0, 1.0) < 0.5 : first.upper > first.usual;
  end = up ? first.upper : first.lower;
  if (effect.name == "payload" || effect.name == "leg_offset" || effect.name == "controller_gains") {
    for (std::size_t i = 1; i < dose.values.size(); ++i) {
      const BenchParameter& p = effect.parameters[i];
      dose.values[i] = effect.name == "payload" ? uniform(random, p.lower, p.upper) : dose.values[i];
    }
  }
  return dose;
}

}  // namespace

std::vector<Stage> all_stages(const std::vector<std::filesystem::path>& plans) {
  std::vector<Stage> stages;
  for (const std::filesystem::path& plan : plans) {
    const bool tail = read_csv(plan).column("tail") >= 0;
    const auto robot = find_robot(tail ? "minitaur_tail" : "minitaur", std::filesystem::current_path() / "robot");
    for (const std::string quantity : {"torque", "duty"}) {
      stages.push_back(
          {fmt::format("leap {} {}", plan.filename().string(), quantity), leap(robot, plan, quantity), tail});
    }
  }
  const auto robot = find_robot("minitaur_tail", std::filesystem::current_path() / "robot");
  stages.push_back({"self_righting", self_righting(robot), true});
  stages.push_back({"tail_bench", tail_bench(robot), true});
  return stages;
}

bool can_act(const BenchEffect& effect, const Stage& stage) {
  const std::string& n = effect.name;
  const bool about_tail = n.starts_with("tail_") || n.starts_with("drag_") || n == "wind";
  if (about_tail && !stage.tail) return false;
  return std::find(effect.experiments.begin(), effect.experiments.end(), stage.asked.experiment) !=
         effect.experiments.end();
}

TrialSpec draw_trials(Random& random, const Stage& stage) {
  TrialSpec spec;
  spec.trials = std::uniform_int_distribution<int>(3, 8)(random);
  SensorSpec& s = spec.sensors;
  s.mocap_rate_hz = one_of<double>(random, {120.0, 240.0, 360.0});
  const double quality = one_of<double>(random, {0.7, 1.0, 1.5});
  s.mocap_position *= quality;
  s.mocap_angle *= quality;
  s.mocap_lost = one_of<double>(random, {0.0, 0.0, 0.03});
  s.joints = stage.asked.experiment == "tail_bench" || uniform(random, 0.0, 1.0) < 0.8;
  s.joints_rate_hz = one_of<double>(random, {250.0, 500.0, 1000.0});
  s.rates = uniform(random, 0.0, 1.0) < 0.7;
  s.electric = uniform(random, 0.0, 1.0) < 0.5;
  s.imu = stage.asked.experiment != "tail_bench" && uniform(random, 0.0, 1.0) < 0.3;
  spec.pose_scatter = one_of<double>(random, {1e-3, 2e-3, 4e-3});
  spec.seed = random();
  return spec;
}

std::optional<Dataset> exact_run(const Stage& stage, const Changes& changes, const TrialSpec& spec) {
  TrialSpec exact = spec;
  exact.exact = true;
  exact.trials = 1;
  exact.after = 0.0;  // a gap counts where the robot is commanded, which is what a diagnosis sees
  try {
    return run_trials(stage.asked, changes, exact);
  } catch (const std::runtime_error&) {
    return std::nullopt;  // the robot is lost: no such case
  }
}

std::optional<Dose> find_dose(const BenchEffect& effect, const Stage& stage, const TrialSpec& spec,
                              const Dataset& nominal, double target, Random& random, double& reached) {
  double end = 0.0;
  Dose dose = draw_dose(effect, random, end);
  const double usual = effect.parameters.front().usual;
  const double least = std::abs(effect.parameters.front().lower - usual) *
                       (end > usual && effect.parameters.front().lower > usual ? 1.0 : 0.0);
  const auto gap_at = [&](double share) {
    dose.values[0] = usual + share * (end - usual);
    Changes changes;
    effect.apply(dose.values, changes);
    const std::optional<Dataset> run = exact_run(stage, changes, spec);
    return run ? gap(nominal, *run, spec.sensors) : kInfinity;
  };
  if (effect.parameters.front().lower == effect.parameters.front().upper) {
    reached = gap_at(1.0);
    return dose;
  }
  // Bisection on the logarithm of the share; the gap need not be proportional to it (limits, slipping feet).
  double low = std::max(1e-3, std::abs(end - usual) > 0.0 ? least / std::abs(end - usual) : 1e-3), high = 1.0;
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
