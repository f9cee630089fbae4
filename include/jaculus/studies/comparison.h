#pragma once
// The comparison of solved problems as values, JSON and CSV: every plan's summary beside its gains.

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "jaculus/model/planar.h"
#include "jaculus/solver/summary.h"
#include "jaculus/studies/compare.h"
#include "jaculus/transcription/problem.h"

namespace jaculus::studies {

/// One solved problem in a comparison.
struct ComparisonRow {
  solver::Summary summary;
  TailKind tail = TailKind::none;  ///< what the robot's tail may do
  std::string conditions;          ///< studies::conditions() of its problem
};

/// `model` is the robot with the problem's overrides, nothing locked.
ComparisonRow comparison_row(const transcription::Problem& problem, const model::PlanarModel& model,
                             const solver::Summary& summary);

/// What gains() and drag_worth() need of the rows, in their order.
std::vector<ComparedPlan> compared_plans(const std::vector<ComparisonRow>& rows);

/// compare.json: `problems`, each with everything of its summary and its gains; `reference`;
/// `drag_worth`.
nlohmann::ordered_json comparison_json(const std::vector<ComparisonRow>& rows);

/// compare.csv: one row a problem, units in the header, empty where there is no figure.
std::string comparison_csv(const std::vector<ComparisonRow>& rows);

/// Both into a folder that is there.
void write_comparison(const std::vector<ComparisonRow>& rows, const std::filesystem::path& folder);

}  // namespace jaculus::studies
