#include "jaculus/testbed/sealed_cases.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>

#include "jaculus/core/error.h"
#include "jaculus/core/interrupt.h"
#include "jaculus/core/json.h"
#include "jaculus/model/robot.h"
#include "testbed/draws.h"
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
          {"strength_in_noise_floors", json_number(label.strength_in_noise_floors)},
          {"parted", label.parted},
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
  label.parted = json.value("parted", std::vector<std::string>());
  label.equivalent = json.at("equivalent").get<std::vector<std::string>>();
  label.component = json.at("component");
  label.experiment = json.at("experiment");
  label.trials = json.at("trials");
  return label;
}

/// How many effects a kind of case has, and whether from outside the catalogue.
std::size_t effects_in(const std::string& kind) { return kind == "none" ? 0 : kind == "pair" ? 2 : 1; }

/// Effects that are to be in a case, drawn before anything else.
std::vector<const BenchEffect*> draw_effects(Random& random, const std::string& kind) {
  std::vector<const BenchEffect*> pool;
  for (const BenchEffect& effect : bench_effects()) {
    if (effect.outside == (kind == "outside")) pool.push_back(&effect);
  }
  std::vector<const BenchEffect*> drawn;
  while (drawn.size() < effects_in(kind)) {
    const BenchEffect* effect = pool[std::uniform_int_distribution<std::size_t>(0, pool.size() - 1)(random)];
    const bool new_part = drawn.empty() || bench_component(drawn[0]->name) != bench_component(effect->name);
    if (new_part) drawn.push_back(effect);
  }
  return drawn;
}

struct Made {
  CaseLabel label;
  Dataset dataset;
};

/// Whether effects part left from right by themselves, or there is none.
bool may_part(const std::vector<const BenchEffect*>& effects) {
  static const std::set<std::string> kOneSided = {"bent_leg", "command_dropout", "thermal_derating", "slipping_belt"};
  return std::all_of(effects.begin(), effects.end(), [](const BenchEffect* e) { return kOneSided.contains(e->name); });
}

/// One attempt; nothing where an effect doesn't show on the stage that was drawn, or where left and right legs part though no effect is
/// one-sided, so that there is more than was drawn: those are listed.
std::optional<Made> attempt(Random& random, const std::string& kind, const std::vector<const BenchEffect*>& effects,
                            const std::vector<Stage>& stages, const std::vector<Signatures>& signatures,
                            std::vector<std::string>& parted) {
  std::vector<std::size_t> fitting;
  for (std::size_t i = 0; i < stages.size(); ++i) {
    const auto acts = [&](const BenchEffect* effect) { return can_act(*effect, stages[i]); };
    if (std::all_of(effects.begin(), effects.end(), acts)) fitting.push_back(i);
  }
  if (fitting.empty()) return std::nullopt;
  const std::size_t at = fitting[std::uniform_int_distribution<std::size_t>(0, fitting.size() - 1)(random)];
  const Stage& stage = stages[at];
  const TrialSpec spec = draw_trials(random, stage);
  const std::optional<Dataset> nominal = exact_run(stage, Changes{}, spec);
  if (!nominal) return std::nullopt;
  const RobotFiles files = read_robot_files(find_robot(stage.asked.robot, fs::current_path() / "robot"));
  Made made;
  Changes changes;
  std::vector<Dose> doses;
  for (const BenchEffect* effect : effects) {
    const double target = std::exp(std::uniform_real_distribution<double>(0.0, std::log(20.0))(random));
    double reached = 0.0;
    const std::optional<Dose> dose = find_dose(*effect, stage, spec, *nominal, target, random, reached);
    if (!dose) return std::nullopt;
    dose->effect->apply(dose->values, changes);
    Changes alone;
    dose->effect->apply(dose->values, alone);
    doses.push_back(*dose);
    made.label.effects.push_back(effect->name);
    made.label.parameters.push_back(measured_parameters(effect->name, dose->values, files, alone));
  }
  const std::optional<Dataset> changed = exact_run(stage, changes, spec);
  if (!changed) return std::nullopt;
  made.label.strength_in_noise_floors =
      gap(*nominal, *changed, spec.sensors) * share_beyond_nuisances(signatures[at], spec, *nominal, *changed);
  if (!effects.empty() && made.label.strength_in_noise_floors < 0.7) return std::nullopt;
  made.label.kind = kind;
  made.label.experiment = stage.name;
  made.label.trials = spec.trials;
  if (kind == "single") {
    made.label.component = bench_component(effects[0]->name);
    made.label.equivalent = equivalents(stage, signatures[at], spec, *nominal, doses[0]);
  }
  double apart = 0.0;
  made.dataset = run_trials(stage.asked, changes, spec, &apart);
  if (apart > kApart && !may_part(effects)) {
    parted.push_back(fmt::format("{} on {}", fmt::join(made.label.effects, " + "), stage.name));
    return std::nullopt;
  }
  made.dataset.provenance = "a sealed case of the MuJoCo testbed";
  return made;
}

