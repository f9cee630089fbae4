#pragma once
// Most probable parameters of a model, and its evidence.
//
//   u = (p - nominal)/scale of the free parameters,  cost(u) = r^T V^-1 r/2 + |u|^2/2,
//   r = T (y - A m - f(p)) (noise/whitening.h),  V = I + G S^2 G^T: what noise and forces that the
//   plant lacks make of it (noise/random_effects.h)
// minimised within bounds (minimise.h), slopes by forward differences through simulation, backward
// at an upper end (residual.h), in turn with the deviations S that maximise the evidence.
// Laplace's evidence, with H = J^T V^-1 J + I and mean mu of the posterior linearised at the
// optimum:
//   log Z = log N(r0; 0, V + J J^T), r0 = r - J u,
//           + sum over bounded parameters [log of the posterior's mass within bounds, less the
//             prior's]
// J of what is integrated over: under a plan what all models share (shared_columns) is at its most
// probable, with the density of its prior there and no mass, and the method is applied at the fit.
// so that a parameter which starts at its boundary carries half a prior and the part of its
// posterior that the boundary leaves. Limits of validity: one mode, nearly Gaussian in u; intervals
// are checked by profile.

#include <optional>
#include <string>
#include <vector>

#include "diagnosis/noise/whitening.h"
#include "diagnosis/selection/residual.h"

namespace jaculus::diagnosis {

struct Fit {
  bool valid = false;
  std::string message;       ///< why not valid
  std::vector<int> free;     ///< indices of the free parameters
  Vector p;                  ///< all parameters, at the optimum
  Vector simulated;          ///< the same, or tolerances where their slopes are (residual.h)
  std::vector<Vector> rows;  ///< predicted at `simulated`, a dataset each [units of the rows]
  Vector residual;           ///< r there
  Matrix jacobian;           ///< dr/du, rows x free
  Vector scales;             ///< deviations S of the random effects
  Matrix covariance;         ///< of u, H^-1
  double chi2 = 0.0;         ///< |r|^2
  double cost = 0.0;         ///< at the optimum, by S
  double log_evidence = 0.0;
  double log_complete = 0.0;  ///< the same where the plant lacks no force: S = 0
  long predictions = 0;       ///< sets of simulations that it took
  RowSlopes nuisance_rows;    ///< as known last, where they were asked for

