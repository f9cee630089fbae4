#include "jaculus/trajectory/dataset.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ranges>

#include "jaculus/core/error.h"
#include "trajectory/channel_units.h"
#include "trajectory/dataset_yaml.h"

namespace jaculus::trajectory {
namespace {

namespace fs = std::filesystem;

/// Line of a row in a CSV file: one header line, no blank lines between (csv.h).
int line_of(int row) { return row + 2; }

Vector read_time(const Table& table, const fs::path& file, bool borders_may_coincide) {
  Vector time = quantity(table, "time", dimension::time, file);
  for (int k = 0; k < count_of(time); ++k) {
    const auto fault = [&](const std::string& what) {
      return InputError({file.string(), line_of(k), "time"}, what);
    };
    if (std::isnan(time[k])) throw fault("an empty cell given; allowed: a time in every row");
    if (k == 0 || time[k] > time[k - 1]) continue;
    if (time[k] < time[k - 1])
      throw fault(
          fmt::format("{:.10g} s follows {:.10g} s; allowed: time that never runs backwards",
                      time[k], time[k - 1]));
    if (!borders_may_coincide)
      throw fault(fmt::format("{} s stands twice; allowed: one row a time", time[k]));
  }
  return time;
}

Stream read_stream(const StreamEntry& entry, const fs::path& file) {
  const Table table = read_csv(file);
  Stream stream;
  stream.name = entry.name;
  stream.rate_hz = entry.rate_hz;
  stream.time = read_time(table, file, false);
  std::vector<Eigen::Index> columns;
  std::vector<double> factors;
  for (int i = 0; i < count_of(table.columns); ++i) {
    if (table.columns[i].name == "time") continue;
    const ChannelUnit unit = channel_unit(table.columns[i], file.string() + ":1");
    stream.channels.push_back(table.columns[i].name);
    stream.units.push_back(unit.si);
    columns.push_back(i);
    factors.push_back(unit.factor);
  }

  if (columns.empty())
    throw InputError({file.string(), 1},
                     "there is no column but time; allowed: at least one channel");
  stream.values.resize(columns.size(), stream.time.size());
  for (int i = 0; i < count_of(columns); ++i)
    stream.values.row(i) = factors[i] * table.values.col(columns[i]).transpose();

  return stream;
}

/// The end of what was commanded, infinite where nothing tells it [s].
double command_end(const Dataset& dataset) {
  if (!dataset.plan) return kInfinity;
  const int time = dataset.plan->column("time");
  return dataset.plan->values(dataset.plan->values.rows() - 1, time);
}

void check_start(const Stream& stream, const fs::path& file, double end) {
  if (stream.time[0] <= end) return;
  throw InputError(
      {file.string(), line_of(0), "time"},
      fmt::format("the stream begins at {} s, after the plan's end at {} s; allowed: a stream that "
                  "overlaps the plan, whose first sample is time 0",
                  stream.time[0], end));
}

InputScript read_script(const fs::path& file, Quantity commanded) {
  const Table table = read_csv(file);
  InputScript script;
  script.quantity = commanded;
  script.time = read_time(table, file, false);

  const std::string allowed = channel_name("JOINT", commanded);
  std::vector<Vector> rows;
  for (const Column& column : table.columns) {
    if (column.name == "time") continue;
    const ChannelName name = parse_channel(column.name);
    if (name.quantity != commanded)
      throw InputError({file.string(), 1}, fmt::format("column '{}' given; allowed: time and {}",
                                                       column.name, allowed));
    script.joints.push_back(name.of);
    rows.push_back(quantity(table, column.name, command_dimension(commanded), file));
    if (rows.back().hasNaN())
      throw InputError(
          {.file = file.string()},
          fmt::format("column '{}' has gaps; allowed: a command in every row", column.name));
  }
  if (rows.empty())
    throw InputError({file.string(), 1},
                     fmt::format("no command given; allowed: a column {}", allowed));

  script.values.resize(rows.size(), script.time.size());
  for (int i = 0; i < count_of(rows); ++i) script.values.row(i) = rows[i].transpose();
  return script;
}

fs::path named_file(const yaml::Node& node, const fs::path& folder) {
  const fs::path file = folder / node.text();
  if (!fs::is_regular_file(file))
    throw node.error(fmt::format("there is no file {}", file.string()));
  return file;
}

/// What drove the joint must have been logged where nothing was commanded.
void check_measured(const Dataset& dataset, const yaml::Node& file) {
  if (dataset.controller.kind != ControllerKind::measured) return;

  const Quantity input = dataset.controller.input;
  const auto has_input = [&](const Stream& stream) {
    return std::any_of(
        stream.channels.begin(), stream.channels.end(),
        [&](const std::string& channel) { return parse_channel(channel).quantity == input; });
  };
  for (const Trial& trial : dataset.trials) {
    if (std::any_of(trial.streams.begin(), trial.streams.end(), has_input)) continue;
    throw file.at("controller")
        .at("input")
        .error(fmt::format("no stream of {} has a column {}; allowed: a quantity that was logged",
                           trial.name, channel_name("JOINT", input)));
  }
}

std::vector<Trial> read_all_trials(const DatasetOutline& outline, const fs::path& folder,
                                   std::vector<std::string>& notes) {
  std::vector<Trial> trials;
  std::vector<bool> found(outline.streams.size(), false);
  const double end = command_end(outline.dataset);
  for (const yaml::Node& node : outline.trials) {
    Trial trial{node.text(), {}};
    if (!fs::is_directory(folder / trial.name))
      throw node.error(fmt::format("there is no folder {}", (folder / trial.name).string()));
    for (std::size_t i = 0; i < outline.streams.size(); ++i) {
      const fs::path file = folder / trial.name / outline.streams[i].file;
      if (!fs::exists(file)) {
        notes.push_back(fmt::format("{} has no {}", trial.name, outline.streams[i].file));
        continue;
      }
      found[i] = true;
      trial.streams.push_back(read_stream(outline.streams[i], file));
      check_start(trial.streams.back(), file, end);
    }
    trials.push_back(std::move(trial));
  }

  for (std::size_t i = 0; i < found.size(); ++i)
    if (!found[i])
      throw outline.streams[i].node.at("file").error(
          fmt::format("no trial has a file {}", outline.streams[i].file));

  return trials;
}

}  // namespace

InputPlace Dataset::place_of(const std::string& key) const {
  const auto stated = places.find(key);
  return stated != places.end() ? stated->second
                                : InputPlace{(folder / "dataset.yaml").string(), 0, key};
}

Table read_plan(const fs::path& file) {
  Table plan = read_csv(file);
  const Vector time = read_time(plan, file, true);
  plan.values.col(plan.column("time")) = time;
  plan.columns[plan.column("time")].unit = "s";
  if (!(time[time.size() - 1] > time[0]))
    throw InputError({file.string(), line_of(count_of(time) - 1)},
                     "the plan ends where it begins; allowed: a plan that lasts");
  return plan;
}

void load_commands(DatasetOutline& outline, const fs::path& folder) {
  Dataset& dataset = outline.dataset;
  if (outline.plan) dataset.plan = read_plan(named_file(*outline.plan, folder));
  if (outline.input_file)
    dataset.script = read_script(named_file(*outline.input_file, folder), dataset.script->quantity);
}

int Stream::channel(const std::string& channel_name) const {
  return index_of(channels, channel_name);
}

const Stream* Trial::stream(const std::string& stream_name) const {
  for (const Stream& stream : streams)
    if (stream.name == stream_name) return &stream;
  return nullptr;
}

Dataset read_dataset(const fs::path& given) {
  const bool is_file = fs::is_regular_file(given);
  if (!is_file && !fs::exists(given))
    throw InputError({.file = given.string()}, "there is no such folder");
  const fs::path folder = is_file ? given.parent_path() : given;
  if (!is_file && !fs::is_regular_file(folder / "dataset.yaml"))
    throw InputError(
        fmt::format("{}: no dataset.yaml here; allowed: the folder of a dataset", folder.string()));
  const yaml::Node file = yaml::Node::load(is_file ? given : folder / "dataset.yaml");
  DatasetOutline outline = read_outline(file);
  load_commands(outline, folder);
  Dataset dataset = std::move(outline.dataset);
  outline.dataset = Dataset{};
  outline.dataset.plan = dataset.plan;
  dataset.folder = folder;
  dataset.trials = read_all_trials(outline, folder, dataset.notes);
  check_measured(dataset, file);
  return dataset;
}

}  // namespace jaculus::trajectory
