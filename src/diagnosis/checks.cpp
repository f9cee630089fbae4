#include "jaculus/diagnosis/checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "diagnosis/nuisance_estimate.h"

namespace jaculus {
namespace {

constexpr double kInverted = -0.9, kScaled = 0.95, kUnitTolerance = 0.15, kMotion = 10.0;
constexpr double kOneOff = 9.0;  // mean square over the runs' median
constexpr double kQuiet = 3.0;   // the same before the onset, at most
constexpr int kFewestRuns = 4;
constexpr int kBins = 12;  // of the window, for onsets

std::size_t at(int i) { return static_cast<std::size_t>(i); }

struct Pair {
  double yy = 0.0, ff = 0.0, yf = 0.0, misfit = 0.0, inverted = 0.0;
};

/// Sums over the spans of one channel, means removed.
Pair sums(const Condition& condition, int channel, const Vector& predicted) {
  Pair sum;
  for (const RowSpan& span : row_spans(condition)) {
    if (span.channel != channel) continue;
    Vector y = condition.runs[at(span.run)].value[at(channel)], f = predicted.segment(span.first, span.count);
    y.array() -= y.mean();
    f.array() -= f.mean();
    sum.yy += y.squaredNorm();
    sum.ff += f.squaredNorm();
    sum.yf += y.dot(f);
    sum.misfit += (y - f).squaredNorm();
    sum.inverted += (y + f).squaredNorm();
  }
  return sum;
}

std::string contradiction(const Channel& channel, const Pair& sum, int rows) {
  const double motion = std::sqrt(std::min(sum.yy, sum.ff) / rows);
  if (sum.yy <= 0.0 || sum.ff <= 0.0) return {};
  const double correlation = sum.yf / std::sqrt(sum.yy * sum.ff), slope = sum.yf / sum.ff;
  const double ratio = std::sqrt(sum.yy / sum.ff);
  if (correlation > kScaled) {
    const std::array<std::pair<double, const char*>, 4> units = {
        {{180.0 / std::numbers::pi, "degrees in place of radians"},
         {std::numbers::pi / 180.0, "radians counted twice as degrees"},
         {1000.0, "thousandths (millimetres) in place of SI units"},
         {0.001, "thousands of the SI unit"}}};
    for (const auto& [factor, what] : units)
      if (std::abs(slope / factor - 1.0) < kUnitTolerance)
        return fmt::format("{} looks like {}: it is {:.3g} times the prediction", channel.name, what, slope);
  }
  if (motion < kMotion * channel.noise_floor) return {};
  if (correlation < kInverted && ratio > 0.3 && ratio < 3.0 && sum.misfit > 9.0 * sum.inverted)
    return fmt::format("{} looks inverted: its correlation with the prediction is {:.2f}", channel.name, correlation);
  return {};
}

/// Mean square of every run's own residual about the mean over runs, by bin of time, in units of the channel's median over runs.
Matrix scatter_by_bin(const Condition& condition, int channel, const Vector& residual) {
  const auto runs = static_cast<Eigen::Index>(condition.runs.size());
  Matrix sums = Matrix::Zero(runs, kBins), counts = sums;
  for (const RowSpan& span : row_spans(condition)) {
    if (span.channel != channel) continue;
    const Vector& time = condition.runs[at(span.run)].time[at(channel)];
    for (int i = 0; i < span.count; ++i) {
      const double share = (time[i] - condition.window_start) / (condition.window_end - condition.window_start);
      const int bin = std::clamp(static_cast<int>(share * kBins), 0, kBins - 1);
      sums(span.run, bin) += residual[span.first + i];
      counts(span.run, bin) += 1.0;
    }
  }
  Matrix means = sums.array() / counts.array().max(1.0);
  for (Eigen::Index b = 0; b < kBins; ++b) {
    std::vector<double> column(static_cast<std::size_t>(runs));
    for (Eigen::Index r = 0; r < runs; ++r) column[static_cast<std::size_t>(r)] = means(r, b);
    std::nth_element(column.begin(), column.begin() + runs / 2, column.end());
    means.col(b).array() -= column[static_cast<std::size_t>(runs / 2)];
  }
  return means;
}

/// Residuals with every run's own nuisances, as the first half of the window tells them, taken away: a start or a shift is no
/// disturbance, and one in the second half doesn't pass for a shift.
Vector without_nuisances(const Condition& condition, const std::vector<RunNuisances>& nuisances, const Vector& residual,
                         const Vector& mean) {
  Vector out = residual;
  for (const RunNuisances& n : nuisances) {
    if (n.count == 0 || n.columns.cols() == 0) continue;
    Vector weight(n.count);
    const double half = 0.5 * (condition.window_start + condition.window_end);
    for (const RowSpan& span : row_spans(condition)) {
      if (span.first < n.first || span.first >= n.first + n.count) continue;
      const Vector& time = condition.runs[at(span.run)].time[at(span.channel)];
      const double one = 1.0 / std::max(1e-12, condition.channels[at(span.channel)].noise_floor);
      for (int i = 0; i < span.count; ++i) weight[span.first - n.first + i] = time[i] < half ? one : 0.0;
    }
    const Vector own = residual.segment(n.first, n.count) - mean.segment(n.first, n.count);
    out.segment(n.first, n.count) -= n.columns * nuisance_deviation(n, own, weight);
  }
  return out;
}

/// Mean over runs of the residual at the rows of every run, by nearest bin of a fine grid.
Vector mean_over_runs(const Condition& condition, const Vector& residual) {
  constexpr int kFine = 60;
  Vector mean = residual;
  for (std::size_t c = 0; c < condition.channels.size(); ++c) {
    Vector sums = Vector::Zero(kFine), counts = sums;
    const auto bin = [&](double t) {
      const double share = (t - condition.window_start) / (condition.window_end - condition.window_start);
      return std::clamp(static_cast<int>(share * kFine), 0, kFine - 1);
    };
    for (const bool writing : {false, true}) {
      for (const RowSpan& span : row_spans(condition)) {
        if (span.channel != static_cast<int>(c)) continue;
        const Vector& time = condition.runs[at(span.run)].time[c];
        for (int i = 0; i < span.count; ++i) {
          const int b = bin(time[i]);
          if (writing) {
            mean[span.first + i] = sums[b] / counts[b];
          } else {
            sums[b] += residual[span.first + i];
            counts[b] += 1.0;
          }
        }
      }
    }
  }
  return mean;
}

/// The earliest bin from which a run is loud to the end while it was quiet before; kBins where there is none.
int onset_bin(const Eigen::RowVectorXd& own, const Eigen::RowVectorXd& usual) {
  int loud = kBins;
  while (loud > 0 && own[loud - 1] > kOneOff * usual[loud - 1]) --loud;
  if (loud == kBins || loud < 2) return kBins;
  for (int b = 0; b + 1 < loud; ++b)
    if (own[b] > kQuiet * kQuiet * usual[b]) return kBins;
  return loud;
}

void find_one_offs(const DiagnosisProblem& problem, const Linearisation& about, int c, std::vector<OneOff>& found) {
  const Condition& condition = problem.observations.conditions[at(c)];
  const auto runs = static_cast<Eigen::Index>(condition.runs.size());
  if (condition.measured_input || runs < kFewestRuns) return;
  const Vector raw = measured_rows(condition) - predicted_rows(condition, about.at_p.runs(condition, c));
  const Vector residual = without_nuisances(condition, about.nuisances[at(c)], raw, mean_over_runs(condition, raw));
  std::vector<OneOff> best(condition.runs.size());
  for (std::size_t k = 0; k < condition.channels.size(); ++k) {
    if (condition.channels[k].held) continue;
    const Matrix squares = scatter_by_bin(condition, static_cast<int>(k), residual).array().square();
    for (Eigen::Index r = 0; r < runs; ++r) {
      Eigen::RowVectorXd usual(kBins);
      for (Eigen::Index b = 0; b < kBins; ++b) {
        std::vector<double> others;
        for (Eigen::Index o = 0; o < runs; ++o)
          if (o != r) others.push_back(squares(o, b));
        usual[b] =
            *std::max_element(others.begin(), others.end()) + 0.1 * std::pow(condition.channels[k].noise_floor, 2);
      }
      const int bin = onset_bin(squares.row(r), usual);
      if (bin == kBins || kBins - bin < 2) continue;
      const double excess = std::sqrt(squares.row(r).tail(kBins - bin).mean() / usual.tail(kBins - bin).mean());
      OneOff& own = best[static_cast<std::size_t>(r)];
      if (excess <= own.excess) continue;
      const double onset = condition.window_start + (bin - 1) * (condition.window_end - condition.window_start) / kBins;
      own = {c, static_cast<int>(r), onset, excess, condition.channels[k].name};
    }
  }
  for (const OneOff& own : best)
    if (own.excess > 0.0) found.push_back(own);
}

}  // namespace

std::vector<std::string> contradictions(const DiagnosisProblem& problem, const Linearisation& about) {
  std::vector<std::string> found;
  const std::vector<Vector> predicted = rows_of(problem, about.at_p);
  for (std::size_t c = 0; c < problem.observations.conditions.size(); ++c) {
    const Condition& condition = problem.observations.conditions[c];
    for (std::size_t k = 0; k < condition.channels.size(); ++k) {
      int rows = 0;
      for (const Run& run : condition.runs) rows += static_cast<int>(run.time[k].size());
      const std::string what =
          contradiction(condition.channels[k], sums(condition, static_cast<int>(k), predicted[c]), std::max(1, rows));
      if (!what.empty()) found.push_back(condition.dataset.folder.filename().string() + ": " + what);
    }
  }
  return found;
}

std::vector<OneOff> one_off_disturbances(const DiagnosisProblem& problem, const Linearisation& about) {
  std::vector<OneOff> found;
  for (std::size_t c = 0; c < problem.observations.conditions.size(); ++c) {
    std::vector<OneOff> own;
    find_one_offs(problem, about, static_cast<int>(c), own);
    // Where half of the runs differ from one another it is no one-off.
    if (own.size() * 2 < problem.observations.conditions[c].runs.size())
      found.insert(found.end(), own.begin(), own.end());
  }
  return found;
}

void cut(DiagnosisProblem& problem, const OneOff& disturbance) {
  Run& run = problem.observations.conditions[at(disturbance.condition)].runs[at(disturbance.run)];
  for (std::size_t c = 0; c < run.time.size(); ++c) {
    Eigen::Index kept = 0;
    while (kept < run.time[c].size() && run.time[c][kept] < disturbance.onset) ++kept;
    run.time[c].conservativeResize(kept);
    run.value[c].conservativeResize(kept);
    if (!run.recorded.empty()) run.recorded[c].conservativeResize(kept);
  }
}

}  // namespace jaculus
