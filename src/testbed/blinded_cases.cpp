#include "jaculus/testbed/blinded_cases.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>

#include "jaculus/core/error.h"
#include "jaculus/core/interrupt.h"
#include "jaculus/core/json.h"
#include "testbed/draws.h"
#include "testbed/noise_floor.h"
#include "testbed/static_tests.h"
#include "testbed/vault.h"

namespace jaculus::testbed {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
constexpr int kAttempts = 40;    ///< draws until a case comes out that shows
constexpr double kApart = 0.02;  ///< rad, from which left and right legs no longer go together

double number(const Json& value) { return value.is_null() ? kNaN : value.get<double>(); }

Json to_json(const CaseLabel& label) {
  Json parameters = Json::array();
  for (const auto& of_one : label.parameters) {
    Json row = Json::array();
    for (const double value : of_one) row.push_back(json_number(value));
    parameters.push_back(row);
  }
  return {{"case_id", label.case_id},
          {"kind", label.kind},
          {"effects", label.effects},
          {"parameters", parameters},
          {"beside", label.beside},
          {"strengths", label.strengths},
          {"legs_apart", label.legs_apart},
          {"strength_in_noise_floors", json_number(label.strength_in_noise_floors)},
          {"parted", label.diverged},
          {"equivalent", label.equivalent},
          {"component", label.component},
          {"experiment", label.experiment},
          {"trials", label.trials}};
}

CaseLabel label_of(const Json& json) {
  CaseLabel label;
  label.case_id = json.at("case_id");
  label.kind = json.at("kind");
  label.effects = json.at("effects").get<std::vector<std::string>>();
  for (const Json& row : json.at("parameters")) {
    label.parameters.emplace_back();
    for (const Json& value : row) label.parameters.back().push_back(number(value));
  }
  label.strength_in_noise_floors = number(json.at("strength_in_noise_floors"));
  label.beside = json.value("beside", std::vector<std::string>());
  label.strengths = json.value("strengths", std::vector<double>());
  label.legs_apart = json.value("legs_apart", 0.0);
  label.diverged = json.value("parted", std::vector<std::string>());
  label.equivalent = json.at("equivalent").get<std::vector<std::string>>();
  label.component = json.at("component");
  label.experiment = json.at("experiment");
  label.trials = json.at("trials");
  return label;
}

/// How many effects a kind of case has, and whether from outside the catalogue.
std::size_t effects_in(const std::string& kind) {
  return kind == "none" ? 0 : kind == "pair" || kind == "mixed" ? 2 : 1;
}

/// Effects that may be drawn, by name, and the part where each acts.
struct Pool {
  std::vector<std::string> catalogue, outside;
  std::map<std::string, std::string> components;
};

/// What cases are drawn on: experiments, what each effect shows on them, effects to draw.
struct Grounds {
  std::vector<Stage> stages;
  std::vector<Signatures> signatures;
  Pool pool;
};

Pool pool_of(const std::vector<fs::path>& robots, const std::vector<std::string>& withheld) {
  Pool pool{effects_of(robots, false), effects_of(robots, true), {}};
  for (const std::string& name : withheld) {
    if (std::erase(pool.outside, name) > 0) continue;
    throw InputError(fmt::format("--withhold '{}': no outside effect of these robots; allowed: {}",
                                 name, fmt::join(pool.outside, ", ")));
  }
  for (const fs::path& robot : robots)
    for (const BenchEffect& effect : bench_effects(robot))
      pool.components[effect.name] = effect.component;
  return pool;
}

/// Names of the effects that are to be in a case, drawn from `pool` before anything else. Two of a
/// case act on different parts; of a mixed case the second is from outside.
std::vector<std::string> draw_effects(Random& random, const std::string& kind, const Pool& pool) {
  std::vector<std::string> drawn;
  while (drawn.size() < effects_in(kind)) {
    const bool from_outside = kind == "outside" || (kind == "mixed" && drawn.size() == 1);
    const std::vector<std::string>& names = from_outside ? pool.outside : pool.catalogue;
    const std::string& name =
        names[std::uniform_int_distribution<std::size_t>(0, names.size() - 1)(random)];
    const bool new_part = drawn.empty() || pool.components.at(drawn[0]) != pool.components.at(name);
    if (new_part) drawn.push_back(name);
  }
  return drawn;
}

struct Made {
  CaseLabel label;
  trajectory::Dataset dataset;
};

/// Whether effects make left and right diverge by themselves, or there is none.
bool may_diverge(const std::vector<std::string>& effects) {
  static const std::set<std::string> kOneSided = {"bent_leg", "command_dropout", "thermal_derating",
                                                  "slipping_belt"};
  return std::all_of(effects.begin(), effects.end(),
                     [](const std::string& name) { return kOneSided.contains(name); });
}

/// A stage, of those on which all effects can act; -1 where there is none.
int draw_stage(Random& random, const std::vector<Stage>& stages,
               const std::vector<std::string>& effects) {
  std::vector<int> fitting;
  for (int i = 0; i < count_of(stages); ++i) {
    const auto acts = [&](const std::string& name) {
      return acting_effect(stages[i], name) != nullptr;
    };
    if (std::all_of(effects.begin(), effects.end(), acts)) fitting.push_back(i);
  }

  if (fitting.empty()) return -1;
  return fitting[std::uniform_int_distribution<std::size_t>(0, fitting.size() - 1)(random)];
}

/// Draws how strong each effect is, puts them on `changes` and what is true of them into the label;
/// nothing where one doesn't show.
std::optional<std::vector<Dose>> draw_doses(Random& random, const Stage& stage,
                                            const std::vector<std::string>& effects,
                                            const TrialSpec& spec,
                                            const trajectory::Dataset& nominal, CaseLabel& label,
                                            Changes& changes) {
  std::vector<Dose> doses;
  for (const std::string& name : effects) {
    const BenchEffect& effect = *acting_effect(stage, name);
    const double target =
        std::exp(std::uniform_real_distribution<double>(0.0, std::log(20.0))(random));
    double reached = 0.0;
    const std::optional<Dose> dose =
        find_dose(effect, stage, spec, nominal, target, random, reached);
    if (!dose) return std::nullopt;

    effect.apply(dose->values, changes);
    Changes alone;
    effect.apply(dose->values, alone);
    doses.push_back(*dose);
    label.strengths.push_back(reached);
    if (label.kind == "mixed" && effect.outside) {
      label.beside.push_back(name);
      continue;
    }
    label.effects.push_back(name);
    label.parameters.push_back(measured_parameters(name, dose->values, stage.robot, alone));
  }
  return doses;
}

/// One attempt; nothing where an effect doesn't show on the stage that was drawn, or where left and
/// right legs diverge though no effect is one-sided, so that there is more than was drawn: those
/// are listed.
std::optional<Made> attempt(Random& random, const std::string& kind,
                            const std::vector<std::string>& effects, const Grounds& grounds,
                            bool clutter, std::vector<std::string>& diverged) {
  const int at = draw_stage(random, grounds.stages, effects);
  if (at < 0) return std::nullopt;
  const Stage& stage = grounds.stages[at];
  const Signatures& signatures = grounds.signatures[at];
  const TrialSpec spec = draw_trials(random, stage, clutter);
  const std::optional<trajectory::Dataset> nominal = exact_run(stage, Changes{}, spec);
  if (!nominal) return std::nullopt;

  Made made;
  made.label.kind = kind;
  Changes changes;
  const auto doses = draw_doses(random, stage, effects, spec, *nominal, made.label, changes);
  if (!doses) return std::nullopt;
  const std::optional<trajectory::Dataset> changed = exact_run(stage, changes, spec);
  if (!changed) return std::nullopt;
  made.label.strength_in_noise_floors =
      gap(*nominal, *changed, spec.sensors, stage.robot) *
      share_beyond_nuisances(stage, signatures, spec, *nominal, *changed);
  if (!effects.empty() && made.label.strength_in_noise_floors < 0.7) return std::nullopt;

  made.label.experiment = stage.name;
  made.label.trials = spec.trials;
  if (kind == "single" || kind == "mixed") {
    made.label.component = doses->front().effect->component;
    made.label.equivalent = equivalents(stage, signatures, spec, *nominal, doses->front());
  }

  made.dataset = run_trials(stage.asked, changes, spec, &made.label.legs_apart);
  if (made.label.legs_apart > kApart && !clutter && !may_diverge(effects)) {
    diverged.push_back(fmt::format("{} on {}", fmt::join(made.label.effects, " + "), stage.name));
    return std::nullopt;
  }

  made.dataset.provenance = "a blinded case of the MuJoCo testbed";
  return made;
}

/// One attempt; nothing where the robot was lost in a noisy trial too. Any other failure (files
/// that are gone, a full disk) is no draw and goes on.
std::optional<Made> attempt_or_lose(Random& random, const std::string& kind,
                                    const std::vector<std::string>& effects, const Grounds& grounds,
                                    bool clutter, std::vector<std::string>& diverged) {
  try {
    return attempt(random, kind, effects, grounds, clutter, diverged);
  } catch (const LostRobot&) {
    return std::nullopt;
  } catch (const UnreachablePose&) {
    return std::nullopt;
  }
}

std::string make_case(const BlindingSpec& spec, const std::string& id, const std::string& kind,
                      std::uint64_t seed, const Grounds& grounds) {
  Random random(seed);
  std::vector<std::string> diverged;

  for (int i = 0; i < kAttempts; ++i) {
    const auto effects = draw_effects(random, kind, grounds.pool);
    std::optional<Made> made =
        attempt_or_lose(random, kind, effects, grounds, spec.clutter, diverged);
    if (!made) continue;

    made->label.case_id = id;
    made->label.diverged = diverged;
    trajectory::write_dataset(made->dataset, spec.out / id);
    return to_json(made->label).dump();
  }

  throw std::runtime_error(fmt::format("case of kind '{}': no draw of {} showed", kind, kAttempts));
}

/// Kinds in random order, with ids that say nothing.
std::vector<std::pair<std::string, std::string>> draw_cases(const BlindingSpec& spec) {
  std::vector<std::string> kinds;
  for (const auto& [kind, count] : {std::pair{"single", spec.singles},
                                    {"none", spec.none},
                                    {"pair", spec.pairs},
                                    {"outside", spec.outside},
                                    {"mixed", spec.mixed}}) {
    kinds.insert(kinds.end(), count, kind);
  }
  Random random(task_seed(spec.seed, 0xca5e));
  std::shuffle(kinds.begin(), kinds.end(), random);
  std::set<std::string> ids;
  while (ids.size() < kinds.size()) ids.insert(fmt::format("case_{:08x}", random() & 0xffffffffU));
  std::vector<std::pair<std::string, std::string>> cases;
  auto id = ids.begin();
  for (const std::string& kind : kinds) cases.emplace_back(*id++, kind);
  return cases;
}

void check_places(const BlindingSpec& spec) {
  std::error_code code;
  if (spec.robots.empty()) throw InputError("testbed seal: no robot; allowed: one or more");
  if (fs::exists(spec.out, code) && !fs::is_empty(spec.out, code)) {
    throw InputError(fmt::format("--out {}: not empty; allowed: a new folder", spec.out.string()));
  }
  fs::create_directories(spec.out, code);
  const fs::path inside =
      fs::weakly_canonical(spec.key).lexically_relative(fs::weakly_canonical(spec.out));
  if (inside.empty() || *inside.begin() != "..") {
    throw InputError(fmt::format("--key {}: lies in the cases' folder; allowed: outside of it",
                                 spec.key.string()));
  }
}

[[noreturn]] void fail(const TaskResult& result) {
  if (result.state == TaskState::cancelled) throw std::runtime_error("interrupted");
  throw std::runtime_error(result.error);
}

/// Signatures of every stage, each run in a process of its own.
std::vector<Signatures> all_signatures(const BlindingSpec& spec, const std::vector<Stage>& stages) {
  std::vector<std::pair<std::size_t, std::string>> jobs;
  for (std::size_t s = 0; s < stages.size() && spec.singles + spec.mixed > 0; ++s) {
    for (const std::string& effect : signature_effects(stages[s])) jobs.emplace_back(s, effect);
  }

  TaskOptions options;
  options.workers = spec.jobs;
  options.progress = spec.progress;
  const auto results = run_tasks(
      count_of(jobs),
      [&](int i) {
        const auto& [stage, effect] = jobs[i];
        return signature_bytes(stages[stage], effect);
      },
      options);
  std::vector<std::vector<std::string>> bytes(stages.size());
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    if (results[i].state != TaskState::done) fail(results[i]);
    bytes[jobs[i].first].push_back(results[i].bytes);
  }

