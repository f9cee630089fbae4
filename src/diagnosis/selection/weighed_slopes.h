#pragma once
// Slopes of a fit on the way to its end, weighed, and their squares by the parts of the rows that a
// misfit weighs alike: what Gauss-Newton's H and g are made of.

#include <cstddef>
#include <utility>
#include <vector>

#include "diagnosis/noise/random_weights.h"
#include "diagnosis/selection/residual.h"

namespace jaculus::diagnosis {

/// W = M J of a residual's slopes on the way, and W^T W of every part of the rows. Where slopes
/// follow secants, J + d s^T with s zero but for those that follow, so do both: W + w s^T with
/// w = M d, and with v = W^T w of a part
///   W^T W + v s^T + s v^T + w^T w s s^T.
/// W itself stays as it was, W_0, with the w s^T beside it,
///   W^T x = W_0^T x + sum s (w^T x),
/// so that a secant is one pass over W_0, which is larger than what a processor keeps at hand.
/// Misfits that follow change the parts' shares in H alone.
class WeighedSlopes {
 public:
  /// Rows that a misfit weighs alike: spans of first and count.
  using Part = std::vector<std::pair<int, int>>;

  /// `weights` have to outlive it.
  WeighedSlopes(const RandomWeights& weights, std::vector<Part> parts);

  /// `told`: whether the effects' slopes, which come first, were told anew.
  void follow(Residual& residual, bool told);

  /// W^T W and W^T x, a share of each part's rows.
  [[nodiscard]] Matrix gram(const Vector& shares) const;
  [[nodiscard]] Vector along(const Vector& shares, const Vector& x) const;

 private:
  /// A secant as W has it; `along` of all columns.
  struct Added {
    Vector w, along;
  };

  [[nodiscard]] Matrix gram_of(const Part& part) const;
  /// W^T X by the rows of a part.
  template <class Columns>
  [[nodiscard]] Matrix along_part(const Part& part, const Columns& X) const;
  /// The first columns by new slopes.
  void renew(ConstMatrixRef J);
  void add(const Residual::Secant& secant);

  const RandomWeights& weights_;
  std::vector<Part> parts_;
  std::vector<Matrix> grams_;  ///< a part each
  Matrix W_;                   ///< W_0, but for the columns that are made anew
  std::vector<Added> added_;
  int renewed_ = 0;
  std::size_t followed_ = 0;
};

}  // namespace jaculus::diagnosis
