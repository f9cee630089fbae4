#pragma once
// The part of `jaculus check` that is about datasets and experiments.

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

namespace jaculus::cli {

/// Whether a path is a dataset's folder, or a file whose `format` is that of a dataset or an
/// experiment.
bool names_dataset(const std::filesystem::path& path);

/// Reads it with its robot and adds what was understood to `text`. InputError where something is
/// wrong with it, the robot or the plan.
nlohmann::ordered_json check_dataset(const std::filesystem::path& path, std::string& text);

}  // namespace jaculus::cli
