#include "diagnosis/preflight/isolability.h"

#include <tbb/parallel_for.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "diagnosis/noise/log_probability.h"
#include "diagnosis/selection/neighbouring_sets.h"

namespace jaculus::diagnosis {
namespace {

/// Of none, then `singles` effects of which one at most is at work.
Vector single_priors(int singles, const Settings& settings) {
  Vector prior = Vector::Constant(singles + 1, settings.prior_single / std::max(1, singles));
  prior[0] = settings.prior_none;
  return prior / prior.sum();
}

}  // namespace

Rival rival_of(const Hypotheses& hypotheses, int at_work, int rival) {
  if (extends(hypotheses, rival, at_work)) return Rival::richer;
  return extends(hypotheses, at_work, rival) ? Rival::simpler : Rival::unlike;
}

TellingChances telling_chances(const TellingWay& way, const Settings& settings) {
  const double least = settings.indistinguishable_below;
  const auto below = [&](double level) {
    if (!(way.spread > 0.0)) return way.expected < level ? 1.0 : 0.0;
    return 0.5 * std::erfc((way.expected - level) / (way.spread * std::numbers::sqrt2));
  };
  const double under = below(way.rival == Rival::richer ? -least : least);
  const double taken = below(way.rival == Rival::simpler ? 0.0 : -least);
  return {way.seen * (1.0 - under), way.seen * (under - taken), taken};
}

Telling telling_of(const TellingWay& way, const Settings& settings) {
  if (std::isnan(way.expected)) return Telling::not_judged;
  const TellingChances chances = telling_chances(way, settings);
  if (chances.told >= settings.telling_chance) return Telling::told;
  if (chances.ambiguous >= settings.telling_chance) return Telling::ambiguous;
  return chances.taken >= settings.telling_chance ? Telling::taken : Telling::open;
}

bool CandidatePair::not_tellable(const Settings& settings) const {
  const double least = settings.indistinguishable_below;
  return told_a < least || told_b < least;
}

bool CandidatePair::structural(const Settings& settings) const {
  return std::min(sine_a, sine_b) < settings.structural_angle;
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

Matrix expected_log_bayes_factors(const SignatureSpace& space,
                                  const std::vector<SignatureCurve>& curves, Matrix* spread) {
  const int n = count_of(curves);
  if (spread != nullptr) *spread = Matrix::Zero(n, n);
  Matrix factors = Matrix::Constant(n, n + 1, kNaN);
  Vector own = Vector::Constant(n, kNaN);  // evidence of each effect where it is at work
  for (int a = 0; a < n; ++a) {
    const CurvePoint* stated = curves[a].stated();
    if (stated == nullptr) continue;
    own[a] = expected_log_evidence(stated->signature, curves[a]);
    factors(a, n) = own[a] - expected_log_evidence_of_none(stated->signature, curves[a].misfits);
  }

  tbb::parallel_for(0, n * n, [&](int i) {
    const int a = i / n, b = i % n;
    const CurvePoint* stated = curves[a].stated();
    if (a == b) {
      factors(a, b) = 0.0;
    } else if (stated != nullptr && !curves[b].points.empty()) {
      const ExpectedEvidence rival = evidence_along(space, stated->signature, curves[b]);
      factors(a, b) = own[a] - rival.value;
      if (spread != nullptr && std::isfinite(rival.left)) (*spread)(a, b) = rival.left;
    }
  });
  return factors;
}

std::vector<CandidatePair> candidate_pairs(const std::vector<SignatureCurve>& curves,
                                           const Matrix& factors, const std::vector<bool>& seen,
                                           const Matrix& spread) {
  std::vector<CandidatePair> pairs;
  for (int a = 0; a < count_of(curves); ++a)
    for (int b = a + 1; b < count_of(curves); ++b) {
      if ((!seen[a] && !seen[b]) || curves[a].points.empty() || curves[b].points.empty()) continue;
      CandidatePair pair{a, b};
      pair.sine_a = sine_to_span(curves[a].plain.col(0), curves[b].plain);
      pair.sine_b = sine_to_span(curves[b].plain.col(0), curves[a].plain);
      if (seen[a]) pair.told_a = factors(a, b);
      if (seen[b]) pair.told_b = factors(b, a);
      if (spread.size() > 0) {
        pair.spread_a = spread(a, b);
        pair.spread_b = spread(b, a);
      }
      pairs.push_back(pair);
    }
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

double information_of(const Matrix& factors, const std::vector<SignatureCurve>& curves,
                      const Settings& settings) {
  const int n = count_of(curves);
  Matrix all = Matrix::Zero(n + 1, n + 1);
  for (int a = 0; a < n; ++a) {
    if (curves[a].stated() == nullptr) continue;
    all(a + 1, 0) = factors(a, n);
    const Vector nothing = Vector::Zero(curves[a].stated()->signature.size());
    all(0, a + 1) = -expected_log_evidence(nothing, curves[a]);
    for (int b = 0; b < n; ++b)
      if (curves[b].stated() != nullptr) all(a + 1, b + 1) = factors(a, b);
  }
  return expected_information(single_priors(n, settings), all);
}

}  // namespace jaculus::diagnosis
