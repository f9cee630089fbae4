#pragma once
// Which effects could be told apart, each as it is stated to be at work.
//
// Structurally (M. Krysander, E. Frisk, "Sensor placement for fault diagnosis", IEEE Trans. SMC A
// 38, 2008): A is isolable from B if some combination of the data reacts to A and not to B, that is
// if A's slope does not lie in the span of B's, of all its parameters. Its sine to that span is
// zero up to rounding of the differences (settings.structural_angle) where no amount of such data
// can tell.
// Statistically: A is told from B if the expected log Bayes factor, data with A at work and B at
// what imitates it best, reaches settings.indistinguishable_below, by which a diagnosis lists
// rivals; below that either is named, and where it is as much below zero B alone. Both ways, for B
// may imitate A and A not B. Of an effect and another that is it with parameters more, these being
// nominal here, a diagnosis names the simpler one where data tell none of them.

#include "diagnosis/preflight/expected_evidence.h"
#include "jaculus/diagnosis/preflight.h"

namespace jaculus::diagnosis {

/// How a rival goes with the effect at work.
enum class Rival {
  unlike,  ///< neither is the other with parameters more
  richer,  ///< the rival is
  simpler  ///< the effect at work is
};
Rival rival_of(const Hypotheses& hypotheses, int at_work, int rival);

/// A pair one way round: its log Bayes factor L is normal (expected_evidence.h), and the effect at
/// work is named at all in a share `seen` of the data.
struct TellingWay {
  double expected = kNaN;  ///< mean of L; NaN: not judged
  double spread = 0.0;     ///< deviation of L by noise
  double seen = 0.0;
  Rival rival = Rival::unlike;
};

/// What a diagnosis would make of data with an effect at work beside another:
///   told seen P(L >= 3), ambiguous seen P(-3 < L < 3), taken P(L <= -3);
/// of a richer rival told seen P(L > -3), beside a simpler one taken P(L <= 0), ambiguous from
/// there on. That zero stands for the L from which the richer one's other parameters, nominal here,
/// would by noise lie outside of their 95 % intervals: 1.92, for what they gain then, less what
/// their priors cost. The mean alone does not decide: of L = 2.5 +- 2.2 four in ten are told.
struct TellingChances {
  double told = 0.0, ambiguous = 0.0, taken = 0.0;
};
TellingChances telling_chances(const TellingWay& way, const Settings& settings);
/// The one whose chance is settings.telling_chance or more, else open.
Telling telling_of(const TellingWay& way, const Settings& settings);

/// Two candidates. What is of `a` is with a at work and b as rival.
struct CandidatePair {
  int a = 0, b = 0;                       ///< candidates
  double sine_a = kNaN, sine_b = kNaN;    ///< of its slope to the other's span
  double told_a = kNaN, told_b = kNaN;    ///< expected log Bayes factors; NaN: not judged
  double spread_a = 0.0, spread_b = 0.0;  ///< their deviations by noise

  /// Whether either can't be told where it is at work.
  [[nodiscard]] bool not_tellable(const Settings& settings) const;
  /// Whether either lies in the other's span.
  [[nodiscard]] bool structural(const Settings& settings) const;
};

/// Sine of a vector to the span of some columns.
double sine_to_span(const Vector& slope, const Matrix& columns);

/// Expected log Bayes factors D(a, b) of curves, a at work as stated and b as rival; NaN where one
/// can't be simulated. The last column is against none.
/// `spread`: their deviations by noise, a x b, where that is given.
Matrix expected_log_bayes_factors(const SignatureSpace& space,
                                  const std::vector<SignatureCurve>& curves,
                                  Matrix* spread = nullptr);

/// All pairs of candidates with a curve of which one at least is `seen`; what is not seen is not
/// judged as at work. `factors`: D.
std::vector<CandidatePair> candidate_pairs(const std::vector<SignatureCurve>& curves,
                                           const Matrix& factors, const std::vector<bool>& seen,
                                           const Matrix& spread = {});

/// Candidates that pairs can't tell, as connected components: each is not told from one other of
/// its set at least. Sorted.
std::vector<std::vector<int>> connected_sets(const std::vector<CandidatePair>& not_told, int count);

/// What data are expected to tell of which effect is at work [bits], each in turn at its stated
/// size, none among them:
///   I = H(prior) - sum_A pi_A log sum_B (pi_B/pi_A) exp(-D_AB),  D_AB: expected log Bayes factors,
/// by Jensen's inequality from the posterior's entropy with A at work. `factors`: D, models x
/// models, none first; `prior`: pi.
double expected_information(const Vector& prior, const Matrix& factors);

/// The entropy of the prior of none and `singles` effects of which one at most is at work [bit].
double prior_uncertainty(int singles, const Settings& settings);

/// I of curves with this prior, `factors` as above; what could not be simulated counts as not told.
double information_of(const Matrix& factors, const std::vector<SignatureCurve>& curves,
                      const Settings& settings);

}  // namespace jaculus::diagnosis
