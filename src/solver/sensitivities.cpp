#include "jaculus/solver/sensitivities.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace jaculus::solver {
namespace {

class SensitivityList {
 public:
  SensitivityList(const transcription::Nlp& nlp, const SensitivityOptions& options)
      : nlp_(nlp), options_(options) {}

  void add(bool is_row, int index, Side side, double limit, double by_limit) {
    const double scale = is_row ? nlp_.row_scale()[index] : nlp_.variable_scale()[index];
    const double rate = options_.maximise ? -by_limit : by_limit;
    const double scaled = rate * scale / nlp_.objective_scale();
    if (!(std::abs(scaled) > options_.threshold) || !std::isfinite(limit)) return;
    if (side == Side::fixed && !options_.equalities) return;
    list_.push_back({is_row, index, is_row ? nlp_.row_name(index) : nlp_.variable_name(index),
                     is_row ? nlp_.row_unit(index) : nlp_.variable_unit(index), side, limit, rate,
                     scaled});
  }

  std::vector<LimitSensitivity> ranked() {
    std::stable_sort(list_.begin(), list_.end(), [](const auto& a, const auto& b) {
      return std::abs(a.scaled) > std::abs(b.scaled);
    });
    return std::move(list_);
  }

 private:
  const transcription::Nlp& nlp_;
  const SensitivityOptions& options_;
  std::vector<LimitSensitivity> list_;
};

}  // namespace

std::vector<LimitSensitivity> limit_sensitivities(const transcription::Nlp& nlp,
                                                  const NlpResult& result,
                                                  const SensitivityOptions& options) {
  // refuses a result that did not converge, in every build
  [[maybe_unused]] const Vector& x = result.x();
  assert(x.size() == nlp.variables());
  SensitivityList list(nlp, options);

  for (int i = 0; i < nlp.rows(); ++i) {
    const double lower = nlp.row_lower()[i], upper = nlp.row_upper()[i];
    const double lambda = result.row_multipliers[i];
    // The multiplier of a range row says by its sign which end is active.
    const Side side = lower == upper ? Side::fixed : (lambda > 0.0 ? Side::upper : Side::lower);
    list.add(true, i, side, side == Side::upper ? upper : lower, -lambda);
  }

  for (int i = 0; i < nlp.variables(); ++i) {
    const double lower = nlp.variable_lower()[i], upper = nlp.variable_upper()[i];
    if (lower == upper) {
      list.add(false, i, Side::fixed, lower,
               result.lower_multipliers[i] - result.upper_multipliers[i]);
      continue;
    }
    list.add(false, i, Side::lower, lower, result.lower_multipliers[i]);
    list.add(false, i, Side::upper, upper, -result.upper_multipliers[i]);
  }

  return list.ranked();
}

std::string to_string(Side side) {
  return side == Side::lower ? "lower" : side == Side::upper ? "upper" : "fixed";
}

}  // namespace jaculus::solver
