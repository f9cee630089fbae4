#pragma once
// Predictions and first-order sensitivities about one point, and what follows from them before any effect is tried: alignment
// of the streams, noise floors, nuisances of every run.
//
// Nuisances of a run k, each a column A_k of d(rows)/d(nuisance) with prior N(m_k, s_k^2):
//   shift of a stream    -df/dt,  m = -(shift aligned so far),  s^2 = (2 (2 ms)^2 + sum (shift - mean)^2)/(1 + runs): the scatter of
//                        the shifts tells how far stamps can be trusted, so that a shift that all runs share stays evidence
//   phase of the loop    -df/dt of a stream's held channels, m = 0, s = period/sqrt(12): where between two steps of a sampled loop its
//                        samples lie
//   start offsets        forward differences through simulation, s as hypotheses.h has it
//   offset of a channel  1; x and pitch of motion capture are relative to rest, hence free
// Noise: residual r at the point, per channel, on hat functions over time that all runs share and the nuisances of each run; what
// is left has sigma^2 = sum r^2/(N - rank) and correlation of neighbours rho = lag-1 autocorrelation + rank/N (the bias of a fit).
// Wander: where the runs' own leftovers, projected on 10 modes over time, hold three times what noise leaves there, a run may go a
// smooth way of its own: 10 columns a channel with the standard deviation that the runs show.
// One run alone: the hats are a smoother and sigma is its scatter, which sees no slow noise.

#include "jaculus/diagnosis/data.h"
#include "jaculus/diagnosis/forward.h"
#include "jaculus/diagnosis/hypotheses.h"

namespace jaculus {

/// What is diagnosed: data, hypotheses and the map from parameters to predictions.
struct DiagnosisProblem {
  Observations observations;
  Hypotheses hypotheses;
  ForwardModel forward;
};

/// Predictions of all conditions at one point; runs that share a simulation share an entry.
struct PredictionSet {
  std::vector<std::vector<Prediction>> simulations;  ///< a condition, a distinct simulation
  bool valid = false;
  std::string message;

  /// A pointer a run.
  [[nodiscard]] std::vector<const Prediction*> runs(const Condition& condition, int c) const;
};
PredictionSet predict_all(const DiagnosisProblem& problem, const Vector& p);
/// Rows of all conditions, one vector each.
std::vector<Vector> rows_of(const DiagnosisProblem& problem, const PredictionSet& predictions);

/// Nuisances of one run, on its rows alone.
struct RunNuisances {
  int first = 0, count = 0;  ///< rows of the run within its condition
  Matrix columns;            ///< rows x k
  Vector mean, scale;        ///< prior, k each
  std::vector<std::string> names;
};

struct Linearisation {
  Vector p;
  PredictionSet at_p;
  std::vector<PredictionSet> starts;  ///< at p with one start offset moved by a share of its scale, an entry each
  std::vector<std::vector<RunNuisances>> nuisances;  ///< a condition, a run
};

/// Aligns streams (sets the runs' shifts), builds nuisances and estimates noise floors and correlations, all about p. The
/// linearisation is invalid (at_p.valid) where the simulation fails at p.
Linearisation linearise(DiagnosisProblem& problem, const Vector& p);

/// Declared discrepancy of each channel: `share` of the gap at the linearisation point, rms, and `floor` noise floors.
void declare_discrepancy(DiagnosisProblem& problem, const Linearisation& about, double share, double floor);

}  // namespace jaculus
