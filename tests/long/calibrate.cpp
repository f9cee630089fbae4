// Is the posterior right? Simulation-based calibration (Talts et al. 2018) of ten effects: their
// parameters drawn from the prior, data simulated with them by the plant, the posterior of that
// effect alone by the code that selection uses (the most probable parameters, and their normal
// distribution in scaled coordinates within the bounds), and the rank of the true first parameter
// among 99 draws from it. Goes on from its journal where it was interrupted.
//   calibrate FOLDER [REPLICATES [EFFECT...]]

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "diagnosis/build_problem.h"
#include "evaluation/rank_statistics.h"
#include "jaculus/core/installation.h"
#include "jaculus/core/tasks.h"
#include "jaculus/effects/effect.h"
#include "jaculus/simulation/experiment.h"

namespace jaculus {
namespace {

constexpr int kDraws = 99, kBins = 10;

/// An effect, and an experiment that is cheap and shows it.
struct Calibrated {
  std::string effect, experiment;
};

const std::vector<Calibrated>& all_calibrated() {
  static const std::vector<Calibrated> list = {{"joint_coulomb_friction", "pendulum_trials"},
                                               {"joint_viscous_friction", "pendulum_trials"},
                                               {"joint_load_friction", "pendulum_trials"},
                                               {"joint_rotor_inertia", "pendulum_trials"},
                                               {"link_mass", "pendulum_trials"},
                                               {"tail_coulomb_friction", "bench_trials"},
                                               {"tail_viscous_friction", "bench_trials"},
                                               {"tail_rotor_inertia", "bench_trials"},
                                               {"torque_constant", "bench_trials"},
                                               {"drag_coefficient", "bench_trials"}};
  return list;
}

/// Parameters from the effect's prior.
Vector from_prior(const effects::Effect& effect, std::mt19937_64& random) {
  Vector scale(count_of(effect.parameters));
  std::vector<Bounds> ranges;
  for (int i = 0; i < count_of(effect.parameters); ++i) {
    scale[i] = effect.parameters[i].scale;
    ranges.push_back(effect.parameters[i].bounds);
  }
  return evaluation::bounded_normal(effect.nominal(), scale.asDiagonal(), ranges, random);
}

trajectory::Dataset data_with(const effects::Effect& effect, const Vector& theta,
                              const std::string& name, std::uint64_t seed) {
  const simulation::Experiment experiment =
      simulation::read_experiment(source_folder().string() + "/problems/" + name + ".yaml");
  const model::Robot robot = simulation::dataset_robot(experiment.setup);
  simulation::Plant plant = simulation::dataset_plant(experiment.setup, robot.planar);
  effect.apply(theta, plant);
  const simulation::Controller controller =
      simulation::experiment_controller(experiment, robot.planar);
  trajectory::Dataset dataset = experiment.setup;
  for (int k = 0; k < experiment.trials; ++k)
    dataset.trials.push_back(simulation::run_trial(experiment, plant, controller, k, seed).trial);
  return dataset;
}

/// Rank of the truth among draws of the posterior; -1 where there is no posterior.
int rank_of(const diagnosis::Problem& problem, const diagnosis::Fit& fit, const Vector& theta,
            std::mt19937_64& random) {
  std::vector<Bounds> ranges;
  for (const int i : fit.free) {
    const diagnosis::FreeParameter& p = problem.hypotheses.parameters[i];
    ranges.push_back(
        {(p.bounds.lower - p.nominal) / p.scale, (p.bounds.upper - p.nominal) / p.scale});
  }
  const Vector u = problem.hypotheses.scaled(fit.free, fit.p);
  const Vector mean = u - fit.covariance * (fit.jacobian.transpose() * fit.residual + u);
  const Eigen::LLT<Matrix> factor(fit.covariance);
  if (factor.info() != Eigen::Success) return -1;
  const Matrix root = factor.matrixL();

  const diagnosis::FreeParameter& first = problem.hypotheses.parameters[fit.free.front()];
  const double truth = (theta[0] - first.nominal) / first.scale;
  int rank = 0;
  for (int k = 0; k < kDraws; ++k) {
    const Vector draw = evaluation::bounded_normal(mean, root, ranges, random);
    if (draw.size() == 0) return -1;
    rank += draw[0] < truth ? 1 : 0;
  }
  return rank;
}

int replicate(const Calibrated& calibrated, std::uint64_t seed) {
  const effects::Effect& effect = *effects::find_effect(calibrated.effect);
  std::mt19937_64 random(seed);
  const Vector theta = from_prior(effect, random);

  diagnosis::DiagnoseOptions alone;
  alone.effects = {&effect};
  const trajectory::Dataset data =
      data_with(effect, theta, calibrated.experiment, 1 + seed % 1000000007);
  const diagnosis::Prepared prepared =
      diagnosis::prepare(diagnosis::build_problem({data}, alone), diagnosis::builder_of(alone));
  if (!prepared.reasons.empty() || prepared.built.problem->hypotheses.candidates.empty()) return -1;
  const diagnosis::Problem& problem = *prepared.built.problem;
  diagnosis::Comparison comparison = diagnosis::first_comparison(problem, prepared.noise);
  const diagnosis::Fit first =
      diagnosis::fit_members(problem, comparison.whitening, comparison.noise.p, {0});
  if (!first.valid) return -1;
  const diagnosis::Fit fit = diagnosis::relinearise(problem, std::move(comparison), first).fit;
  return fit.valid ? rank_of(problem, fit, theta, random) : -1;
}

void print_effect(const Calibrated& calibrated, const std::vector<int>& ranks, int failed) {
  const evaluation::RankStatistics s = evaluation::rank_statistics(ranks, kDraws, kBins);
  fmt::print(
      "{:<24} {:>4} ranks, {} without  [{}]  chi2 {:6.2f}, p {:.4f}  ecdf {:.3f} of {:.3f}\n",
      calibrated.effect, s.count, failed, fmt::join(s.histogram, " "), s.chi2, s.probability,
      s.ecdf, s.band);
}

std::vector<Calibrated> chosen(const std::vector<std::string>& wanted) {
  std::vector<Calibrated> list;
  for (const Calibrated& one : all_calibrated())
    if (wanted.empty() || std::find(wanted.begin(), wanted.end(), one.effect) != wanted.end())
      list.push_back(one);
  return list;
}

int run_all(const std::filesystem::path& folder, int replicates,
            const std::vector<Calibrated>& list) {
  std::filesystem::create_directories(folder);
  TaskOptions options;
  options.journal = folder / "calibrate.journal";
  options.fingerprint = version();
  for (const Calibrated& one : list) options.fingerprint += " " + one.effect;
  options.time_limit_s = 120.0;
  options.notice = [](const std::string& text) { fmt::print(stderr, "{}\n", text); };
  const auto task = [&](int i) {
    const auto seed = task_seed(1, static_cast<std::uint64_t>(i));
    return fmt::format("{}", replicate(list[i / replicates], seed));
  };
  const std::vector<TaskResult> results = run_tasks(count_of(list) * replicates, task, options);

  for (int e = 0; e < count_of(list); ++e) {
    std::vector<int> ranks;
    int failed = 0;
    for (int r = 0; r < replicates; ++r) {
      const TaskResult& result = results[e * replicates + r];
      if (result.state == TaskState::cancelled) return 1;
      const int rank = result.state == TaskState::done ? std::stoi(result.bytes) : -1;
      if (rank < 0) ++failed;
      if (rank >= 0) ranks.push_back(rank);
    }
    print_effect(list[e], ranks, failed);
  }
  return 0;
}

}  // namespace
}  // namespace jaculus

int main(int argc, char** argv) {
  if (argc < 2) {
    fmt::print(stderr, "calibrate FOLDER [REPLICATES [EFFECT...]]\n");
    return 2;
  }
  const int replicates = argc > 2 ? std::atoi(argv[2]) : 100;
  const auto list = jaculus::chosen({argv + std::min(argc, 3), argv + argc});
  if (replicates < 1 || list.empty()) {
    fmt::print(stderr, "calibrate: no replicate or effect; allowed: 1 or more, and effects of:\n");
    for (const auto& one : jaculus::all_calibrated()) fmt::print(stderr, "  {}\n", one.effect);
    return 2;
  }
  return jaculus::run_all(argv[1], replicates, list);
}
