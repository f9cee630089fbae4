#include "diagnosis/preflight/isolability.h"

#include <tbb/parallel_for.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "diagnosis/preflight/dev_settings.h"
#include "diagnosis/selection/posterior.h"

namespace jaculus::diagnosis {
namespace {

/// Of none, then `singles` effects of which one at most is at work.
Vector single_priors(int singles, const Settings& settings) {
  Vector prior = Vector::Constant(singles + 1, settings.prior_single / std::max(1, singles));
  prior[0] = settings.prior_none;
  return prior / prior.sum();
}

}  // namespace

Telling telling_of(double log_factor, const Settings& settings) {
  if (std::isnan(log_factor)) return Telling::not_judged;
  if (log_factor >= settings.indistinguishable_below) return Telling::told;
  return log_factor > -settings.indistinguishable_below ? Telling::ambiguous : Telling::taken;
}

bool CandidatePair::not_tellable([[maybe_unused]] const Settings& settings) const {
  const double least = settings.indistinguishable_below;
  return told_a < least || told_b < least;
}

bool CandidatePair::structural([[maybe_unused]] const Settings& settings) const {
  return std::min(sine_a, sine_b) < kDev.structural_angle;
}

double sine_to_span(const Vector& slope, const Matrix& columns) {
  const double norm = slope.norm();
  if (!(norm > 0.0)) return 0.0;
  Matrix scaled = columns;
  for (Eigen::Index k = 0; k < scaled.cols(); ++k)
    if (const double own = scaled.col(k).norm(); own > 0.0) scaled.col(k) /= own;
  const Eigen::ColPivHouseholderQR<Matrix> factor(scaled);
  const Vector rest = slope - scaled * factor.solve(slope);
  return rest.norm() / norm;
}

std::vector<CandidatePair> candidate_pairs(const std::vector<SignatureCurve>& curves,
                                           const std::vector<bool>& seen) {
  std::vector<CandidatePair> pairs;
  for (int a = 0; a < count_of(curves); ++a)
    for (int b = a + 1; b < count_of(curves); ++b)
      if ((seen[a] || seen[b]) && !curves[a].points.empty() && !curves[b].points.empty())
        pairs.push_back({a, b});

  tbb::parallel_for(0, count_of(pairs), [&](int i) {
    CandidatePair& pair = pairs[i];
    const SignatureCurve &a = curves[pair.a], &b = curves[pair.b];
    pair.sine_a = sine_to_span(a.plain.col(0), b.plain);
    pair.sine_b = sine_to_span(b.plain.col(0), a.plain);
    if (seen[pair.a]) pair.told_a = expected_log_bayes_factor(a, b);
    if (seen[pair.b]) pair.told_b = expected_log_bayes_factor(b, a);
  });
  return pairs;
}

std::vector<std::vector<int>> connected_sets(const std::vector<CandidatePair>& not_told,
                                             int count) {
  std::vector<int> set(count);
  std::iota(set.begin(), set.end(), 0);
  for (const CandidatePair& pair : not_told) {
    const int from = set[pair.b], to = set[pair.a];
    std::replace(set.begin(), set.end(), from, to);
  }

  std::vector<std::vector<int>> out;
  for (int s = 0; s < count; ++s) {
    std::vector<int> members;
    for (int c = 0; c < count; ++c)
      if (set[c] == s) members.push_back(c);
    if (members.size() > 1) out.push_back(members);
  }
  std::sort(out.begin(), out.end());
  return out;
}

double expected_information(const Vector& prior, const Matrix& factors) {
  double information = 0.0;
  for (Eigen::Index a = 0; a < prior.size(); ++a) {
    double log_sum = -kInfinity;
    for (Eigen::Index b = 0; b < prior.size(); ++b)
      log_sum = log_of_sum(log_sum, std::log(prior[b] / prior[a]) - factors(a, b));
    information += prior[a] * (-std::log(prior[a]) - log_sum);
  }
  return std::max(0.0, information) / std::numbers::ln2;
}

double prior_uncertainty(int singles, const Settings& settings) {
  const Vector prior = single_priors(singles, settings);
  return -(prior.array() * prior.array().log()).sum() / std::numbers::ln2;
}

double expected_information(const SignatureSpace& space,
                            const std::vector<SignatureCurve>& curves) {
  const Settings& settings = space.problem->settings;
  std::vector<const SignatureCurve*> models;
  for (const SignatureCurve& curve : curves)
    if (curve.stated() != nullptr) models.push_back(&curve);
  const int n = count_of(models);
  Matrix factors = Matrix::Zero(n + 1, n + 1);
  const Vector nothing = Vector::Zero(space.whitening.rows);
  for (int b = 0; b < n; ++b) factors(0, b + 1) = -expected_log_evidence(nothing, *models[b]);
  tbb::parallel_for(0, n, [&](int a) {
    const Vector& signature = models[a]->stated()->signature;
    const double own = expected_log_evidence(signature, *models[a]);
    factors(a + 1, 0) = own - expected_log_evidence_of_none(signature);
    for (int b = 0; b < n; ++b)
      if (b != a) factors(a + 1, b + 1) = own - expected_log_evidence(signature, *models[b]);
  });
  return expected_information(single_priors(n, settings), factors);
}

}  // namespace jaculus::diagnosis
