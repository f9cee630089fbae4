#include "diagnosis/remainder/sparse_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

namespace jaculus::diagnosis {
namespace {

constexpr int kChunks = 40;                  ///< wanted, for halves that differ
constexpr int kShortest = 5, kLongest = 40;  ///< boxes of a chunk
constexpr int kPairs = 50;                   ///< B of Shah and Samworth
constexpr double kRidge = 1e-9;              ///< of the rows, beside columns of mean square 1
constexpr double kSamePeriod = 0.05;
constexpr double kLeastTau = 0.75;  ///< from which their bound has this form
constexpr std::uint64_t kSeed = 1;

const std::vector<NoiseShape>& noise_shapes() {
  static const std::vector<NoiseShape> shapes = [] {
    std::vector<NoiseShape> all;
    for (const double slow : {0.0, 0.6, 0.9})
      for (const double rates : {0.0, 0.3, 1.0, 3.0, 10.0, 100.0}) all.push_back({slow, rates});
    return all;
  }();
  return shapes;
}

Eigen::LLT<Matrix> factor_of(const NoiseShape& shape, Eigen::Index count) {
  Matrix covariance(count, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    for (Eigen::Index j = 0; j < count; ++j) {
      const auto apart = std::abs(i - j);
      covariance(i, j) = apart == 0 ? 1.0 : std::pow(shape.slow, static_cast<double>(apart));
      if (apart == 0) covariance(i, j) += 2.0 * shape.rates;
      if (apart == 1) covariance(i, j) -= shape.rates;
    }
  }
  return Eigen::LLT<Matrix>(covariance);
}

/// Products of white rows: base [force, functions of all groups], and with those of each period.
struct Grams {
  Matrix base;
  std::vector<Matrix> cross;  ///< base' x two functions, a period each
  std::vector<Matrix> own;    ///< two functions, a period each
  double rows = 0.0, log_det = 0.0;

