#include "jaculus/diagnosis/evidence_space.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace jaculus {
namespace {

constexpr int kFaultModes = 6;
constexpr double kLeastEnergy = 1e-5;  // s^2 below which a direction shrinks by less than its rounding
constexpr double kJitter = 3e-4;       // s, by which steps of a held quantity may be off between log and prediction
constexpr double kTick = 2.5e-4;       // s, by which a loop's answer to an impact may be off: some of its period
constexpr double kBounce =
    0.02;                      // of the time since the first impact, by which later ones may be off: a rebound's form
constexpr double kJump = 0.5;  // of a jump, by which a row beside it may be off
constexpr double kClock =
    2e-3;  // s, by which a run's clock may be off while its jumps are dated: the prior scatter of stamps
constexpr double kMuch = 3.0;     // times the next row's deviation, from which a row says nothing of its noise
constexpr double kUntold = 1e6;   // times its deviation, of a row that tells nothing
constexpr double kSought = 0.03;  // s, within which a predicted jump is sought in the data

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Model times between which a jump may fall: around an impact, as predicted and as this span's data show it.
struct JumpWindow {
  double from = 0.0, to = 0.0;  ///< [s]
  double size = 0.0;            ///< predicted across it [unit]
};

/// Where data fall or rise by half the predicted jump or more between neighbours, the steepest place within reach is taken for it;
/// where none do (positions only bend), the jump is where it was predicted.
JumpWindow jump_window(const Vector& time, const Vector& value, double shift, double impact, double size,
                       double reach) {
  JumpWindow window{impact - reach, impact + reach, std::abs(size)};
  double most = kJump * std::abs(size);
  for (Eigen::Index i = 1; i < time.size(); ++i) {
    const double t = 0.5 * (time[i - 1] + time[i]) - shift,
                 rise = (value[i] - value[i - 1]) * (size < 0.0 ? -1.0 : 1.0);
    if (std::abs(t - impact) > kSought || rise <= most) continue;
    most = rise;
    window.from = std::min(impact, t) - reach;
    window.to = std::max(impact, t) + reach;
  }
  return window;
}

/// Windows of the jumps that a span's rows may be off by.
std::vector<JumpWindow> jump_windows(const Condition& condition, const RowSpan& span, const Prediction& prediction,
                                     double shift, double reach) {
  const Channel& channel = condition.channels[at(span.channel)];
  const Run& run = condition.runs[at(span.run)];
  std::vector<JumpWindow> windows;
  const auto add = [&](double t) {
    const double size = prediction.at(span.channel, t + reach) - prediction.at(span.channel, t - reach);
    windows.push_back(jump_window(run.time[at(span.channel)], run.value[at(span.channel)], shift, t, size, reach));
  };
  for (const double impact : prediction.impacts) add(impact);
  if (channel.held)
    for (const double step : prediction.steps) add(step);
  return windows;
}

/// By how much what follows the last impact before t may come sooner or later than predicted [s].
double late_impact(const Prediction& prediction, double t) {
  const auto next = std::upper_bound(prediction.impacts.begin(), prediction.impacts.end(), t);
  return kTick + kBounce * (*std::prev(next) - prediction.impacts.front());
}

/// What timing alone may do to a row at model time t [unit]: a held quantity steps; an impact jumps, and a sampled loop answers it a
/// part of its period sooner or later than predicted.
double timing_error(const Prediction& prediction, const std::vector<JumpWindow>& windows, bool held, int c, double t) {
  const double step = prediction.step;
  const double slope = std::abs(prediction.at(c, t + step) - prediction.at(c, t - step)) / (2.0 * step);
  double error = held ? kJitter * slope : 0.0;
  if (!prediction.impacts.empty() && t > prediction.impacts.front())
    error = std::max(error, late_impact(prediction, t) * slope);
  for (const JumpWindow& window : windows)
    if (t >= window.from && t <= window.to) error = std::max(error, kJump * window.size);
  return error;
}

/// Standard deviation of every row of a span: the channel's floor, more where timing matters.
Vector deviations(const Condition& condition, const RowSpan& span, const Prediction& prediction) {
  const Channel& channel = condition.channels[at(span.channel)];
  const Run& run = condition.runs[at(span.run)];
  Vector sigma = Vector::Constant(span.count, channel.noise_floor);
  if (!channel.held && prediction.impacts.empty()) return sigma;
  const double half_block = 0.5 * (run.block[at(span.channel)] - 1) * run.spacing[at(span.channel)];
  const double shift = run.start + run.shift[at(condition.stream_index(channel.stream))];
  const auto windows = jump_windows(condition, span, prediction, shift, half_block + prediction.step + kClock);
  const bool commanded = channel.held && !condition.measured_input;
  for (int i = 0; i < span.count; ++i) {
    const double t = run.time[at(span.channel)][i] - shift;
    sigma[i] = std::hypot(sigma[i], timing_error(prediction, windows, channel.held, span.channel, t));
    if (commanded && t < prediction.lateness(at(span.channel)) + kCommanded) sigma[i] *= kUntold;
  }
  return sigma;
}

void add_span(const Condition& condition, const RowSpan& span, const Prediction& prediction, int first,
              ConditionSpace& space) {
  const Channel& channel = condition.channels[at(span.channel)];
  const Vector& time = condition.runs[at(span.run)].time[at(span.channel)];
  const Vector sigma = deviations(condition, span, prediction);
  for (int i = 0; i < span.count; ++i) {
    double rho = 0.0;
    const bool tells = i > 0 && sigma[i - 1] < kMuch * sigma[i];  // a row that may be off says nothing of the next
    if (tells && channel.correlation > 0.0) {
      rho = std::pow(channel.correlation, std::max(1.0, (time[i] - time[i - 1]) / channel.spacing));
    }
    space.previous[first + i] = i > 0 ? rho * sigma[i] / sigma[i - 1] : 0.0;
    space.weight[first + i] = 1.0 / (sigma[i] * std::sqrt(1.0 - rho * rho));
    space.sigma[first + i] = sigma[i];
  }
}

/// Layout of the rows that take part, with weights.
ConditionSpace whitening(const Condition& condition, const std::vector<const Prediction*>& predictions,
                         const std::vector<bool>& mask) {
  ConditionSpace space;
  std::vector<int> run_of;
  for (const RowSpan& span : row_spans(condition)) {
    if (!mask.empty() && !mask[at(span.run)]) continue;
    if (run_of.empty() || run_of.back() != span.run) {
      run_of.push_back(span.run);
      space.run_first.push_back(space.rows);
      space.run_count.push_back(0);
    }
    space.spans.push_back(span);
    space.run_count.back() += span.count;
    space.rows += span.count;
  }
  space.weight.resize(space.rows);
  space.sigma.resize(space.rows);
  space.previous.resize(space.rows);
  int first = 0;
  for (const RowSpan& span : space.spans) {
    add_span(condition, span, *predictions[at(span.run)], first, space);
    first += span.count;
  }
  return space;
}

/// Columns of the plant's faults on the rows that take part, white.
Matrix fault_columns(const Condition& condition, const ConditionSpace& space) {
  const auto channels = static_cast<int>(condition.channels.size());
  Matrix raw = Matrix::Zero(condition.rows(), channels * kFaultModes);
  for (const RowSpan& span : space.spans) {
    const Channel& channel = condition.channels[at(span.channel)];
    if (channel.discrepancy <= 0.0) continue;
    const Run& run = condition.runs[at(span.run)];
    raw.block(span.first, span.channel * kFaultModes, span.count, kFaultModes) =
        channel.discrepancy / std::sqrt(double(kFaultModes)) *
        fault_modes(condition, channel, run.time[at(span.channel)], kFaultModes);
  }
  Matrix columns(space.rows, raw.cols());
  for (Eigen::Index k = 0; k < raw.cols(); ++k) columns.col(k) = space.apply(raw.col(k));
  return columns;
}

ConditionSpace condition_space(const Condition& condition, const std::vector<const Prediction*>& predictions,
                               const std::vector<RunNuisances>& nuisances, const std::vector<bool>& mask) {
  ConditionSpace space = whitening(condition, predictions, mask);
  space.prior_mean_rows = Vector::Zero(condition.rows());
  std::vector<Shrinkage> shrinkages;
  for (std::size_t b = 0, s = 0; b < space.run_first.size(); ++b) {
    const int run = space.spans[s].run;
    while (s < space.spans.size() && space.spans[s].run == run) ++s;
    const RunNuisances& n = nuisances[at(run)];
    space.prior_mean_rows.segment(n.first, n.count) = n.columns * n.mean;
    Matrix white(space.run_count[b], n.columns.cols());
    for (Eigen::Index k = 0; k < n.columns.cols(); ++k) {
      Vector raw = Vector::Zero(condition.rows());
      raw.segment(n.first, n.count) = n.scale[k] * n.columns.col(k);
      white.col(k) = space.whiten(raw).segment(space.run_first[b], space.run_count[b]);
    }
    shrinkages.push_back(shrinkage(white));
  }
  space.runs = std::move(shrinkages);
  if (!condition.measured_input) space.shared = shrinkage(fault_columns(condition, space));
  return space;
}

}  // namespace

