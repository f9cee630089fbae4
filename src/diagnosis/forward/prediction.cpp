#include "diagnosis/forward/prediction.h"

#include "simulation/experiment/channel_values.h"
#include "simulation/plant/named_values.h"

namespace jaculus::diagnosis {

double Prediction::at(int channel, double time) const {
  const double behind = stamped.empty() ? 0.0 : stamped[channel];
  return simulation::interpolate(values.row(channel), step, time - first - behind);
}

double Prediction::row(const Segment& segment, int channel, double time) const {
  const int block = segment.block[channel];
  if (block == 1) return at(channel, time);

  const double spacing = segment.spacing[channel];
  double sum = 0.0;
  for (int k = 0; k < block; ++k) sum += at(channel, time + (k - 0.5 * (block - 1)) * spacing);
  return sum / block;
}

double Prediction::row_slope(const Segment& segment, int channel, double time) const {
  return (row(segment, channel, time + step) - row(segment, channel, time - step)) / (2.0 * step);
}

Prediction prediction_of(const ObservedDataset& observed, const simulation::Plant& plant,
                         const simulation::Simulation& simulation) {
  using simulation::value_or;
  Prediction prediction;
  prediction.valid = true;
  prediction.first = simulation.time[0];
  if (simulation.time.size() > 1) prediction.step = simulation.time[1] - simulation.time[0];
  prediction.values.resize(count_of(observed.channels), simulation.time.size());

  for (int c = 0; c < prediction.values.rows(); ++c) {
    const Channel& channel = observed.channels[c];
    const double scale = value_or(plant.sensing.scale, channel.name, 1.0);
    const double offset = value_or(plant.sensing.offset, channel.name, 0.0);
    const double filter = value_or(plant.sensing.filter, channel.name, 0.0);
    const Eigen::RowVectorXd raw = simulation::low_passed(
        tracked_channel(plant, simulation, channel.name), prediction.step, filter);
    prediction.values.row(c) = scale * raw.array() + offset;
    if (const auto law = plant.sensing.laws.find(channel.name); law != plant.sensing.laws.end())
      for (Eigen::Index k = 0; k < simulation.time.size(); ++k)
        prediction.values(c, k) = law->second(prediction.values(c, k), simulation.time[k]);

    const double stamped = value_or(plant.sensing.latency, channel.stream, 0.0);
    const double late = plant.actuation.late_start + plant.actuation.delay + stamped;
    prediction.stamped.push_back(stamped);
    prediction.late.push_back(observed.measured_input ? 0.0 : late);
  }

  return prediction;
}

double Alignment::origin(const ObservedDataset& observed, int segment, int channel) const {
  return observed.segments[segment].start + segments[segment].shift[observed.stream_of(channel)];
}

Alignment unaligned(const ObservedDataset& observed) {
  Alignment alignment;
  for (const Segment& segment : observed.segments)
    alignment.segments.push_back(
        {std::vector<double>(observed.streams.size(), 0.0), segment.value});
  alignment.late.assign(observed.channels.size(), 0.0);
  return alignment;
}

Vector measured_rows(const ObservedDataset& observed, const Alignment& alignment) {
  Vector rows(observed.rows());
  for (const RowSpan& span : row_spans(observed))
    rows.segment(span.first, span.count) = alignment.segments[span.segment].value[span.channel];
  return rows;
}

Vector predicted_rows(const ObservedDataset& observed, const Alignment& alignment,
                      const std::vector<const Prediction*>& segments) {
  Vector rows(observed.rows());

  for (const RowSpan& span : row_spans(observed)) {
    const Segment& segment = observed.segments[span.segment];
    const Prediction& prediction = *segments[span.segment];
    const double origin = alignment.origin(observed, span.segment, span.channel);
    const double later = prediction.lateness(span.channel) - alignment.late[span.channel];

    for (int i = 0; i < span.count; ++i) {
      const double t = segment.time[span.channel][i] - origin + later;
      double& row = rows[span.first + i];
      row = prediction.row(segment, span.channel, t);
      if (later != 0.0) row -= later * prediction.row_slope(segment, span.channel, t);
    }
  }

  return rows;
}

}  // namespace jaculus::diagnosis
