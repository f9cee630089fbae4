#pragma once
// What a diagnosis works on: measured channels, selected and cut, of one or several datasets.
// Constant once read: later steps return values of their own (noise model, posterior) and never
// edit these.
//
// A row is one sample of one channel in one segment. A segment is what one simulation start
// predicts:
// a trial where a plan or a script drove the robot, or a window of a trial where a logged input
// drove it (controller kind `measured`), restarted from the measured state. Rows are ordered by
// segment, then channel, then time; this order is the one of every residual vector of the
// diagnosis.

#include <string>
#include <vector>

#include "jaculus/core/types.h"
#include "jaculus/diagnosis/diagnosis.h"
#include "jaculus/diagnosis/settings.h"
#include "jaculus/model/planar.h"
#include "jaculus/trajectory/dataset.h"

namespace jaculus::diagnosis {

/// One measured quantity of a dataset that counts as evidence. Commands (a duty that was asked for,
/// the logged input) are none.
struct Channel {
  std::string stream;            ///< "mocap", "joints"
  std::string name;              ///< "x", "pitch", "front_a", "tail_velocity", ...
  std::string unit;              ///< SI
  bool zero_order_hold = false;  ///< steps with the loop (torque, current, voltage, duty)
  double spacing = kNaN;         ///< between samples as used, median over segments [s]
};

/// Samples that one simulation start predicts.
struct Segment {
  int trial = 0;             ///< index in the dataset's trials
  double start = 0.0;        ///< data's time at which the simulation begins [s]
  double prefix_end = 0.0;   ///< nuisances of a held-out segment are estimated before it [s]
  std::vector<Vector> time;  ///< a channel each: data's time of samples [s]; empty without any
  std::vector<int> block;    ///< a channel each: samples averaged into one row at their mean time
  std::vector<double> spacing;  ///< a channel each: between those samples [s]
  std::vector<Vector> value;    ///< a channel each: samples without gaps, as recorded [unit]
  Vector start_q, start_v;      ///< kind measured: initial coordinates and rates, else empty

  /// Data's time of the last sample of any channel; `start` where there is none [s].
  [[nodiscard]] double end() const;
};

/// A dataset as it is diagnosed.
struct ObservedDataset {
  trajectory::Dataset dataset;
  model::PlanarModel model;
  std::vector<std::string> streams;
  std::vector<Channel> channels;
  std::vector<Segment> segments;
  bool measured_input = false;  ///< a segment is a window
  double window_start = 0.0;    ///< data before this or after window_end are not used [s]
  double window_end = 0.0;
  int trials = 0;  ///< that have data

  [[nodiscard]] int rows() const;
  [[nodiscard]] std::string name() const;                           ///< of its folder
  [[nodiscard]] int stream_index(const std::string& stream) const;  ///< -1 where there is none
  [[nodiscard]] int stream_of(int channel) const;                   ///< index of its stream
};

struct Observations {
  std::vector<ObservedDataset> datasets;
  std::vector<std::string> notes;         ///< what was left out or assumed, a sentence each
  std::vector<std::string> insufficient;  ///< why the data can't answer; empty where they may
  std::vector<Parting> partings{};        ///< from which on data are left out
};

/// Selects and cuts. `models` holds the robot of each dataset, its overrides applied.
Observations observe(const std::vector<trajectory::Dataset>& datasets,
                     const std::vector<model::PlanarModel>& models, const Settings& settings = {});

/// Whether positions and rates are all that a dataset's channels show.
bool motion_alone(const ObservedDataset& observed);

/// Whether motion capture is all there is: its clock is not the robot's, and nothing logged on the
/// robot says by how much.
bool tracked_alone(const ObservedDataset& observed);

/// The same dataset without a channel.
ObservedDataset without_channel(ObservedDataset observed, int channel);

/// A channel of a dataset, by their indices.
struct ChannelPlace {
  int dataset = 0, channel = 0;
};
/// The same observations without some channels, and without datasets that then have no row.
Observations without_channels(Observations observations, const std::vector<ChannelPlace>& dropped);

/// A segment's data from a time on.
struct SegmentTail {
  int dataset = 0, segment = 0;
  double from = 0.0;  ///< [s]
};
/// The same observations without some tails.
Observations without_tails(Observations observations, const std::vector<SegmentTail>& dropped);

/// How many windows of logged inputs there are.
int windows_of(const Observations& observations);
/// The same observations with `most` windows of logged inputs, evenly spread over all of them, two
/// of each dataset at least.
Observations with_windows(Observations observations, int most);

/// A stretch of a trial, by indices of dataset and trial.
struct TrialSpan {
  int dataset = 0, trial = 0;
  double from = 0.0, to = 0.0;  ///< data's time [s]
};
/// The same observations with windows of logged inputs cut anew beside these stretches, as many as
/// before where a trial has room for them. A trial without room for one keeps its windows.
Observations with_windows_beside(Observations observations, const std::vector<TrialSpan>& left_out,
                                 const Settings& settings);

/// Where the rows of one channel of one segment stand in the vector of all rows of a dataset.
struct RowSpan {
  int segment = 0, channel = 0;
  int first = 0, count = 0;
};
std::vector<RowSpan> row_spans(const ObservedDataset& observed);

}  // namespace jaculus::diagnosis
