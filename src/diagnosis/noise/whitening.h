#pragma once
// Whitened residuals: the space in which residuals of the true model are independent standard
// normal numbers.
//
//   y = f(p) + A n + B b + e,   n ~ N(m, S^2) nuisances of every segment,   b random effects that
//   segments share (random_effects.h),   e: noise with sigma_c and neighbours' correlation
//   rho_c^(gap/spacing).
// 1. Rows           w_i = (r_i - rho r_{i-1})/(sigma sqrt(1 - rho^2)),  first of a span r/sigma
// 2. Nuisances      M^-1/2 = I - U diag(1 - 1/sqrt(1 + s^2)) U^T,  W A S = U diag(s) V^T,
//                   segment by segment (nuisance_shrinkage.h)
// Marginalising n is thus a fixed linear map T, whose log det is the same for every model. The
// random effects follow on white rows, for their deviations are each model's own.
//
// Under a plan a misfit adds to e, not to n: how far a clock or a start may be off does not grow
// with what the model lacks. Along U the rows have the variance 1 + s^2 before they are white and
// 1 + m + s^2 with a misfit's m, in white rows 1 + m/(1 + s^2); so directions of a large s (setting
// nuisance_apart) stand apart, x as
//   (I - U U^T) x,   then U^T x/sqrt(1 + s^2) behind the rows of all datasets, without the misfit.
// Counted as rows like others they would let a wrong model move clocks at hardly any price, which
// held-out data then have to pay.

#include <vector>

#include "diagnosis/noise/noise_model.h"
#include "diagnosis/noise/nuisance_shrinkage.h"

namespace jaculus::diagnosis {

/// Rows of one segment that takes part.
struct SegmentBlock {
  int segment = 0;
  int first = 0, count = 0;  ///< of its rows among those that take part
  NuisanceShrinkage nuisances;
};

struct DatasetWhitening {
  std::vector<RowSpan> spans;        ///< of the dataset's rows, those that take part
  std::vector<SegmentBlock> blocks;  ///< segments that take part, in order
  int rows = 0;
  int apart = 0;           ///< directions of nuisances that stand apart
  Vector sigma;            ///< standard deviation of every row here [unit]
  Vector weight;           ///< 1/(sigma sqrt(1 - rho^2)) of every row here
  Vector previous;         ///< rho to the row before, in units of sigma; 0 at a span's start
  Vector prior_mean_rows;  ///< A m, raw rows of the dataset

  /// Steps 1 and 2 on a raw vector (a residual, a sensitivity) of all the dataset's rows, without
  /// what stands apart.
  [[nodiscard]] Vector apply(const Vector& raw) const;
  [[nodiscard]] Vector whiten(const Vector& raw) const;  ///< step 1 alone
  /// Step 2 on white rows, which loses what stands apart; and that, of the same rows before. Each
  /// column by itself.
  void take_nuisances(MatrixRef white) const;
  [[nodiscard]] Matrix apart_of(ConstMatrixRef white) const;
  /// Step 1 on the rows of one block, each column of `raw` a vector of that segment's own rows.
  [[nodiscard]] Matrix whiten_block(int block, const Matrix& raw) const;
  /// The block of a segment; -1 where it takes no part.
  [[nodiscard]] int block_of(int segment) const;
};

/// Slopes of predicted rows by some parameters, before whitening: slopes in any space follow.
struct RowSlopes {
  /// A parameter each: a dataset each [units of its rows per prior scale].
  std::vector<std::vector<Vector>> columns;
};

struct Whitening {
  std::vector<DatasetWhitening> datasets;
  int rows = 0;                       ///< of all datasets in their order, then of what stands apart
  int apart = 0;                      ///< of these; as many of the others hold no noise
  std::vector<Alignment> alignments;  ///< by which rows are predicted, a dataset each
  std::vector<Vector> measured;       ///< raw rows less the nuisances' prior mean, a dataset each
  RandomEffects random;               ///< on white rows

  /// T (y - A m - f).
  [[nodiscard]] Vector residual(const std::vector<Vector>& predicted) const;
  /// T g of a raw difference of predictions.
  [[nodiscard]] Vector apply(const std::vector<Vector>& raw) const;
  /// The same of several differences, a column each: much less time than one by one.
  [[nodiscard]] Matrix columns(const std::vector<std::vector<Vector>>& raws) const;
  /// dr/du, white rows x parameters.
  [[nodiscard]] Matrix slopes(const RowSlopes& of_rows) const;
  /// The rows of all datasets with what stands apart put back, M^-1/2 of step 2.
  [[nodiscard]] Vector in_rows(const Vector& white) const;
};

/// Which segments of which dataset take part; empty: all.
using SegmentMask = std::vector<std::vector<bool>>;
Whitening whitening_of(const Problem& problem, const NoiseModel& noise,
                       const SegmentMask& mask = {});

/// Of the white rows of all segments those of a part of them, in its order: each segment is made
/// white by itself, so that the values are the same. Both by one noise model.
std::vector<Eigen::Index> rows_of_part(const Whitening& all, const Whitening& part);

}  // namespace jaculus::diagnosis
