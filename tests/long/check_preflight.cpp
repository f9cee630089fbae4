// Does a preflight hold? Random experiments of shipped robots; of each, pairs of effects that its
// preflight calls tellable or not, drawn at random, are simulated with one of the two at work as
// stated and diagnosed. Candidates are the two alone: what is judged is whether these data tell
// this pair, and with the whole catalogue a third effect could lead. Without where the gap lies.
//   check_preflight [EXPERIMENTS [FIRST_SEED [PAIRS]]]
// Measures, fixed before the first run:
//   told apart      the verdict names the effect at work and the other neither beside it nor among
//                   what can't be told from it; wanted in 0.9 of what is called tellable
//   ambiguous       the verdict `ambiguous`; wanted in 0.8 of what is called not tellable
//   taken           names the other and not the effect at work; of pairs of which one passes for
//                   the other
// PAIRS (2) of each kind an experiment at most, with the way round to which the kind belongs; told
// ways are those of pairs that are tellable either way. 95 % intervals by Wilson.

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>

#include "diagnosis/build_problem.h"
#include "diagnosis/preflight/simulated_data.h"
#include "evaluation/estimates.h"
#include "jaculus/core/installation.h"
#include "jaculus/core/tasks.h"
#include "jaculus/diagnosis/diagnose.h"
#include "jaculus/diagnosis/preflight.h"
#include "jaculus/effects/select.h"
#include "simulation/experiment/random.h"

