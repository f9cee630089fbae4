#include "jaculus/diagnosis/settings.h"

#include <fmt/format.h>

#include <variant>

#include "jaculus/core/error.h"
#include "jaculus/core/units.h"
#include "jaculus/core/yaml.h"

namespace jaculus::diagnosis {
namespace {

/// A row of settings.def.
struct Entry {
  std::string group, name, unit;
  Bounds range;
  std::string meaning, origin;
  std::variant<int Settings::*, double Settings::*> field;
};

double value_of(const Entry& entry, const Settings& settings) {
  return std::visit([&](auto field) { return double(settings.*field); }, entry.field);
}

std::vector<Entry> make_entries() {
  std::vector<Entry> entries;
  std::string group;
#define GROUP(title) group = title;
#define SETTING(type, name, value, unit, lower, upper, meaning, origin) \
  entries.push_back({group, #name, unit, {lower, upper}, meaning, origin, &Settings::name});
#include "jaculus/diagnosis/settings.def"
#undef SETTING
#undef GROUP
  return entries;
}

const std::vector<Entry>& entries() {
  static const std::vector<Entry> all = make_entries();
  return all;
}

void set_field(const yaml::Node& node, const Entry& entry, Settings& settings) {
  if (const auto* field = std::get_if<int Settings::*>(&entry.field))
    settings.** field =
        node.integer(static_cast<int>(entry.range.lower), static_cast<int>(entry.range.upper));
  else
    settings.*std::get<double Settings::*>(entry.field) = node.number(dimension::none, entry.range);
}

}  // namespace

std::vector<SettingRow> setting_rows(const Settings& settings) {
  std::vector<SettingRow> rows;
  for (const Entry& e : entries())
    rows.push_back({e.group, e.name, e.unit, e.meaning, e.origin, e.range, value_of(e, settings),
                    value_of(e, {})});
  return rows;
}

double read_horizon(const std::string& text, const std::string& name) {
  double value = kNaN;
  try {
    value = parse_quantity(text, dimension::time);
  } catch (const InputError& e) {
    throw InputError({.key = name}, e.what());
  }
  for (const SettingRow& row : setting_rows({})) {
    if (row.name != "horizon" || row.range.contains(value)) continue;
    throw InputError({.key = name}, fmt::format("'{}' given; allowed: {} to {} s", text,
                                                row.range.lower, row.range.upper));
  }
  return value;
}

Settings read_settings(const std::filesystem::path& file) {
  return read_settings(yaml::Node::load(file));
}

Settings read_settings(const yaml::Node& root) {
  std::vector<std::string> names;
  for (const Entry& entry : entries()) names.push_back(entry.name);
  root.only(names);

  Settings settings;
  for (const Entry& entry : entries())
    if (const auto node = root.find(entry.name)) set_field(*node, entry, settings);
  return settings;
}

std::string settings_text(const Settings& settings) {
  std::string text, group;
  for (const SettingRow& row : setting_rows(settings)) {
    if (row.group != group) text += fmt::format("\n{}\n", group = row.group);
    const bool changed = row.value != row.default_value;
    text += fmt::format("  {:<30} {:>10.6g} {:<20} {}{}\n", row.name, row.value, row.unit,
                        changed ? fmt::format("(default {:.6g}) ", row.default_value) : "",
                        row.meaning);
    text += fmt::format("  {:<30} {:.10g} to {:.10g}; {}\n", "", row.range.lower, row.range.upper,
                        row.origin);
  }
  return text;
}

}  // namespace jaculus::diagnosis
