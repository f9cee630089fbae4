#include "diagnosis/selection/push_scan.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "diagnosis/forward/missing_forces.h"
#include "diagnosis/selection/line_search.h"

namespace jaculus::diagnosis {
namespace {

constexpr double kShortest = 0.05, kLongest = 0.5;  ///< pushes that are sought [s]
constexpr double kLengthRatio = std::numbers::sqrt2;
constexpr double kStartsALength = 4.0;  ///< starts are no farther apart than a push by this
constexpr std::size_t kTriedAgain = 6;  ///< of a coordinate, with deviations that follow
constexpr double kBoxesAPush = 4.0;     ///< of the shortest push
constexpr double kMostBoxes = 500.0;    ///< of all coordinates: each is a simulation
/// What a fit may make of a push that was found.
constexpr Bounds kLengths{0.01, 1.0};  ///< [s]
constexpr double kLengthScale = 0.1;   ///< [s]
constexpr double kLargestPeak = 30.0;  ///< in forces that count as large [-]

/// A push of one size as forces over narrow boxes.
struct ScannedPush {
  int force = -1;                    ///< index in Hypotheses::forces
  double start = 0.0, length = 0.0;  ///< [s]
  Vector weights;                    ///< of all boxes of all coordinates
  double gain = 0.0;                 ///< at deviations that stay
};

/// Means of half a sine over boxes of time that follow one another.
Vector means_over_boxes(double start, double length, double box, Eigen::Index boxes) {
  Vector until(boxes + 1);
  for (Eigen::Index k = 0; k <= boxes; ++k) {
    const double into = std::clamp((static_cast<double>(k) * box - start) / length, 0.0, 1.0);
    until[k] = length / std::numbers::pi * (1.0 - std::cos(std::numbers::pi * into));
  }
  return (until.tail(boxes) - until.head(boxes)) / box;
}

/// Every push that is tried.
std::vector<ScannedPush> pushes_of(const Problem& narrow) {
  const std::vector<ForceGroup>& forces = narrow.hypotheses.forces;
  const double box = narrow.settings.force_box;
  Eigen::Index all = 0, first = 0;
  for (const ForceGroup& force : forces) all += std::ssize(force.boxes);

  std::vector<ScannedPush> pushes;
  for (int force = 0; force < count_of(forces); ++force) {
    const Eigen::Index own = std::ssize(forces[force].boxes);
    const double end = box * static_cast<double>(own);
    for (double length = kShortest; length <= std::min(kLongest, end); length *= kLengthRatio) {
      for (double start = 0.0; start + length <= end; start += length / kStartsALength) {
        ScannedPush push{force, start, length, Vector::Zero(all)};
        push.weights.segment(first, own) = means_over_boxes(start, length, box, own);
        pushes.push_back(std::move(push));
      }
    }
    first += own;
  }
  return pushes;
}

/// Products of [X F], X = [r Y], and how many columns X has.
struct ScanProducts {
  Products all;
  Eigen::Index model = 0;
};

ScanProducts scan_products(const Problem& problem, const Problem& narrow,
                           const Comparison& comparison, const Fit& none) {
  // Forces come last, so that all before them stand where they do in the problem.
  Vector p = narrow.hypotheses.nominal();
  const int first = narrow.hypotheses.forces.front().boxes.front();
  p.head(first) = none.simulated.head(first);
  const RandomColumns columns =
      random_columns(narrow, comparison.whitening.alignments, p, none.rows);
  const Matrix& raw = columns.forces.front();

  const Matrix model = linear_model(problem, none);
  Matrix X(model.rows(), model.cols() + raw.cols());
  X.leftCols(model.cols()) = model;
  for (Eigen::Index k = 0; k < raw.cols(); ++k)
    X.col(model.cols() + k) = comparison.whitening.apply({Vector(raw.col(k))});
  return {products_of(comparison.whitening.random, X), model.cols()};
}

/// Products of [X F P].
Products with_pushes(const ScanProducts& products, const Matrix& P) {
  const Eigen::Index n = products.model, m = P.cols();
  const Matrix& gram = products.all.gram;
  const Eigen::Index boxes = gram.cols() - n;
  const Matrix XP = gram.topRightCorner(n, boxes) * P;
  Products out{Matrix(n + m, n + m), {}};
  out.gram << gram.topLeftCorner(n, n), XP, XP.transpose(),
      P.transpose() * gram.bottomRightCorner(boxes, boxes) * P;
  for (const Matrix& own : products.all.blocks) {
    out.blocks.emplace_back(own.rows(), n + m);
    out.blocks.back() << own.leftCols(n), own.rightCols(boxes) * P;
  }
  return out;
}

/// What each push adds to the log evidence of X at deviations that stay: with a and b its energy
/// and what of it is in r, both after the others and by V^-1,
///   (b^2/(1 + a) - log(1 + a))/2.
void set_gains(const RandomEffects& random, const ScanProducts& products, const Vector& scales,
               std::vector<ScannedPush>& pushes) {
  Matrix P(pushes.front().weights.size(), std::ssize(pushes));
  for (Eigen::Index k = 0; k < P.cols(); ++k) P.col(k) = pushes[k].weights;
  const Matrix gram = weigh(random, with_pushes(products, P), scales).gram;
  const Eigen::Index n = products.model - 1, m = P.cols();

  Matrix A = gram.block(1, 1, n, n);
  A.diagonal().array() += 1.0;
  const Eigen::LLT<Matrix> factor(A);
  const Matrix cross = gram.block(1, n + 1, n, m);
  const Matrix taken = factor.solve(cross);
  const Vector left = gram.col(0).tail(m) - taken.transpose() * gram.col(0).segment(1, n);
  for (Eigen::Index k = 0; k < m; ++k) {
    const double energy =
        std::max(0.0, gram(n + 1 + k, n + 1 + k) - cross.col(k).dot(taken.col(k)));
    pushes[k].gain = 0.5 * (left[k] * left[k] / (1.0 + energy) - std::log1p(energy));
  }
}

/// The best of a coordinate's pushes by deviations that follow.
LikelyPush best_along(const Problem& problem, const RandomEffects& random,
                      const ScanProducts& products, const Followed& without,
                      const std::vector<ScannedPush>& pushes) {
  LikelyPush best;
  best.gain = -kInfinity;
  for (const ScannedPush& push : pushes) {
    const Followed with = followed_by(problem, random, with_pushes(products, push.weights),
                                      without.scales, problem.settings.set_scale_steps);
    const double gain = with.linear.log_evidence - without.linear.log_evidence;
    if (!(gain > best.gain)) continue;
    const ForceGroup& force = problem.hypotheses.forces[push.force];
    const double scale = problem.hypotheses.parameters[force.boxes.front()].scale;
    const double peak = scale * with.linear.mean[with.linear.mean.size() - 1];
    best = {force.name, push.start, push.length, peak, gain};
  }
  return best;
}

}  // namespace

double scanned_box(const Problem& problem) {
  const double duration = problem.observations.datasets.front().window_end;
  const double all = duration * static_cast<double>(problem.hypotheses.forces.size());
  return std::min(problem.settings.force_box, std::max(kShortest / kBoxesAPush, all / kMostBoxes));
}

std::vector<LikelyPush> likely_pushes(const Problem& problem, const Problem& narrow,
                                      const Comparison& comparison, const Fit& none, int most) {
  const RandomEffects& random = comparison.whitening.random;
  std::vector<ScannedPush> pushes = pushes_of(narrow);
  if (in_windows(problem) || problem.observations.datasets.size() != 1 || pushes.empty()) return {};

  const ScanProducts products = scan_products(problem, narrow, comparison, none);
  set_gains(random, products, none.scales, pushes);
  std::stable_sort(pushes.begin(), pushes.end(),
                   [](const ScannedPush& a, const ScannedPush& b) { return a.gain > b.gain; });
  const Followed without =
      followed_by(problem, random, with_pushes(products, Matrix(pushes.front().weights.size(), 0)),
                  none.scales, problem.settings.set_scale_steps);

  std::vector<LikelyPush> likely;
  for (int force = 0; force < count_of(problem.hypotheses.forces); ++force) {
    std::vector<ScannedPush> along;
    for (const ScannedPush& push : pushes)
      if (push.force == force && along.size() < kTriedAgain) along.push_back(push);
    const LikelyPush best = best_along(problem, random, products, without, along);
    if (std::isfinite(best.gain)) likely.push_back(best);
  }
  std::stable_sort(likely.begin(), likely.end(),
                   [](const LikelyPush& a, const LikelyPush& b) { return a.gain > b.gain; });
  if (count_of(likely) > most) likely.resize(most);
  return likely;
}

effects::Effect push_effect(const Problem& problem, const LikelyPush& push, double duration) {
  const auto& forces = problem.hypotheses.forces;
  const auto own = std::find_if(forces.begin(), forces.end(),
                                [&](const ForceGroup& f) { return f.name == push.coordinate; });
  const FreeParameter& box = problem.hypotheses.parameters[own->boxes.front()];
  const double middle = push.start + 0.5 * push.length;

  effects::Effect effect;
  effect.name = "push@" + push.coordinate;
  effect.caption = "something pushes once along " + push.coordinate;
  effect.where = {effects::Component::body};
  effect.event = true;
  effect.of_plan = true;
  const double most = kLargestPeak * box.scale;
  effect.parameters = {{"peak", box.unit, 0.0, {-most, most}, box.scale, push.peak},
                       {"middle", "s", middle, {0.0, duration}, duration / std::sqrt(12.0)},
                       {"length", "s", push.length, kLengths, kLengthScale}};
  effect.applies = [name = push.coordinate](const model::PlanarModel& robot) {
    return has_place(robot, name);
  };
  effect.apply = [name = push.coordinate](const Vector& theta, simulation::Plant& plant) {
    simulation::Push half = box_push(name, theta[0], theta[1] - 0.5 * theta[2], theta[2]);
    half.half_sine = true;
    plant.pushes.push_back(half);
  };
  effect.overrides = [](const Vector&, const model::PlanarModel&) {
    return std::vector<effects::ModelOverride>{};
  };
  return effect;
}

}  // namespace jaculus::diagnosis
