// jaculus import: logs of real robots into a dataset.

#include "jaculus/trajectory/import.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "cli/command.h"
#include "cli/dataset_doubts.h"
#include "jaculus/core/error.h"
#include "jaculus/simulation/experiment.h"
#include "jaculus/trajectory/column_map.h"
#include "jaculus/trajectory/leap_speed.h"
#include "jaculus/trajectory/openlog.h"
#include "jaculus/trajectory/optitrack.h"

namespace jaculus::cli {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct ImportOptions {
  Common common;
  std::vector<std::string> files;
  std::string experiment = name_of(trajectory::ExperimentKind::leap);
  std::string robot, plan, controller, provenance, description;
  std::string start, cut;
  std::string up = "y", forward = "auto";  ///< of `axes`, as given
  trajectory::MocapAxes axes;
};

double number(const std::string& flag, const std::string& text) {
  double value = 0.0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (code != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
    throw InputError(fmt::format("{}: '{}' given; allowed: a number", flag, text));
  return value;
}

/// Time zero by --start: `rule` (the authors', on horizontal motion), `first` (sample), seconds of
/// the file, or CHANNEL>VALUE.
double start_of(const trajectory::Stream& stream, const std::string& rule, const std::string& file,
                std::vector<std::string>& notes) {
  if (rule == "first") return stream.time[0];
  if (rule == "rule") {
    const int x = stream.channel("x"), y = stream.channel("y");
    if (x < 0)
      throw InputError(
          "--start: 'rule' needs a channel x; allowed here: first, a time, CHANNEL>VALUE");
    const Vector lateral = y < 0 ? Vector() : Vector(stream.values.row(y).transpose());
    const auto start =
        trajectory::leap_start(stream.time, stream.values.row(x).transpose(), lateral);
    if (!start)
      throw InputError(
          fmt::format("{}: nothing moves as the start rule asks (last under 0.005 m/s before the "
                      "first over 0.1 m/s); "
                      "allowed: --start first, a time, CHANNEL>VALUE",
                      file));
    notes.push_back(
        fmt::format("time zero by the authors' start rule: {:.6g} s of the file", *start));
    return *start;
  }

  const std::size_t above = rule.find('>');
  if (above == std::string::npos) return number("--start", rule);
  const int channel = stream.channel(rule.substr(0, above));
  const double value = number("--start", rule.substr(above + 1));
  if (channel < 0) {
    throw InputError(fmt::format("--start: there is no channel '{}'{}", rule.substr(0, above),
                                 yaml::did_you_mean(rule.substr(0, above), stream.channels)));
  }

  for (Eigen::Index k = 0; k < stream.time.size(); ++k) {
    if (!(stream.values(channel, k) > value)) continue;
    notes.push_back(fmt::format("time zero where {} first passes {}: {:.6g} s of the file",
                                rule.substr(0, above), value, stream.time[k]));
    return stream.time[k];
  }

  throw InputError(fmt::format("{}: {} never passes {}; allowed: another --start", file,
                               rule.substr(0, above), value));
}

Bounds cut_of(const std::string& text) {
  if (text.empty()) return {};
  const std::size_t comma = text.find(',');
  if (comma == std::string::npos)
    throw InputError(fmt::format("--cut: '{}' given; allowed: FROM,TO in seconds", text));
  const Bounds cut{number("--cut", text.substr(0, comma)), number("--cut", text.substr(comma + 1))};
  if (!(cut.lower < cut.upper))
    throw InputError(fmt::format("--cut: '{}' given; allowed: FROM,TO with FROM below TO", text));
  return cut;
}

/// Moves time zero to `start` and keeps what lies within `cut`.
void cut_stream(trajectory::Stream& stream, double start, const Bounds& cut,
                const std::string& file) {
  constexpr double kRounding = 1e-9;
  stream.time.array() -= start;
  Eigen::Index first = 0, last = stream.time.size();
  while (first < last && stream.time[first] < cut.lower - kRounding) ++first;
  while (last > first && stream.time[last - 1] > cut.upper + kRounding) --last;
  if (first == last)
    throw InputError(fmt::format("{}: no sample lies within --cut {},{} s of time zero", file,
                                 cut.lower, cut.upper));
  stream.time = Vector(stream.time.segment(first, last - first));
  stream.values = Matrix(stream.values.middleCols(first, last - first));
}

/// The window of a log by --start and --cut; nothing where the start is told by the motion as a
/// whole.
std::optional<trajectory::LogWindow> log_window(const std::string& rule, const Bounds& cut) {
  if (rule == "rule") return {};
  trajectory::LogWindow window{{}, "", 0.0, cut};
  if (rule == "first") return window;
  const std::size_t above = rule.find('>');
  if (above == std::string::npos) {
    window.zero = number("--start", rule);
  } else {
    window.channel = rule.substr(0, above);
    window.above = number("--start", rule.substr(above + 1));
  }
  return window;
}

/// A log's stream, time zero and cut taken: a long log is never held as a whole.
trajectory::Stream read_log(const ImportOptions& options, const std::string& file,
                            const Bounds& cut, std::vector<std::string>& notes) {
  const trajectory::OpenLogFormat format =
      trajectory::read_openlog_format(yaml::Node::load(options.description));
  if (const auto window = log_window(options.start, cut))
    return trajectory::read_openlog(fs::path(file), format, *window, notes);
  trajectory::Stream stream = trajectory::read_openlog(fs::path(file), format, notes);
  cut_stream(stream, start_of(stream, options.start, file, notes), cut, file);
  return stream;
}

trajectory::Stream read_file(const std::string& kind, const ImportOptions& options,
                             const std::string& file, std::vector<std::string>& notes) {
  if (kind == "csv")
    return trajectory::read_mapped_csv(
        fs::path(file), trajectory::read_column_map(yaml::Node::load(options.description)), notes);

  trajectory::MocapAxes axes = options.axes;
  axes.up = *trajectory::mocap_ups().find(options.up);
  axes.forward = *trajectory::mocap_forwards().find(options.forward);
  const trajectory::MocapTake take = trajectory::read_optitrack(fs::path(file));
  notes.push_back(fmt::format("format version {}, {} bodies, {} frames at {:.6g} Hz", take.version,
                              take.bodies.size(), take.time.size(), take.rate_hz));
  notes.insert(notes.end(), take.notes.begin(), take.notes.end());
  notes.push_back(fmt::format(
      "{} is taken as up{}; the first {} s as rest", options.up,
      axes.up == trajectory::MocapUp::y ? " (Motive's own; --up z otherwise)" : "", axes.rest));
  try {
    return trajectory::mocap_stream(take, axes, notes);
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", file, error.what()));
  }
}

/// A file's stream, counted from its time zero and cut.
trajectory::Stream read_trial(const std::string& kind, const ImportOptions& options,
                              const std::string& file, const Bounds& cut,
                              std::vector<std::string>& notes) {
  if (kind == "openlog") return read_log(options, file, cut, notes);
  trajectory::Stream stream = read_file(kind, options, file, notes);
  cut_stream(stream, start_of(stream, options.start, file, notes), cut, file);
  return stream;
}

int run_import(const std::string& kind, const ImportOptions& options) {
  if (options.common.out.empty())
    throw InputError("--out: missing; allowed: the folder of the dataset to write");

  const Bounds cut = cut_of(options.cut);
  const fs::path robot = model::find_robot(options.robot, fs::current_path());
  trajectory::Dataset dataset =
      trajectory::begin_dataset({*trajectory::experiment_kinds().find(options.experiment),
                                 options.robot, options.plan, options.controller});

  // A robot that is named by its place stands in the dataset in full, for the dataset lies
  // elsewhere.
  if (fs::path(options.robot).has_parent_path() || fs::is_directory(options.robot))
    dataset.robot = fs::absolute(robot).lexically_normal().string();
  const model::Robot in_dataset = simulation::dataset_robot(dataset);
  const std::vector<std::string> setup_notes = dataset.notes;
  Json json = {{"files", Json::array()}, {"assumed", setup_notes}};
  std::string text;
  for (const std::string& note : setup_notes) text += "assumed: " + note + "\n";
  for (std::size_t i = 0; i < options.files.size(); ++i) {
    std::vector<std::string> notes;
    trajectory::Stream stream = read_trial(kind, options, options.files[i], cut, notes);
    trajectory::Trial trial{fmt::format("trial_{:02}", i + 1), {}};
    text += fmt::format("{} -> {}: {} samples of {} channels, {:.4g} to {:.4g} s\n",
                        options.files[i], trial.name, stream.time.size(), stream.channels.size(),
                        stream.time[0], stream.time[stream.time.size() - 1]);
    for (const std::string& note : notes) text += "  " + note + "\n";
    json["files"].push_back({{"file", options.files[i]},
                             {"trial", trial.name},
                             {"samples", stream.time.size()},
                             {"channels", stream.channels},
                             {"notes", notes}});
    trial.streams.push_back(std::move(stream));
    dataset.trials.push_back(std::move(trial));
  }

  dataset.provenance = options.provenance.empty()
                           ? fmt::format("Imported by jaculus from {} {} file{}; time zero: {}.",
                                         options.files.size(), kind,
                                         options.files.size() == 1 ? "" : "s", options.start)
                           : options.provenance;
  const DatasetDoubts doubts = dataset_doubts(dataset, in_dataset);
  text += to_text(doubts);
  json["strange_channels"] = doubts.strange_channels;
  json["contradictions"] = doubts.contradictions;
  prepare_folder(options.common.out);
  trajectory::write_dataset(dataset, options.common.out);
  if (options.common.json) {
    print(json.dump(1) + "\n");
  } else if (!options.common.quiet) {
    print(text + fmt::format("written to {}\n", options.common.out));
  }

  return kDone;
}

CLI::App* add_kind(CLI::App& parent, const std::string& kind, const std::string& help,
                   const std::string& start, const std::string& example,
                   const std::shared_ptr<ImportOptions>& options, Action& chosen) {
  CLI::App* command = parent.add_subcommand(kind, help);
  command->add_option("files", options->files, "logs, a trial each")->required();
  command->add_option("--out", options->common.out, "folder of the dataset");
  command->add_flag("--quiet", options->common.quiet, "print nothing but errors");
  command->add_flag("--json", options->common.json,
                    "machine-readable result on standard output, nothing else there");
  command->add_option("--robot", options->robot, "the robot: a folder of models/, or a path")
      ->required();
  command->add_option("--experiment", options->experiment, "what was done")
      ->check(one_of(trajectory::experiment_kinds().names()));
  command->add_option("--plan", options->plan, "plan.csv that was commanded");
  command->add_option("--controller", options->controller,
                      "as in dataset.yaml: \"{kind: measured, input: torque}\"");
  command->add_option("--provenance", options->provenance, "where the logs come from");
  options->start = start;
  command->add_option("--start", options->start,
                      "time zero: rule (the authors', on horizontal speed), first (sample), "
                      "seconds of the file, or CHANNEL>VALUE");
  command->add_option("--cut", options->cut,
                      "FROM,TO: seconds about time zero that are kept; default: everything");
  command->footer("Example:\n  jaculus import " + example);
  command->callback([kind, options, &chosen] {
    chosen = [kind, options] { return run_import(kind, *options); };
  });

  return command;
}

/// Kinds that the Python package reads: its command takes them before it comes here.
void add_python_kinds(CLI::App& parent, Action& chosen) {
  for (const std::string kind : {"mcap", "bag", "parquet"}) {
    CLI::App* command = parent.add_subcommand(
        kind, kind == "parquet"
                  ? "Parquet tables; by the command of the Python package."
                  : "ROS 2 bags (MCAP, sqlite3); by the command of the Python package.");
    command->allow_extras();
    command->callback([kind, &chosen] {
      chosen = [kind]() -> int {
        throw InputError(
            fmt::format("import {0}: this is the program alone, which can't read it; allowed: the "
                        "command of the "
                        "Python package (pip install of its wheel with rosbags, then python -m "
                        "jaculus import {0})",
                        kind));
      };
    });
  }
}

}  // namespace

void add_import(CLI::App& app, Action& chosen) {
  CLI::App* command =
      app.add_subcommand("import", "Logs of real robots into a dataset; prints what was assumed.");
  const std::string optitrack_example =
      "optitrack take1.csv take2.csv --robot minitaur_tail --plan plan.csv --cut=-0.3,1 --out "
      "leaps";
  const std::string openlog_example =
      "openlog LOG1.TXT --format minitaur_log.yaml --robot minitaur --plan plan.csv --out joints";
  const std::string csv_example =
      "csv log1.csv log2.csv --map columns.yaml --robot my_arm --experiment pendulum --out swings";
  command->footer("Example:\n  jaculus import " + optitrack_example + "\n  jaculus import " +
                  openlog_example + "\n  jaculus import " + csv_example);
  command->require_subcommand(1);
  auto mocap = std::make_shared<ImportOptions>();
  CLI::App* optitrack =
      add_kind(*command, "optitrack",
               "Motion capture as OptiTrack's Motive exports it, CSV of version 1.1 and later.",
               "rule", optitrack_example, mocap, chosen);
  optitrack->add_option("--up", mocap->up, "axis of the file that points up")
      ->check(one_of(trajectory::mocap_ups().names()));

  optitrack
      ->add_option("--forward", mocap->forward,
                   "axis of the file that points forward; auto: told by the motion")
      ->check(one_of(trajectory::mocap_forwards().names()));
  optitrack->add_option("--body", mocap->axes.body,
                        "rigid body that is the robot's base; default: the first");
  optitrack
      ->add_option("--rest", mocap->axes.rest, "seconds at the beginning in which the robot rests")
      ->check(CLI::PositiveNumber);
  auto log = std::make_shared<ImportOptions>();
  add_kind(*command, "openlog", "Binary logs of records, by a description of their layout.",
           "first", openlog_example, log, chosen)
      ->add_option("--format", log->description,
                   "layout of the records (YAML, format: jaculus-openlog/1)")
      ->required();
  auto csv = std::make_shared<ImportOptions>();
  add_kind(*command, "csv", "Any CSV through a map of its columns.", "first", csv_example, csv,
           chosen)
      ->add_option("--map", csv->description,
                   "columns of the channels (YAML, format: jaculus-columns/1)")
      ->required();
  add_python_kinds(*command, chosen);
}

}  // namespace jaculus::cli
