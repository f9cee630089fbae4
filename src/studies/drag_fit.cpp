#include "studies/drag_fit.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cassert>
#include <cmath>

#include "jaculus/components/tail_drag.h"

namespace jaculus::studies {
namespace {

constexpr double kTellApart = 2.0;  // in AICc

struct Model {
  const char* name;
  bool viscous, coulomb;
};
constexpr Model kModels[] = {{"drag", false, false},
                             {"drag + viscous", true, false},
                             {"drag + Coulomb", false, true},
                             {"drag + viscous + Coulomb", true, true}};

// Least squares y = X beta with Student intervals.
struct Regression {
  Vector beta, half_width;
  double squares = 0.0;  // of the residuals
  double condition = 0.0;
};

Regression regress(const Matrix& x, const Vector& y, double confidence) {
  Regression r;
  const Vector norms = x.colwise().norm();
  const Matrix scaled = x * norms.cwiseInverse().asDiagonal();
  const Eigen::JacobiSVD<Matrix> svd(scaled, Eigen::ComputeThinU | Eigen::ComputeThinV);
  const Vector sigma = svd.singularValues();
  r.condition = sigma(0) / sigma(sigma.size() - 1);
  r.beta = svd.solve(y).cwiseQuotient(norms);
  r.squares = (y - x * r.beta).squaredNorm();
  const double freedom = static_cast<double>(x.rows() - x.cols());
  const Matrix inverse =
      svd.matrixV() * sigma.cwiseAbs2().cwiseInverse().asDiagonal() * svd.matrixV().transpose();
  const double t = boost::math::quantile(boost::math::students_t(freedom), 0.5 + 0.5 * confidence);
  r.half_width = t * (r.squares / freedom * inverse.diagonal()).cwiseSqrt().cwiseQuotient(norms);
  return r;
}

// AICc with the error's size as one more unknown.
double corrected_criterion(double squares, double n, double unknowns) {
  const double k = unknowns + 1.0;
  if (n - k - 1.0 <= 0.0) return kInfinity;
  return n * std::log(std::max(squares, 1e-300) / n) + 2.0 * k +
         2.0 * k * (k + 1.0) / (n - k - 1.0);
}

DragFit fit_model(const Model& model, const std::vector<DragObservation>& observations,
                  double confidence) {
  const auto n = std::ssize(observations);
  const Eigen::Index unknowns = 1 + (model.viscous ? 1 : 0) + (model.coulomb ? 1 : 0);

  Matrix x(n, unknowns);
  Vector y(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const DragObservation& o = observations[i];
    y(i) = o.torque;
    x(i, 0) = o.quadratic;
    if (model.viscous) x(i, 1) = o.viscous;
    if (model.coulomb) x(i, unknowns - 1) = 1.0;
  }

  const Regression r = regress(x, y, confidence);
  const auto estimate = [&](Eigen::Index j) {
    return Estimate{r.beta(j), r.beta(j) - r.half_width(j), r.beta(j) + r.half_width(j)};
  };

  DragFit fit;
  fit.model = model.name;
  fit.quadratic = estimate(0);
  if (model.viscous) fit.viscous = estimate(1);
  if (model.coulomb) fit.coulomb = estimate(unknowns - 1);

  fit.r_squared = 1.0 - r.squares / (y.array() - y.mean()).matrix().squaredNorm();
  fit.residual = std::sqrt(r.squares / static_cast<double>(n - unknowns));
  fit.aicc = corrected_criterion(r.squares, static_cast<double>(n), static_cast<double>(unknowns));
  fit.condition = r.condition;
  fit.physical = (r.beta.array() >= 0.0).all();

  return fit;
}

// The simplest of those that the data can't tell from the best.
void choose(DragFits& fits) {
  double best = kInfinity;
  for (const DragFit& fit : fits.fits) {
    if (fit.physical) best = std::min(best, fit.aicc);
  }

  std::vector<std::string> plausible;
  for (int i = 0; i < count_of(fits.fits); ++i) {
    DragFit& fit = fits.fits[i];
    fit.plausible = fit.physical && (std::isfinite(best) ? fit.aicc <= best + kTellApart : i == 0);
    if (fit.plausible) {
      plausible.push_back(fit.model);
      if (fits.taken < 0) fits.taken = i;
    } else if (!fit.physical && fit.aicc < best) {
      fits.notes.push_back(
          fmt::format("{}: fits better, but with a negative share, so it is not taken", fit.model));
    }
  }

  if (plausible.size() > 1) {
    fits.notes.push_back(fmt::format("the data can't tell these apart: {}; the simplest is taken",
                                     fmt::join(plausible, " | ")));
  }
  if (!std::isfinite(best)) fits.notes.emplace_back("too few points to rank the models");
}

}  // namespace

std::string bench_fault(const BenchPoint& p, double resistance) {
  if (!std::isfinite(p.voltage) || !std::isfinite(p.current) || !std::isfinite(p.speed)) {
    return "voltage, current and speed must all be there";
  }
  if (p.speed == 0.0) return "the tail stands still, which says nothing of drag";
  const double power = p.voltage * p.current - resistance * p.current * p.current;
  if (!(power > 0.0)) {
    return fmt::format(
        "{:.4g} W go in and {:.4g} W are lost in the winding; the rest, which drives the tail, "
        "must be above 0",
        p.voltage * p.current, resistance * p.current * p.current);
  }
  return "";
}

std::vector<DragObservation> steady_observations(const std::vector<BenchPoint>& points,
                                                 double resistance) {
  std::vector<DragObservation> observations;
  for (const BenchPoint& p : points) {
    assert(bench_fault(p, resistance).empty());
    const double speed = std::abs(p.speed);
    const double power = p.voltage * p.current - resistance * p.current * p.current;
    observations.push_back({power / speed, speed * speed, speed});
  }
  return observations;
}

std::vector<DragObservation> transient_observations(const std::vector<double>& time,
                                                    const std::vector<double>& speed,
                                                    const std::vector<double>& power,
                                                    double inertia, double window) {
  assert(time.size() == speed.size() && time.size() == power.size() && window > 0.0);

  std::vector<DragObservation> observations;
  std::size_t first = 0;
  for (std::size_t last = 1; last < time.size(); ++last) {
    if (time[last] - time[first] < window * (1.0 - 1e-9)) continue;

    double work = 0.0, path = 0.0, square = 0.0, cube = 0.0;
    bool turns = false;
    for (std::size_t i = first; i < last; ++i) {
      const double h = 0.5 * (time[i + 1] - time[i]);
      const double a = std::abs(speed[i]);
      const double b = std::abs(speed[i + 1]);
      work += h * (power[i] + power[i + 1]);
      path += h * (a + b);
      square += h * (a * a + b * b);
      cube += h * (a * a * a + b * b * b);
      turns |= !(speed[i] * speed[i + 1] > 0.0);
    }

    if (!turns) {
      const double energy =
          0.5 * inertia * (speed[last] * speed[last] - speed[first] * speed[first]);
      observations.push_back({(work - energy) / path, cube / path, square / path});
    }

    first = last;
  }
  return observations;
}

DragFits fit_drag(const std::vector<DragObservation>& observations, double confidence) {
  assert(observations.size() >= 2 && confidence > 0.0 && confidence < 1.0);
  DragFits fits;
  for (const Model& model : kModels) {
    const std::size_t unknowns = 1u + (model.viscous ? 1u : 0u) + (model.coulomb ? 1u : 0u);
    if (observations.size() <= unknowns) {
      fits.notes.push_back(fmt::format("{}: left out, {} points for {} unknowns", model.name,
                                       observations.size(), unknowns));
      continue;
    }
    fits.fits.push_back(fit_model(model, observations, confidence));
  }
  choose(fits);
  return fits;
}

Estimate drag_coefficient(const Estimate& b, double density, double width, double shaft,
                          double length) {
  const double per_unit = components::rotation_drag_factor(density, 1.0, width, shaft, length);
  return {b.value / per_unit, b.low / per_unit, b.high / per_unit};
}

}  // namespace jaculus::studies
