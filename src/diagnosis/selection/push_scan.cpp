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
constexpr std::size_t kAtOnce = 200;    ///< pushes whose columns stand side by side
constexpr double kLengthScale = 0.1;    ///< [s]
constexpr double kLargestPeak = 30.0;   ///< in forces that count as large [-]

/// What acts as long as the motion takes is no push: it has to begin or end within.
double longest_push(double duration) { return std::min(kLongest, duration); }

/// A push of one size.
struct ScannedPush {
  int force = -1;                     ///< index in Hypotheses::forces
  Eigen::Index first = 0, boxes = 0;  ///< of its coordinate among all narrow boxes
  double start = 0.0, length = 0.0;   ///< [s]
  double gain = 0.0;                  ///< at deviations that stay
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
  const double end = narrow.observations.datasets.front().window_end;
  std::vector<ScannedPush> pushes;
  Eigen::Index first = 0;
  for (int force = 0; force < count_of(forces); ++force) {
    const Eigen::Index own = std::ssize(forces[force].boxes);
    for (double length = kShortest; length <= longest_push(end); length *= kLengthRatio)
      for (double start = 0.0; start + length <= end; start += length / kStartsALength)
        pushes.push_back({force, first, own, start, length});
    first += own;
  }
  return pushes;
}

/// Forces of some pushes over all narrow boxes, a column each.
Matrix weights_of(const std::vector<ScannedPush>& pushes, std::size_t from, std::size_t count,
                  const Problem& narrow) {
  Eigen::Index boxes = 0;
  for (const ForceGroup& force : narrow.hypotheses.forces) boxes += std::ssize(force.boxes);
  Matrix P = Matrix::Zero(boxes, static_cast<Eigen::Index>(count));
  for (std::size_t k = 0; k < count; ++k) {
    const ScannedPush& push = pushes[from + k];
    P.col(static_cast<Eigen::Index>(k)).segment(push.first, push.boxes) =
        means_over_boxes(push.start, push.length, narrow.settings.force_box, push.boxes);
  }
  return P;
}

/// Products of [X F], X = [r Y], and how many columns X has.
struct ScanProducts {
  Products all;
  Eigen::Index model = 0;
};

ScanProducts scan_products(const Problem& problem, const Problem& narrow,
                           const Comparison& comparison, const Fit& about) {
  // Forces come last, so that all before them stand where they do in the problem.
  Vector p = narrow.hypotheses.nominal();
  const int first = narrow.hypotheses.forces.front().boxes.front();
  p.head(first) = about.simulated.head(first);
  const RandomColumns columns =
      random_columns(narrow, comparison.whitening.alignments, p, about.rows);
  const Matrix& raw = columns.forces.front();

  const Matrix model = linear_model(problem, about);
  Matrix X(model.rows(), model.cols() + raw.cols());
  X.leftCols(model.cols()) = model;
  std::vector<std::vector<Vector>> forces;
  for (Eigen::Index k = 0; k < raw.cols(); ++k) forces.push_back({raw.col(k)});
  X.rightCols(raw.cols()) = comparison.whitening.columns(forces);
  ScanProducts products{products_of(comparison.whitening.random, X), model.cols()};
  products.all.shared = shared_columns(problem, comparison.whitening.random, about);
  return products;
}

/// Products of [X F P].
Products with_pushes(const ScanProducts& products, const Matrix& P) {
  const Eigen::Index n = products.model, m = P.cols(), boxes = products.all.gram.cols() - n;
  const auto of_pushes = [&](const Matrix& gram) {
    const Matrix XP = gram.topRightCorner(n, boxes) * P;
    Matrix both(n + m, n + m);
    both << gram.topLeftCorner(n, n), XP, XP.transpose(),
        P.transpose() * gram.bottomRightCorner(boxes, boxes) * P;
    return both;
  };
  Products out{of_pushes(products.all.gram), {}, {}};
  out.shared = products.all.shared;
  for (const Matrix& own : products.all.misfits) out.misfits.push_back(of_pushes(own));
  for (const Matrix& own : products.all.blocks) {
    out.blocks.emplace_back(own.rows(), n + m);
    out.blocks.back() << own.leftCols(n), own.rightCols(boxes) * P;
  }
  return out;
}