void Shrinkage::apply(VectorRef x) const {
  if (shrink.size() == 0) return;
  const Vector along = shrink.cwiseProduct(U.transpose() * x);
  x -= U * along;
}

Shrinkage shrinkage(const Matrix& A) {
  if (A.cols() == 0 || A.rows() == 0) return {};
  const Eigen::SelfAdjointEigenSolver<Matrix> solver(A.transpose() * A);
  Eigen::Index kept = 0;
  while (kept < A.cols() && solver.eigenvalues()[A.cols() - 1 - kept] > kLeastEnergy) ++kept;
  const Vector energy = solver.eigenvalues().tail(kept);
  Shrinkage result;
  result.U = A * solver.eigenvectors().rightCols(kept) * energy.cwiseSqrt().cwiseInverse().asDiagonal();
  result.shrink = 1.0 - (1.0 + energy.array()).sqrt().inverse();
  return result;
}

Matrix fault_modes(const Condition& condition, const Channel& channel, const Vector& time, int modes) {
  Matrix values(time.size(), modes);
  for (Eigen::Index i = 0; i < time.size(); ++i) {
    const double share = std::max(0.0, time[i]) / std::max(1e-9, condition.window_end);
    for (int k = 0; k < modes; ++k) {
      values(i, k) = channel.held ? (k == 0 ? 1.0 : std::numbers::sqrt2 * std::cos(k * std::numbers::pi * share))
                                  : std::numbers::sqrt2 * std::sin((k + 0.5) * std::numbers::pi * share);
    }
    if (channel.held && time[i] < 0.0) values.row(i).setZero();
  }
  return values;
}