std::string make_case(const SealSpec& spec, const std::string& id, const std::string& kind, std::uint64_t seed,
                      const std::vector<Stage>& stages, const std::vector<Signatures>& signatures) {
  Random random(seed);
  std::vector<std::string> parted;
  for (int i = 0; i < kAttempts; ++i) {
    const auto effects = draw_effects(random, kind);
    try {
      std::optional<Made> made = attempt(random, kind, effects, stages, signatures, parted);
      if (!made) continue;
      made->label.case_id = id;
      made->label.parted = parted;
      write_dataset(made->dataset, spec.out / id);
      return to_json(made->label).dump();
    } catch (const InputError&) {
      throw;
    } catch (const std::runtime_error&) {
      continue;  // the robot was lost in a noisy trial
    }
  }
  throw std::runtime_error(fmt::format("case of kind '{}': no draw of {} showed", kind, kAttempts));
}

/// Kinds in random order, with ids that say nothing.
std::vector<std::pair<std::string, std::string>> draw_cases(const SealSpec& spec) {
  std::vector<std::string> kinds;
  for (const auto& [kind, count] :
       {std::pair{"single", spec.singles}, {"none", spec.none}, {"pair", spec.pairs}, {"outside", spec.outside}}) {
    kinds.insert(kinds.end(), static_cast<std::size_t>(count), kind);
  }
  Random random(task_seed(spec.seed, 0xca5e));
  std::shuffle(kinds.begin(), kinds.end(), random);
  std::set<std::string> ids;
  while (ids.size() < kinds.size()) ids.insert(fmt::format("case_{:08x}", static_cast<std::uint32_t>(random())));
  std::vector<std::pair<std::string, std::string>> cases;
  auto id = ids.begin();
  for (const std::string& kind : kinds) cases.emplace_back(*id++, kind);
  return cases;
}

void check_places(const SealSpec& spec) {
  std::error_code code;
  if (fs::exists(spec.out, code) && !fs::is_empty(spec.out, code)) {
    throw InputError(fmt::format("--out {}: not empty; allowed: a new folder", spec.out.string()));
  }
  fs::create_directories(spec.out, code);
  const fs::path inside = fs::weakly_canonical(spec.key).lexically_relative(fs::weakly_canonical(spec.out));
  if (inside.empty() || *inside.begin() != "..") {
    throw InputError(fmt::format("--key {}: lies in the cases' folder; allowed: outside of it", spec.key.string()));
  }
}

[[noreturn]] void fail(const TaskResult& result) {
  if (result.state == TaskState::cancelled) throw std::runtime_error("interrupted");
  throw std::runtime_error(result.error);
}

/// Signatures of every stage, each run in a process of its own.
std::vector<Signatures> all_signatures(const SealSpec& spec, const std::vector<Stage>& stages) {
  std::vector<std::pair<std::size_t, std::string>> jobs;
  for (std::size_t s = 0; s < stages.size() && spec.singles > 0; ++s) {
    for (const std::string& effect : signature_effects(stages[s])) jobs.emplace_back(s, effect);
  }
  TaskOptions options;
  options.workers = spec.jobs;
  options.progress = spec.progress;
  const auto results = run_tasks(
      static_cast<int>(jobs.size()),
      [&](int i) {
        const auto& [stage, effect] = jobs[static_cast<std::size_t>(i)];
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

std::vector<std::string> seal_cases(const SealSpec& spec) {
  check_places(spec);
  const std::vector<Stage> stages = all_stages(spec.plans);
  const std::vector<Signatures> signatures = all_signatures(spec, stages);
  const auto cases = draw_cases(spec);
  TaskOptions options;
  options.workers = spec.jobs;
  options.progress = spec.progress;
  const auto results = run_tasks(
      static_cast<int>(cases.size()),
      [&](int i) {
        const auto& [id, kind] = cases[static_cast<std::size_t>(i)];
        return make_case(spec, id, kind, task_seed(spec.seed, static_cast<std::uint64_t>(i) + 1), stages, signatures);
      },
      options);
  Json labels = {{"format", "jaculus-sealed/1"}, {"provenance", spec.provenance}, {"cases", Json::array()}};
  std::vector<std::string> ids;
  for (std::size_t i = 0; i < results.size(); ++i) {
    if (results[i].state != TaskState::done) fail(results[i]);
    labels["cases"].push_back(Json::parse(results[i].bytes));
    ids.push_back(cases[i].first);
  }
  lock_labels(labels.dump(1), spec.out, spec.key);
  return ids;
}

std::vector<std::string> sealed_ids(const fs::path& folder) {
  std::error_code code;
  if (!fs::exists(folder / "labels.sealed", code)) {
    throw InputError(fmt::format("{}: no labels.sealed; allowed: a folder of `testbed seal`", folder.string()));
  }
  std::vector<std::string> ids;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (entry.is_directory() && fs::exists(entry.path() / "dataset.yaml")) ids.push_back(entry.path().filename());
  }
  std::sort(ids.begin(), ids.end());
  return ids;
}

std::vector<CaseLabel> open_labels(const fs::path& folder, const fs::path& key, std::string* provenance) {
  const Json json = Json::parse(unlock_labels(folder, key));
  if (provenance != nullptr) *provenance = json.at("provenance");
  std::vector<CaseLabel> labels;
  for (const Json& one : json.at("cases")) labels.push_back(label_of(one));
  std::sort(labels.begin(), labels.end(), [](const CaseLabel& a, const CaseLabel& b) { return a.case_id < b.case_id; });
  return labels;
}

}  // namespace jaculus::testbed
