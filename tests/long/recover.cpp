// Gives every effect of the catalogue back? For each, in the shipped experiment that excites it:
// data of the plant at realistic noise, diagnosed against the whole catalogue once, and against it
// alone in every replicate to see how often the 95 % interval holds the truth. The first parameter
// is half its probing step from nominal, and twice as far, up to eight times, while that is lost in
// the experiment's noise; the strength taken is printed. A new entry is walked unasked.
//   recover [REPLICATES [EFFECT...]]

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <map>

#include "diagnosis/build_problem.h"
#include "jaculus/core/installation.h"
#include "jaculus/core/tasks.h"
#include "jaculus/diagnosis/diagnose.h"
#include "jaculus/effects/effect.h"
#include "jaculus/effects/select.h"
#include "jaculus/simulation/experiment.h"

namespace jaculus {
namespace {

using trajectory::ExperimentKind;

const std::map<ExperimentKind, std::string> kExperiments = {
    {ExperimentKind::leap, "leap_trials"},
    {ExperimentKind::self_righting, "drop_trials"},
    {ExperimentKind::tail_bench, "bench_trials"},
    {ExperimentKind::pendulum, "pendulum_trials"}};

struct Walk {
  const effects::Effect* effect;
  std::string problem;
  double share = 0.5;  ///< of the probing step
};

std::vector<Walk> walks(const std::vector<std::string>& wanted) {
  std::vector<Walk> list;
  for (const effects::Effect& effect : effects::effect_catalogue()) {
    if (!wanted.empty() && std::find(wanted.begin(), wanted.end(), effect.name) == wanted.end())
      continue;
    for (const ExperimentKind by : effect.excited_by) {
      const std::string file =
          source_folder().string() + "/problems/" + kExperiments.at(by) + ".yaml";
      if (!effect.applies(
              simulation::dataset_robot(simulation::read_experiment(file).setup).planar))
        continue;
      list.push_back({&effect, file});
      break;
    }
  }
  return list;
}

Vector truth_of(const Walk& walk) {
  const effects::Effect& effect = *walk.effect;
  const Bounds& bounds = effect.parameters.front().bounds;
  Vector theta = effect.probed();
  theta[0] = std::clamp(effect.nominal()[0] + walk.share * (theta[0] - effect.nominal()[0]),
                        bounds.lower, bounds.upper);
  return theta;
}

trajectory::Dataset data_of(const Walk& walk, int replicate) {
  const simulation::Experiment experiment = simulation::read_experiment(walk.problem);
  const model::Robot robot = simulation::dataset_robot(experiment.setup);
  simulation::Plant plant = simulation::dataset_plant(experiment.setup, robot.planar);
  walk.effect->apply(truth_of(walk), plant);
  const simulation::Controller controller =
      simulation::experiment_controller(experiment, robot.planar);
  trajectory::Dataset dataset = experiment.setup;
  for (int k = 0; k < experiment.trials; ++k)
    dataset.trials.push_back(simulation::run_trial(experiment, plant, controller, k,
                                                   static_cast<std::uint64_t>(replicate) + 1)
                                 .trial);
  return dataset;
}

/// Whether the interval of the first parameter holds the truth; nothing where the effect was not
/// stated.
std::optional<bool> covered(const Walk& walk, const diagnosis::Diagnosis& diagnosis) {
  for (const diagnosis::FoundEffect& found : diagnosis.effects) {
    if (found.name != walk.effect->name) continue;
    const effects::EffectParameter& own = walk.effect->parameters.front();
    return found.parameters.front().ci95.contains(effects::shown_value(own, truth_of(walk)[0]));
  }
  return std::nullopt;
}

/// "first", "in its class" (equivalents by the sensitivities named with it, or an ambiguous verdict
/// that holds it), else the verdict.
std::string standing(const Walk& walk, const diagnosis::Diagnosis& diagnosis) {
  for (const diagnosis::FoundEffect& found : diagnosis.effects) {
    if (found.name == walk.effect->name)
      return &found == &diagnosis.effects.front() ? "first" : "in its class";
    if (std::find(found.indistinguishable.begin(), found.indistinguishable.end(),
                  walk.effect->name) != found.indistinguishable.end())
      return "in its class";
  }
  std::string text = diagnosis::to_text(diagnosis.verdict);
  for (const diagnosis::FoundEffect& found : diagnosis.effects) text += " " + found.name;
  return text;
}

std::string report(Walk walk, int replicates) {
  diagnosis::DiagnoseOptions alone;
  alone.effects = {walk.effect};
  const auto by_itself = [&](int replicate) {  // without where the gap lies, which takes longest
    return diagnosis::diagnose_problem(
        *diagnosis::build_problem({data_of(walk, replicate)}, alone).problem, alone);
  };
  while (walk.share < 4.0 && !covered(walk, by_itself(0))) walk.share *= 2.0;
  const std::string place = standing(walk, diagnosis::diagnose({data_of(walk, 0)}));
  int held = 0, stated = 0;
  for (int r = 0; r < replicates; ++r) {
    const auto in = covered(walk, by_itself(r));
    stated += in.has_value() ? 1 : 0;
    held += in.value_or(false) ? 1 : 0;
  }
  return fmt::format("{:<28} {:<24} {:<34} covered {:>3} of {:>3} stated, {} replicates",
                     walk.effect->name,
                     fmt::format("{} {:.4g} {}", walk.effect->parameters.front().name,
                                 truth_of(walk)[0], walk.effect->parameters.front().unit),
                     place, held, stated, replicates);
}

}  // namespace
}  // namespace jaculus

int main(int argc, char** argv) {
  using namespace jaculus;
  const int replicates = argc > 1 ? std::atoi(argv[1]) : 20;
  const std::vector<Walk> list = walks({argv + std::min(argc, 2), argv + argc});
  TaskOptions options;
  const auto task = [&](int i) { return report(list[i], replicates); };
  for (const TaskResult& result : run_tasks(count_of(list), task, options))
    fmt::print("{}\n", result.state == TaskState::done ? result.bytes : "failed: " + result.error);
  return 0;
}
