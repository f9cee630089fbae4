#include "diagnosis/noise/whitening.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "diagnosis/noise/force_bands.h"
#include "diagnosis/noise/row_deviations.h"
#include "jaculus/trajectory/quantity.h"

namespace jaculus::diagnosis {
namespace {

void add_span(const Problem& problem, const NoiseModel& noise, int dataset, const RowSpan& span,
              const Prediction& prediction, int first, DatasetWhitening& out) {
  const ObservedDataset& observed = problem.observations.datasets[dataset];
  const double correlation = noise.datasets[dataset].channels[span.channel].correlation;
  const double spacing = observed.channels[span.channel].spacing;
  const Vector& time = observed.segments[span.segment].time[span.channel];
  const Vector sigma = row_deviations(problem, noise, dataset, span, prediction);

  for (int i = 0; i < span.count; ++i) {
    // A row that may be off says nothing of the next.
    const bool tells = i > 0 && sigma[i - 1] < problem.settings.uncertain_neighbour * sigma[i];
    double rho = 0.0;
    if (tells && correlation > 0.0)
      rho = std::pow(correlation, std::max(1.0, (time[i] - time[i - 1]) / spacing));

    out.previous[first + i] = i > 0 ? rho * sigma[i] / sigma[i - 1] : 0.0;
    out.weight[first + i] = 1.0 / (sigma[i] * std::sqrt(1.0 - rho * rho));
    out.sigma[first + i] = sigma[i];
  }
}

/// Layout of the rows that take part, with weights.
DatasetWhitening row_whitening(const Problem& problem, const NoiseModel& noise, int dataset,
                               const std::vector<bool>& mask) {
  const ObservedDataset& observed = problem.observations.datasets[dataset];
  DatasetWhitening out;
  for (const RowSpan& span : row_spans(observed)) {
    if (!mask.empty() && !mask[span.segment]) continue;
    if (out.blocks.empty() || out.blocks.back().segment != span.segment)
      out.blocks.push_back({span.segment, out.rows, 0, {}});
    out.spans.push_back(span);
    out.blocks.back().count += span.count;
    out.rows += span.count;
  }

  out.weight.resize(out.rows);
  out.sigma.resize(out.rows);
  out.previous.resize(out.rows);
  const std::vector<const Prediction*> predictions = noise.at_p.segments(observed, dataset);
  int first = 0;
  for (const RowSpan& span : out.spans) {
    add_span(problem, noise, dataset, span, *predictions[span.segment], first, out);
    first += span.count;
  }
  return out;
}

/// Groups of the forces, one a band of each.
std::vector<RandomGroup> force_groups(const Problem& problem) {
  std::vector<RandomGroup> groups;
  const std::vector<ForceGroup>& forces = problem.hypotheses.forces;
  for (int g = 0; g < count_of(forces); ++g) {
    const int boxes = count_of(forces[g].boxes);
    for (int b = 0; b < bands_of(boxes); ++b)
      groups.push_back({forces[g].name, g, share_of_band(b, boxes),
                        b > 0 ? count_of(groups) - 1 : -1, problem.settings.largest_force});
  }
  return groups;
}

/// Slopes by boxes as those by cosines, and the group of each.
Matrix in_bands(const Matrix& slopes, const std::vector<ForceGroup>& forces,
                std::vector<int>& group) {
  Matrix out(slopes.rows(), slopes.cols());
  int column = 0, first_band = 0;
  for (const ForceGroup& force : forces) {
    const int boxes = count_of(force.boxes);
    out.middleCols(column, boxes) = slopes.middleCols(column, boxes) * cosines(boxes);
    for (int k = 0; k < boxes; ++k) group.push_back(first_band + band_of(k));
    column += boxes;
    first_band += bands_of(boxes);
  }
  return out;
}

/// Forces on the rows of a window.
RandomBlock force_block(const DatasetWhitening& whitening, const SegmentBlock& segment,
                        const DatasetNoise& noise, const Matrix& raw,
                        const std::vector<ForceGroup>& forces, int first) {
  const SegmentNuisances& own = noise.nuisances[segment.segment];
  RandomBlock block{first + segment.first, segment.count, {}, {}, {}};
  const Matrix slopes = in_bands(raw.middleRows(own.first, own.count), forces, block.group);
  block.columns = whitening.whiten_block(whitening.block_of(segment.segment), slopes);
  segment.nuisances.apply(block.columns);
  return block;
}

/// Of each row of a segment, how much of it the directions that stand apart hold; adds up to their
/// number.
Vector held_apart(const SegmentBlock& block) {
  const Shrinkage& apart = block.nuisances.apart();
  if (apart.shrink.size() == 0) return Vector::Zero(block.count);
  return apart.U.rowwise().squaredNorm();
}

/// Of each coordinate that datasets under a plan measure, a misfit without rows: whatever segments
/// take part, their groups are the same. Channels of one coordinate tell of the same motion, its
/// rate and its current too; an IMU's pitch is a sensor beside motion capture's, and counts apart.
std::map<std::string, Misfit> measured_coordinates(const Problem& problem) {
  std::map<std::string, Misfit> misfits;
  for (const ObservedDataset& observed : problem.observations.datasets)
    for (const Channel& channel : observed.channels)
      if (!observed.measured_input) misfits[trajectory::parse_channel(channel.name).of];
  return misfits;
}

/// The rows of a dataset, behind `first` white ones, in the misfits of their coordinates.
void add_rows(const Problem& problem, const ObservedDataset& observed, const DatasetWhitening& own,
              int first, std::map<std::string, Misfit>& misfits) {
  Vector held = Vector::Zero(own.rows);
  for (const SegmentBlock& block : own.blocks)
    held.segment(block.first, block.count) = held_apart(block);

  std::map<std::string, double> rows;
  int at = 0;
  for (const RowSpan& span : own.spans) {
    const std::string name = trajectory::parse_channel(observed.channels[span.channel].name).of;
    misfits.at(name).spans.emplace_back(first + at, span.count);
    rows[name] += span.count - held.segment(at, span.count).sum();
    at += span.count;
  }
  for (const auto& [name, count] : rows) {
    misfits.at(name).rows += count;
    misfits.at(name).values += std::min(double(problem.settings.discrepancy_modes), count);
  }
}

/// The misfits of the datasets under a plan, one a coordinate.
void add_misfits(const Problem& problem, const std::vector<DatasetWhitening>& datasets,
                 RandomEffects& out) {
  std::map<std::string, Misfit> misfits = measured_coordinates(problem);
  int first = 0;
  for (int d = 0; d < count_of(datasets); ++d) {
    const ObservedDataset& observed = problem.observations.datasets[d];
    if (!observed.measured_input) add_rows(problem, observed, datasets[d], first, misfits);
    first += datasets[d].rows;
  }
  for (auto& [name, misfit] : misfits) {
    misfit.group = out.size();
    out.misfits.push_back(std::move(misfit));
    out.groups.push_back({"misfit of " + name});
    out.groups.back().least = problem.settings.least_misfit;
  }
}

RandomEffects random_effects(const Problem& problem, const NoiseModel& noise,
                             const std::vector<DatasetWhitening>& datasets) {
  RandomEffects out;
  if (!noise.may_lack) return out;
  if (!noise.random.forces.empty()) out.groups = force_groups(problem);

  int first = 0;
  for (int d = 0; d < count_of(datasets); ++d) {
    if (problem.observations.datasets[d].measured_input)
      for (const SegmentBlock& segment : datasets[d].blocks)
        out.blocks.push_back(force_block(datasets[d], segment, noise.datasets[d],
                                         noise.random.forces[d], problem.hypotheses.forces, first));
    first += datasets[d].rows;
  }
  if (!in_windows(problem)) add_misfits(problem, datasets, out);
  int apart = 0;
  for (const DatasetWhitening& own : datasets) apart += own.apart;
  if (apart > 0) out.plain.emplace_back(first, apart);
  for (RandomBlock& block : out.blocks) block.gram = block.columns.transpose() * block.columns;
  return out;
}

/// First and count of the rows of each channel in a block.
std::vector<std::pair<int, int>> spans_of(const DatasetWhitening& whitening,
                                          const SegmentBlock& block) {
  std::vector<std::pair<int, int>> spans;
  int next = 0;
  for (const RowSpan& span : whitening.spans) {
    if (span.segment != block.segment) continue;
    spans.emplace_back(next, span.count);
    next += span.count;
  }
  return spans;
}

DatasetWhitening dataset_whitening(const Problem& problem, const NoiseModel& noise, int dataset,
                                   const std::vector<bool>& mask) {
  const ObservedDataset& observed = problem.observations.datasets[dataset];
  DatasetWhitening out = row_whitening(problem, noise, dataset, mask);
  out.prior_mean_rows = Vector::Zero(observed.rows());

  const bool misfits = noise.may_lack && !observed.measured_input;
  const double apart = misfits ? problem.settings.nuisance_apart : kInfinity;
  for (int b = 0; b < count_of(out.blocks); ++b) {
    const SegmentNuisances& own = noise.datasets[dataset].nuisances[out.blocks[b].segment];
    out.prior_mean_rows.segment(own.first, own.count) = own.columns * own.mean;
    const Matrix white = out.whiten_block(b, own.columns * own.scale.asDiagonal());
    out.blocks[b].nuisances = {white, spans_of(out, out.blocks[b]), apart};
    out.apart += static_cast<int>(out.blocks[b].nuisances.apart().shrink.size());
  }
  return out;
}

}  // namespace

Vector DatasetWhitening::whiten(const Vector& raw) const {
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

Matrix DatasetWhitening::whiten_block(int block, const Matrix& raw) const {
  // A segment's rows stand together, here and in `raw`; `previous` is zero where a span begins.
  const SegmentBlock& own = blocks[block];
  Matrix white = raw;
  for (int i = own.count - 1; i > 0; --i)
    white.row(i) -= previous[own.first + i] * white.row(i - 1);
  return weight.segment(own.first, own.count).asDiagonal() * white;
}

int DatasetWhitening::block_of(int segment) const {
  for (int b = 0; b < count_of(blocks); ++b)
    if (blocks[b].segment == segment) return b;
  return -1;
}

Vector DatasetWhitening::apply(const Vector& raw) const {
  Vector white = whiten(raw);
  take_nuisances(white);
  return white;
}

void DatasetWhitening::take_nuisances(MatrixRef white) const {
  for (const SegmentBlock& block : blocks)
    block.nuisances.apply(white.middleRows(block.first, block.count));
}

Matrix DatasetWhitening::apart_of(ConstMatrixRef white) const {
  Matrix out(apart, white.cols());
  Eigen::Index next = 0;
  for (const SegmentBlock& block : blocks) {
    const Shrinkage& own = block.nuisances.apart();
    const Eigen::Index count = own.shrink.size();
    if (count == 0) continue;
    out.middleRows(next, count) = (1.0 - own.shrink.array()).matrix().asDiagonal() *
                                  (own.U.transpose() * white.middleRows(block.first, block.count));
    next += count;
  }
  return out;
}

Vector Whitening::residual(const std::vector<Vector>& predicted) const {
  std::vector<Vector> raw;
  for (std::size_t d = 0; d < datasets.size(); ++d) raw.push_back(measured[d] - predicted[d]);
  return apply(raw);
}

Vector Whitening::apply(const std::vector<Vector>& raw) const { return columns({raw}); }

Matrix Whitening::columns(const std::vector<std::vector<Vector>>& raws) const {
  Matrix white(rows, count_of(raws));
  int first = 0, behind = rows - apart;
  for (std::size_t d = 0; d < datasets.size(); ++d) {
    const DatasetWhitening& dataset = datasets[d];
    auto own = white.middleRows(first, dataset.rows);
    for (int k = 0; k < count_of(raws); ++k) own.col(k) = dataset.whiten(raws[k][d]);
    white.middleRows(behind, dataset.apart) = dataset.apart_of(own);
    dataset.take_nuisances(own);
    first += dataset.rows;
    behind += dataset.apart;
  }
  return white;
}

Matrix Whitening::slopes(const RowSlopes& of_rows) const { return -columns(of_rows.columns); }

Vector Whitening::in_rows(const Vector& white) const {
  Vector out = white.head(rows - apart);
  Eigen::Index first = 0, next = out.size();
  for (const DatasetWhitening& dataset : datasets) {
    for (const SegmentBlock& block : dataset.blocks) {
      const Shrinkage& own = block.nuisances.apart();
      const Eigen::Index count = own.shrink.size();
      if (count == 0) continue;
      out.segment(first + block.first, block.count) += own.U * white.segment(next, count);
      next += count;
    }
    first += dataset.rows;
  }
  return out;
}

Whitening whitening_of(const Problem& problem, const NoiseModel& noise, const SegmentMask& mask) {
  Whitening out;
  out.alignments = noise.alignments;
  for (int d = 0; d < count_of(problem.observations.datasets); ++d) {
    const ObservedDataset& observed = problem.observations.datasets[d];
    out.datasets.push_back(
        dataset_whitening(problem, noise, d, mask.empty() ? std::vector<bool>() : mask[d]));
    out.rows += out.datasets.back().rows + out.datasets.back().apart;
    out.apart += out.datasets.back().apart;
    out.measured.push_back(measured_rows(observed, noise.alignments[d]) -
                           out.datasets.back().prior_mean_rows);
  }
  out.random = random_effects(problem, noise, out.datasets);
  return out;
}

std::vector<Eigen::Index> rows_of_part(const Whitening& all, const Whitening& part) {
  std::vector<Eigen::Index> rows, apart;
  Eigen::Index first = 0, behind = all.rows - all.apart;
  const auto add = [](Eigen::Index from, Eigen::Index count, std::vector<Eigen::Index>& to) {
    for (Eigen::Index i = 0; i < count; ++i) to.push_back(from + i);
  };
  for (std::size_t d = 0; d < all.datasets.size(); ++d) {
    for (const SegmentBlock& block : all.datasets[d].blocks) {
      const bool in_part = part.datasets[d].block_of(block.segment) >= 0;
      if (in_part) add(first + block.first, block.count, rows);
      const Eigen::Index own = block.nuisances.apart().shrink.size();
      if (in_part) add(behind, own, apart);
      behind += own;
    }
    first += all.datasets[d].rows;
  }
  rows.insert(rows.end(), apart.begin(), apart.end());
  return rows;
}

}  // namespace jaculus::diagnosis
