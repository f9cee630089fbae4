#pragma once
// Predicted channels on a grid of model time.
//
// One simulation serves all segments of a dataset that share command and start; they differ in
// nuisances that are linear:
//   y_c(t_i) = f_c(t_i - shift; p) + sum_k (df_c/ds_k) s_k + offset_c.
// f stands on a uniform grid of model time and is interpolated; before the start it keeps its first
// value (the robot is held), so that data from before the command count as rest.

#include <functional>
#include <string>
#include <vector>

#include "diagnosis/data/observations.h"
#include "jaculus/simulation/simulate.h"

namespace jaculus::diagnosis {

/// Channels of one dataset on a uniform grid of model time.
struct Prediction {
  bool valid = false;
  std::string message;            ///< why not valid: the simulation's own
  double step = 1e-3;             ///< of the grid [s]
  Matrix values;                  ///< channels x grid points [unit of each channel]
  std::vector<double> impacts{};  ///< of stops and landing feet, in order, model time [s]
  /// Of a scripted command and the end of any, where they arrive, model time [s].
  std::vector<double> steps{};
  double first = 0.0;             ///< of the grid, model time [s]
  std::vector<double> stamped{};  ///< a channel each: its sensor stamps late by this [s]; empty: 0
  /// A channel each: its command and its stamps are late together by this [s]; empty: 0.
  std::vector<double> late{};
  /// Where not valid: model time that the simulation reached; NaN: it never began [s].
  double reached = kNaN;

  /// By which a channel is late [s].
  [[nodiscard]] double lateness(int channel) const { return late.empty() ? 0.0 : late[channel]; }
  /// Value of a channel at a model time, linear between grid points, constant beyond the ends.
  [[nodiscard]] double at(int channel, double time) const;
  /// Mean over the samples that a segment averages into a row of mean model time `time`.
  [[nodiscard]] double row(const Segment& segment, int channel, double time) const;
  /// d(row)/dt at that time, a central difference over the grid.
  [[nodiscard]] double row_slope(const Segment& segment, int channel, double time) const;
};

/// Predicts a segment of a dataset at the flat parameters `p`. Pure: may be called from several
/// threads.
using ForwardModel = std::function<Prediction(int dataset, int segment, const Vector& p)>;

/// Channels of a dataset as its sensors show them: joints on the motor's side, scale and offset of
/// the plant's sensing, and by how much they are late. A logged input that drives the joints comes
/// with its own clock, so that nothing is late there.
Prediction prediction_of(const ObservedDataset& observed, const simulation::Plant& plant,
                         const simulation::Simulation& simulation);

/// How a dataset's clocks and start correct its rows (noise/noise_model.h).
struct SegmentAlignment {
  std::vector<double> shift;  ///< a stream each: stamps are late by this [s]
  /// A channel each: samples as recorded, less the start's curvature (noise/start_curvature.h)
  /// [unit].
  std::vector<Vector> value;
};
struct Alignment {
  std::vector<SegmentAlignment> segments;
  /// A channel each: lateness of the prediction by which segments are aligned [s].
  std::vector<double> late;

  /// Data's time that is the model's zero for a channel of a segment [s].
  [[nodiscard]] double origin(const ObservedDataset& observed, int segment, int channel) const;
};
/// Nothing shifted, values as recorded.
Alignment unaligned(const ObservedDataset& observed);

/// All rows' values, in order.
Vector measured_rows(const ObservedDataset& observed, const Alignment& alignment);

/// Predictions at the rows of a dataset, given those of its segments; segments that share a
/// prediction repeat it. A clock's shift is a nuisance with one slope, f(t - s) = f(t) - s f'(t),
/// good for a part of a millisecond. A prediction that is later than the one by which the segments
/// were aligned, by d, is therefore unrolled as the same motion later: f(t + d) - d f'(t + d). A
/// body that falls meanwhile does not wait: its height is off by g d^2/2, 0.12 mm at 5 ms.
Vector predicted_rows(const ObservedDataset& observed, const Alignment& alignment,
                      const std::vector<const Prediction*>& segments);

}  // namespace jaculus::diagnosis