  /// Whether tolerances were not simulated, so that p is no point of the forward model.
  [[nodiscard]] bool by_slopes() const { return p != simulated; }
};

struct FitOptions {
  std::optional<int> iterations{};   ///< at most, a start; else settings.fit_iterations
  std::optional<int> rounds{};       ///< of fits and deviations, beyond the first; else as settings
  std::optional<int> scale_steps{};  ///< of the deviations a round, at most; else as settings
  double enough = kInfinity;         ///< log evidence at which no further start is tried
  Vector scales{};                   ///< deviations to begin with; empty: first_scales()
  bool hold_scales = false;          ///< whether they stay
  /// Slopes of the nuisances to set out with, white rows x nuisances (residual.h); empty: those at
  /// the start.
  Matrix known{};
  /// The same of their rows, which serve where `known` is empty; and whether the fit keeps those it
  /// ends with.
  RowSlopes known_rows{};
  bool keep_rows = false;
  /// The same of the effects, white rows x their parameters, then by secants; empty: differenced.
  Matrix effect_slopes{};
  /// Whether they follow by secants where no slope is given at all, once differenced.
  bool effects_follow = false;
  /// Tolerances by their slopes alone (residual.h); null or without slopes: simulated. Has to
  /// outlive the fit.
  const LinearNuisances* by_slopes = nullptr;
  /// Whether slopes that follow by secants are told anew where a fit ends, and it goes on from
  /// there; else it ends with the first round.
  bool renew = true;
  /// Whether forces are granted from the first round on, at `scales`; else it is plain least
  /// squares.
  bool with_forces = false;
};

/// Fits the parameters `free` from `starts` (full vectors; their other entries count as fixed),
/// those of the least cost first, settings.starts_tried at most and until one gives `enough`, and
/// keeps the best.
Fit fit_model(const Problem& problem, const Whitening& whitening, const std::vector<int>& free,
              const std::vector<Vector>& starts, const FitOptions& options = {});

/// The same from where a fit of another space stands, `known_rows` that one's: misfits follow from
/// the first step on, and no plain least squares lead away from there.
Fit fit_near(const Problem& problem, const Whitening& whitening, const std::vector<int>& free,
             const Vector& start, const FitOptions& options);

/// Fixed parameters: r and log evidence alone. Of the options the deviations count.
Fit evaluate_model(const Problem& problem, const Whitening& whitening, const Vector& p,
                   const FitOptions& options = {});

/// X = [r0 -J] of a fit: what is left of the data at u = 0, and its columns.
Matrix linear_model(const Problem& problem, const Fit& fit);

/// Of a fit's free parameters those that all models share (Products::shared), by their places; none
/// where forces may be missing.
std::vector<Eigen::Index> shared_columns(const Problem& problem, const RandomEffects& random,
                                         const Fit& fit);

/// Whether the evidence says that a model lacks forces or has a misfit, by settings.remainder_left.
bool lacks(const Problem& problem, const Fit& fit);

/// Whether a model leaves what another effect, or a push, may explain: what it lacks; or, under a
/// plan, tolerances that are strained to explain it themselves, by the log density that |t|^2 costs
/// beyond the number of them that the data tell, settings.remainder_left at least.
bool leaves_more(const Problem& problem, const Fit& fit);

/// The same fit, or the one from the best of some starts, if the cost there is less by more than
/// `lower_valley` before any step is taken.
Fit fit_from_lower(const Problem& problem, const Whitening& whitening, Fit fit,
                   const std::vector<Vector>& starts, const FitOptions& options = {});

/// The same from where the first free parameter's departure from nominal is somewhat smaller or
/// larger (`kAround`), the others as they are: where a prediction jumps, an impact that crosses a
/// row makes valleys of its own.
Fit fit_around(const Problem& problem, const Whitening& whitening, Fit fit,
               const FitOptions& options = {});

/// By how much a deviation is larger than curvature says, for what windows contradict one another.
/// With the scores g_w = J_w^T (V^-1 r)_w of the windows, the root of
///   (H^-1 sum_w g_w g_w^T H^-1)_ii/(H^-1 sum_w J_w^T (V^-1)_ww J_w H^-1)_ii,
/// what they are over what they would be if V were true (White 1982), at least 1. Where a model's
/// form is wrong its misfit repeats with the motion and does not average out as noise does.
/// Of the sum a^T u of the free parameters, a: `along`.
double widening(const Whitening& whitening, const Fit& fit, const Vector& along);

/// 95 % interval of one free parameter: q standard deviations to both sides (interval_basis.h has
/// both; 1.96 where no misfit was estimated), cut at the bounds, where the cost there rises as the
/// curvature says within `profile_tolerance`; else ends where the profile (others refitted by known
/// slopes) has risen by q^2/2. Widened by what windows contradict one another.
Bounds interval95(const Problem& problem, const Whitening& whitening, const Fit& fit,
                  int parameter);

/// A parameter of an effect, and its 95 % interval.
struct Estimate {
  double value = 0.0;
  Bounds ci95;
};
/// Parameters of a candidate that a fit frees, with what tolerances of the same quantity add to
/// them (tolerance_part.h). Where they do, the interval is that of the sum by the covariance,
/// widened likewise and cut at the bounds; else it is interval95.
std::vector<Estimate> with_tolerances(const Problem& problem, const Whitening& whitening,
                                      const Fit& fit, int candidate);
/// The values alone.
Vector theta_with_tolerances(const Problem& problem, const Fit& fit, int candidate);

}  // namespace jaculus::diagnosis
