#pragma once
// The comparison of solved problems as text, JSON and CSV.

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "jaculus/report/summary.h"
#include "jaculus/studies/compare.h"

namespace jaculus {

/// One solved problem in a comparison.
struct ComparisonRow {
  Summary summary;
  TailKind kind = TailKind::none;
  std::string conditions;  ///< jaculus::conditions() of its problem
};

std::vector<ComparedPlan> compared_plans(const std::vector<ComparisonRow>& rows);

/// compare.json: `problems`, each with everything of its summary and its gains; `reference`; `drag_worth`.
nlohmann::ordered_json comparison_json(const std::vector<ComparisonRow>& rows);
/// compare.csv: one row a problem, units in the header, empty where there is no figure.
std::string comparison_csv(const std::vector<ComparisonRow>& rows);
/// The table that `jaculus compare` prints.
std::string comparison_text(const std::vector<ComparisonRow>& rows, bool colour);

}  // namespace jaculus
