// What sensors show of a simulation, and predictions at the rows of the data.

#include <cstddef>

#include "jaculus/diagnosis/forward.h"
#include "simulation/channel_values.h"

namespace jaculus {
double Prediction::at(int channel, double time) const {
  const double behind = stamped.empty() ? 0.0 : stamped[static_cast<std::size_t>(channel)];
  return interpolate(values.row(channel), step, time - first - behind);
}

double Prediction::row(const Run& run, int channel, double time) const {
  const int block = run.block[static_cast<std::size_t>(channel)];
  if (block == 1) return at(channel, time);
  const double spacing = run.spacing[static_cast<std::size_t>(channel)];
  double sum = 0.0;
  for (int k = 0; k < block; ++k) sum += at(channel, time + (k - 0.5 * (block - 1)) * spacing);
  return sum / block;
}

Prediction prediction_of(const Condition& condition, const Plant& plant, const Simulation& simulation) {
  Prediction prediction;
  prediction.valid = true;
  prediction.first = simulation.time[0];
  if (simulation.time.size() > 1) prediction.step = simulation.time[1] - simulation.time[0];
  prediction.values.resize(static_cast<Eigen::Index>(condition.channels.size()), simulation.time.size());
  for (std::size_t c = 0; c < condition.channels.size(); ++c) {
    const Channel& channel = condition.channels[c];
    const double scale = value_or(plant.sensing.scale, channel.name, 1.0);
    const double offset = value_or(plant.sensing.offset, channel.name, 0.0);
    prediction.values.row(static_cast<Eigen::Index>(c)) =
        scale * raw_channel(plant.model, simulation, channel.name).array() + offset;
    prediction.stamped.push_back(value_or(plant.sensing.latency, channel.stream, 0.0));
    const double late = plant.actuation.late_start + plant.actuation.delay + prediction.stamped.back();
    prediction.late.push_back(condition.measured_input ? 0.0 : late);
  }
  return prediction;
}

Vector predicted_rows(const Condition& condition, const std::vector<const Prediction*>& runs) {
  Vector rows(condition.rows());
  for (const RowSpan& span : row_spans(condition)) {
    const Run& run = condition.runs[static_cast<std::size_t>(span.run)];
    const Prediction& prediction = *runs[static_cast<std::size_t>(span.run)];
    const Channel& channel = condition.channels[static_cast<std::size_t>(span.channel)];
    const int stream = condition.stream_index(channel.stream);
    const double shift = run.start + run.shift[static_cast<std::size_t>(stream)];
    const Vector& time = run.time[static_cast<std::size_t>(span.channel)];
    const double later = prediction.lateness(static_cast<std::size_t>(span.channel)) - channel.late;
    const auto value = [&](double t) { return prediction.row(run, span.channel, t); };
    for (int i = 0; i < span.count; ++i) {
      const double t = time[i] - shift + later, h = prediction.step;
      rows[span.first + i] = value(t);
      if (later != 0.0) rows[span.first + i] -= later * (value(t + h) - value(t - h)) / (2.0 * h);
    }
  }
  return rows;
}

}  // namespace jaculus
