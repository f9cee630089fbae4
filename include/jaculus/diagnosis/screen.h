#pragma once
// Screening: what each candidate could explain of a residual, from a few probing simulations and no fit.
//
//   columns of a candidate: g_i = T (f(p + h_i) - f(p))/h_i, at a small step and at its probing step, because friction, play and
//   limits are not linear from nominal on; second parameters (a damping) are probed with the first one set.
//   score = log evidence of the linear Gaussian model with these columns and those of the base model, prior N(0, I) in u, less that
//   of the base model alone:  b^T A^-1 b/2 - log det(A)/2,  A = I + G^T G,  b = G^T r.
// Strong effects leave the reach of slopes (a tail that rebounds, air that no longer brakes), so the first parameter also walks a
// ladder, its probing step times 1/8, 1/4, ... 8, both ways, or 16 even spaces where its bounds are closer than that; at a rung u, with
// the base model's parameters moved linearly, score = log evidence there - u^2/2 - log(1 + |(r(u) - r)/u|^2)/2. Effects with a
// threshold (slip, limits) do nothing up to it and soon too much: where what a rung changes is far beyond the proportion of the rung
// before, and does harm, the space between the two is halved until a step helps.

#include <vector>

#include "jaculus/diagnosis/fit.h"

namespace jaculus {

/// Signatures of one candidate about a base model.
struct Probe {
  bool valid = false;
  Matrix small, full;  ///< rows x parameters, per prior scale, at the two strengths
  double score = -kInfinity;
  Vector estimate;       ///< u of its parameters by the better linear model, within bounds
  double rung = kNaN;    ///< u of the first parameter on the best rung of the ladder; NaN: none beats standing still
  long predictions = 0;  ///< sets of simulations that it took
};

/// How thorough screening is: at the two steps, or up the ladder as well.
enum class Screening { steps, ladder };

/// Probes one candidate. Invalid where `base` has freed it, or where it has no influence on these data.
Probe probe_candidate(const DiagnosisProblem& problem, const EvidenceSpace& space, const Fit& base, int candidate,
                      Screening how);
/// The same of every candidate, in parallel and in their order.
std::vector<Probe> screen(const DiagnosisProblem& problem, const EvidenceSpace& space, const Fit& base,
                          Screening how = Screening::steps);

/// Where a fit of one more candidate may start: at the linear estimate, on the best rung of the ladder where there is one, at the probing
/// step. The base model's parameters are `base`, p of all parameters.
std::vector<Vector> fit_starts(const DiagnosisProblem& problem, const Vector& base, int candidate, const Probe& probe);

/// Energy |.|^2 of a signature that the columns `own`, with prior N(0, I) times `stretch`^2, can't reproduce.
double unexplained_energy(const Vector& signature, const Matrix& own);

}  // namespace jaculus
