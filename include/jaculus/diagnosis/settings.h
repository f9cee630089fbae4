#pragma once
// Settings of a diagnosis: every constant that decides something, with unit, default, range,
// meaning and origin. The list is settings.def; `jaculus diagnose --explain` prints it and
// `--settings FILE` overrides it.

#include <filesystem>
#include <string>
#include <vector>

#include "jaculus/core/types.h"
#include "jaculus/core/yaml.h"

namespace jaculus::diagnosis {

/// One field a row of settings.def, in its unit.
struct Settings {
#define GROUP(title)
#define SETTING(type, name, value, unit, lower, upper, meaning, origin) type name = value;
#include "jaculus/diagnosis/settings.def"
#undef SETTING
#undef GROUP
};

/// A setting as users read it.
struct SettingRow {
  std::string group, name, unit, meaning;
  std::string origin;          ///< begins with its kind (settings.def)
  Bounds range;                ///< that a file may set [unit]
  double value = 0.0;          ///< [unit]
  double default_value = 0.0;  ///< [unit]
};
/// All of them, in the order of settings.def.
std::vector<SettingRow> setting_rows(const Settings& settings);

/// Settings from a YAML map of names to numbers in their units; what is not named keeps its
/// default. InputError (file:line: key) where a name is unknown or a value is no number in the
/// setting's range.
Settings read_settings(const std::filesystem::path& file);
Settings read_settings(const yaml::Node& root);

/// The time up to which errors are judged [s], "0.1 s". InputError, which calls it `name`, where it
/// is no time or outside the range of the setting `horizon`.
double read_horizon(const std::string& text, const std::string& name);

/// The table for terminals.
std::string settings_text(const Settings& settings);

}  // namespace jaculus::diagnosis
