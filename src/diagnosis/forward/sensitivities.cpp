#include "diagnosis/forward/sensitivities.h"

#include <algorithm>

namespace jaculus::diagnosis {
namespace {

/// rows(moved) less those at another point, as a difference by `step`.
std::optional<Difference> difference_to(const Problem& problem,
                                        const std::vector<Alignment>& alignments,
                                        const Vector& moved, const std::vector<Vector>& rows_at_p,
                                        double step) {
  const PredictionSet there = predict_all(problem, moved);
  if (!there.valid) return {};

  Difference difference{step, rows_of(problem, alignments, there)};
  for (std::size_t d = 0; d < rows_at_p.size(); ++d) difference.rows[d] -= rows_at_p[d];
  return difference;
}

}  // namespace

std::optional<Difference> difference_at(const Problem& problem,
                                        const std::vector<Alignment>& alignments, const Vector& p,
                                        const std::vector<Vector>& rows_at_p, int parameter,
                                        double step) {
  Vector moved = p;
  moved[parameter] += step;
  return difference_to(problem, alignments, moved, rows_at_p, step);
}

std::optional<Difference> difference(const Problem& problem,
                                     const std::vector<Alignment>& alignments, const Vector& p,
                                     const std::vector<Vector>& rows_at_p, int parameter,
                                     double step) {
  const Bounds& bounds = problem.hypotheses.parameters[parameter].bounds;
  if (!bounds.contains(p[parameter] + step)) step = -step;

  auto found = difference_at(problem, alignments, p, rows_at_p, parameter, step);
  if (found || !bounds.contains(p[parameter] - step)) return found;
  return difference_at(problem, alignments, p, rows_at_p, parameter, -step);
}

std::optional<Difference> difference_along(const Problem& problem,
                                           const std::vector<Alignment>& alignments,
                                           const Vector& p, const std::vector<Vector>& rows_at_p,
                                           const Vector& move) {
  auto found = difference_to(problem, alignments, p + move, rows_at_p, 1.0);
  return found ? found : difference_to(problem, alignments, p - move, rows_at_p, -1.0);
}

double difference_step(double sensitivity, const Settings& settings) {
  return std::clamp(0.5 / (1.0 + sensitivity), settings.least_step, settings.most_step);
}

}  // namespace jaculus::diagnosis
