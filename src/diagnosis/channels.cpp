// What sensors show of a simulation, and predictions at the rows of the data.

#include <cstddef>

#include "jaculus/diagnosis/forward.h"
#include "simulation/channel_values.h"

namespace jaculus {
double Prediction::at(int channel, double time) const { return interpolate(values.row(channel), step, time); }

double Prediction::row(const Run& run, int channel, double time) const {
  const int block = run.block[static_cast<std::size_t>(channel)];
  if (block == 1) return at(channel, time);
  const double spacing = run.spacing[static_cast<std::size_t>(channel)];
  double sum = 0.0;
  for (int k = 0; k < block; ++k) sum += at(channel, time + (k - 0.5 * (block - 1)) * spacing);
  return sum / block;
}

Matrix channels_of(const Condition& condition, const Plant& plant, const Simulation& simulation) {
  const double step = simulation.time.size() > 1 ? simulation.time[1] - simulation.time[0] : 1.0;
  Matrix values(static_cast<Eigen::Index>(condition.channels.size()), simulation.time.size());
  for (std::size_t c = 0; c < condition.channels.size(); ++c) {
    const Channel& channel = condition.channels[c];
    Eigen::RowVectorXd row = raw_channel(plant.model, simulation, channel.name);
    const double latency = value_or(plant.sensing.latency, channel.stream, 0.0);
    if (latency != 0.0) {
      const Eigen::RowVectorXd prompt = row;
      for (Eigen::Index k = 0; k < row.size(); ++k)
        row[k] = interpolate(prompt, step, static_cast<double>(k) * step - latency);
    }
    const double scale = value_or(plant.sensing.scale, channel.name, 1.0);
    const double offset = value_or(plant.sensing.offset, channel.name, 0.0);
    values.row(static_cast<Eigen::Index>(c)) = scale * row.array() + offset;
  }
  return values;
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
    for (int i = 0; i < span.count; ++i) rows[span.first + i] = prediction.row(run, span.channel, time[i] - shift);
  }
  return rows;
}

}  // namespace jaculus
