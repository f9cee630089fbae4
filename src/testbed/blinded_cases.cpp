#include "jaculus/testbed/blinded_cases.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <fstream>
#include <set>
#include <stdexcept>

#include "jaculus/core/error.h"
#include "jaculus/core/executor.h"
#include "jaculus/core/installation.h"
#include "jaculus/core/journal.h"
#include "testbed/case_draws.h"
#include "testbed/labels.h"
#include "testbed/vault.h"

namespace jaculus::testbed {
namespace {

namespace fs = std::filesystem;

struct DrawnCase {
  std::string id;
  CaseKind kind;
};

/// Kinds in random order, with ids that say nothing.
std::vector<DrawnCase> draw_cases(const BlindingSpec& spec) {
  std::vector<CaseKind> kinds;
  const auto add = [&](int count, const CaseKind& kind) { kinds.insert(kinds.end(), count, kind); };
  add(spec.singles, {"single"});
  add(spec.none, {"none"});
  add(spec.pairs, {"pair"});
  add(spec.several, {"several"});
  add(spec.outside, {"outside"});
  add(spec.mixed, {"mixed"});
  add(spec.events, {"event"});
  add(spec.groups, {"single", true});

  Random random(task_seed(spec.seed, 0xca5e));
  std::shuffle(kinds.begin(), kinds.end(), random);
  std::set<std::string> ids;
  while (ids.size() < kinds.size()) ids.insert(fmt::format("case_{:08x}", random() & 0xffffffffU));
  std::vector<DrawnCase> cases;
  auto id = ids.begin();
  for (const CaseKind& kind : kinds) cases.push_back({*id++, kind});
  return cases;
}

fs::path journal_of(const BlindingSpec& spec) { return spec.key.string() + ".journal"; }

void check_journal(const BlindingSpec& spec) {
  std::error_code code;
  const bool begun = fs::exists(journal_of(spec), code);
  if (begun && !spec.resume) {
    throw InputError(fmt::format(
        "{}: cases of an earlier run are in it; allowed: --resume, or another --out and --key",
        journal_of(spec).string()));
  }
  if (!fs::exists(spec.out, code) || fs::is_empty(spec.out, code)) return;
  if (fs::exists(spec.out / "labels.sealed", code) && !begun) {
    throw InputError(
        fmt::format("--out {}: a whole batch is in it; allowed: a new folder", spec.out.string()));
  }
  if (begun) return;
  throw InputError(fmt::format("--out {}: not empty{}; allowed: a new folder", spec.out.string(),
                               spec.resume ? ", and there is no journal to go on with" : ""));
}

void check_places(const BlindingSpec& spec) {
  if (spec.robots.empty()) throw InputError("testbed seal: no robot; allowed: one or more");
  const fs::path inside =
      fs::weakly_canonical(spec.key).lexically_relative(fs::weakly_canonical(spec.out));
  if (inside.empty() || *inside.begin() != "..") {
    throw InputError(fmt::format("--key {}: lies in the cases' folder; allowed: outside of it",
                                 spec.key.string()));
  }
  check_journal(spec);
  std::error_code code;
  fs::create_directories(spec.out, code);
}

std::uint64_t hash_of_bytes(const fs::path& file, std::uint64_t state) {
  std::ifstream in(file, std::ios::binary);
  std::string block(1 << 20, '\0');
  while (in.read(block.data(), count_of(block)) || in.gcount() > 0)
    state = hash64(std::string_view(block).substr(0, in.gcount()), state);
  return state;
}

/// Everything that cases depend on: program, robots, plans, what is asked for.
std::string fingerprint(const BlindingSpec& spec) {
  std::uint64_t files = hash_of_bytes("/proc/self/exe", hash64(version()));
  for (const fs::path& robot : spec.robots)
    for (const char* name : {"robot.urdf", "robot.yaml"})
      files = hash_of_bytes(robot / name, files);
  for (const fs::path& plan : spec.plans) files = hash_of_bytes(plan, files);
  return fmt::format("seal {:x} {} {} {} {} {} {} {} {} {} {} {} {}", files, spec.seed,
                     spec.singles, spec.none, spec.pairs, spec.several, spec.outside, spec.mixed,
                     spec.events, spec.groups, spec.clutter, fmt::join(spec.withheld, ","),
                     fs::weakly_canonical(spec.out).string());
}

/// The journal, readable by its owner alone: labels are in it.
void make_journal(const BlindingSpec& spec) {
  std::error_code code;
  fs::create_directories(fs::absolute(spec.key).parent_path(), code);
  std::ofstream(journal_of(spec), std::ios::app).flush();
  fs::permissions(journal_of(spec), fs::perms::owner_read | fs::perms::owner_write, code);
}

std::string set_name(int index) { return fmt::format("set_{}", index + 1); }

/// Draws, plays and writes a case; its label as text.
std::string make_case(const BlindingSpec& spec, const DrawnCase& drawn, std::uint64_t seed,
                      const Grounds& grounds) {
  MadeCase made = draw_case(drawn.kind, seed, grounds);
  made.label.case_id = drawn.id;
  const fs::path folder = spec.out / drawn.id;
  fs::remove_all(folder);  // what an interrupted run left of it
  for (int i = 0; i < count_of(made.datasets); ++i) {
    trajectory::write_dataset(made.datasets[i], drawn.kind.group ? folder / set_name(i) : folder);
  }
  return label_text(made.label);
}

[[noreturn]] void fail(const TaskResult& result) {
  if (result.state == TaskState::cancelled)
    throw std::runtime_error("interrupted; finished cases are kept, --resume goes on");
  throw std::runtime_error(result.error);
}

/// Signatures of every stage, each run in a process of its own.
std::vector<Signatures> all_signatures(const BlindingSpec& spec, const std::vector<Stage>& stages) {
  std::vector<std::pair<std::size_t, std::string>> jobs;
  for (std::size_t s = 0; s < stages.size() && spec.singles + spec.mixed + spec.groups > 0; ++s) {
    for (const std::string& effect : signature_effects(stages[s])) jobs.emplace_back(s, effect);
  }

  TaskOptions options;
  options.workers = spec.jobs;
  options.progress = spec.progress;
  options.notice = spec.notice;
  options.executor = spec.executor;
  options.stage = "signatures";
  options.fingerprint = fingerprint(spec);
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
  Grounds grounds{all_stages(spec.plans, spec.robots), {}, {}, spec.clutter};
  grounds.pool = pool_of(grounds.stages, spec.withheld);
  const std::vector<DrawnCase> cases = draw_cases(spec);
  for (const DrawnCase& drawn : cases) check_kind(drawn.kind, grounds);
  grounds.signatures = all_signatures(spec, grounds.stages);

  make_journal(spec);
  TaskOptions options;
  options.workers = spec.jobs;
  options.progress = spec.progress;
  options.notice = spec.notice;
  options.journal = journal_of(spec);
  options.fingerprint = fingerprint(spec);
  options.executor = spec.executor;
  options.stage = "cases";
  const auto results = run_tasks(
      count_of(cases),
      [&](int i) { return make_case(spec, cases[i], task_seed(spec.seed, i + 1), grounds); },
      options);

  std::vector<std::string> ids, labels;
  for (int i = 0; i < count_of(results); ++i) {
    if (results[i].state != TaskState::done) fail(results[i]);
    labels.push_back(results[i].bytes);
    ids.push_back(cases[i].id);
    if (!case_datasets(spec.out / ids.back()).empty()) continue;
    throw InputError(fmt::format("{}: gone since an earlier run finished it; allowed: a new folder",
                                 (spec.out / ids.back()).string()));
  }

  lock_labels(sealed_text(labels, spec.provenance), spec.out, spec.key);
  fs::remove(journal_of(spec));
  if (spec.executor) remove_jobs(*spec.executor);
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
    if (entry.is_directory() && !case_datasets(entry.path()).empty())
      ids.push_back(entry.path().filename());
  }
  std::sort(ids.begin(), ids.end());
  return ids;
}

std::vector<fs::path> case_datasets(const fs::path& case_folder) {
  if (fs::exists(case_folder / "dataset.yaml")) return {case_folder};
  std::vector<fs::path> sets;
  for (int i = 0; fs::exists(case_folder / set_name(i) / "dataset.yaml"); ++i)
    sets.push_back(case_folder / set_name(i));
  return sets;
}

std::vector<CaseLabel> open_labels(const fs::path& folder, const fs::path& key,
                                   std::string* provenance) {
  return labels_in(unlock_labels(folder, key), provenance);
}

}  // namespace jaculus::testbed
