#pragma once
// dataset.yaml, before any other file of the dataset is opened.

#include <optional>
#include <string>
#include <vector>

#include "jaculus/core/yaml.h"
#include "jaculus/trajectory/dataset.h"

namespace jaculus::trajectory {

struct StreamEntry {
  std::string name;
  std::string file;  ///< in every trial's folder
  double rate_hz = kNaN;
  yaml::Node node;  ///< for messages
};

/// What dataset.yaml says; files it names are not read yet.
struct DatasetOutline {
  Dataset dataset;                 ///< without plan, trials and a script that stands in a file
  std::optional<yaml::Node> plan;  ///< the plan's file name
  std::optional<yaml::Node> input_file;  ///< the script's file name
  std::vector<StreamEntry> streams;
  std::vector<yaml::Node> trials;
};

/// Checks keys, kinds, units and ranges. Faults: InputError with the node's place.
DatasetOutline read_outline(const yaml::Node& file);

/// The part that experiments have as well: robot, override, plan, input, initial, stops,
/// controller. Other keys are the caller's.
DatasetOutline read_dataset_setup(const yaml::Node& file);
extern const std::vector<std::string> kSetupKeys;
/// The help on these keys.
std::string explain_setup();

/// The block `controller`; what it leaves open goes to `notes`.
StatedController read_stated_controller(const yaml::Node& node, std::vector<std::string>& notes);

/// Notes where a key of dataset.yaml and those in it stand, for messages.
void note_places(const yaml::Node& node, const std::string& key, Dataset& dataset);

/// Reads plan and script, which stand in `folder`, into outline.dataset.
void load_commands(DatasetOutline& outline, const std::filesystem::path& folder);
/// A plan's table, its time checked and in seconds.
Table read_plan(const std::filesystem::path& file);

/// The text of dataset.yaml that reads back the same. Streams and trials are taken from
/// dataset.trials.
std::string outline_text(const Dataset& dataset);

/// Dimension of kp (per rad) or kd (per rad/s) in the controller's quantity.
Dimension gain_dimension(Quantity quantity, bool derivative);

/// Dimension of a command: torque [N m], voltage [V], duty [-].
Dimension command_dimension(Quantity quantity);

}  // namespace jaculus::trajectory
