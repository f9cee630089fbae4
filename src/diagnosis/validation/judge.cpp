#include "diagnosis/validation/judge.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace jaculus::diagnosis {
namespace {

/// -r^T (I + B B^T)^-1 r/2 of the white rows that are judged, B: what the prefix leaves open of the
/// nuisances, C L^-T, and what is open of tolerances, `more`.
double log_density(const Vector& white, const Vector& judged, const Matrix& columns,
                   const Matrix& root, const Matrix& more) {
  const Vector r = white.cwiseProduct(judged);
  Matrix open(columns.rows(), columns.cols() + more.cols());
  open.leftCols(columns.cols()) =
      root.triangularView<Eigen::Lower>().solve(columns.transpose()).transpose();
  open.rightCols(more.cols()) = more;
  const Matrix B = judged.asDiagonal() * open;
  const Vector along = B.transpose() * r;
  const Matrix inner = B.transpose() * B + Matrix::Identity(B.cols(), B.cols());
  return -0.5 * (r.squaredNorm() - along.dot(inner.llt().solve(along)));
}

/// Data's time from which a segment's horizon counts [s].
double start_of(const ObservedDataset& observed, int segment) {
  return observed.measured_input ? observed.segments[segment].start : 0.0;
}

/// 1 for the rows of a segment in [from, to), else 0.
Vector rows_between(const ObservedDataset& observed, const SegmentNuisances& own, int segment,
                    double from, double to) {
  Vector chosen = Vector::Zero(own.count);
  for (const RowSpan& span : row_spans(observed)) {
    if (span.segment != segment) continue;
    const Vector& time = observed.segments[segment].time[span.channel];
    for (int i = 0; i < span.count; ++i)
      if (time[i] >= from && time[i] < to) chosen[span.first - own.first + i] = 1.0;
  }
  return chosen;
}

/// Of the channels' mean squares; NaN where none was judged.
double mean_over_channels(const Errors& errors, bool motion_alone) {
  double sum = 0.0, channels = 0.0;
  for (std::size_t d = 0; d < errors.squares.size(); ++d) {
    for (Eigen::Index c = 0; c < errors.squares[d].size(); ++c) {
      const double count = errors.counts[d][c];
      if (count == 0.0 || (motion_alone && !errors.of_motion[d][c])) continue;
      sum += errors.squares[d][c] / count;
      channels += 1.0;
    }
  }
  return channels > 0.0 ? sum / channels : kNaN;
}

}  // namespace

std::vector<double> horizons_of(const Settings& settings) { return {kInfinity, settings.horizon}; }

void UnitSums::add(const UnitSums& other) {
  squares += other.squares;
  variance += other.variance;
  count += other.count;
  reach = std::max(reach, other.reach);
}

Errors::Errors(const Problem& problem) {
  std::vector<std::vector<UnitSums>> none;
  for (const ObservedDataset& observed : problem.observations.datasets) {
    squares.push_back(Vector::Zero(count_of(observed.channels)));
    counts.push_back(squares.back());
    none.emplace_back(observed.channels.size());
    of_motion.emplace_back();
    for (const Channel& channel : observed.channels)
      of_motion.back().push_back(!channel.zero_order_hold);
  }
  units.assign(horizons_of(problem.settings).size(), none);
}

void Errors::add(const Errors& other) {
  log_density += other.log_density;
  for (std::size_t d = 0; d < squares.size(); ++d) {
    squares[d] += other.squares[d];
    counts[d] += other.counts[d];
    for (std::size_t h = 0; h < units.size(); ++h)
      for (std::size_t c = 0; c < units[h][d].size(); ++c) units[h][d][c].add(other.units[h][d][c]);
  }
}

double Errors::overall() const {
  const double motion = mean_over_channels(*this, true);
  return std::sqrt(std::isfinite(motion) ? motion : mean_over_channels(*this, false));
}

