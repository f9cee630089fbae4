// 95 % intervals of parameters, checked by profile.

#include <algorithm>
#include <cmath>

#include "diagnosis/noise/random_weights.h"
#include "diagnosis/selection/fit.h"
#include "diagnosis/selection/interval_basis.h"
#include "diagnosis/selection/known_slopes.h"

namespace jaculus::diagnosis {
namespace {

constexpr double kFailed = 1e100;  // cost where the simulation fails

/// The costs along one free parameter of a fit, the others refitted.
class Profile {
 public:
  Profile(const Problem& problem, const Whitening& whitening, const Fit& fit,
          const IntervalBasis& basis, Eigen::Index place)
      : problem_(problem),
        whitening_(whitening),
        fit_(fit),
        place_(place),
        weights_(whitening.random, basis.scales) {
    std::vector<Eigen::Index> columns;
    for (Eigen::Index k = 0; k < fit.jacobian.cols(); ++k) {
      if (k == place) continue;
      others_.push_back(fit.free[k]);
      columns.push_back(k);
    }
    slopes_ = fit.jacobian(Eigen::all, columns);
    along_ = basis.covariance.col(place)(columns) / basis.covariance(place, place);
    cost_ = fit.by_slopes() || basis.scales != fit.scales ? reached(value()) : fit.cost;
  }

  [[nodiscard]] const FreeParameter& own() const {
    return problem_.hypotheses.parameters[fit_.free[place_]];
  }
  [[nodiscard]] double value() const { return fit_.p[fit_.free[place_]]; }

  /// By how much the cost at a value of the parameter is more than the fit's; kFailed where it
  /// can't be had. The others begin where slopes have them: du = (H^-1)_oi/(H^-1)_ii du_i.
  [[nodiscard]] double risen(double value) const {
    return std::min(reached(value) - cost_, kFailed);
  }

 private:
  [[nodiscard]] double reached(double value) const {
    const double moved = (value - this->value()) / own().scale;
    const Vector u = problem_.hypotheses.scaled(others_, fit_.p) + moved * along_;
    Vector p = problem_.hypotheses.unscaled(others_, u, fit_.p);
    p[fit_.free[place_]] = value;
    const NearFit there = fit_by_known_slopes(problem_, whitening_, weights_, others_, slopes_, p,
                                              problem_.settings.profile_iterations);
    const double own_u = (value - own().nominal) / own().scale;
    return there.valid ? there.cost + 0.5 * own_u * own_u : kFailed;
  }

