#pragma once
// The evidence that data of an experiment would hold, on the mean over their noise.
//
// White data with an effect at work are r = g + e, e ~ N(0, I) over sensors, clocks, starts and the
// robot's tolerances (signatures.h). A model whose signature near its point k is
// g_k + Y (u - u_k), u ~ N(0, I), has of them, by Laplace's method at its most probable u within
// the point's reach and the bounds,
//   E log Z = -(c(g - g_k - Y (u - u_k)) + |u|^2 + log det A - tr(A^-1 Y^T W^2 Y))/2
//             + log of the posterior's mass within bounds of the first parameter over the prior's,
//   A = I + Y^T W Y,   c and W = diag(1/v): of the misfits (signatures.h); without any
//   c(r) = |r|^2 and W = I,
// up to a constant of the rows: E|e|^2 and what a fit takes of it are the same for all models but
// for the trace, without misfits the number of parameters that data tell. The best point counts. So
//   expected log Bayes factor of A against B = E log Z_A - E log Z_B,   data with A at work,
// is the least Kullback-Leibler divergence between data of A and of B, less their prior's price:
// the distinguishability of faults of E. Eriksson, E. Frisk, M. Krysander, Automatica 49, 2013.
// Models with forces that they lack (noise/random_effects.h) count where an effect is told from
// none: B with such forces can't come nearer to A than their prior odds (settings.prior_lacking),
// which are as strong as `indistinguishable_below`.

#include "diagnosis/preflight/signatures.h"

namespace jaculus::diagnosis {

/// E log Z of a model along a curve, data with `signature`; -infinity where the curve has no point.
double expected_log_evidence(const Vector& signature, const SignatureCurve& curve);

/// The same, the best point moved by Gauss-Newton steps that are simulated while the model imitates
/// the signature well: strong signatures leave the reach of slopes before they can be told apart.
double expected_log_evidence(const SignatureSpace& space, const Vector& signature,
                             const SignatureCurve& curve);

/// The same of no effect, nothing lacking.
double expected_log_evidence_of_none(const Vector& signature, const MisfitShapes& misfits = {});

/// E log p(data) of no effect, complete and with lacking forces, each at its prior odds.
double expected_log_weight_of_none(const SignatureSpace& space, const Vector& signature);

/// What one model's evidence is on the mean, and by how much noise moves it: with r_B what its best
/// point leaves of g_A, noise e adds r_B . W e to log Z_A - log Z_B, a normal number of deviation
/// |W r_B|.
struct ExpectedEvidence {
  double value = -kInfinity;
  double left = kNaN;
};
ExpectedEvidence evidence_along(const SignatureSpace& space, const Vector& signature,
                                const SignatureCurve& curve);

/// Of the curve `at_work`, as stated, against another; NaN where it can't be simulated.
double expected_log_bayes_factor(const SignatureSpace& space, const SignatureCurve& at_work,
                                 const SignatureCurve& other);

}  // namespace jaculus::diagnosis
