#include "jaculus/solver/violations.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace jaculus::solver {
namespace {

double distance(double value, double lower, double upper) {
  return std::max({0.0, lower - value, value - upper});
}

std::optional<Vector> row_values(transcription::Nlp& nlp, const ConstVectorRef& x) {
  assert(x.size() == nlp.variables());
  Vector values = Vector::Constant(nlp.rows(), kNaN);
  if (!nlp.constraints(x, values) || !values.allFinite()) return std::nullopt;
  return values;
}

}  // namespace

std::optional<std::vector<Violation>> ranked_violations(transcription::Nlp& nlp,
                                                        const ConstVectorRef& x, int count,
                                                        double least) {
  assert(count >= 0);
  const std::optional<Vector> values = row_values(nlp, x);
  if (!values) return std::nullopt;

  std::vector<Violation> found;
  const auto add = [&](bool is_row, int i, double value, double lower, double upper, double scale) {
    const double amount = distance(value, lower, upper);
    if (amount > least * scale)
      found.push_back({is_row, i, "", "", value, lower, upper, amount, amount / scale});
  };

  for (int i = 0; i < nlp.rows(); ++i) {
    add(true, i, (*values)[i], nlp.row_lower()[i], nlp.row_upper()[i], nlp.row_scale()[i]);
  }
  for (int i = 0; i < nlp.variables(); ++i) {
    add(false, i, x[i], nlp.variable_lower()[i], nlp.variable_upper()[i], nlp.variable_scale()[i]);
  }

  std::stable_sort(found.begin(), found.end(),
                   [](const auto& a, const auto& b) { return a.scaled > b.scaled; });
  if (count_of(found) > count) found.resize(count);

  for (Violation& v : found) {  // names are built only for what is shown
    v.name = v.is_row ? nlp.row_name(v.index) : nlp.variable_name(v.index);
    v.unit = v.is_row ? nlp.row_unit(v.index) : nlp.variable_unit(v.index);
  }
  return found;
}

std::optional<WorstViolation> worst_violation(transcription::Nlp& nlp, const ConstVectorRef& x) {
  const std::optional<Vector> values = row_values(nlp, x);
  if (!values) return std::nullopt;
  WorstViolation worst;
  const auto add = [&](double amount, double scale) {
    worst.absolute = std::max(worst.absolute, amount);
    worst.scaled = std::max(worst.scaled, amount / scale);
  };
  for (int i = 0; i < nlp.rows(); ++i) {
    add(distance((*values)[i], nlp.row_lower()[i], nlp.row_upper()[i]), nlp.row_scale()[i]);
  }
  for (int i = 0; i < nlp.variables(); ++i) {
    add(distance(x[i], nlp.variable_lower()[i], nlp.variable_upper()[i]), nlp.variable_scale()[i]);
  }
  return worst;
}

}  // namespace jaculus::solver