Vector ConditionSpace::whiten(const Vector& raw) const {
  Vector white(rows);
  int first = 0;
  for (const RowSpan& span : spans) {
    for (int i = 0; i < span.count; ++i) {
      const double before = i > 0 ? previous[first + i] * raw[span.first + i - 1] : 0.0;
      white[first + i] = weight[first + i] * (raw[span.first + i] - before);
    }
    first += span.count;
  }
  return white;
}

Vector ConditionSpace::apply(const Vector& raw) const {
  Vector white = whiten(raw);
  for (std::size_t b = 0; b < runs.size(); ++b) runs[b].apply(white.segment(run_first[b], run_count[b]));
  shared.apply(white);
  return white;
}

Vector EvidenceSpace::residual(const std::vector<Vector>& predicted) const {
  std::vector<Vector> raw;
  for (std::size_t c = 0; c < conditions.size(); ++c) raw.push_back(measured[c] - predicted[c]);
  return apply(raw);
}

Vector EvidenceSpace::apply(const std::vector<Vector>& raw) const {
  Vector white(rows);
  int first = 0;
  for (std::size_t c = 0; c < conditions.size(); ++c) {
    white.segment(first, conditions[c].rows) = conditions[c].apply(raw[c]);
    first += conditions[c].rows;
  }
  return white;
}

EvidenceSpace evidence_space(const DiagnosisProblem& problem, const Linearisation& about, const RunMask& mask) {
  EvidenceSpace space;
  for (std::size_t c = 0; c < problem.observations.conditions.size(); ++c) {
    const Condition& condition = problem.observations.conditions[c];
    space.conditions.push_back(condition_space(condition, about.at_p.runs(condition, static_cast<int>(c)),
                                               about.nuisances[c], mask.empty() ? std::vector<bool>() : mask[c]));
    space.rows += space.conditions.back().rows;
    space.measured.push_back(measured_rows(condition) - space.conditions.back().prior_mean_rows);
  }
  return space;
}

}  // namespace jaculus