/// What pushes P add to the log evidence of X at deviations that stay: with a and b the energy of
/// one and what of it is in r, both after the others and by V^-1,
///   (b^2/(1 + a) - log(1 + a))/2.
Vector gains_of(const RandomEffects& random, const ScanProducts& products, const Vector& scales,
                const Matrix& P) {
  const Matrix gram = weigh(random, with_pushes(products, P), scales).gram;
  const Eigen::Index n = products.model - 1, m = P.cols();
  Matrix A = gram.block(1, 1, n, n);
  A.diagonal().array() += 1.0;
  const Eigen::LLT<Matrix> factor(A);
  const Matrix cross = gram.block(1, n + 1, n, m);
  const Matrix taken = factor.solve(cross);
  const Vector left = gram.col(0).tail(m) - taken.transpose() * gram.col(0).segment(1, n);

  Vector gains(m);
  for (Eigen::Index k = 0; k < m; ++k) {
    const double energy =
        std::max(0.0, gram(n + 1 + k, n + 1 + k) - cross.col(k).dot(taken.col(k)));
    gains[k] = 0.5 * (left[k] * left[k] / (1.0 + energy) - std::log1p(energy));
  }
  return gains;
}

void set_gains(const RandomEffects& random, const ScanProducts& products, const Vector& scales,
               const Problem& narrow, std::vector<ScannedPush>& pushes) {
  for (std::size_t from = 0; from < pushes.size(); from += kAtOnce) {
    const std::size_t count = std::min(kAtOnce, pushes.size() - from);
    const Vector gains =
        gains_of(random, products, scales, weights_of(pushes, from, count, narrow));
    for (std::size_t k = 0; k < count; ++k)
      pushes[from + k].gain = gains[static_cast<Eigen::Index>(k)];
  }
}

/// The best of a coordinate's pushes by deviations that follow.
LikelyPush best_along(const Problem& problem, const Problem& narrow, const RandomEffects& random,
                      const ScanProducts& products, const ScaleEstimate& without,
                      const std::vector<ScannedPush>& pushes) {
  LikelyPush best;
  best.gain = -kInfinity;
  for (std::size_t k = 0; k < pushes.size(); ++k) {
    const ScannedPush& push = pushes[k];
    const Products own = with_pushes(products, weights_of(pushes, k, 1, narrow));
    const ScaleEstimate with =
        followed_by(problem, random, own, without.scales, problem.settings.set_scale_steps);
    const double gain = with.evidence() - without.evidence();
    if (!(gain > best.gain)) continue;
    const ForceGroup& force = problem.hypotheses.forces[push.force];
    const double scale = problem.hypotheses.parameters[force.boxes.front()].scale;
    const double peak = scale * with.mean[with.mean.size() - 1];
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
                                      const Comparison& comparison, const Fit& about, int most) {
  const RandomEffects& random = comparison.whitening.random;
  std::vector<ScannedPush> pushes = pushes_of(narrow);
  if (in_windows(problem) || problem.observations.datasets.size() != 1 || pushes.empty()) return {};

  const ScanProducts products = scan_products(problem, narrow, comparison, about);
  set_gains(random, products, about.scales, narrow, pushes);
  std::stable_sort(pushes.begin(), pushes.end(),
                   [](const ScannedPush& a, const ScannedPush& b) { return a.gain > b.gain; });
  const ScaleEstimate without =
      followed_by(problem, random, with_pushes(products, weights_of(pushes, 0, 0, narrow)),
                  about.scales, problem.settings.set_scale_steps);

  std::vector<LikelyPush> likely;
  for (int force = 0; force < count_of(problem.hypotheses.forces); ++force) {
    std::vector<ScannedPush> along;
    for (const ScannedPush& push : pushes)
      if (push.force == force && along.size() < kTriedAgain) along.push_back(push);
    const LikelyPush best = best_along(problem, narrow, random, products, without, along);
    if (best.gain > 0.0) likely.push_back(best);
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
  const bool of_body =
      problem.observations.datasets.front().model.body_of_joint(push.coordinate) < 0;
  effect.where = {of_body ? effects::Component::body : effects::Component::actuation};
  effect.event = true;
  effect.of_plan = true;
  const double most = kLargestPeak * box.scale;
  effect.parameters = {{"peak", box.unit, 0.0, {-most, most}, box.scale, push.peak},
                       {"middle", "s", middle, {0.0, duration}, duration / std::sqrt(12.0)},
                       {"length",
                        "s",
                        push.length,
                        {kShortest / kBoxesAPush, longest_push(duration)},
                        kLengthScale}};
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