namespace jaculus {
namespace {

using diagnosis::PlannedPair;
using simulation::Experiment;
using simulation::Random;

int pick(Random& random, int count) {
  return std::min(count - 1, static_cast<int>(random.uniform() * count));
}

/// A shipped experiment on scripts, with another script of random levels within its largest values,
/// random length, two to five trials and a random part of its sensors.
Experiment random_experiment(int seed) {
  static const std::vector<std::string> files = {"pendulum_trials", "double_pendulum_trials",
                                                 "slider_trials", "bench_trials"};
  Random random(task_seed(static_cast<std::uint64_t>(seed), 1));
  const std::string name = files[pick(random, count_of(files))];
  Experiment experiment =
      simulation::read_experiment(source_folder() / "problems" / (name + ".yaml"));
  experiment.name = fmt::format("{}_{}", name, seed);
  experiment.seed = 1000 + seed;
  experiment.trials = 2 + pick(random, 4);

  trajectory::InputScript& script = *experiment.setup.script;
  const Vector largest = script.values.cwiseAbs().rowwise().maxCoeff();
  const int levels = 3 + pick(random, 6);
  const double length =
      (0.6 + 0.8 * random.uniform()) * simulation::command_duration(experiment.setup);
  experiment.duration = length + 0.1;
  script.time = Vector::LinSpaced(levels + 1, 0.0, length);
  script.values = Matrix::Zero(largest.size(), levels + 1);
  for (Eigen::Index j = 0; j < largest.size(); ++j)
    for (int k = 0; k < levels; ++k)
      script.values(j, k) = (2.0 * random.uniform() - 1.0) * largest[j];

  std::vector<std::string>& channels = experiment.streams.front().channels;
  for (int c = count_of(channels) - 1; c >= 0 && channels.size() > 1; --c)
    if (random.uniform() < 0.3) channels.erase(channels.begin() + c);
  return experiment;
}

/// A pair and the way round.
struct Case {
  std::string at_work, rival;
  diagnosis::Telling called{};
  double expected = kNaN;  ///< log Bayes factor
};

/// `most` cases of each kind at most.
std::vector<Case> draw_cases(const diagnosis::Preflight& preflight, Random& random, int most) {
  using diagnosis::Telling;
  std::vector<Case> ways;
  for (const PlannedPair& pair : preflight.pairs) {
    ways.push_back({pair.a, pair.b, pair.with_a, pair.told_a});
    ways.push_back({pair.b, pair.a, pair.with_b, pair.told_b});
    for (int k = 0; k < 2; ++k)  // one way of a pair that is not tellable
      if (!pair.tellable && ways[ways.size() - 1 - k].called == Telling::told)
        ways[ways.size() - 1 - k].called = Telling::not_judged;
  }

  std::vector<Case> drawn;
  for (const Telling kind : {Telling::told, Telling::ambiguous, Telling::taken}) {
    std::vector<Case> own;
    for (const Case& way : ways)
      if (way.called == kind) own.push_back(way);
    for (int i = 0; i < most && !own.empty(); ++i) {
      const int chosen = pick(random, count_of(own));
      drawn.push_back(own[chosen]);
      own.erase(own.begin() + chosen);
    }
  }
  return drawn;
}

/// An effect as this robot has it, at the size that a preflight states.
effects::EffectValue stated_effect(const diagnosis::Preflight& preflight,
                                   const model::PlanarModel& model, const std::string& name) {
  for (const diagnosis::PlannedEffect& e : preflight.effects)
    if (e.name == name)
      return effects::read_effect(fmt::format("{}:{}={:.17g}", name, e.parameter, e.stated), model,
                                  "check_preflight");
  throw std::logic_error(name + " is not in the preflight");
}

diagnosis::Diagnosis diagnosed(const Experiment& experiment, const effects::EffectValue& truth,
                               const effects::EffectValue& rival) {
  Experiment done = experiment;
  done.seed += 5000;  // other noise than the preflight's
  const auto data = diagnosis::simulated_data(done, {{truth.effect.get()}, {truth.theta}});
  if (!data) throw std::runtime_error("the plant is lost");
  diagnosis::DiagnoseOptions options;
  options.effects = {truth.effect.get(), rival.effect.get()};
  return diagnosis::diagnose_problem(*diagnosis::build_problem({*data}, options).problem, options);
}

/// Whether the verdict names the first and not the second, nor can't tell it from that.
bool names_alone(const std::string& first, const std::string& second,
                 const diagnosis::Diagnosis& diagnosis) {
  bool found = false;
  for (const diagnosis::FoundEffect& effect : diagnosis.effects) {
    if (effect.name == second || index_of(effect.indistinguishable, second) >= 0) return false;
    found = found || effect.name == first;
  }
  return found;
}

bool as_called(const Case& way, const diagnosis::Diagnosis& diagnosis) {
  if (way.called == diagnosis::Telling::told) return names_alone(way.at_work, way.rival, diagnosis);
  if (way.called == diagnosis::Telling::taken)
    return names_alone(way.rival, way.at_work, diagnosis);
  return diagnosis.verdict == diagnosis::Verdict::ambiguous;
}

/// A line a case: kind, whether it came as it was called, and what it was.
std::string check(int seed, int most) {
  const Experiment experiment = random_experiment(seed);
  diagnosis::PreflightOptions options;
  options.alternatives = false;
  const diagnosis::Preflight preflight = diagnosis::preflight(experiment, options);
  if (!preflight.reasons.empty()) return fmt::format("skipped {}\n", preflight.reasons.front());

  const model::PlanarModel model = simulation::dataset_robot(experiment.setup).planar;
  Random random(task_seed(static_cast<std::uint64_t>(seed), 2));
  std::string lines;
  for (const Case& pair : draw_cases(preflight, random, most)) {
    const diagnosis::Diagnosis answer =
        diagnosed(experiment, stated_effect(preflight, model, pair.at_work),
                  stated_effect(preflight, model, pair.rival));
    lines +=
        fmt::format("{} {} {:<28} {:<26} {:<26} expected {:7.1f} verdict {}", name_of(pair.called),
                    as_called(pair, answer) ? "right" : "WRONG", experiment.name, pair.at_work,
                    pair.rival, pair.expected, diagnosis::to_text(answer.verdict));
    for (const diagnosis::FoundEffect& effect : answer.effects) lines += " " + effect.name;
    lines += "\n";
  }
  return lines;
}

int occurrences(const std::string& text, const std::string& part) {
  int count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1))
    ++count;
  return count;
}

void print_share(const std::string& lines, const std::string& kind, const std::string& what) {
  const int right = occurrences(lines, "\n" + kind + " right");
  const int all = right + occurrences(lines, "\n" + kind + " WRONG");
  const auto share = evaluation::proportion(right, all);
  fmt::print("{}: {} of {} {}, {:.2f} [{:.2f}, {:.2f}]\n", kind, right, all, what, share.value,
             share.ci95.lower, share.ci95.upper);
}

}  // namespace
}  // namespace jaculus

int main(int argc, char** argv) {
  using namespace jaculus;
  const int experiments = argc > 1 ? std::atoi(argv[1]) : 40;
  const int first = argc > 2 ? std::atoi(argv[2]) : 1;
  const int most = argc > 3 ? std::atoi(argv[3]) : 2;
  std::string lines = "\n";
  const auto task = [&](int i) { return check(first + i, most); };
  for (const TaskResult& result : run_tasks(experiments, task, TaskOptions{}))
    lines += result.state == TaskState::done ? result.bytes : "failed " + result.error + "\n";
  fmt::print("{}", lines.substr(1));
  print_share(lines, "told", "told apart");
  print_share(lines, "ambiguous", "ambiguous");
  print_share(lines, "taken", "taken for the other");
  return 0;
}
