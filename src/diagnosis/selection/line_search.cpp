#include "diagnosis/selection/line_search.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace jaculus::diagnosis {
namespace {

/// A step of the first parameter alone, and what it does to the misfit.
struct Point {
  double u = 0.0;             ///< prior scales
  double score = -kInfinity;  ///< log evidence gained, width of the valley by its slope
  double gain = -kInfinity;   ///< the same where the valley has no width
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
  const auto add = [&](double to) {
    if (to != value && bounds.contains(to)) steps.push_back((to - value) / parameter.scale);
  };
  if (range < highest * std::abs(step)) {
    const int spaces = settings.line_search_even;
    for (int i = 0; i < spaces; ++i) add(bounds.lower + i * range / spaces);
    add(bounds.upper);
    return steps;
  }
  for (double share = settings.line_search_lowest; share <= highest; share *= 2.0) {
    add(value + share * step);
    add(value - share * step);
  }
  return steps;
}

/// Where points are evaluated.
struct Line {
  const Problem& problem;
  const Whitening& whitening;
  const Fit& base;
  int parameter = 0;
  const Standing& standing;

  /// Log evidence gained by a smaller residual, as if it were one random effect in all directions
  /// that the random effects have: on the way to a valley a residual may be smaller and yet of a
  /// shape that no force has (a foot that slips too soon).
  [[nodiscard]] double gain_of_size(ConstVectorRef r) const {
    double directions = 0.0;
    for (const RandomBlock& block : whitening.random.blocks)
      directions += static_cast<double>(block.columns.cols());
    const double before = standing.model.X.col(0).squaredNorm(), now = r.squaredNorm();
    return 0.5 * std::min(directions, before) * std::log(before / std::max(now, 1e-300));
  }

  [[nodiscard]] Point at(double u) const { return at(std::vector<double>{u}).front(); }

  /// A point each.
  [[nodiscard]] std::vector<Point> at(const std::vector<double>& steps) const {
    std::vector<Point> points;
    std::vector<std::vector<Vector>> changes;  // of rows
    std::vector<std::size_t> simulated;        // of which steps they are
    for (const double u : steps) {
      points.push_back({u});
      Vector p = base.simulated;
      p[parameter] = problem.hypotheses.parameters[parameter].moved(p[parameter], u);
      const PredictionSet set = predict_all(problem, p);
      if (!set.valid) continue;
      changes.push_back(rows_of(problem, whitening.alignments, set));
      for (std::size_t d = 0; d < base.rows.size(); ++d) changes.back()[d] -= base.rows[d];
      simulated.push_back(points.size() - 1);
    }

    const Matrix moved = -whitening.columns(changes);
    const Across across = products_between(whitening.random, standing.model.X, moved);
    for (Eigen::Index k = 0; k < moved.cols(); ++k) {
      Point& point = points[simulated[static_cast<std::size_t>(k)]];
      point = scored(point.u, moved.col(k), across.of(k, 1));
    }
    return points;
  }

 private:
  /// Of a step that moves the residual by `moved`. The base model's own parameters move linearly
  /// along.
  [[nodiscard]] Point scored(double u, const Vector& moved, const Across& across) const {
    const RandomEffects& random = whitening.random;
    const Products own = products_of(random, moved);
    const ScaleEstimate followed =
        followed_by(problem, random, first_moved(standing.model.products, across, own), base.scales,
                    problem.settings.screening_scale_steps);
    const double evidence = followed.evidence() - 0.5 * u * u;
    const double energy = weigh(random, own, followed.scales).gram(0, 0);
    const double width = 0.5 * std::log1p(energy / (u * u));
    double gain = evidence - standing.log_evidence;
    const double smaller = gain_of_size(standing.model.X.col(0) + moved);
    if (smaller > 0.0) gain = std::max(gain, smaller - 0.5 * u * u);
    return {u, gain - width, gain, moved.norm()};
  }
};

/// Goes on about the best of some steps, each time to the middle of the wider space beside it.
/// Where data tell a parameter to a percent, a valley lies between steps that double, and a score
/// beside it says nothing of its depth. `points`: in the order of u.
Point refined(const Line& line, std::vector<Point> points, long& predictions) {
  auto best = std::max_element(points.begin(), points.end(), scores_less);
  for (int i = 0; i < line.problem.settings.line_search_refinements; ++i) {
    const double below = best == points.begin() ? 0.0 : best->u - std::prev(best)->u;
    const double above = std::next(best) == points.end() ? 0.0 : std::next(best)->u - best->u;
    const Point middle = line.at(best->u + (above > below ? 0.5 * above : -0.5 * below));
    ++predictions;
    points.insert(above > below ? std::next(best) : best, middle);
    best = std::max_element(points.begin(), points.end(), scores_less);
  }
  return *best;
}

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
    // Next to a threshold a valley is narrow: where it begins to help, a fit goes on.
    if (middle.gain > 0.0) return middle;
    (middle.score < near.score - settings.threshold_harm ? far : near) = middle;
  }
  return {0.0, 0.0, 0.0, 0.0};
}

}  // namespace

ScaleEstimate followed_by(const Problem& problem, const RandomEffects& random,
                          const Products& products, const Vector& scales, int steps) {
  return estimated_scales(random, products, scales, steps, problem.settings.scale_spread);
}

Standing standing_of(const Problem& problem, const Whitening& whitening, const Fit& base) {
  const RandomEffects& random = whitening.random;
  Columns model = columns_of(random, linear_model(problem, base));
  model.products.shared = shared_columns(problem, random, base);
  const double evidence = followed_by(problem, random, model.products, base.scales,
                                      problem.settings.screening_scale_steps)
                              .evidence();
  return {std::move(model), evidence};
}

double probe_step(const FreeParameter& parameter, double value, double share) {
  const double step = share * parameter.usual_step();
  return parameter.bounds.contains(value + step) ? step : -step;
}

BestStep line_search(const Problem& problem, const Whitening& whitening, const Fit& base,
                     const Standing& standing, int first) {
  const Line line{problem, whitening, base, first, standing};
  BestStep found;
  std::vector<Point> points{{0.0, 0.0, 0.0, 0.0}};
  const FreeParameter& parameter = problem.hypotheses.parameters[first];
  for (const Point& point : line.at(steps_of(parameter, base.p[first], problem.settings)))
    points.push_back(point);
  found.predictions = count_of(points) - 1;

  Point best = *std::max_element(points.begin(), points.end(), scores_less);
  std::sort(points.begin(), points.end(), comes_before);
  if (best.u != 0.0) best = refined(line, points, found.predictions);
  for (std::size_t i = 0; best.u == 0.0 && i + 1 < points.size(); ++i) {
    const bool below = points[i + 1].u <= 0.0;
    const Point &near = points[below ? i + 1 : i], &far = points[below ? i : i + 1];
    best = past_threshold(line, near, far, found.predictions);
  }

  if (best.u != 0.0) found.u = best.u;
  found.score = best.score;
  return found;
}

}  // namespace jaculus::diagnosis
