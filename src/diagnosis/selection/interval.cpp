// 95 % intervals of parameters, checked by profile.

#include <algorithm>
#include <cmath>

#include "diagnosis/noise/quantiles.h"
#include "diagnosis/noise/random_weights.h"
#include "diagnosis/selection/fit.h"

namespace jaculus::diagnosis {
namespace {

constexpr double kFailed = 1e100;  // cost where the simulation fails

/// Cost at u_i = value with the others refitted; kFailed where it can't be had.
double profile(const Problem& problem, const Whitening& whitening, const Fit& fit, int parameter,
               double p_value) {
  std::vector<int> others;
  for (const int i : fit.free)
    if (i != parameter) others.push_back(i);
  Vector p = fit.p;
  p[parameter] = p_value;
  FitOptions options;
  options.iterations = problem.settings.profile_iterations;
  options.scales = fit.scales;
  options.hold_scales = true;
  options.beside = fit.jacobian;
  const Fit there = fit_model(problem, whitening, others, {p}, options);
  const FreeParameter& own = problem.hypotheses.parameters[parameter];
  const double u = (p_value - own.nominal) / own.scale;
  return there.valid ? there.cost + 0.5 * u * u : kFailed;
}

/// End of the interval on one side.
double interval_end(const Problem& problem, const Whitening& whitening, const Fit& fit,
                    int parameter, double deviation, double side) {
  const FreeParameter& own = problem.hypotheses.parameters[parameter];
  const double from = fit.p[parameter],
               rise = 0.5 * quantiles::kTwoSided95 * quantiles::kTwoSided95;
  const double end = std::clamp(from + side * quantiles::kTwoSided95 * deviation, own.bounds.lower,
                                own.bounds.upper);
  if (end == from) return end;
  const double share = (end - from) / (side * quantiles::kTwoSided95 * deviation);
  const double risen = profile(problem, whitening, fit, parameter, end) - fit.cost;
  const double expected = rise * share * share;
  if (std::abs(risen - expected) < problem.settings.profile_tolerance * rise) return end;
  double inside = from, outside = end;
  const int doublings = problem.settings.profile_doublings;
  for (int i = 0;
       i < doublings && profile(problem, whitening, fit, parameter, outside) - fit.cost < rise;
       ++i) {
    inside = outside;
    outside = std::clamp(from + 2.0 * (outside - from), own.bounds.lower, own.bounds.upper);
    if (outside == inside) return outside;
  }

  for (int i = 0; i < problem.settings.profile_halvings; ++i) {
    const double middle = 0.5 * (inside + outside);
    (profile(problem, whitening, fit, parameter, middle) - fit.cost < rise ? inside : outside) =
        middle;
  }

  return 0.5 * (inside + outside);
}

}  // namespace

double widening(const Whitening& whitening, const Fit& fit, Eigen::Index place) {
  const RandomEffects beside = beside_columns(whitening.random, fit.jacobian);
  const auto windows = static_cast<double>(beside.blocks.size()),
             free = static_cast<double>(fit.jacobian.cols());
  if (windows < 2.0 * free) return 1.0;  // too few to tell

  // With j = J (H^-1)_i: observed sum of (j_w^T V^-1 r_w)^2, expected sum of j_w^T (V^-1)_ww j_w.
  const RandomWeights weights(beside, fit.scales);
  const Vector r = weights.inverse(fit.residual), j = fit.jacobian * fit.covariance.col(place);
  double observed = 0.0, expected = 0.0;
  for (const RandomBlock& block : beside.blocks) {
    Vector own = Vector::Zero(j.size());
    own.segment(block.first, block.count) = j.segment(block.first, block.count);
    observed += std::pow(own.dot(r), 2);
    expected += own.dot(weights.inverse(own).col(0));
  }
  return std::sqrt(std::max(1.0, observed / expected * windows / (windows - free)));
}

Bounds interval95(const Problem& problem, const Whitening& whitening, const Fit& fit,
                  int parameter) {
  const auto place = std::find(fit.free.begin(), fit.free.end(), parameter) - fit.free.begin();
  const FreeParameter& own = problem.hypotheses.parameters[parameter];
  const double deviation = own.scale * std::sqrt(fit.covariance(place, place));
  const double granted = quantiles::kTwoSided95 * own.scale * fit.shared[place],
               value = fit.p[parameter];
  const double wider = widening(whitening, fit, place);
  const auto end = [&](double side) {
    const double told =
        wider * (interval_end(problem, whitening, fit, parameter, deviation, side) - value);
    return std::clamp(value + side * std::hypot(told, granted), own.bounds.lower, own.bounds.upper);
  };
  return {end(-1.0), end(1.0)};
}

}  // namespace jaculus::diagnosis
