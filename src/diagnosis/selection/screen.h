#pragma once
// Screening: what each candidate could explain of a residual, from a few probing simulations and no
// fit.
//
//   columns of a candidate: g_i = T (f(p + h_i) - f(p))/h_i, at a small step and at its probing
//   step, because friction, play and limits are not linear from nominal on; second parameters (a
//   damping) are probed with the first one set. Where both steps of a candidate said the same about
//   another model, the small one is taken alone.
//   score = log evidence of the linear Gaussian model with these columns and those of the base
//   model, prior N(0, I) in u, less that of the base model alone, each by the deviations of random
//   effects that it needs (noise/random_effects.h);
//   or that of the best step of a line search (line_search.h), where it is larger. Under a plan no
//   line is searched where both steps say the same and so does one to the estimate, if that lies
//   beyond them.

#include <vector>

#include "diagnosis/selection/line_search.h"

namespace jaculus::diagnosis {

/// Signatures of one candidate about a base model.
struct Probe {
  bool valid = false;
  Matrix small, full;     ///< rows x parameters, per prior scale, at the two strengths
  bool linear = false;    ///< whether both say the same (settings.same_slope), or did before
  bool by_small = false;  ///< whether the score is that of the small step's columns
  double score = -kInfinity;
  Vector estimate;  ///< u of its parameters by the better linear model, within bounds
  double step =
      kNaN;  ///< u of the first parameter by line search; NaN: none helps, or none was tried
  long predictions = 0;  ///< sets of simulations that it took

  [[nodiscard]] const Matrix& better() const { return by_small ? small : full; }
};

/// How thorough screening is: at the two steps, or by line search as well.
enum class Screening { steps, line_search };

/// Probes one candidate. Invalid where `base` has freed it, or where it has no influence on these
/// data. `linear`: it is known to be so about another model.
Probe probe_candidate(const Problem& problem, const Whitening& whitening, const Fit& base,
                      const Standing& standing, int candidate, Screening how, bool linear = false);
/// The same of every candidate, in parallel and in their order. `before`: their probes about
/// another model, if any.
std::vector<Probe> screen(const Problem& problem, const Whitening& whitening, const Fit& base,
                          Screening how = Screening::steps,
                          const std::vector<Probe>* before = nullptr);

/// Where a fit of one more candidate may start: at the linear estimate, at the line search's step
/// where there is one, at the probing step. The base model's parameters are `base`, p of all
/// parameters.
std::vector<Vector> fit_starts(const Problem& problem, const Vector& base, int candidate,
                               const Probe& probe);

/// Energy, by V^-1 at some deviations, of a white signature, the first of the columns, that the
/// others can't reproduce. Of these the first `with_prior` are a prior scale each and may be moved
/// by as much only (nuisances); the others freely.
double unexplained_energy(const RandomEffects& random, const Vector& scales,
                          const Products& columns, Eigen::Index with_prior);
/// The same of a signature and other columns whose products are not known.
double unexplained_energy(const RandomEffects& random, const Vector& scales,
                          const Vector& signature, const Matrix& others, Eigen::Index with_prior);

}  // namespace jaculus::diagnosis
