#include "diagnosis/remainder/describe.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "diagnosis/validation/fold_interval.h"
#include "diagnosis/validation/shapley.h"

namespace jaculus::diagnosis {
namespace {

constexpr int kFewestChunks = 8;
constexpr int kFolds = 8;
constexpr double kPeriodStep = 0.25;  ///< of the periods' spacing, to begin with
constexpr int kPeriodSteps = 12;      ///< halvings of it

/// The stable groups' functions.
struct Fitted {
  Matrix columns;           ///< boxes x functions
  std::vector<int> member;  ///< of every column, place among the groups
};

Fitted columns_of(const PlaceRegressors& place, const std::vector<int>& groups, double period) {
  Fitted fitted;
  const Eigen::Index rows = place.boxes.force.size();
  fitted.columns.resize(rows, 0);
  for (int m = 0; m < count_of(groups); ++m) {
    const bool periodic = groups[m] == count_of(place.groups);
    const Matrix own =
        periodic ? periodic_columns(place.boxes, period) : place.groups[groups[m]].columns;
    const Eigen::Index before = fitted.columns.cols();
    fitted.columns.conservativeResize(rows, before + own.cols());
    fitted.columns.rightCols(own.cols()) = own;
    fitted.member.insert(fitted.member.end(), own.cols(), m);
  }
  return fitted;
}

/// White rows of all chunks, force first, in the order of chunks.
Matrix white_rows(const PlaceRegressors& place, const Fitted& fitted,
                  const std::vector<Chunk>& chunks, const NoiseShape& shape) {
  Matrix all(place.boxes.force.size(), 1 + fitted.columns.cols());
  all << place.boxes.force, fitted.columns;
  Matrix white(0, all.cols());
  for (const Chunk& chunk : chunks) {
    white.conservativeResize(white.rows() + chunk.count, all.cols());
    white.bottomRows(chunk.count) = whitened(shape, all.middleRows(chunk.first, chunk.count));
  }
  return white;
}

/// Coefficients by least squares of white rows.
Vector solved(const Matrix& white, const std::vector<int>& columns) {
  if (columns.empty()) return {};
  const Matrix X = white.rightCols(white.cols() - 1)(Eigen::all, columns);
  return (X.transpose() * X).ldlt().solve(X.transpose() * white.col(0));
}

/// The same by all of their columns.
Vector solved(const Matrix& white) {
  std::vector<int> columns(static_cast<std::size_t>(white.cols() - 1));
  std::iota(columns.begin(), columns.end(), 0);
  return solved(white, columns);
}

double white_energy_left(const PlaceRegressors& place, const Selected& selected,
                         const std::vector<Chunk>& chunks, double period) {
  const Fitted fitted = columns_of(place, selected.groups, period);
  const Matrix white = white_rows(place, fitted, chunks, selected.shape);
  return (white.col(0) - white.rightCols(white.cols() - 1) * solved(white)).squaredNorm();
}

/// The period by which least is left, about the grid's: by halved steps of 1/period.
double refined_period(const PlaceRegressors& place, const Selected& selected,
                      const std::vector<Chunk>& chunks) {
  const std::vector<double> grid = periods_of(place.boxes);
  if (!std::isfinite(selected.period) || grid.size() < 2) return selected.period;
  double frequency = 1.0 / selected.period, step = kPeriodStep * (1.0 / grid[1] - 1.0 / grid[0]);
  double least = white_energy_left(place, selected, chunks, 1.0 / frequency);
  for (int k = 0; k < kPeriodSteps; ++k) {
    bool moved = false;
    for (const double sign : {-1.0, 1.0}) {
      const double there = frequency + sign * step;
      const double left = white_energy_left(place, selected, chunks, 1.0 / there);
      if (left >= least) continue;
      least = left;
      frequency = there;
      moved = true;
      break;
    }
    if (!moved) step *= 0.5;
  }
  return 1.0 / frequency;
}

/// Boxes' rows that chunks hold, in their order.
std::vector<int> rows_in(const std::vector<Chunk>& chunks) {
  std::vector<int> rows;
  for (const Chunk& chunk : chunks)
    for (int k = 0; k < chunk.count; ++k) rows.push_back(chunk.first + k);
  return rows;
}

/// Energy that each set of groups explains in each fold [unit^2], by bits; and the force's own.
struct HeldOutEnergy {
  std::vector<std::vector<double>> explained;  ///< folds x sets
  std::vector<double> total;                   ///< a fold each, noise taken off
};

HeldOutEnergy held_out_energy(const PlaceRegressors& place, const Fitted& fitted, int groups,
                              const std::vector<Chunk>& chunks, const NoiseShape& shape,
                              double noise) {
  const int folds = std::min(kFolds, count_of(chunks));
  HeldOutEnergy out;
  for (int fold = 0; fold < folds; ++fold) {
    const int begin = count_of(chunks) * fold / folds, end = count_of(chunks) * (fold + 1) / folds;
    std::vector<Chunk> train(chunks.begin(), chunks.begin() + begin);
    train.insert(train.end(), chunks.begin() + end, chunks.end());
    const std::vector<int> rows = rows_in({chunks.begin() + begin, chunks.begin() + end});
    const Matrix white = white_rows(place, fitted, train, shape);
    const Vector force = place.boxes.force(rows);

    out.explained.emplace_back();
    for (unsigned set = 0; set < 1u << groups; ++set) {
      std::vector<int> columns;
      for (int k = 0; k < count_of(fitted.member); ++k)
        if ((set >> fitted.member[k] & 1u) != 0) columns.push_back(k);
      Vector left = force;
      if (!columns.empty()) left -= fitted.columns(rows, columns) * solved(white, columns);
      out.explained.back().push_back(force.squaredNorm() - left.squaredNorm());
    }
    out.total.push_back(force.squaredNorm() - noise * static_cast<double>(rows.size()));
  }
  return out;
}

/// Shares of the groups, of all folds together and with their intervals by fold.
void add_shares(const HeldOutEnergy& energy, int groups, std::vector<Dependence>& follows) {
  const auto sets = static_cast<std::size_t>(1) << groups;
  double total = 0.0;
  for (const double own : energy.total) total += own;
  const double usual = total / static_cast<double>(energy.total.size());
  std::vector<double> sum(sets, 0.0);
  std::vector<Vector> by_fold;
  for (const std::vector<double>& fold : energy.explained) {
    std::vector<double> share(sets);
    for (std::size_t set = 0; set < sets; ++set) {
      sum[set] += fold[set] / total;
      share[set] = fold[set] / usual;
    }
    by_fold.push_back(shapley_values(share, groups));
  }

  const Vector shares = shapley_values(sum, groups);
  for (int m = 0; m < groups; ++m) {
    std::vector<double> own;
    for (const Vector& fold : by_fold) own.push_back(fold[m]);
    follows[m].share = shares[m];
    follows[m].ci95 = fold_interval(own, shares[m]);
  }
}

/// What the noise of rates at both ends of a box makes of its force, and what is left in all
/// [unit^2].
double rate_noise(const PlaceRegressors& place, const std::vector<Chunk>& chunks,
                  const Selected& selected) {
  const double rows = static_cast<double>(rows_in(chunks).size());
  const double left = white_energy_left(place, selected, chunks, selected.period);
  return 2.0 * selected.shape.rates * left / rows;
}

/// Only the groups that stand by stability.
Selected stable(Selected selected) {
  Selected out = selected;
  out.groups.clear();
  out.chosen.clear();
  for (std::size_t m = 0; m < selected.groups.size(); ++m) {
    if (selected.chosen[m] < selected.needed) continue;
    out.groups.push_back(selected.groups[m]);
    out.chosen.push_back(selected.chosen[m]);
  }
  return out;
}

Dependence followed(const PlaceRegressors& place, const Selected& selected, int m) {
  Dependence own;
  const int group = selected.groups[m];
  const bool periodic = group == count_of(place.groups);
  own.regressor = periodic ? Regressor::periodic : place.groups[group].regressor;
  if (periodic) {
    own.period = selected.period;
    own.unit = place.boxes.angular ? "rad" : "m";
  } else {
    own.of = place.groups[group].of;
  }
  own.selected = selected.chosen[m];
  return own;
}

/// Coefficients in units of the functions, over all boxes.
void add_coefficients(const PlaceRegressors& place, const Selected& selected, const Fitted& fitted,
                      const std::vector<Chunk>& chunks, std::vector<Dependence>& follows) {
  const Matrix white = white_rows(place, fitted, chunks, selected.shape);
  const Vector solution = solved(white);
  std::vector<int> seen(selected.groups.size(), 0);
  for (int k = 0; k < count_of(fitted.member); ++k) {
    const int m = fitted.member[k], group = selected.groups[m];
    const bool periodic = group == count_of(place.groups);
    const double scale = periodic ? 1.0 : place.groups[group].scale[seen[m]];
    follows[m].coefficients.push_back(solution[k] / scale);
    ++seen[m];
  }
}

}  // namespace

RemainderPlace describe(const PlaceRegressors& place, const Settings& settings) {
  RemainderPlace out;
  out.joint = place.boxes.name;
  out.unit = place.boxes.angular ? "N m" : "N";
  out.boxes = count_of(place.boxes.run);
  out.rest = place.boxes.rest;
  const std::vector<Chunk> chunks = chunks_of(place.boxes.run);
  if (count_of(chunks) < kFewestChunks) return out;

  const Selected chosen = select_regressors(place, chunks, settings);
  const double noise = rate_noise(place, chunks, chosen);
  const double mean_square = place.boxes.force.squaredNorm() / static_cast<double>(out.boxes);
  out.rms = std::sqrt(std::max(0.0, mean_square - noise));
  Selected selected = stable(chosen);
  if (selected.groups.empty() || !(out.rms > 0.0)) return out;

  selected.period = refined_period(place, selected, chunks);
  const Fitted fitted = columns_of(place, selected.groups, selected.period);
  std::vector<Dependence> follows;
  for (int m = 0; m < count_of(selected.groups); ++m)
    follows.push_back(followed(place, selected, m));
  add_shares(held_out_energy(place, fitted, count_of(follows), chunks, selected.shape, noise),
             count_of(follows), follows);
  add_coefficients(place, selected, fitted, chunks, follows);

  std::erase_if(follows, [&](const Dependence& own) {
    return !(own.ci95.lower > 0.0) || own.share < settings.least_followed;
  });
  std::stable_sort(follows.begin(), follows.end(),
                   [](const Dependence& a, const Dependence& b) { return a.share > b.share; });
  out.follows = std::move(follows);
  return out;
}

}  // namespace jaculus::diagnosis
