#include "testbed/case_draws.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <set>
#include <stdexcept>

#include "jaculus/core/error.h"
#include "testbed/noise_floor.h"
#include "testbed/static_tests.h"

namespace jaculus::testbed {
namespace {

using Names = std::vector<std::string>;

constexpr int kAttempts = 100;       ///< draws until a case comes out that shows
constexpr double kApart = 0.02;      ///< rad, from which left and right legs part
constexpr double kLeastShown = 0.7;  ///< noise floors that a case shows
constexpr double kMostDrawn = 20.0;  ///< noise floors of one effect

/// Whether effects make left and right diverge by themselves, or there is none.
bool may_diverge(const Names& effects) {
  static const std::set<std::string> kOneSided = {"bent_leg", "command_dropout", "thermal_derating",
                                                  "slipping_belt"};
  return std::all_of(effects.begin(), effects.end(),
                     [](const std::string& name) { return kOneSided.contains(name); });
}

/// What has been drawn of one case so far.
struct Draft {
  CaseLabel label;
  Changes changes;
  std::vector<Dose> doses;
};

/// Draws how strong each effect is on a stage and what is true of it; false where one doesn't show.
bool draw_doses(Random& random, const Stage& stage, const Names& effects, const TrialSpec& spec,
                const trajectory::Dataset& nominal, Draft& draft) {
  for (const std::string& name : effects) {
    const BenchEffect& effect = *acting_effect(stage, name);
    const double target =
        std::exp(std::uniform_real_distribution<double>(0.0, std::log(kMostDrawn))(random));
    double reached = 0.0;
    const std::optional<Dose> dose =
        find_dose(effect, stage, spec, nominal, target, random, reached);
    if (!dose) return false;

    effect.apply(dose->values, draft.changes);
    Changes alone;
    effect.apply(dose->values, alone);
    draft.doses.push_back(*dose);
    draft.label.strengths.push_back(reached);
    if (effect.event) draft.label.events.push_back(event_of(*dose, commands_end(stage)));
    if (draft.label.kind == "mixed" && effect.outside) {
      draft.label.beside.push_back(name);
      continue;
    }
    draft.label.effects.push_back(name);
    draft.label.parameters.push_back(measured_parameters(name, dose->values, stage.robot, alone));
  }
  return true;
}

/// One dataset of a case, to be played.
struct Plan {
  int stage = -1;
  TrialSpec spec;
  trajectory::Dataset nominal;  ///< its noise-free run without any effect
};

/// A plan on a stage; nothing where the robot is lost there. `earlier`: a plan whose robot
/// this one has.
std::optional<Plan> draw_plan(Random& random, const Grounds& grounds, int stage,
                              const Plan* earlier) {
  Plan plan{stage, draw_trials(random, grounds.stages[stage], grounds.clutter), {}};
  if (earlier != nullptr) plan.spec.clutter_seed = earlier->spec.clutter_seed;
  std::optional<trajectory::Dataset> nominal =
      exact_run(grounds.stages[stage], Changes{}, plan.spec);
  if (!nominal) return std::nullopt;
  plan.nominal = std::move(*nominal);
  return plan;
}

/// What a case shows in one of its datasets, beyond what clocks and starts may do [noise floors];
/// 0 where the robot is lost.
double shown(const Grounds& grounds, const Plan& plan, const Changes& changes) {
  const Stage& stage = grounds.stages[plan.stage];
  const std::optional<trajectory::Dataset> changed = exact_run(stage, changes, plan.spec);
  if (!changed) return 0.0;
  return gap(plan.nominal, *changed, plan.spec.sensors, stage.robot) *
         share_beyond_nuisances(stage, grounds.signatures[plan.stage], plan.spec, plan.nominal,
                                *changed);
}

/// Effects that none of the datasets tells from the true one.
Names common_equivalents(const Grounds& grounds, const std::vector<Plan>& plans,
                         const Dose& truth) {
  Names common;
  for (const Plan& plan : plans) {
    const Names found = equivalents(grounds.stages[plan.stage], grounds.signatures[plan.stage],
                                    plan.spec, plan.nominal, truth);
    if (&plan == &plans.front()) common = found;
    std::erase_if(common, [&](const std::string& name) {
      return std::find(found.begin(), found.end(), name) == found.end();
    });
  }
  return common;
}

/// Plays a case's datasets.
MadeCase play_plans(const Grounds& grounds, const std::vector<Plan>& plans, const Draft& draft) {
  MadeCase made{draft.label, {}};
  CaseLabel& label = made.label;
  label.datasets = count_of(plans);
  for (const Plan& plan : plans) {
    const Stage& stage = grounds.stages[plan.stage];
    double apart = 0.0;
    made.datasets.push_back(run_trials(stage.asked, draft.changes, plan.spec, &apart));
    made.datasets.back().provenance = "a blinded case of the MuJoCo testbed";
    label.legs_apart = std::max(label.legs_apart, apart);
    label.experiment += (label.experiment.empty() ? "" : " + ") + stage.name;
    label.trials += plan.spec.trials;
  }
  return made;
}

/// One attempt; nothing where an effect doesn't show on the stage that was drawn, or where left and
/// right legs diverge though no effect is one-sided, so that there is more than was drawn: those
/// are listed.
std::optional<MadeCase> attempt(Random& random, const CaseKind& kind, const Grounds& grounds,
                                Names& diverged) {
  const Names effects = draw_effects(random, kind, grounds);
  const std::vector<int> stages = draw_stages(random, kind, grounds, effects);
  std::vector<Plan> plans;
  for (const int stage : stages) {
    const std::optional<Plan> plan =
        draw_plan(random, grounds, stage, plans.empty() ? nullptr : &plans.front());
    if (!plan) return std::nullopt;
    plans.push_back(*plan);
  }

  Draft draft;
  draft.label.kind = kind.name;
  const Stage& first = grounds.stages[stages.front()];
  if (!draw_doses(random, first, effects, plans.front().spec, plans.front().nominal, draft))
    return std::nullopt;
  for (const Plan& plan : plans) {
    draft.label.strength_in_noise_floors =
        std::max(draft.label.strength_in_noise_floors, shown(grounds, plan, draft.changes));
  }
  if (!effects.empty() && draft.label.strength_in_noise_floors < kLeastShown) return std::nullopt;

  if (kind.name == "single" || kind.name == "mixed") {
    draft.label.component = draft.doses.front().effect->component;
    draft.label.equivalent = common_equivalents(grounds, plans, draft.doses.front());
  }
  MadeCase made = play_plans(grounds, plans, draft);
  if (made.label.legs_apart > kApart && !grounds.clutter && !may_diverge(effects)) {
    diverged.push_back(
        fmt::format("{} on {}", fmt::join(made.label.effects, " + "), made.label.experiment));
    return std::nullopt;
  }
  return made;
}

}  // namespace

TrueEvent event_of(const Dose& dose, double end) {
  const std::string& joint = dose.effect->joint;
  const double from = dose.values.at(1);
  return {joint.empty() ? "base" : joint, std::clamp(from, 0.0, end),
          std::clamp(from + dose.values.at(2), 0.0, end), dose.values.at(0)};
}

MadeCase draw_case(const CaseKind& kind, std::uint64_t seed, const Grounds& grounds) {
  Random random(seed);
  Names diverged;

  for (int i = 0; i < kAttempts; ++i) {
    // Any other failure (files that are gone, a full disk) is no draw and goes on.
    try {
      std::optional<MadeCase> made = attempt(random, kind, grounds, diverged);
      if (!made) continue;
      made->label.diverged = diverged;
      return std::move(*made);
    } catch (const LostRobot&) {  // in a noisy trial too
    } catch (const UnreachablePose&) {
    }
  }

  throw std::runtime_error(
      fmt::format("case of kind '{}': no draw of {} showed", kind.name, kAttempts));
}

}  // namespace jaculus::testbed
