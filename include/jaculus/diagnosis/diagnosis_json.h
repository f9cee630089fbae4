#pragma once
// What a diagnosis writes: diagnosis.json, augmented.yaml, a table for terminals. Formats:
// docs/commands.md.

#include <filesystem>
#include <string>

#include "jaculus/diagnosis/diagnose.h"

namespace jaculus::diagnosis {

/// diagnosis.json; a number that doesn't exist is null.
std::string diagnosis_json(const Diagnosis& diagnosis);
/// The model with the effect added: robot, overrides for what planning can have, effects for
/// simulation.
std::string augmented_yaml(const Diagnosis& diagnosis);
/// Writes both into a folder, made where it is absent.
void write_diagnosis(const Diagnosis& diagnosis, const std::filesystem::path& folder);
/// For people, some thirty lines.
std::string diagnosis_text(const Diagnosis& diagnosis);

}  // namespace jaculus::diagnosis
