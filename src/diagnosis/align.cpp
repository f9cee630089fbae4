#include "diagnosis/align.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "diagnosis/nuisance_estimate.h"
#include "jaculus/diagnosis/evidence_space.h"

namespace jaculus {
namespace {

constexpr double kMostShift = 0.03;  // s
constexpr double kRidge = 0.01;      // s, weak prior of a shift while aligning
constexpr int kHats = 40;            // of the mean over runs
constexpr double kMostCorrelation = 0.98;
constexpr double kRidgeOfModes = 0.02;  // of their square mean
constexpr int kLeastAligned = 8;        // rows of a prefix by which a span may be aligned
constexpr double kBeforeImpact = 3e-3;  // s, that an impact may come sooner than predicted
constexpr double kWanders = 3.0;  // times what noise alone leaves in the modes, from which runs have ways of their own

std::size_t at(int i) { return static_cast<std::size_t>(i); }

bool relative_to_rest(const Channel& channel) { return channel.name == "x" || channel.name == "pitch"; }

/// Residual of one span, less its mean where the channel is relative to rest, and minus its slope in time likewise.
void span_system(const Condition& condition, const RowSpan& span, const Prediction& prediction, double shift,
                 Vector& residual, Vector& slope) {
  const Run& run = condition.runs[at(span.run)];
  const Vector& time = run.time[at(span.channel)];
  residual.resize(span.count);
  slope.resize(span.count);
  for (int i = 0; i < span.count; ++i) {
    const double t = time[i] - run.start - shift, h = prediction.step;
    residual[i] = run.value[at(span.channel)][i] - prediction.row(run, span.channel, t);
    slope[i] = -(prediction.at(span.channel, t + h) - prediction.at(span.channel, t - h)) / (2.0 * h);
  }
  if (relative_to_rest(condition.channels[at(span.channel)])) {
    residual.array() -= residual.mean();
    slope.array() -= slope.mean();
  }
}

/// Misfit of every channel over all runs as they are aligned: the unit in which alignment weighs it.
Vector misfits(const Condition& condition, const std::vector<const Prediction*>& predictions) {
  Vector squares = Vector::Zero(static_cast<Eigen::Index>(condition.channels.size())), counts = squares;
  for (const RowSpan& span : row_spans(condition)) {
    const int stream = condition.stream_index(condition.channels[at(span.channel)].stream);
    Vector residual, slope;
    span_system(condition, span, *predictions[at(span.run)], condition.runs[at(span.run)].shift[at(stream)], residual,
                slope);
    squares[span.channel] += residual.squaredNorm();
    counts[span.channel] += span.count;
  }
  return (squares.array() / counts.array().max(1.0)).sqrt().max(1e-12);
}

/// Cost of a shift of one stream of one run, with the Gauss-Newton step from there.
double shift_cost(const Condition& condition, const std::vector<RowSpan>& spans, const Prediction& prediction,
                  const Vector& unit, double shift, double& step) {
  double cost = std::pow(shift / kRidge, 2), gradient = -shift / (kRidge * kRidge), curvature = 1.0 / (kRidge * kRidge);
  for (const RowSpan& span : spans) {
    Vector residual, slope;
    span_system(condition, span, prediction, shift, residual, slope);
    const double weight = 1.0 / (unit[span.channel] * unit[span.channel]);
    cost += weight * residual.squaredNorm();
    gradient += weight * slope.dot(residual);
    curvature += weight * slope.squaredNorm();
  }
  step = gradient / curvature;
  return cost;
}

double best_shift(const Condition& condition, const std::vector<RowSpan>& spans, const Prediction& prediction,
                  const Vector& unit, double shift) {
  double step = 0.0;
  double cost = shift_cost(condition, spans, prediction, unit, shift, step);
  for (int i = 0; i < 8 && std::abs(step) > 1e-7; ++i) {
    const double next = std::clamp(shift + step, -kMostShift, kMostShift);
    double next_step = 0.0;
    const double next_cost = shift_cost(condition, spans, prediction, unit, next, next_step);
    if (next_cost >= cost) {
      step *= 0.3;
      continue;
    }
    shift = next;
    cost = next_cost;
    step = next_step;
  }
  return shift;
}

/// Spans of one channel up to the first impact, after which scatter says more of times than of noise; whole where less than a third or
/// `least` rows come before it.
std::vector<RowSpan> quiet_spans(const Condition& condition, int channel,
                                 const std::vector<const Prediction*>& predictions, int least) {
  std::vector<RowSpan> spans;
  for (RowSpan span : row_spans(condition)) {
    if (span.channel != channel) continue;
    const Run& run = condition.runs[at(span.run)];
    const std::vector<double>& impacts = predictions[at(span.run)]->impacts;
    const double shift = run.start + run.shift[at(condition.stream_index(condition.channels[at(channel)].stream))];
    int before = span.count;
    if (!impacts.empty()) {
      const double end = *std::min_element(impacts.begin(), impacts.end()) - kBeforeImpact + shift;
      const Vector& time = run.time[at(channel)];
      before = static_cast<int>(std::lower_bound(time.begin(), time.begin() + span.count, end) - time.begin());
    }
    if (before >= std::max(least, span.count / 3)) span.count = before;
    spans.push_back(span);
  }
  return spans;
}

/// The rows of one channel: residual and what is fitted to it before the scatter is taken.
struct ChannelSystem {
  std::vector<RowSpan> spans;
  Vector residual;
  Matrix columns;
};

void add_hats(const Condition& condition, double from, double to, int hats, ChannelSystem& system) {
  int row = 0;
  for (std::size_t s = 0; s < system.spans.size(); ++s) {
    const RowSpan& span = system.spans[s];
    const Run& run = condition.runs[at(span.run)];
    for (int i = 0; i < span.count; ++i, ++row) {
      const double place = (run.time[at(span.channel)][i] - from) / std::max(1e-12, to - from) * (hats - 1);
      const int left = std::clamp(static_cast<int>(std::floor(place)), 0, hats - 2);
      const int block = condition.measured_input ? static_cast<int>(s) * hats : 0;
      system.columns(row, block + left) = 1.0 - (place - left);
      system.columns(row, block + left + 1) = place - left;
    }
  }
}

ChannelSystem channel_system(const Condition& condition, int channel, const std::vector<const Prediction*>& predictions,
                             const std::vector<RunNuisances>& nuisances) {
  ChannelSystem system;
  const Vector residual = measured_rows(condition) - predicted_rows(condition, predictions);
  Eigen::Index nuisance = 0;
  for (const RunNuisances& run : nuisances) nuisance = std::max(nuisance, run.columns.cols());
  system.spans = quiet_spans(condition, channel, predictions, 2 * static_cast<int>(nuisance));
  int rows = 0;
  for (const RowSpan& span : system.spans) rows += span.count;
  const bool shared = !condition.measured_input;
  const int runs = static_cast<int>(system.spans.size());
  const int per_run = runs > 0 ? rows / runs : 0;
  const int hats = std::clamp(per_run / (shared && runs > 1 ? 2 : 5), 2, shared && runs > 1 ? kHats : kHats / 2);
  int extra = 0;
  if (shared && runs > 1)
    for (const RowSpan& span : system.spans) extra += static_cast<int>(nuisances[at(span.run)].columns.cols());
  const int width = hats * (shared ? 1 : runs);
  system.residual.resize(rows);
  system.columns = Matrix::Zero(rows, width + extra);
  if (shared) {
    add_hats(condition, condition.window_start, condition.window_end, hats, system);
  }
  int row = 0, column = width;
  for (int s = 0; s < runs; ++s) {
    const RowSpan& span = system.spans[at(s)];
    system.residual.segment(row, span.count) = residual.segment(span.first, span.count);
    if (extra > 0) {
      const RunNuisances& n = nuisances[at(span.run)];
      system.columns.block(row, column, span.count, n.columns.cols()) =
          n.columns.middleRows(span.first - n.first, span.count) * n.scale.asDiagonal();
      column += static_cast<int>(n.columns.cols());
    }
    row += span.count;
  }
  if (!shared) {
    row = 0;
    for (int s = 0; s < runs; ++s) {
      const RowSpan& span = system.spans[at(s)];
      const Vector& time = condition.runs[at(span.run)].time[at(channel)];
      for (int i = 0; i < span.count; ++i, ++row) {
        const double place = (time[i] - time[0]) / std::max(1e-12, time[span.count - 1] - time[0]) * (hats - 1);
        const int left = std::clamp(static_cast<int>(std::floor(place)), 0, hats - 2);
        system.columns(row, s * hats + left) = 1.0 - (place - left);
        system.columns(row, s * hats + left + 1) = place - left;
      }
    }
  }
  return system;
}

void set_noise(const ChannelSystem& system, Channel& channel) {
  const auto rows = static_cast<double>(system.residual.size());
  Eigen::ColPivHouseholderQR<Matrix> qr(system.columns);
  qr.setThreshold(1e-8);
  const Vector scatter = system.residual - system.columns * qr.solve(system.residual);
  const auto rank = static_cast<double>(qr.rank());
  channel.noise_floor = rows > rank ? std::sqrt(scatter.squaredNorm() / (rows - rank)) : 0.0;
  double products = 0.0, squares = 0.0;
  int row = 0;
  for (const RowSpan& span : system.spans) {
    const Vector own = scatter.segment(row, span.count);
    products += own.head(span.count - 1).dot(own.tail(span.count - 1));
    squares += own.squaredNorm();
    row += span.count;
  }
  const double lag_one = squares > 0.0 ? products / squares + rank / rows : 0.0;
  channel.correlation = std::clamp(lag_one, 0.0, kMostCorrelation);
}

/// Rows less what all nuisances of each run, estimated together, make of them.
Vector without_nuisances(const Condition& condition, const std::vector<const Prediction*>& predictions,
                         const std::vector<RunNuisances>& nuisances) {
  Vector residual = measured_rows(condition) - predicted_rows(condition, predictions), weight(residual.size());
  for (const RowSpan& span : row_spans(condition)) {
    const double floor = condition.channels[at(span.channel)].noise_floor;
    weight.segment(span.first, span.count).setConstant(floor > 0.0 ? 1.0 / floor : 0.0);
  }
  for (const RunNuisances& n : nuisances) {
    if (n.count == 0 || n.columns.cols() == 0) continue;
    const Vector r = residual.segment(n.first, n.count) - n.columns * n.mean;
    residual.segment(n.first, n.count) -=
        n.columns * (n.mean + nuisance_deviation(n, r, weight.segment(n.first, n.count)));
  }
  return residual;
}

/// Runs that go smooth ways of their own (a foot slips in one and not in the next): what they do beyond noise and starts in the modes.
void set_wander(const Condition& condition, const std::vector<const Prediction*>& predictions, const Vector& residual,
                int c, Channel& channel) {
  const std::vector<RowSpan> spans = quiet_spans(condition, c, predictions, 0);
  int rows = 0;
  for (const RowSpan& span : spans) rows += span.count;
  const auto runs = static_cast<double>(spans.size());
  if (runs < 2.0 || channel.noise_floor == 0.0) return;
  // Modes of every run, less what all runs share of them.
  std::vector<Vector> found;
  Vector mean = Vector::Zero(kWanderModes);
  for (const RowSpan& span : spans) {
    const Matrix modes =
        fault_modes(condition, channel, condition.runs[at(span.run)].time[at(c)].head(span.count), kWanderModes);
    // Modes that the rows hardly tell apart stay small.
    const Matrix H =
        modes.transpose() * modes + kRidgeOfModes * span.count * Matrix::Identity(kWanderModes, kWanderModes);
    found.push_back(H.ldlt().solve(modes.transpose() * residual.segment(span.first, span.count)));
    mean += found.back() / runs;
  }
  double square = 0.0;  // of a mode in a run
  for (const Vector& own : found) square += (own - mean).squaredNorm() / (runs - 1.0) / kWanderModes;
  const double rho = channel.correlation, samples = rows / runs;
  const double by_noise = std::pow(channel.noise_floor, 2) * (1.0 + rho) / (1.0 - rho) / samples;
  channel.wander = square > kWanders * by_noise ? std::sqrt(square - by_noise) : 0.0;
}

/// The rows by which a span is aligned: all, or those of the prefix where the prediction jumps, if it has any to speak of. Rows between a
/// jump and where it was predicted would pull the clock by milliseconds, each run's its own way.
RowSpan aligned_part(const Condition& condition, const RowSpan& span, const Prediction& prediction) {
  if (prediction.impacts.empty()) return span;
  const Run& run = condition.runs[at(span.run)];
  const Vector& time = run.time[at(span.channel)];
  RowSpan part = span;
  const auto before = static_cast<int>(
      std::lower_bound(time.begin(), time.begin() + span.count, run.start + condition.prefix_end) - time.begin());
  if (before >= kLeastAligned) part.count = before;
  return part;
}

}  // namespace

void align(Condition& condition, const std::vector<const Prediction*>& predictions) {
  for (std::size_t c = 0; c < condition.channels.size(); ++c)
    condition.channels[c].late = predictions.front()->lateness(c);
  const Vector unit = misfits(condition, predictions);
  const std::vector<RowSpan> all = row_spans(condition);
  for (std::size_t r = 0; r < condition.runs.size(); ++r) {
    for (std::size_t s = 0; s < condition.streams.size(); ++s) {
      std::vector<RowSpan> spans;
      for (const RowSpan& span : all) {
        const Channel& channel = condition.channels[at(span.channel)];
        if (at(span.run) == r && !channel.held && channel.stream == condition.streams[s])
          spans.push_back(aligned_part(condition, span, *predictions[r]));
      }
      if (spans.empty()) continue;
      condition.runs[r].shift[s] = best_shift(condition, spans, *predictions[r], unit, condition.runs[r].shift[s]);
    }
  }
}

void estimate_noise(Condition& condition, const std::vector<const Prediction*>& predictions,
                    const std::vector<RunNuisances>& nuisances) {
  for (std::size_t c = 0; c < condition.channels.size(); ++c) {
    const ChannelSystem system = channel_system(condition, static_cast<int>(c), predictions, nuisances);
    if (system.residual.size() > 0) set_noise(system, condition.channels[c]);
  }
  if (condition.measured_input) return;
  const Vector residual = without_nuisances(condition, predictions, nuisances);
  for (std::size_t c = 0; c < condition.channels.size(); ++c)
    set_wander(condition, predictions, residual, static_cast<int>(c), condition.channels[c]);
}

}  // namespace jaculus
