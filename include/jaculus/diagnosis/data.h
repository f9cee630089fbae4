#pragma once
// What a diagnosis works on: measured channels, selected and cut, of one or several operating conditions (a dataset each).
//
// A row is one sample of one channel in one run. A run is what one simulation start predicts: a trial where a plan or a script
// drove the robot, or a window of a trial where a logged input drove it (kind `measured`), restarted from the measured state.
// Rows are ordered by run, then channel, then time; this order is the one of every residual vector of the diagnosis.

#include <string>
#include <vector>

#include "jaculus/core/types.h"
#include "jaculus/model/planar.h"
#include "jaculus/trajectory/dataset.h"

namespace jaculus {

/// From this time after the first command on, what follows the loop is the command's; before, of whatever held the robot [s].
inline constexpr double kCommanded = 5e-3;

/// One measured quantity of a condition that counts as evidence. Commands (a duty that was asked for, the logged input) are none.
struct Channel {
  std::string stream;         ///< "mocap", "joints"
  std::string name;           ///< "x", "pitch", "front_a", "tail_velocity", ...
  std::string unit;           ///< SI
  bool held = false;          ///< follows the loop's hold in steps (torque, current, voltage, duty)
  double spacing = kNaN;      ///< between samples as used, median over runs [s]
  double late = 0.0;          ///< of the prediction by which runs are aligned (Prediction::late) [s]
  double noise_floor = kNaN;  ///< standard deviation of one trial about the trials' mean after alignment [unit]
  double correlation = 0.0;   ///< of neighbouring samples of that scatter, 0 to 0.98 [-]
  double wander = 0.0;        ///< standard deviation of each smooth mode of a run's own, beyond noise and starts [unit]
  double discrepancy = 0.0;   ///< standard deviation declared for smooth faults of the plant itself [unit]
};

/// Samples of one run.
struct Run {
  int trial = 0;                 ///< index in the dataset's trials
  double start = 0.0;            ///< data's time at which the simulation begins [s]
  std::vector<Vector> time;      ///< a channel each: data's time of samples [s]; empty where it has none
  std::vector<int> block;        ///< a channel each: samples averaged into one row, whose time is their mean
  std::vector<double> spacing;   ///< a channel each: between those samples [s]
  std::vector<Vector> value;     ///< a channel each: samples without gaps, less what start_curvature.h takes off [unit]
  std::vector<Vector> recorded;  ///< the same as recorded; empty: as `value` [unit]
  std::vector<double> shift;     ///< a stream each: stamps are late by this, as aligned so far [s]
  Vector start_q, start_v;       ///< kind measured: initial coordinates and rates from the data, else empty
};

struct Condition {
  Dataset dataset;
  PlanarModel model;
  std::vector<std::string> streams;
  std::vector<Channel> channels;
  std::vector<Run> runs;
  bool measured_input = false;  ///< a run is a window
  double window_start = 0.0;    ///< data before this or after window_end are not used [s]
  double window_end = 0.0;
  double prefix_end = 0.0;  ///< nuisances of a held-out run are estimated from data before this, judged after it [s]
  int trials = 0;           ///< that have data

  [[nodiscard]] int rows() const;
  [[nodiscard]] int stream_index(const std::string& name) const;  ///< -1 where there is none
};

struct Observations {
  std::vector<Condition> conditions;
  std::vector<std::string> notes;         ///< what was left out or assumed, a sentence each
  std::vector<std::string> insufficient;  ///< why the data can't answer; empty where they may
};

struct ObservationOptions {
  int samples = 120;           ///< of a channel in a run at most; denser ones are averaged in blocks
  double rest = 0.1;           ///< data used before time zero [s]
  double prefix_share = 0.25;  ///< of the motion's duration that belongs to the prefix
  double window = 0.5;         ///< length of windows of measured input [s]
  int windows = 12;            ///< at most, of one trial
};

/// Selects and cuts. `models` holds the robot of each dataset, its overrides applied.
Observations observe(const std::vector<Dataset>& datasets, const std::vector<PlanarModel>& models,
                     const ObservationOptions& options = {});

/// Where the rows of one channel of one run stand in the vector of all rows of a condition.
struct RowSpan {
  int run = 0, channel = 0;
  int first = 0, count = 0;
};
std::vector<RowSpan> row_spans(const Condition& condition);
/// Leaves a channel out of a condition and all its runs.
void drop_channel(Condition& condition, std::size_t channel);
/// All rows' values, in order.
Vector measured_rows(const Condition& condition);

}  // namespace jaculus