Judge::Estimated Judge::estimated(int segment, int block, const Vector& about_mean,
                                  const Vector& prefix) const {
  const SegmentNuisances& own = noise.nuisances[segment];
  const Matrix scaled = own.columns * own.scale.asDiagonal();
  // A row whose predecessor is in the prefix is in it by time order, so its correlation counts.
  const Matrix white_columns = whitening.whiten_block(block, scaled);
  const Vector white = whitening.whiten_block(block, about_mean);
  const NuisanceEstimate estimate =
      estimate_nuisances(own, prefix.asDiagonal() * white_columns, prefix.cwiseProduct(white));

  Estimated out{about_mean - own.columns * estimate.deviation, Vector(own.count), estimate.root,
                Matrix(own.count, 0)};
  if (open != nullptr) {
    // The prefix takes of a tolerance's influence what looks like its nuisances.
    const Matrix raw = open->middleRows(own.first, own.count);
    const Matrix white_open = prefix.asDiagonal() * whitening.whiten_block(block, raw);
    Matrix taken = white_columns.transpose() * white_open;
    estimate.root.triangularView<Eigen::Lower>().solveInPlace(taken);
    estimate.root.transpose().triangularView<Eigen::Upper>().solveInPlace(taken);
    out.open = raw - scaled * taken;
  }
  // What the prefix leaves open of the nuisances: each row's square sum is a variance.
  const Matrix left_open =
      estimate.root.triangularView<Eigen::Lower>().solve(scaled.transpose()).transpose();
  for (int row = 0; row < own.count; ++row) {
    const double sigma = whitening.sigma[own.first + row];
    out.variance[row] = sigma * sigma * (1.0 + 1.0 / trained) + left_open.row(row).squaredNorm();
    out.variance[row] += out.open.row(row).squaredNorm();
  }
  return out;
}

void Judge::add_units(int dataset, int segment, const Estimated& at, const Vector& judged,
                      std::vector<std::vector<UnitSums>>& units) const {
  const int first = noise.nuisances[segment].first;
  for (const RowSpan& span : row_spans(observed)) {
    if (span.segment != segment) continue;
    UnitSums& sums = units[dataset][span.channel];
    for (int i = 0; i < span.count; ++i) {
      const int row = span.first - first + i;
      if (judged[row] == 0.0) continue;
      const double since =
          observed.segments[segment].time[span.channel][i] - start_of(observed, segment);
      sums.add({at.left[row] * at.left[row], at.variance[row], 1.0, since});
    }
  }
}

void Judge::judge(int dataset, int segment, const Vector& residual, Errors& errors) const {
  const SegmentNuisances& own = noise.nuisances[segment];
  const int block = whitening.block_of(segment);
  if (block < 0) return;

  const Vector prefix = prefix_rows(observed, own, segment);
  const Vector judged = (1.0 - prefix.array()).matrix();
  const Vector about_mean = residual.segment(own.first, own.count) - own.columns * own.mean;
  const Estimated whole = estimated(segment, block, about_mean, prefix);
  const Matrix white_columns =
      whitening.whiten_block(block, Matrix(own.columns * own.scale.asDiagonal()));
  errors.log_density +=
      log_density(whitening.whiten_block(block, whole.left), judged, white_columns, whole.root,
                  whitening.whiten_block(block, whole.open));
  for (const RowSpan& span : row_spans(observed)) {
    if (span.segment != segment) continue;
    for (int i = 0; i < span.count; ++i) {
      const int row = span.first - own.first + i;
      if (judged[row] == 0.0) continue;
      errors.squares[dataset][span.channel] +=
          whole.left[row] * whole.left[row] / whole.variance[row];
      errors.counts[dataset][span.channel] += 1.0;
    }
  }

  const std::vector<double> horizons = horizons_of(settings);
  const double start = start_of(observed, segment);
  for (std::size_t h = 0; h < horizons.size(); ++h) {
    const double end = start + horizons[h];
    if (end > observed.segments[segment].end()) {
      add_units(dataset, segment, whole, judged, errors.units[h]);
      continue;
    }
    const double known = start + settings.prefix_share * horizons[h];
    const Vector before = rows_between(observed, own, segment, -kInfinity, known);
    add_units(dataset, segment, estimated(segment, block, about_mean, before),
              rows_between(observed, own, segment, known, end), errors.units[h]);
  }
}

}  // namespace jaculus::diagnosis
