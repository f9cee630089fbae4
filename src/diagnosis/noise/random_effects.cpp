#include "diagnosis/noise/random_effects.h"

#include <tbb/parallel_for.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "diagnosis/forward/sensitivities.h"

namespace jaculus::diagnosis {
namespace {

/// Least deviation, in the force that counts as large (missing_forces.h) or in noise floors.
constexpr double kLeastScale = 1e-7;
constexpr double kFirstScale = 1e-2;
/// Of one fixed-point step: factor on a deviation at most, and below which it stays.
constexpr double kLargestFactor = 10.0, kStays = 0.02;
/// Number of w told below which a deviation no longer matters.
constexpr double kTold = 1e-3;
constexpr Eigen::Index kInvertedAtOnce = 8;  ///< rows, below which halves gain nothing

/// Deviations of the columns of a block.
Vector column_scales(const RandomBlock& block, const Vector& scales) {
  Vector own(count_of(block.group));
  for (int k = 0; k < count_of(block.group); ++k) own[k] = scales[block.group[k]];
  return own;
}

/// Slopes of all rows by some parameters, a prior scale each; a matrix a dataset.
std::vector<Matrix> slopes_by(const Problem& problem, const std::vector<Alignment>& alignments,
                              const Vector& p, const std::vector<Vector>& rows_at_p,
                              const std::vector<int>& parameters) {
  std::vector<Matrix> slopes;
  for (const Vector& rows : rows_at_p)
    slopes.emplace_back(Matrix::Zero(rows.size(), count_of(parameters)));

  tbb::parallel_for(0, count_of(parameters), [&](int k) {
    const FreeParameter& own = problem.hypotheses.parameters[parameters[k]];
    const double step = own.usual_step();
    const auto moved = difference(problem, alignments, p, rows_at_p, parameters[k], step);
    if (!moved) return;
    for (std::size_t d = 0; d < slopes.size(); ++d)
      slopes[d].col(k) = moved->rows[d] * (own.scale / moved->step);
  });
  return slopes;
}

double log_det(const Eigen::LLT<Matrix>& factor) {
  return 2.0 * factor.matrixLLT().diagonal().array().log().sum();
}

/// Lower R = L^-1 by halves, [L1 0; B L2]^-1 = [R1 0; -R2 B R1 R2]: a third of what solving for the
/// identity takes.
void invert_lower(ConstMatrixRef L, MatrixRef R) {
  const Eigen::Index n = L.rows(), h = n / 2;
  if (n <= kInvertedAtOnce) {
    R.setIdentity();
    L.triangularView<Eigen::Lower>().solveInPlace(R);
    return;
  }
  invert_lower(L.topLeftCorner(h, h), R.topLeftCorner(h, h));
  invert_lower(L.bottomRightCorner(n - h, n - h), R.bottomRightCorner(n - h, n - h));
  R.topRightCorner(h, n - h).setZero();
  const Matrix along = L.bottomLeftCorner(n - h, h) * R.topLeftCorner(h, h);
  R.bottomLeftCorner(n - h, h).noalias() = -R.bottomRightCorner(n - h, n - h) * along;
}

/// One block's part of weighing, L L^T = I + S G^T G S.
struct WeighedBlock {
  Matrix root;           ///< L^-1; none where it is not asked for
  Matrix half;           ///< L^-1 S G^T X
  double log_det = 0.0;  ///< of L L^T
};

WeighedBlock weighed_block(const RandomBlock& block, const Matrix& products, const Vector& scales,
                           bool with_root) {
  const Vector own = column_scales(block, scales);
  if (own.size() == 0) return {};  // Eigen's products of no rows fail where they are wide
  Matrix inner = own.asDiagonal() * block.gram * own.asDiagonal();
  inner.diagonal().array() += 1.0;
  const Eigen::LLT<Matrix> factor(inner);

  const Matrix scaled = own.asDiagonal() * products;
  if (!with_root) return {{}, factor.matrixL().solve(scaled), log_det(factor)};

  WeighedBlock out{Matrix(own.size(), own.size()), {}, log_det(factor)};
  invert_lower(factor.matrixLLT(), out.root);
  out.half = out.root.triangularView<Eigen::Lower>() * scaled;
  return out;
}

/// log det A of a factor of A, less that of what models share.
double log_det_of_own(const Eigen::LLT<Matrix>& factor, const Matrix& A,
                      const std::vector<Eigen::Index>& shared) {
  if (shared.empty()) return log_det(factor);
  return log_det(factor) - log_det(Matrix(A(shared, shared)).llt());
}

/// X^T V^-1 X and log det V, with the blocks that they were made of where these are asked for.
struct WeighedBlocks {
  Matrix gram;
  double log_det = 0.0;
  std::vector<WeighedBlock> blocks;
};

WeighedBlocks weighed_blocks(const RandomEffects& effects, const Products& products,
                             const Vector& scales, bool with_blocks) {
  WeighedBlocks out{products.gram, 0.0, {}};
  for (std::size_t c = 0; c < effects.misfits.size(); ++c) {
    const Misfit& own = effects.misfits[c];
    const double s = scales[own.group];
    out.gram -= (1.0 - 1.0 / own.variance(s)) * products.misfits[c];
    out.log_det += own.log_det(s);
  }
  for (std::size_t b = 0; b < effects.blocks.size(); ++b) {
    WeighedBlock own = weighed_block(effects.blocks[b], products.blocks[b], scales, with_blocks);
    if (own.half.size() > 0)
      out.gram.selfadjointView<Eigen::Lower>().rankUpdate(own.half.transpose(), -1.0);
    out.log_det += own.log_det;
    if (with_blocks) out.blocks.push_back(std::move(own));
  }
  out.gram.triangularView<Eigen::StrictlyUpper>() = out.gram.transpose();
  return out;
}

/// What one fixed-point step needs to know of a group.
struct GroupSums {
  Vector energy;   ///< |w/s|^2
  Vector told;     ///< number of w that the data tell
  Vector squares;  ///< of a misfit the next s^2
};

struct FixedPoint {
  double log_evidence = 0.0;
  Vector mean;  ///< of u
  GroupSums sums;
};

/// -2 log density of r and u, up to constants, at u = `mean`, b = Y^T V^-1 r, A = Y^T V^-1 Y + I.
double squares_at(const Matrix& gram, double log_det, const Vector& b, const Matrix& A,
                  const Vector& mean) {
  return gram(0, 0) - 2.0 * b.dot(mean) + mean.dot(A * mean) + log_det;
}

/// Evidence of X = [r Y] and the sums, all of u marginalised.
FixedPoint fixed_point(const RandomEffects& effects, const Products& products, const Vector& scales,
                       const Vector* at) {
  const WeighedBlocks weighed = weighed_blocks(effects, products, scales, true);
  const Eigen::Index n = weighed.gram.cols() - 1;
  Matrix A = weighed.gram.bottomRightCorner(n, n);
  A.diagonal().array() += 1.0;
  const Vector b = weighed.gram.col(0).tail(n);
  const Eigen::LLT<Matrix> factor(A);

  FixedPoint out;
  out.mean = at != nullptr ? *at : Vector(factor.solve(b));
  const Vector& mean = out.mean;
  out.log_evidence = -0.5 * (squares_at(weighed.gram, weighed.log_det, b, A, mean) +
                             log_det_of_own(factor, A, products.shared));
  out.sums = {Vector::Zero(effects.size()), Vector::Zero(effects.size()),
              Vector::Zero(effects.size())};
  const Matrix covariance =
      effects.misfits.empty() ? Matrix() : Matrix(factor.solve(Matrix::Identity(n, n)));
  for (std::size_t c = 0; c < effects.misfits.size(); ++c) {
    const Misfit& own = effects.misfits[c];
    if (own.rows <= 0.0) continue;
    const Matrix& gram = products.misfits[c];
    const auto by_u = gram.bottomRightCorner(n, n);
    // Expected over u: with tr(cov by_u) added, the sum over the entries' products.
    const double energy = gram(0, 0) - 2.0 * mean.dot(gram.col(0).tail(n)) + mean.dot(by_u * mean) +
                          covariance.cwiseProduct(by_u).sum();
    // At its least nothing was chosen.
    const double least = own.variance(effects.groups[own.group].least);
    const double share = 1.0 - least / own.variance(scales[own.group]);
    out.sums.told[own.group] = own.values * share * share;
    out.sums.squares[own.group] = std::max(0.0, energy / own.rows - 1.0);
  }
  for (std::size_t i = 0; i < effects.blocks.size(); ++i) {
    const WeighedBlock& own = weighed.blocks[i];
    if (own.root.size() == 0) continue;
    const Matrix P = own.root.transpose().triangularView<Eigen::Upper>() * own.half;
    const Vector w = P.col(0) - P.rightCols(n) * mean;
    const Vector alone = own.root.colwise().squaredNorm();
    const Matrix along = factor.matrixL().solve(P.rightCols(n).transpose());
    const Vector variance = alone + along.colwise().squaredNorm().transpose();
    for (Eigen::Index j = 0; j < w.size(); ++j) {
      const int group = effects.blocks[i].group[j];
      out.sums.energy[group] += w[j] * w[j];
      out.sums.told[group] += std::max(0.0, 1.0 - variance[j]);
    }
  }
  return out;
}

/// s^2 of the next step: |w|^2/told, and where a group is below its slower one, that of both
/// together (pool adjacent violators: Ayer et al. 1955).
Vector next_squares(const RandomEffects& effects, const GroupSums& sums, const Vector& scales) {
  struct Pool {
    std::vector<int> groups;
    double energy = 0.0, told = 0.0;
    [[nodiscard]] double square() const { return energy / std::max(1e-12, told); }
  };
  Vector squares = sums.squares;
  std::vector<Pool> pools;
  for (int g = 0; g < effects.size(); ++g) {
    if (effects.groups[g].force < 0) continue;
    if (effects.groups[g].slower < 0) pools.clear();
    pools.push_back({{g}, sums.energy[g] * scales[g] * scales[g], sums.told[g]});
    while (pools.size() > 1 && pools.back().square() < pools[pools.size() - 2].square()) {
      const Pool last = pools.back();
      pools.pop_back();
      Pool& into = pools.back();
      into.groups.insert(into.groups.end(), last.groups.begin(), last.groups.end());
      into.energy += last.energy;
      into.told += last.told;
    }
    for (const Pool& pool : pools)
      for (const int own : pool.groups) squares[own] = pool.square();
  }
  return squares;
}

}  // namespace

double Misfit::variance(double s) const { return values > 0.0 ? 1.0 + s * s * rows / values : 1.0; }

double Misfit::likely(double energy, const RandomGroup& group) const {
  const double square = rows > 0.0 ? std::max(0.0, energy / rows - 1.0) : 0.0;
  return std::clamp(std::sqrt(square), group.least, group.largest);
}

double Misfit::energy(const Vector& r) const {
  double sum = 0.0;
  for (const auto& [first, count] : spans) sum += r.segment(first, count).squaredNorm();
  return sum;
}

double Misfit::log_det(double s) const {
  const double own = variance(s);
  return values * std::log(own) + (rows - values) * (1.0 - 1.0 / own);
}

void Shrinkage::apply(MatrixRef X) const {
  if (shrink.size() == 0) return;
  const Matrix along = shrink.asDiagonal() * (U.transpose() * X);
  X.noalias() -= U * along;
}

Shrinkage shrinkage(const Matrix& A) {
  if (A.cols() == 0 || A.rows() == 0) return {};
  const Eigen::SelfAdjointEigenSolver<Matrix> solver(A.transpose() * A);
  Eigen::Index kept = 0;
  while (kept < A.cols() && solver.eigenvalues()[A.cols() - 1 - kept] > kLeastEnergy) ++kept;

  const Vector energy = solver.eigenvalues().tail(kept);
  const Vector inverse = energy.cwiseSqrt().cwiseInverse();
  return {A * solver.eigenvectors().rightCols(kept) * inverse.asDiagonal(),
          1.0 - (1.0 + energy.array()).sqrt().inverse()};
}

RandomColumns random_columns(const Problem& problem, const std::vector<Alignment>& alignments,
                             const Vector& p, const std::vector<Vector>& rows_at_p) {
  RandomColumns columns;
  std::vector<int> boxes;
  for (int g = 0; g < count_of(problem.hypotheses.forces); ++g)
    for (const int i : problem.hypotheses.forces[g].boxes) {
      boxes.push_back(i);
      columns.group.push_back(g);
    }

  columns.forces = slopes_by(problem, alignments, p, rows_at_p, boxes);
  return columns;
}

Vector complete_scales(const RandomEffects& effects) {
  Vector scales = Vector::Zero(effects.size());
  for (const Misfit& misfit : effects.misfits)
    scales[misfit.group] = effects.groups[misfit.group].least;
  return scales;
}

Vector without_misfits(const RandomEffects& effects, Vector scales) {
  for (const Misfit& misfit : effects.misfits) scales[misfit.group] = 0.0;
  return scales;
}

Vector first_scales(const RandomEffects& effects) {
  return complete_scales(effects).cwiseMax(kFirstScale);
}

Products products_of(const RandomEffects& effects, const Matrix& X) {
  Products products{Matrix::Zero(X.cols(), X.cols()), {}, {}};
  for (const Misfit& misfit : effects.misfits) {
    products.misfits.emplace_back(Matrix::Zero(X.cols(), X.cols()));
    Matrix& own = products.misfits.back();
    for (const auto& [first, count] : misfit.spans)
      own.selfadjointView<Eigen::Lower>().rankUpdate(X.middleRows(first, count).transpose());
    own.triangularView<Eigen::StrictlyUpper>() = own.transpose();
    products.gram += own;
  }
  // Beside a misfit all rows belong to it, to a block or are plain.
  if (effects.misfits.empty()) products.gram = X.transpose() * X;
  for (const auto& [first, count] : effects.plain)
    products.gram.noalias() += X.middleRows(first, count).transpose() * X.middleRows(first, count);
  for (const RandomBlock& block : effects.blocks) {
    const auto rows = X.middleRows(block.first, block.count);
    if (!effects.misfits.empty()) products.gram.noalias() += rows.transpose() * rows;
    products.blocks.emplace_back(block.columns.transpose() * rows);
  }
  return products;
}

Weighed weigh(const RandomEffects& effects, const Products& products, const Vector& scales) {
  WeighedBlocks all = weighed_blocks(effects, products, scales, false);
  return {std::move(all.gram), all.log_det};
}

LinearEvidence linear_evidence(const RandomEffects& effects, const Products& products,
                               const Vector& scales, const Vector* at) {
  const Weighed weighed = weigh(effects, products, scales);
  const Eigen::Index n = weighed.gram.cols() - 1;
  LinearEvidence out;
  out.log_evidence = -0.5 * (weighed.gram(0, 0) + weighed.log_det);
  if (n == 0) return out;

  Matrix A = weighed.gram.bottomRightCorner(n, n);
  A.diagonal().array() += 1.0;
  const Vector b = weighed.gram.col(0).tail(n);
  const Eigen::LLT<Matrix> factor(A);
  out.mean = at != nullptr ? *at : Vector(factor.solve(b));
  out.covariance = factor.solve(Matrix::Identity(n, n));
  out.log_evidence = -0.5 * (squares_at(weighed.gram, weighed.log_det, b, A, out.mean) +
                             log_det_of_own(factor, A, products.shared));
  return out;
}

ScaleEstimate estimated_scales(const RandomEffects& effects, const Products& products,
                               Vector scales, int steps, double spread, const Vector* at) {
  if (effects.size() == 0) {
    LinearEvidence linear = linear_evidence(effects, products, scales, at);
    return {scales, 0.0, linear.log_evidence, std::move(linear.mean)};
  }
  ScaleEstimate best;
  double most = -kInfinity;
  for (int step = 0; step <= steps; ++step) {
    FixedPoint point = fixed_point(effects, products, scales, at);
    const Vector& told = point.sums.told;
    const double cost = -0.5 * (1.0 + 2.0 * spread * spread * told.array()).log().sum();
    // The first counts even where no number comes out, so that there is a mean.
    const double reached = point.log_evidence + cost;
    if (step == 0 || reached > most) {
      most = std::isnan(reached) ? -kInfinity : reached;
      best = {scales, cost, point.log_evidence, std::move(point.mean)};
    }

    const Vector squares = next_squares(effects, point.sums, scales);
    double moved = 0.0;
    for (int g = 0; g < effects.size(); ++g) {
      const bool force = effects.groups[g].force >= 0;
      const double ratio = std::sqrt(squares[g]) / scales[g];
      const double factor = force ? std::clamp(ratio, 1.0 / kLargestFactor, kLargestFactor) : ratio;
      const double next =
          std::clamp(scales[g] * factor, std::max(kLeastScale, effects.groups[g].least),
                     effects.groups[g].largest);
      if (!force || told[g] > kTold) moved = std::max(moved, std::abs(std::log(next / scales[g])));
      scales[g] = next;
    }
    if (moved < kStays) break;
  }
  return best;
}

Vector misfits_of(const RandomEffects& effects, const Vector& r, const Vector& scales) {
  Vector out = scales;
  for (const Misfit& misfit : effects.misfits) {
    out[misfit.group] = misfit.likely(misfit.energy(r), effects.groups[misfit.group]);
  }
  return out;
}

double misfits_log_det(const RandomEffects& effects, const Vector& scales) {
  double sum = 0.0;
  for (const Misfit& misfit : effects.misfits) sum += misfit.log_det(scales[misfit.group]);
  return sum;
}

Vector told_by(const RandomEffects& effects, const Products& products, const Vector& scales) {
  return fixed_point(effects, products, scales, nullptr).sums.told;
}

}  // namespace jaculus::diagnosis