  void add(const Grams& other) {
    if (base.size() == 0) {
      *this = other;
      return;
    }
    base += other.base;
    for (std::size_t k = 0; k < cross.size(); ++k) {
      cross[k] += other.cross[k];
      own[k] += other.own[k];
    }
    rows += other.rows;
    log_det += other.log_det;
  }
};

/// Columns of all candidates, the force first.
struct Table {
  Matrix base;
  std::vector<std::vector<int>> columns;  ///< of base, a group each
  std::vector<Matrix> periodic;           ///< two functions, a period each
  std::vector<double> periods;
  int periodic_group = 0;
};

Table table_of(const PlaceRegressors& place) {
  Table table;
  Eigen::Index width = 1;
  for (const RegressorGroup& group : place.groups) width += group.columns.cols();
  table.base.resize(place.boxes.force.size(), width);
  table.base.col(0) = place.boxes.force;
  Eigen::Index next = 1;
  for (const RegressorGroup& group : place.groups) {
    table.columns.emplace_back();
    for (Eigen::Index k = 0; k < group.columns.cols(); ++k) {
      table.columns.back().push_back(static_cast<int>(next));
      table.base.col(next++) = group.columns.col(k);
    }
  }
  table.periods = periods_of(place.boxes);
  for (const double period : table.periods)
    table.periodic.push_back(periodic_columns(place.boxes, period));
  table.periodic_group = count_of(place.groups);
  return table;
}

Grams grams_of(const Table& table, const Chunk& chunk, const NoiseShape& shape) {
  const Eigen::LLT<Matrix> factor = factor_of(shape, chunk.count);
  const auto white = [&](const Matrix& X) -> Matrix {
    return factor.matrixL().solve(X.middleRows(chunk.first, chunk.count));
  };

  Grams grams;
  const Matrix base = white(table.base);
  grams.base = base.transpose() * base;
  for (const Matrix& columns : table.periodic) {
    const Matrix periodic = white(columns);
    grams.cross.emplace_back(base.transpose() * periodic);
    grams.own.emplace_back(periodic.transpose() * periodic);
  }
  grams.rows = chunk.count;
  grams.log_det = 2.0 * factor.matrixLLT().diagonal().array().log().sum();
  return grams;
}

/// Groups, and the place of the period where they have the periodic one.
struct Choice {
  std::vector<int> groups;
  int period = -1;
  double score = -kInfinity;
};

double score_of(const Table& table, const Grams& grams, const Choice& choice) {
  std::vector<int> columns;
  for (const int g : choice.groups)
    if (g != table.periodic_group)
      columns.insert(columns.end(), table.columns[g].begin(), table.columns[g].end());
  const Eigen::Index plain = count_of(columns), all = plain + (choice.period >= 0 ? 2 : 0);

  Matrix normal(all, all);
  Vector right(all);
  normal.topLeftCorner(plain, plain) = grams.base(columns, columns);
  right.head(plain) = grams.base.col(0)(columns);
  if (choice.period >= 0) {
    const Matrix& cross = grams.cross[choice.period];
    normal.topRightCorner(plain, 2) = cross(columns, Eigen::all);
    normal.bottomLeftCorner(2, plain) = normal.topRightCorner(plain, 2).transpose();
    normal.bottomRightCorner(2, 2) = grams.own[choice.period];
    right.tail(2) = cross.row(0).transpose();
  }
  normal.diagonal().array() += kRidge * grams.rows;

  const double left = grams.base(0, 0) - (all > 0 ? right.dot(normal.ldlt().solve(right)) : 0.0);
  const double tiny = kRidge * grams.base(0, 0);
  double score = -0.5 * (grams.rows * std::log(std::max(left, tiny) / grams.rows) + grams.log_det);
  score -= 0.5 * static_cast<double>(all) * std::log(grams.rows);
  if (choice.period >= 0) score -= std::log(static_cast<double>(table.periods.size()));
  return std::isfinite(score) ? score : -kInfinity;
}

/// The best that one group more makes of a choice.
Choice extended(const Table& table, const Grams& grams, const Choice& choice) {
  Choice best = choice;
  for (int g = 0; g <= table.periodic_group; ++g) {
    if (index_of(choice.groups, g) >= 0) continue;
    const int periods = g == table.periodic_group ? count_of(table.periods) : 1;
    for (int k = 0; k < periods; ++k) {
      Choice more = choice;
      more.groups.push_back(g);
      if (g == table.periodic_group) more.period = k;
      more.score = score_of(table, grams, more);
      if (more.score > best.score) best = std::move(more);
    }
  }
  return best;
}

Choice chosen_by(const Table& table, const Grams& grams, int most) {
  Choice choice;
  choice.score = score_of(table, grams, choice);
  while (count_of(choice.groups) < most) {
    const Choice more = extended(table, grams, choice);
    if (more.groups.size() == choice.groups.size()) break;
    choice = more;
  }
  return choice;
}

/// Whether a half's choice has a group, and of the periodic one the same period.
bool has(const Table& table, const Choice& half, int group, double period) {
  if (index_of(half.groups, group) < 0) return false;
  if (group != table.periodic_group) return true;
  return std::abs(table.periods[half.period] - period) <= kSamePeriod * period;
}

/// Choices of random halves of the chunks and of their complements.
std::vector<Choice> choices_of_halves(const Table& table, const std::vector<Grams>& chunks,
                                      int most) {
  std::mt19937_64 generator(kSeed);
  std::vector<int> order(chunks.size());
  std::iota(order.begin(), order.end(), 0);
  std::vector<Choice> choices;
  for (int pair = 0; pair < kPairs; ++pair) {
    std::shuffle(order.begin(), order.end(), generator);
    const std::size_t half = chunks.size() / 2;
    for (int side = 0; side < 2; ++side) {
      Grams sum;
      for (std::size_t k = 0; k < half; ++k) sum.add(chunks[order[side == 0 ? k : half + k]]);
      choices.push_back(chosen_by(table, sum, most));
    }
  }
  return choices;
}

/// The least tau at which the bound is `level`.
double needed_share(double q, double p, double level) {
  const double pairs = kPairs;
  if (!(q > 0.0)) return kLeastTau;
  const double C = level * p / (q * q);
  return std::max(kLeastTau, 1.0 + 0.5 / pairs - 0.25 * C * (1.0 + 1.0 / pairs));
}

}  // namespace

std::vector<Chunk> chunks_of(const std::vector<int>& run) {
  const int wanted = std::clamp(count_of(run) / kChunks, kShortest, kLongest);
  std::vector<Chunk> chunks;
  for (int first = 0; first < count_of(run);) {
    int end = first;
    while (end < count_of(run) && run[end] == run[first]) ++end;
    const int pieces = (end - first) / wanted;
    for (int k = 0; k < pieces; ++k) {
      const int from = first + (end - first) * k / pieces,
                to = first + (end - first) * (k + 1) / pieces;
      chunks.push_back({from, to - from});
    }
    first = end;
  }
  return chunks;
}

Matrix whitened(const NoiseShape& shape, const Matrix& X) {
  return factor_of(shape, X.rows()).matrixL().solve(X);
}

Selected select_regressors(const PlaceRegressors& place, const std::vector<Chunk>& chunks,
                           const Settings& settings) {
  const Table table = table_of(place);
  Selected out;
  Choice best;
  for (const NoiseShape& shape : noise_shapes()) {
    Grams all;
    for (const Chunk& chunk : chunks) all.add(grams_of(table, chunk, shape));
    const Choice choice = chosen_by(table, all, settings.most_followed);
    if (choice.score <= best.score) continue;
    best = choice;
    out.shape = shape;
  }
  out.groups = best.groups;
  if (best.period >= 0) out.period = table.periods[best.period];
  if (out.groups.empty()) return out;

  std::vector<Grams> each;
  each.reserve(chunks.size());
  for (const Chunk& chunk : chunks) each.push_back(grams_of(table, chunk, out.shape));
  const std::vector<Choice> halves = choices_of_halves(table, each, settings.most_followed);
  const auto count = static_cast<double>(halves.size());
  double selected = 0.0;
  for (const Choice& half : halves) selected += static_cast<double>(half.groups.size());
  for (const int group : out.groups) {
    const auto same = std::count_if(halves.begin(), halves.end(), [&](const Choice& half) {
      return has(table, half, group, out.period);
    });
    out.chosen.push_back(static_cast<double>(same) / count);
  }
  const double kinds = table.periodic_group + (table.periods.empty() ? 0.0 : 1.0);
  out.needed = needed_share(selected / count, kinds, settings.pattern_level);
  return out;
}

}  // namespace jaculus::diagnosis
