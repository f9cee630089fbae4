// What an experiment could tell, on a problem that is linear, so that every figure has a closed
// form.

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "diagnosis/preflight/detection.h"
#include "diagnosis/preflight/isolability.h"
#include "diagnosis/selection/comparison.h"
#include "diagnosis/selection/posterior.h"
#include "toy.h"

namespace jaculus::test {
namespace {

using diagnosis::CurvePoint;
using diagnosis::SignatureCurve;
using diagnosis::SignatureSpace;

enum ToyCandidate { kFirst, kSecond, kTwin, kBlind };

/// The toy's nominal data and their space, without forces that may be missing.
SignatureSpace toy_space() {
  const auto problem = toy_problem(Vector::Zero(4));
  const diagnosis::Comparison comparison =
      diagnosis::comparison_about(*problem, diagnosis::estimate_noise(*problem, Vector::Zero(4)));
  SignatureSpace space;
  space.problem = problem;
  space.whitening = comparison.whitening;
  space.rows = diagnosis::rows_of(*problem, comparison.noise, comparison.noise.at_p);
  for (const diagnosis::RowSpan& span : space.whitening.datasets.front().spans)
    space.channel.insert(space.channel.end(), span.count, span.channel);
  space.channels = 2;
  return space;
}

SignatureCurve toy_curve(const SignatureSpace& space, int candidate, double size) {
  return signature_curve(space, {candidate}, stated_departure(*space.problem, candidate, size),
                         {0.25, -0.25, 1.0, -1.0, 4.0, -4.0});
}

TEST(ExpectedEvidence, OfALinearEffectAgainstNoneIsTheClosedForm) {
  const SignatureSpace space = toy_space();
  for (const double size : {0.05, 0.5, 2.0}) {
    const SignatureCurve curve = toy_curve(space, kSecond, size);
    const CurvePoint* stated = curve.stated();
    ASSERT_NE(stated, nullptr);
    const double u = stated->u[0], E = stated->signature.squaredNorm() / (u * u);
    EXPECT_NEAR(u, size, 1e-12);
    const double expected = 0.5 * (u * u * E * E + E) / (1.0 + E) - 0.5 * std::log1p(E);
    EXPECT_NEAR(expected_log_evidence(stated->signature, curve) -
                    diagnosis::expected_log_evidence_of_none(stated->signature),
                expected, 1e-3 * std::abs(expected) + 1e-3);
  }
}

TEST(ExpectedEvidence, OfARivalIsThatOfItsProjection) {
  // By far more data than prior: B's best imitation leaves |g|^2 sin^2 of its angle.
  const SignatureSpace space = toy_space();
  const SignatureCurve first = toy_curve(space, kFirst, 1.0),
                       second = toy_curve(space, kSecond, 1.0);
  const Vector &g = first.stated()->signature, &y = second.stated()->signature;
  const double u = g.dot(y) / y.squaredNorm();
  const double rest = (g - u * y).squaredNorm();
  const double occam = 0.5 * std::log(y.squaredNorm() / g.squaredNorm());
  const double prior = 0.5 * (u * u - 1.0);
  const double half_of_a_bound = std::log(2.0);  // `first` can't be negative
  const double factor = expected_log_bayes_factor(space, first, second);
  EXPECT_NEAR(factor, 0.5 * rest + occam + prior + half_of_a_bound, 0.02 * factor);
}

TEST(Isolability, IsNoneOfWhatHasTheSameSlope) {
  const SignatureSpace space = toy_space();
  std::vector<SignatureCurve> curves;
  for (const int c : {kFirst, kSecond, kTwin}) curves.push_back(toy_curve(space, c, 1.0));
  const diagnosis::Settings& settings = space.problem->settings;
  const Matrix factors = diagnosis::expected_log_bayes_factors(space, curves);
  for (const diagnosis::CandidatePair& pair :
       diagnosis::candidate_pairs(curves, factors, {true, true, true})) {
    const bool twins = pair.a == kFirst && pair.b == kTwin;
    EXPECT_EQ(pair.structural(settings), twins) << pair.a << ' ' << pair.b;
    EXPECT_EQ(pair.not_tellable(settings), twins) << pair.told_a << ' ' << pair.told_b;
  }
}

TEST(Isolability, OfWhatIsNotSeenIsNotJudged) {
  const SignatureSpace space = toy_space();
  std::vector<SignatureCurve> curves;
  for (const int c : {kFirst, kSecond}) curves.push_back(toy_curve(space, c, 1.0));
  const Matrix factors = diagnosis::expected_log_bayes_factors(space, curves);
  EXPECT_TRUE(diagnosis::candidate_pairs(curves, factors, {false, false}).empty());
  const auto pairs = diagnosis::candidate_pairs(curves, factors, {true, false});
  ASSERT_EQ(pairs.size(), 1u);
  EXPECT_FALSE(std::isnan(pairs[0].told_a));
  EXPECT_TRUE(std::isnan(pairs[0].told_b));
}

TEST(Telling, NoiseMovesTheBayesFactorByWhatTheRivalLeaves) {
  // The deviation over draws of noise of what is stated on their mean.
  const SignatureSpace space = toy_space();
  const SignatureCurve first = toy_curve(space, kFirst, 1.0),
                       second = toy_curve(space, kSecond, 1.0);
  const Vector& g = first.stated()->signature;
  const diagnosis::ExpectedEvidence rival = diagnosis::evidence_along(space, g, second);
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  constexpr int kDraws = 400;
  double sum = 0.0, squares = 0.0;
  for (int i = 0; i < kDraws; ++i) {
    const Vector data = g + Vector::NullaryExpr(g.size(), [&] { return normal(random); });
    const double factor = expected_log_evidence(data, first) - expected_log_evidence(data, second);
    sum += factor;
    squares += factor * factor;
  }
  const double mean = sum / kDraws, deviation = std::sqrt(squares / kDraws - mean * mean);
  EXPECT_NEAR(deviation, rival.left, 0.15 * rival.left);
}

TEST(MisfitShape, CountsWhatIsMissedByValuesAndNotByRows) {
  const diagnosis::MisfitShape none;
  EXPECT_EQ(none.cost(170.0), 170.0);
  EXPECT_EQ(none.variance(170.0), 1.0);

  const diagnosis::MisfitShape misfit{{0, 6.0, 3000.0, {}}, 0.3};
  const double least = 1.0 + 0.09 * 3000.0 / 6.0;
  EXPECT_NEAR(misfit.variance(0.0), least, 1e-12);
  EXPECT_EQ(misfit.cost(0.0), 0.0);
  // Below the least misfit it is L over its variance, far beyond n log L.
  EXPECT_NEAR(misfit.cost(100.0), 100.0 / least, 1e-12);
  EXPECT_NEAR(misfit.cost(2e6) - misfit.cost(1e6), 6.0 * std::log(2.0), 1e-4);
  EXPECT_LT(misfit.cost(172.0), 10.0) << "what 86 nats of rows are worth";
  // The likely variance is the one of least cost.
  const auto at = [](double L, double v) { return (L + 6.0) / v + 6.0 * std::log(v); };
  const double v = misfit.variance(5000.0);
  EXPECT_LE(at(5000.0, v), std::min(at(5000.0, 1.01 * v), at(5000.0, 0.99 * v)));
}

TEST(Telling, IsOpenWhereNoiseDecides) {
  const diagnosis::Settings settings;
  using diagnosis::Telling;
  // P(N(2.5, sqrt 5) >= 3) = 0.41: neither told nor ambiguous for sure.
  const auto chances = diagnosis::telling_chances({2.5, std::sqrt(5.0), 1.0}, settings);
  EXPECT_NEAR(chances.told, 0.4115, 1e-3);
  EXPECT_NEAR(chances.told + chances.ambiguous + chances.taken, 1.0, 1e-12);
  EXPECT_EQ(telling_of({2.5, std::sqrt(5.0), 1.0}, settings), Telling::open);
  EXPECT_EQ(telling_of({2.5, 0.1, 1.0}, settings), Telling::ambiguous);
  EXPECT_EQ(telling_of({40.0, 9.0, 1.0}, settings), Telling::told);
  EXPECT_EQ(telling_of({-9.0, 1.0, 1.0}, settings), Telling::taken);
  EXPECT_EQ(telling_of({40.0, 9.0, 0.6}, settings), Telling::open) << "not named in four of ten";
  EXPECT_EQ(telling_of({kNaN, 1.0, 1.0}, settings), Telling::not_judged);
}

TEST(Telling, NamesTheSimplerOfTwoWhereNothingTellsMore) {
  const diagnosis::Settings settings;
  using diagnosis::Rival;
  using diagnosis::Telling;
  EXPECT_EQ(telling_of({2.0, 0.1, 1.0, Rival::richer}, settings), Telling::told);
  EXPECT_EQ(telling_of({-4.0, 0.1, 1.0, Rival::richer}, settings), Telling::taken);
  EXPECT_EQ(telling_of({-2.0, 0.1, 1.0, Rival::simpler}, settings), Telling::taken);
  EXPECT_EQ(telling_of({2.0, 0.1, 1.0, Rival::simpler}, settings), Telling::ambiguous);
  EXPECT_EQ(telling_of({9.0, 0.1, 1.0, Rival::simpler}, settings), Telling::told);
}

TEST(SineToSpan, IsZeroWithinAndOneAcross) {
  Matrix span(3, 2);
  span << 1.0, 1e6, 0.0, 1e6, 0.0, 0.0;
  EXPECT_NEAR(diagnosis::sine_to_span(Eigen::Vector3d(0.0, 3.0, 0.0), span), 0.0, 1e-9);
  EXPECT_NEAR(diagnosis::sine_to_span(Eigen::Vector3d(0.0, 0.0, 2.0), span), 1.0, 1e-12);
  EXPECT_NEAR(diagnosis::sine_to_span(Eigen::Vector3d(0.0, 1.0, 1.0), span), std::sqrt(0.5), 1e-9);
}

TEST(Detection, OfWhatChangesNothingIsNoneAtAnySize) {
  const SignatureSpace space = toy_space();
  const diagnosis::Detection found = detect(space, kBlind, toy_curve(space, kBlind, 1.0),
                                            stated_departure(*space.problem, kBlind, 1.0));
  EXPECT_FALSE(found.structural);
  EXPECT_TRUE(std::isnan(found.size));
  EXPECT_FALSE(found.stated.named);
}

TEST(Detection, FindsTheSizeFromWhichAnEffectIsNamed) {
  const SignatureSpace space = toy_space();
  const diagnosis::Settings& settings = space.problem->settings;
  const SignatureCurve curve = toy_curve(space, kSecond, 1.0);
  const diagnosis::Detection found =
      detect(space, kSecond, curve, stated_departure(*space.problem, kSecond, 1.0));
  ASSERT_TRUE(found.structural && std::isfinite(found.size));

  // The least u at which odds and gap suffice, by the closed forms of both.
  const double E = curve.stated()->signature.squaredNorm();
  const double prior = diagnosis::log_prior(1, 4, settings) - diagnosis::log_prior(0, 4, settings);
  const auto odds = [&](double u) {
    return prior + 0.5 * (u * u * E * E + E) / (1.0 + E) - 0.5 * std::log1p(E);
  };
  double least = 1e-6;
  const double rows = space.whitening.rows;
  const auto named = [&](double u) {
    const bool gains = 0.5 * u * u * E > settings.worth_small_gap;
    const double gap = std::sqrt(1.0 + u * u * E / rows);  // as many rows in both channels
    return odds(u) >= settings.worth &&
           (gap >= settings.plain_gap ||
            (gains && 1.0 < (1.0 - settings.least_improvement_small_gap) * gap));
  };
  while (!named(least)) least *= 1.001;
  EXPECT_NEAR(found.size / (0.1 * least), 1.0, 0.06);
}

TEST(ConnectedSets, HoldWhatPairsConnect) {
  std::vector<diagnosis::CandidatePair> pairs = {{0, 3}, {3, 5}, {1, 2}};
  EXPECT_EQ(diagnosis::connected_sets(pairs, 6),
            (std::vector<std::vector<int>>{{0, 3, 5}, {1, 2}}));
}

TEST(ExpectedInformation, IsThePriorsEntropyWhereAllIsToldAndNothingWhereNothingIs) {
  const Vector even = Vector::Constant(4, 0.25);
  Matrix told = Matrix::Constant(4, 4, 1e3);
  told.diagonal().setZero();
  EXPECT_NEAR(diagnosis::expected_information(even, told), 2.0, 1e-9);
  EXPECT_NEAR(diagnosis::expected_information(even, Matrix::Zero(4, 4)), 0.0, 1e-9);

  // Two halves that are told from one another and not within: one bit of the two.
  for (const int half : {0, 2}) told(half, half + 1) = told(half + 1, half) = 0.0;
  EXPECT_NEAR(diagnosis::expected_information(even, told), 1.0, 1e-9);
}

}  // namespace
}  // namespace jaculus::test
