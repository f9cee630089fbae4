#pragma once
// Nuisances of one segment: what may differ from segment to segment without being an effect.
//
// Each is a column A_k of d(rows)/d(nuisance) with prior N(m_k, s_k^2):
//   shift of a stream    -df/dt,  m = -(shift aligned so far),
//                        s^2 = (2 (2 ms)^2 + sum (shift - mean)^2)/(1 + segments): the scatter of
//                        the shifts tells how far stamps can be trusted, so that a shift that all
//                        segments share stays evidence
//   phase of the loop    -df/dt of a stream's zero-order-hold channels, m = 0, s = period/sqrt(12):
//                        where between two steps of a sampled loop its samples lie
//   start offsets        differences through simulation, s as the hypotheses have it
//   offset of a channel  1; x and pitch of motion capture are relative to rest, hence free
//   variability          smooth modes of a segment's own (channel_noise.h), where segments differ
//                        by more than noise and starts

#include <string>
#include <vector>

#include "diagnosis/forward/problem.h"

namespace jaculus::diagnosis {

/// Nuisances of one segment, on its rows alone.
struct SegmentNuisances {
  int first = 0, count = 0;  ///< rows of the segment within its dataset
  Matrix columns;            ///< count x k
  Vector mean, scale;        ///< prior, k each
  std::vector<std::string> names;
};

/// d(rows)/d(start) of every start offset of the hypotheses: an entry each, rows of all datasets;
/// empty where the moved start can't be simulated.
using StartSlopes = std::vector<std::vector<Vector>>;

/// Shifts, phases, starts and offsets of a segment.
SegmentNuisances segment_nuisances(const Problem& problem, const Alignment& alignment,
                                   const Prediction& prediction, const StartSlopes& starts,
                                   int dataset, int segment);

/// The name of a start's nuisance.
std::string start_nuisance(const FreeParameter& start);

/// Prior standard deviation of a channel's own constant offset in a segment; 0: it has none [unit].
double offset_scale(const ObservedDataset& observed, const Channel& channel,
                    const Settings& settings);
/// Whether a channel is relative to rest, wherever that was.
bool relative_to_rest(const ObservedDataset& observed, const Channel& channel);

/// The same nuisances and `variability` [unit], a channel each, of smooth modes of the segment's
/// own.
SegmentNuisances with_variability(SegmentNuisances nuisances, const ObservedDataset& observed,
                                  int segment, const std::vector<double>& variability, int modes);

/// Orthonormal modes of smooth faults at the times of a channel, times x modes:
/// sqrt(2) sin((k - 1/2) pi t/T) over the dataset's time T, cosines for zero-order-hold channels (a
/// torque may be wrong at once, a position can't).
Matrix fault_modes(const ObservedDataset& observed, const Channel& channel, const Vector& time,
                   int modes);
/// The same over [0, duration] of `time`.
Matrix fault_modes(const Vector& time, double duration, bool zero_order_hold, int modes);

/// What the rows of a segment tell of its nuisances, about their prior mean:
///   d = argmin |W (r - A d)|^2 + |d/s|^2,   r: residual of the segment's rows less A m.
/// `white_columns` = W A diag(s), `white_residual` = W r, rows that don't tell being zero in both.
struct NuisanceEstimate {
  Vector deviation;  ///< d, k
  Matrix root;       ///< L of I + (W A S)^T (W A S) = L L^T, k x k
};
NuisanceEstimate estimate_nuisances(const SegmentNuisances& nuisances, const Matrix& white_columns,
                                    const Vector& white_residual);
/// The same by one weight a row (1/deviation; 0: left out).
NuisanceEstimate estimate_by_weights(const SegmentNuisances& nuisances, const Vector& residual,
                                     const Vector& weight);

/// 1 for the rows of a segment before its prefix ends, else 0: the one definition of what may be
/// known of a segment that is to be predicted.
Vector prefix_rows(const ObservedDataset& observed, const SegmentNuisances& nuisances, int segment);

}  // namespace jaculus::diagnosis