  std::vector<Signatures> out;
  for (std::size_t s = 0; s < stages.size(); ++s) out.push_back(signatures_of(stages[s], bytes[s]));
  return out;
}

}  // namespace

std::vector<std::string> blind_cases(const BlindingSpec& spec) {
  check_places(spec);
  Grounds grounds{all_stages(spec.plans, spec.robots), {}, pool_of(spec.robots, spec.withheld)};
  grounds.signatures = all_signatures(spec, grounds.stages);
  const auto cases = draw_cases(spec);
  TaskOptions options;
  options.workers = spec.jobs;
  options.progress = spec.progress;
  const auto results = run_tasks(
      count_of(cases),
      [&](int i) {
        const auto& [id, kind] = cases[i];
        return make_case(spec, id, kind, task_seed(spec.seed, i + 1), grounds);
      },
      options);
  Json labels = {
      {"format", "jaculus-sealed/1"}, {"provenance", spec.provenance}, {"cases", Json::array()}};

  std::vector<std::string> ids;
  for (std::size_t i = 0; i < results.size(); ++i) {
    if (results[i].state != TaskState::done) fail(results[i]);
    labels["cases"].push_back(Json::parse(results[i].bytes));
    ids.push_back(cases[i].first);
  }

  lock_labels(labels.dump(1), spec.out, spec.key);
  return ids;
}

std::uint64_t seed_of_commit(const std::string& hash) { return seed_of_hash(hash); }

std::vector<std::string> blinded_ids(const fs::path& folder) {
  std::error_code code;
  if (!fs::exists(folder / "labels.sealed", code)) {
    throw InputError(
        fmt::format("{}: no labels.sealed; allowed: a folder of `testbed seal`", folder.string()));
  }
  std::vector<std::string> ids;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (entry.is_directory() && fs::exists(entry.path() / "dataset.yaml"))
      ids.push_back(entry.path().filename());
  }
  std::sort(ids.begin(), ids.end());
  return ids;
}

std::vector<CaseLabel> open_labels(const fs::path& folder, const fs::path& key,
                                   std::string* provenance) {
  const Json json = Json::parse(unlock_labels(folder, key));
  if (provenance != nullptr) *provenance = json.at("provenance");
  std::vector<CaseLabel> labels;
  for (const Json& one : json.at("cases")) labels.push_back(label_of(one));
  std::sort(labels.begin(), labels.end(),
            [](const CaseLabel& a, const CaseLabel& b) { return a.case_id < b.case_id; });
  return labels;
}

}  // namespace jaculus::testbed
