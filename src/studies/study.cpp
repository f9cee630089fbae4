#include "jaculus/studies/study.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "jaculus/core/executor.h"
#include "jaculus/core/installation.h"
#include "jaculus/core/journal.h"
#include "jaculus/trajectory/csv.h"
#include "studies/study_kind.h"

namespace jaculus::studies {
namespace {

namespace fs = std::filesystem;

struct Kind {
  const char* name;
  detail::PreparedStudy (*prepare)(const yaml::Node& root);
};

const std::vector<Kind>& kinds() {
  static const std::vector<Kind> table{{"reorientation", detail::prepare_reorientation},
                                       {"motion", detail::prepare_motion},
                                       {"tail_design", detail::prepare_tail_design},
                                       {"drag_bench", detail::prepare_drag_bench},
                                       {"plan", detail::prepare_plan}};
  return table;
}

struct Loaded {
  yaml::Node root;
  std::string name, kind, caption;
  detail::PreparedStudy study;
  std::vector<detail::ReferenceQuery> references;
  std::vector<StudyPlot> plots;
};

Loaded load(const yaml::Node& node) {
  Loaded loaded;
  loaded.root = node;
  if (!loaded.root.is_map()) throw loaded.root.error("a study is a map of keys");
  yaml::refuse_other_kind(loaded.root, "jaculus-study/1");
  static_cast<void>(loaded.root.at("format").choice({"jaculus-study/1"}));
  loaded.name = loaded.root.at("name").text();
  loaded.caption = loaded.root.at("caption").text();
  std::vector<std::string> names;
  for (const Kind& kind : kinds()) names.emplace_back(kind.name);
  loaded.kind = loaded.root.at("kind").choice(names);
  for (const Kind& kind : kinds()) {
    if (loaded.kind == kind.name) loaded.study = kind.prepare(loaded.root);
  }
  loaded.references = detail::read_references(loaded.root, loaded.study.columns);
  loaded.plots = detail::read_plots(loaded.root, loaded.study.columns);
  return loaded;
}

// Puts the journal in place: one that does not fit is refused with --resume, set aside without.
TaskOptions task_options(const Loaded& loaded, const fs::path& folder,
                         const StudyOptions& options) {
  TaskOptions t;
  t.workers = options.jobs;
  t.isolate = loaded.study.isolate;
  t.progress = options.progress;
  t.notice = options.notice;
  t.executor = options.executor;
  t.stage = options.stage;
  t.fingerprint =
      fmt::format("study {:016x}",
                  hash64(loaded.root.dump() + loaded.study.fingerprint + std::string(version())));

  if (folder.empty()) return t;
  t.journal = folder / "study.journal";
  const bool worker = options.executor && !worker_stage().empty();  // the journal is not its own
  if (options.resume || worker || !fs::exists(t.journal)) return t;
  if (read_journal(t.journal).key.find(t.fingerprint) != std::string::npos) return t;

  const fs::path aside = folder / "study.journal.old";
  fs::rename(t.journal, aside);
  if (options.notice)
    options.notice(fmt::format("the journal of another study is set aside as {}", aside.string()));
  return t;
}

/// Rows of points that failed, where they belong.
void add_failed(const Loaded& loaded, const std::vector<int>& failed,
                std::vector<StudyJson>& rows) {
  for (const int index : failed) {
    StudyJson row = loaded.study.failed_row(index);
    for (const std::string& column : loaded.study.columns)
      if (!row.contains(column)) row[column] = nullptr;
    rows.insert(rows.begin() + index, std::move(row));
  }
}

StudyResult collect(const Loaded& loaded, const std::vector<TaskResult>& results) {
  StudyResult result{loaded.name, loaded.kind, loaded.caption, true, loaded.study.columns, {},
                     {},          {}};

  result.axes = loaded.study.axes;
  result.plots = loaded.plots;
  result.samples = loaded.study.samples;

  std::vector<std::string> bytes;
  std::vector<int> failed;
  for (std::size_t i = 0; i < results.size(); ++i) {
    const TaskResult& task = results[i];
    if (task.state == TaskState::done) {
      bytes.push_back(task.bytes);
      continue;
    }
    result.complete = false;
    if (task.state != TaskState::failed) continue;
    result.notes.push_back(fmt::format("point {} failed: {}", i + 1, task.error));
    failed.push_back(static_cast<int>(i));
  }

  if (bytes.size() < results.size())
    result.notes.push_back(
        fmt::format("{} of {} points are finished", bytes.size(), results.size()));
  const bool interrupted = bytes.size() + failed.size() < results.size();
  if (interrupted || (!failed.empty() && !loaded.study.failed_row)) return result;

  result.rows = loaded.study.rows(bytes);
  add_failed(loaded, failed, result.rows);
  if (loaded.study.notes)
    for (std::string& note : loaded.study.notes(result.rows))
      result.notes.push_back(std::move(note));
  for (const detail::ReferenceQuery& query : loaded.references) {
    result.references.push_back(detail::evaluate(query, result.rows, result.notes));
  }

  return result;
}

std::string csv_cell(const StudyJson& value) {
  if (value.is_null()) return "";
  if (!value.is_string()) return value.dump();
  const std::string text = value.get<std::string>();
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

}  // namespace

std::vector<std::string> detail::with_common_keys(std::vector<std::string> keys) {
  keys.insert(keys.end(), {"format", "name", "kind", "caption", "reference", "plots"});
  return keys;
}

fs::path detail::named_file(const yaml::Node& node) {
  const fs::path file = node.file().parent_path() / node.text();
  if (fs::is_regular_file(file)) return file;
  throw node.error(
      fmt::format("'{}' not found; allowed: a file, named relative to this one", node.text()));
}

std::string check_study(const fs::path& file) { return check_study(yaml::Node::load(file)); }

std::string check_study(const yaml::Node& node) {
  const Loaded loaded = load(node);
  return fmt::format("study {} ({}): {}", loaded.name, loaded.kind, loaded.study.description);
}

StudyResult run_study(const fs::path& file, const fs::path& folder, const StudyOptions& options) {
  return run_study(yaml::Node::load(file), folder, options);
}

StudyResult run_study(const yaml::Node& node, const fs::path& folder, const StudyOptions& options) {
  const Loaded loaded = load(node);
  const TaskOptions t = task_options(loaded, folder, options);
  const StudyResult result = collect(loaded, run_tasks(loaded.study.tasks, loaded.study.task, t));
  if (folder.empty() || result.rows.empty()) return result;
  trajectory::write_file(folder / "study.csv", study_csv(result));
  trajectory::write_file(folder / "study.json", study_json(result));
  if (!result.complete) return result;  // the journal stays: --resume tries the rest again
  fs::remove(t.journal);
  if (options.executor) remove_jobs(*options.executor);
  return result;
}

std::string study_csv(const StudyResult& result) {
  std::string text = fmt::format("{}\n", fmt::join(result.columns, ","));
  std::vector<std::string> cells(result.columns.size());
  for (const StudyJson& row : result.rows) {
    for (std::size_t i = 0; i < cells.size(); ++i) cells[i] = csv_cell(row.at(result.columns[i]));
    text += fmt::format("{}\n", fmt::join(cells, ","));
  }
  return text;
}

std::string study_json(const StudyResult& result) {
  StudyJson json{{"format", "jaculus-study-result/1"},
                 {"name", result.name},
                 {"kind", result.kind},
                 {"caption", result.caption},
                 {"complete", result.complete},
                 {"columns", result.columns},
                 {"rows", result.rows}};

  if (!result.samples.empty()) json["samples"] = result.samples;
  json["reference"] = StudyJson::array();
  for (const StudyReference& r : result.references) {
    json["reference"].push_back({{"quantity", r.quantity},
                                 {"paper", r.paper},
                                 {"computed", r.computed},
                                 {"deviation", json_number(r.deviation)},
                                 {"disagrees", r.disagrees},
                                 {"note", r.note}});
  }

  json["notes"] = result.notes;
  json["version"] = version();
  return json.dump(1) + "\n";
}

}  // namespace jaculus::studies
