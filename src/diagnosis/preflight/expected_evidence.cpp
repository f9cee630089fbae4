#include "diagnosis/preflight/expected_evidence.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "diagnosis/noise/log_probability.h"

namespace jaculus::diagnosis {
namespace {

// Of a method, not of a diagnosis: weights by the misfits that a model's best point leaves are
// taken anew so often at most, or until none changes by this share. Chosen.
constexpr int kMisfitRounds = 20;
constexpr double kWeightsStay = 1e-3;

/// How much of a step from `from` keeps every parameter within its bounds and its reach: from
/// nominal to twice as far, or a prior scale where that is more.
double share_of_step(const Vector& from, const Vector& step, const SignatureCurve& curve) {
  double share = 1.0;
  for (Eigen::Index i = 0; i < step.size(); ++i) {
    if (step[i] == 0.0) continue;
    const double reach = i == 0 ? std::abs(from[i]) : std::max(1.0, std::abs(from[i]));
    const double room =
        step[i] > 0.0 ? curve.bounds[i].upper - from[i] : from[i] - curve.bounds[i].lower;
    share = std::min(share, std::min(reach, std::max(0.0, room)) / std::abs(step[i]));
  }
  return share;
}

/// A model's evidence by its slopes at one point.
struct PointEvidence {
  double expected = -kInfinity;  ///< E log Z at the most probable u
  double achieved = -kInfinity;  ///< the same if it stayed at the point, which is simulated
  Vector missed;                 ///< g_A - g_B at the most probable u
  Vector u;                      ///< the most probable
};

/// With the misfits' variances of all rows; r: what is left at the point.
PointEvidence evidence_by(const Vector& variances, const Vector& r, const SignatureCurve& curve,
                          const CurvePoint& point) {
  const Matrix& Y = point.slopes;
  const Matrix weighed = variances.cwiseInverse().asDiagonal() * Y;
  Matrix A = Y.transpose() * weighed;
  A.diagonal().array() += 1.0;
  const Eigen::LLT<Matrix> factor(A);
  const Matrix covariance = factor.solve(Matrix::Identity(A.rows(), A.cols()));
  const Vector step = factor.solve(weighed.transpose() * r - point.u);
  const Vector moved = share_of_step(point.u, step, curve) * step;

  const double log_det = 2.0 * factor.matrixLLT().diagonal().array().log().sum();
  const double told = factor.solve(weighed.transpose() * weighed).trace();
  const auto evidence = [&](const Vector& u, const Vector& missed) {
    const double mass = log_mass_ratio(curve.bounds[0], u[0], std::sqrt(covariance(0, 0)));
    return -0.5 * (curve.misfits.cost(missed) + u.squaredNorm() + log_det - told) + mass;
  };
  PointEvidence out;
  out.u = point.u + moved;
  out.missed = r - Y * moved;
  out.expected = evidence(out.u, out.missed);
  out.achieved = evidence(point.u, r);
  return out;
}

PointEvidence evidence_at(const Vector& signature, const SignatureCurve& curve,
                          const CurvePoint& point) {
  const Vector r = signature - point.signature;
  if (point.slopes.cols() == 0) {
    const double value = -0.5 * curve.misfits.cost(r);
    return {value, value, r, point.u};
  }

  PointEvidence out;
  Vector variances = curve.misfits.variances(r);
  for (int round = 0; round < kMisfitRounds; ++round) {
    out = evidence_by(variances, r, curve, point);
    const Vector likely = curve.misfits.variances(out.missed);
    if ((likely - variances).cwiseAbs().maxCoeff() <= kWeightsStay * variances.minCoeff()) break;
    variances = likely;
  }
  return out;
}

PointEvidence best_of(const Vector& signature, const SignatureCurve& curve) {
  PointEvidence best;
  for (const CurvePoint& point : curve.points) {
    PointEvidence own = evidence_at(signature, curve, point);
    if (own.expected > best.expected) best = std::move(own);
  }
  return best;
}

}  // namespace

double expected_log_evidence(const Vector& signature, const SignatureCurve& curve) {
  return best_of(signature, curve).expected;
}

double expected_log_evidence(const SignatureSpace& space, const Vector& signature,
                             const SignatureCurve& curve) {
  return evidence_along(space, signature, curve).value;
}

ExpectedEvidence evidence_along(const SignatureSpace& space, const Vector& signature,
                                const SignatureCurve& curve) {
  const Problem& problem = *space.problem;
  const double energy = signature.squaredNorm();
  PointEvidence best = best_of(signature, curve);
  if (!std::isfinite(best.expected)) return {};
  for (int i = 0; i < problem.settings.relinearisations; ++i) {
    const bool alike = best.missed.squaredNorm() < problem.settings.imitation_followed * energy;
    if (!alike || energy < problem.settings.indistinguishable_below) break;
    const Vector p = problem.hypotheses.unscaled(curve.free, best.u, problem.hypotheses.nominal());
    const auto point = curve_point(space, curve.free, p);
    if (!point) break;

    PointEvidence next = evidence_at(signature, curve, *point);
    const double gained = next.expected - best.expected;
    const bool nearer = next.achieved > best.achieved;
    if (nearer) best = std::move(next);
    if (!nearer || std::abs(gained) < problem.settings.lower_valley) break;
  }
  const Vector variances = curve.misfits.variances(best.missed);
  return {best.expected, best.missed.cwiseQuotient(variances).norm()};
}

double expected_log_evidence_of_none(const Vector& signature, const MisfitShapes& misfits) {
  return -0.5 * misfits.cost(signature);
}

double expected_log_weight_of_none(const SignatureSpace& space, const Vector& signature) {
  const Settings& settings = space.problem->settings;
  const double complete =
      std::log1p(-settings.prior_lacking) + expected_log_evidence_of_none(signature, space.misfits);
  if (space.random.size() == 0) return complete;

  // Rows of a misfit hold their noise as well, N in the mean; in blocks it adds half of the told.
  Products products = products_of(space.random, signature);
  double noise = 0.0;
  for (std::size_t c = 0; c < space.random.misfits.size(); ++c) {
    products.misfits[c](0, 0) += space.random.misfits[c].rows;
    noise += space.random.misfits[c].rows;
  }
  products.gram(0, 0) += noise;
  const ScaleEstimate estimate =
      estimated_scales(space.random, products, first_scales(space.random), settings.scale_steps,
                       settings.scale_spread);
  const Vector told = told_by(space.random, products, estimate.scales);
  double of_forces = 0.0;
  for (int g = 0; g < space.random.size(); ++g)
    if (space.random.groups[g].force >= 0) of_forces += told[g];
  // as costs are counted from the least misfit on
  double least_misfits = 0.0;
  for (const MisfitShape& misfit : space.misfits.own) {
    const double v = misfit.variance(0.0), n = misfit.of.values;
    least_misfits += n / v + n * std::log(v) - n;
  }
  const double lacking = estimate.evidence() + 0.5 * (of_forces + noise + least_misfits);
  return log_of_sum(complete, std::log(settings.prior_lacking) + lacking);
}

double expected_log_bayes_factor(const SignatureSpace& space, const SignatureCurve& at_work,
                                 const SignatureCurve& other) {
  const CurvePoint* stated = at_work.stated();
  if (stated == nullptr || other.points.empty()) return kNaN;
  return expected_log_evidence(stated->signature, at_work) -
         expected_log_evidence(space, stated->signature, other);
}

}  // namespace jaculus::diagnosis
