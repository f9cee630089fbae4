#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <system_error>

#include "jaculus/core/error.h"
#include "jaculus/core/yaml.h"
#include "trajectory/dataset_yaml.h"

namespace jaculus::trajectory {
namespace {

namespace fs = std::filesystem;
using yaml::quoted;

std::string yaml_number(double value) {
  if (std::isinf(value)) return value < 0.0 ? "-.inf" : ".inf";
  return fmt::format("{}", value);
}

std::string gain_text(const StatedGain& gain) {
  if (gain.known()) return fmt::format("{}", gain.range.lower);
  if (std::isinf(gain.range.upper)) return "unknown";
  return fmt::format("[{}, {}]", gain.range.lower, gain.range.upper);
}

std::string gains_text(const std::map<std::string, StatedGain>& gains) {
  std::string out;
  for (const auto& [joint, gain] : gains)
    out += fmt::format("{}{}: {}", out.empty() ? "" : ", ", quoted(joint), gain_text(gain));
  return "{" + out + "}";
}

std::string controller_text(const StatedController& controller) {
  const bool feedback = controller.kind == ControllerKind::feedforward_pd;
  std::string out = fmt::format("{{kind: {}", name_of(controller.kind));
  if (feedback && controller.quantity_stated)
    out += fmt::format(", quantity: {}", name_of(controller.quantity));
  if (controller.kind == ControllerKind::measured) {
    out += fmt::format(", input: {}", name_of(controller.input));
  } else {
    out += fmt::format(", rate_hz: {}", controller.rate_hz);
  }

  if (!controller.kp.empty()) out += ", kp: " + gains_text(controller.kp);
  if (!controller.kd.empty()) out += ", kd: " + gains_text(controller.kd);
  if (controller.gains_at_joint) out += ", gains_at: joint";
  if (controller.bus_voltage) out += fmt::format(", bus_voltage: {}", *controller.bus_voltage);
  if (controller.after_end == AfterEnd::pose) {
    std::string pose;
    for (const auto& [joint, value] : controller.landing_pose)
      pose += fmt::format("{}{}: {}", pose.empty() ? "" : ", ", quoted(joint), value);
    out += fmt::format(", after_end: {{pose: {{{}}}, within: {}}}", pose, controller.landing_time);
  } else if (controller.after_end) {
    out += fmt::format(", after_end: {}", name_of(*controller.after_end));
  }

  return out + "}";
}

/// Streams in the order in which the trials first have them.
std::vector<const Stream*> stream_kinds(const Dataset& dataset) {
  std::vector<const Stream*> kinds;
  for (const Trial& trial : dataset.trials) {
    for (const Stream& stream : trial.streams) {
      bool known = false;
      for (const Stream* kind : kinds) known = known || kind->name == stream.name;
      if (!known) kinds.push_back(&stream);
    }
  }
  return kinds;
}

Table script_table(const InputScript& script) {
  Table table;
  table.columns.push_back({"time", "s"});
  for (const std::string& joint : script.joints)
    table.columns.push_back(
        {channel_name(joint, script.quantity), unit_name(command_dimension(script.quantity))});
  table.values.resize(script.time.size(), 1 + script.values.rows());
  table.values.col(0) = script.time;
  table.values.rightCols(script.values.rows()) = script.values.transpose();
  return table;
}

/// Block by block, for a stream may be long.
void write_stream(const Stream& stream, const fs::path& file) {
  assert(stream.channels.size() == stream.units.size());
  assert(stream.values.rows() == std::ssize(stream.channels));
  std::vector<Column> columns = {{"time", "s"}};
  for (std::size_t i = 0; i < stream.channels.size(); ++i)
    columns.push_back({stream.channels[i], stream.units[i]});
  const auto block = [&](Eigen::Index first) {
    constexpr Eigen::Index kRows = 4096;
    const Eigen::Index rows = std::min(kRows, stream.time.size() - first);
    Matrix values(rows, 1 + stream.values.rows());
    values.col(0) = stream.time.segment(first, rows);
    values.rightCols(stream.values.rows()) = stream.values.middleCols(first, rows).transpose();
    return values;
  };
  write_csv(columns, block, file);
}

void make_folder(const fs::path& folder) {
  std::error_code code;
  fs::create_directories(folder, code);
  if (code || !fs::is_directory(folder))
    throw InputError(fmt::format("{}: can't be made: {}", folder.string(),
                                 code ? code.message() : "it is a file"));
}

}  // namespace

std::string outline_text(const Dataset& dataset) {
  std::string out = "format: jaculus-dataset/1\n";
  out += fmt::format("experiment: {}\nrobot: {}\n", name_of(dataset.experiment),
                     quoted(dataset.robot));
  if (!dataset.overrides.empty()) {
    out += "override:\n";
    for (const auto& [path, value] : dataset.overrides)
      out += fmt::format("  {}: {}\n", quoted(path), value);
  }

  if (dataset.plan) out += "plan: plan.csv\n";
  if (dataset.script)
    out += fmt::format("input: {{quantity: {}, file: input.csv}}\n",
                       name_of(dataset.script->quantity));
  if (!dataset.initial.empty()) {
    out += "initial:\n";
    for (const auto& [name, value] : dataset.initial)
      out += fmt::format("  {}: {}\n", quoted(name), value);
  }

  if (!dataset.stops.empty()) out += "stops:\n";
  for (const auto& [joint, stop] : dataset.stops)
    out +=
        fmt::format("  {}: {{range: [{}, {}], restitution: {}}}\n", quoted(joint),
                    yaml_number(stop.range.lower), yaml_number(stop.range.upper), stop.restitution);
  out += fmt::format("controller: {}\nstreams:\n", controller_text(dataset.controller));
  for (const Stream* stream : stream_kinds(dataset)) {
    out += fmt::format("  {}: {{file: {}", quoted(stream->name), quoted(stream->name + ".csv"));
    if (!std::isnan(stream->rate_hz)) out += fmt::format(", rate_hz: {}", stream->rate_hz);
    out += "}\n";
  }

  out += "trials:\n";
  for (const Trial& trial : dataset.trials) out += fmt::format("  - {}\n", quoted(trial.name));
  if (!dataset.provenance.empty())
    out += fmt::format("provenance: {}\n", quoted(dataset.provenance));
  return out;
}

void write_dataset(Dataset& dataset, const fs::path& folder) {
  assert(!(dataset.plan && dataset.script));
  make_folder(folder);
  std::error_code code;
  fs::remove(folder / "dataset.yaml", code);
  if (dataset.plan) write_csv(*dataset.plan, folder / "plan.csv");
  if (dataset.script) write_csv(script_table(*dataset.script), folder / "input.csv");
  for (const Trial& trial : dataset.trials) {
    make_folder(folder / trial.name);
    for (const Stream& stream : trial.streams)
      write_stream(stream, folder / trial.name / (stream.name + ".csv"));
  }
  write_file(folder / "dataset.yaml", outline_text(dataset));
  dataset.folder = folder;
}

}  // namespace jaculus::trajectory
