#include "diagnosis/selection/line_search.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace jaculus::diagnosis {
namespace {

/// A step of the first parameter alone, and what it does to the misfit.
struct Point {
  double u = 0.0;             ///< prior scales
  double score = -kInfinity;  ///< log evidence gained, width of the valley by its slope
  double influence =
      kInfinity;  ///< norm of what the step changes; infinite where the simulation fails
};

bool scores_less(const Point& a, const Point& b) { return a.score < b.score; }
bool comes_before(const Point& a, const Point& b) { return a.u < b.u; }

/// u of the steps to try, within the parameter's bounds.
std::vector<double> steps_of(const FreeParameter& parameter, double value,
                             const Settings& settings) {
  const double step = probe_step(parameter, value, 1.0);
  const Bounds& bounds = parameter.bounds;
  const double range = bounds.upper - bounds.lower;
  const double highest = settings.line_search_highest;

  std::vector<double> steps;
  const auto add = [&](double move) {
    if (move != 0.0 && bounds.contains(value + move)) steps.push_back(move / parameter.scale);
  };
  if (range < highest * std::abs(step)) {
    const int spaces = settings.line_search_even;
    for (int i = 0; i <= spaces; ++i) add(bounds.lower + i * range / spaces - value);
    return steps;
  }
  for (double share = settings.line_search_lowest; share <= highest; share *= 2.0) {
    add(share * step);
    add(-share * step);
  }
  return steps;
}

/// Where points are evaluated.
struct Line {
  const Problem& problem;
  const Whitening& whitening;
  const Fit& base;
  int parameter = 0;
  double standing = 0.0;  ///< log evidence of the base model

  [[nodiscard]] Point at(double u) const {
    Vector p = base.p;
    p[parameter] += u * problem.hypotheses.parameters[parameter].scale;
    const PredictionSet set = predict_all(problem, p);
    if (!set.valid) return {u};

    const Vector r = whitening.residual(rows_of(problem, whitening.alignments, set));
    const double there =
        linear_evidence(-base.jacobian, r).log_evidence - 0.5 * r.squaredNorm() - 0.5 * u * u;
    const double influence = (r - base.residual).norm();
    const double width = 0.5 * std::log1p(influence * influence / (u * u));
    return {u, there - standing - width, influence};
  }
};

/// Whether an effect sets in between two steps: what it changes grows far beyond proportion, and
/// does harm.
bool sets_in(const Point& near, const Point& far, const Settings& settings) {
  const double proportional = near.influence * std::abs(far.u);
  return near.u != 0.0 && far.score < near.score - settings.threshold_harm &&
         far.influence * std::abs(near.u) > settings.threshold_growth * proportional;
}

/// The point past a threshold between `near` and `far` that helps, by halving; u = 0 where none
/// does.
Point past_threshold(const Line& line, Point near, Point far, long& predictions) {
  const Settings& settings = line.problem.settings;
  for (int i = 0; i < settings.threshold_halvings && sets_in(near, far, settings); ++i) {
    const Point middle = line.at(0.5 * (near.u + far.u));
    ++predictions;
    if (middle.score > 0.0) return middle;
    (middle.score < near.score - settings.threshold_harm ? far : near) = middle;
  }
  return {0.0, 0.0, 0.0};
}

}  // namespace

LinearEvidence linear_evidence(const Matrix& G, const Vector& r) {
  if (G.cols() == 0) return {};
  const Matrix A = G.transpose() * G + Matrix::Identity(G.cols(), G.cols());
  const Vector b = G.transpose() * r;
  const Eigen::LLT<Matrix> factor(A);
  const Vector mean = factor.solve(b);
  return {0.5 * b.dot(mean) - factor.matrixLLT().diagonal().array().log().sum(), mean};
}

double probe_step(const FreeParameter& parameter, double value, double share) {
  const double step = share * parameter.usual_step();
  return parameter.bounds.contains(value + step) ? step : -step;
}

BestStep line_search(const Problem& problem, const Whitening& whitening, const Fit& base,
                     int first) {
  const double alone = linear_evidence(-base.jacobian, base.residual).log_evidence;
  const Line line{problem, whitening, base, first, alone - 0.5 * base.residual.squaredNorm()};
  BestStep found;
  std::vector<Point> points{{0.0, 0.0, 0.0}};
  const FreeParameter& parameter = problem.hypotheses.parameters[first];
  for (const double u : steps_of(parameter, base.p[first], problem.settings)) {
    points.push_back(line.at(u));
    ++found.predictions;
  }

  Point best = *std::max_element(points.begin(), points.end(), scores_less);
  std::sort(points.begin(), points.end(), comes_before);
  for (std::size_t i = 0; i + 1 < points.size() && best.u == 0.0; ++i) {
    const bool below = points[i + 1].u <= 0.0;
    const Point &near = points[below ? i + 1 : i], &far = points[below ? i : i + 1];
    best = past_threshold(line, near, far, found.predictions);
  }

  if (best.u != 0.0) found.u = best.u;
  found.score = best.score;
  return found;
}

}  // namespace jaculus::diagnosis