  const Problem& problem_;
  const Whitening& whitening_;
  const Fit& fit_;
  Eigen::Index place_;
  RandomWeights weights_;
  std::vector<int> others_;
  Matrix slopes_;
  Vector along_;
  double cost_ = 0.0;
};

/// End of the interval on one side, `quantile` deviations away where the cost is quadratic.
double interval_end(const Profile& profile, const Settings& settings, double deviation,
                    double quantile, double side) {
  const Bounds& bounds = profile.own().bounds;
  const double from = profile.value(), rise = 0.5 * quantile * quantile;
  const double end = std::clamp(from + side * quantile * deviation, bounds.lower, bounds.upper);
  if (end == from) return end;
  const double share = (end - from) / (side * quantile * deviation);
  const double expected = rise * share * share;
  if (std::abs(profile.risen(end) - expected) < settings.profile_tolerance * rise) return end;
  double inside = from, outside = end;
  for (int i = 0; i < settings.profile_doublings && profile.risen(outside) < rise; ++i) {
    inside = outside;
    outside = std::clamp(from + 2.0 * (outside - from), bounds.lower, bounds.upper);
    if (outside == inside) return outside;
  }

  for (int i = 0; i < settings.profile_halvings; ++i) {
    const double middle = 0.5 * (inside + outside);
    (profile.risen(middle) < rise ? inside : outside) = middle;
  }

  return 0.5 * (inside + outside);
}

/// A parameter and what tolerances add to it.
struct Sum {
  double value = 0.0;  ///< in the parameter's unit, within its bounds
  Vector along;        ///< d(value)/du of the free parameters
};

/// What a candidate's parameters add for each tolerance, halfway to their sum with all of them: the
/// midpoint rule, for a share (friction that differs by direction) falls as what it is of grows.
Matrix part_halfway(const Problem& problem, const Fit& fit, int candidate) {
  const Hypotheses& hypotheses = problem.hypotheses;
  const std::vector<int>& parameters = hypotheses.candidates[candidate].parameters;
  const Vector t = fit.p(hypotheses.tolerances);
  const Vector half = 0.5 * (problem.tolerance_part(candidate, fit.p) * t);
  Vector p = fit.p;
  for (int k = 0; k < count_of(parameters); ++k) {
    const Bounds& bounds = hypotheses.parameters[parameters[k]].bounds;
    p[parameters[k]] = std::clamp(p[parameters[k]] + half[k], bounds.lower, bounds.upper);
  }
  return problem.tolerance_part(candidate, p);
}

/// Of each parameter of a candidate that the fit frees.
std::vector<Sum> sums_with_tolerances(const Problem& problem, const Fit& fit, int candidate) {
  const Hypotheses& hypotheses = problem.hypotheses;
  const std::vector<int>& parameters = hypotheses.candidates[candidate].parameters;
  const bool tolerated = problem.tolerance_part && !hypotheses.tolerances.empty();
  const Matrix part = tolerated ? part_halfway(problem, fit, candidate) : Matrix();

  std::vector<Sum> sums;
  for (int k = 0; k < count_of(parameters); ++k) {
    const int i = parameters[k];
    const FreeParameter& own = hypotheses.parameters[i];
    Sum sum{fit.p[i], own.scale * Vector::Unit(count_of(fit.free), index_of(fit.free, i))};
    for (int j = 0; j < part.cols(); ++j) {
      const int tolerance = hypotheses.tolerances[j], place = index_of(fit.free, tolerance);
      if (place < 0 || part(k, j) == 0.0) continue;
      sum.value += part(k, j) * fit.p[tolerance];
      sum.along[place] = part(k, j) * hypotheses.parameters[tolerance].scale;
    }

    sum.value = std::clamp(sum.value, own.bounds.lower, own.bounds.upper);
    sums.push_back(sum);
  }
  return sums;
}

/// interval95() by the basis of its fit.
Bounds interval_on(const IntervalBasis& basis, const Problem& problem, const Whitening& whitening,
                   const Fit& fit, int parameter) {
  const auto place = std::find(fit.free.begin(), fit.free.end(), parameter) - fit.free.begin();
  const Profile profile(problem, whitening, fit, basis, place);
  const FreeParameter& own = profile.own();
  const Vector own_alone = Vector::Unit(fit.jacobian.cols(), place);
  const double deviation = own.scale * basis.deviation(own_alone);
  const double quantile = basis.quantile(own_alone);
  const double wider = widening(whitening, fit, own_alone), value = profile.value();
  const auto end = [&](double side) {
    const double told = interval_end(profile, problem.settings, deviation, quantile, side) - value;
    return std::clamp(value + wider * told, own.bounds.lower, own.bounds.upper);
  };
  return {end(-1.0), end(1.0)};
}

}  // namespace

double widening(const Whitening& whitening, const Fit& fit, const Vector& along) {
  const std::vector<RandomBlock>& blocks = whitening.random.blocks;
  // Parameters that the data tell: a tolerance that they don't moves no score.
  const auto windows = static_cast<double>(blocks.size()),
             free = static_cast<double>(fit.jacobian.cols()) - fit.covariance.trace();
  if (windows < 2.0 * free) return 1.0;  // too few to tell

  // With j = J H^-1 a: observed sum of (j_w^T V^-1 r_w)^2, expected sum of j_w^T (V^-1)_ww j_w.
  const RandomWeights weights(whitening.random, fit.scales);
  const Vector r = weights.inverse(fit.residual), j = fit.jacobian * (fit.covariance * along);
  double observed = 0.0, expected = 0.0;
  for (const RandomBlock& block : blocks) {
    Vector own = Vector::Zero(j.size());
    own.segment(block.first, block.count) = j.segment(block.first, block.count);
    observed += std::pow(own.dot(r), 2);
    expected += own.dot(weights.inverse(own).col(0));
  }
  return std::sqrt(std::max(1.0, observed / expected * windows / (windows - free)));
}

Bounds interval95(const Problem& problem, const Whitening& whitening, const Fit& fit,
                  int parameter) {
  return interval_on(interval_basis(whitening, fit), problem, whitening, fit, parameter);
}

std::vector<Estimate> with_tolerances(const Problem& problem, const Whitening& whitening,
                                      const Fit& fit, int candidate) {
  const std::vector<Sum> sums = sums_with_tolerances(problem, fit, candidate);
  const IntervalBasis basis = interval_basis(whitening, fit);
  std::vector<Estimate> estimates;
  for (int k = 0; k < count_of(sums); ++k) {
    const Sum& sum = sums[k];
    const int i = problem.hypotheses.candidates[candidate].parameters[k];
    if ((sum.along.array() != 0.0).count() == 1) {
      estimates.push_back({sum.value, interval_on(basis, problem, whitening, fit, i)});
      continue;
    }

    const Bounds& bounds = problem.hypotheses.parameters[i].bounds;
    const double half = basis.quantile(sum.along) * widening(whitening, fit, sum.along) *
                        basis.deviation(sum.along);
    estimates.push_back({sum.value,
                         {std::clamp(sum.value - half, bounds.lower, bounds.upper),
                          std::clamp(sum.value + half, bounds.lower, bounds.upper)}});
  }
  return estimates;
}

Vector theta_with_tolerances(const Problem& problem, const Fit& fit, int candidate) {
  const std::vector<Sum> sums = sums_with_tolerances(problem, fit, candidate);
  Vector theta(count_of(sums));
  for (int k = 0; k < theta.size(); ++k) theta[k] = sums[k].value;
  return theta;
}

}  // namespace jaculus::diagnosis
