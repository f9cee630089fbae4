#include "jaculus/core/column_pattern.h"

namespace jaculus {
namespace {

using Eigen::Index;

constexpr Index kSummedRows = 4;  ///< of a result that are summed in registers

/// Four rows (or fewer, `height`) of one column: c += sum_k A(:, rows[k]) factors(rows[k]).
template <class S, class Factor>
JACULUS_INLINE void add_columns(const S* A, Index stride, Index height,
                                const std::vector<int>& rows, Factor&& factor, S* c) {
  if (height >= kSummedRows) {
    S sum[kSummedRows] = {c[0], c[1], c[2], c[3]};
    for (const int i : rows) {
      const S b = factor(i);
      const S* a = A + i * stride;
      for (Index k = 0; k < kSummedRows; ++k) sum[k] += a[k] * b;
    }
    for (Index k = 0; k < kSummedRows; ++k) c[k] = sum[k];
    return;
  }

  for (Index k = 0; k < height; ++k) {
    S sum = c[k];
    for (const int i : rows) sum += A[i * stride + k] * factor(i);
    c[k] = sum;
  }
}

}  // namespace

ColumnPattern ColumnPattern::of(const Matrix& matrix) {
  ColumnPattern pattern;
  pattern.rows.resize(static_cast<std::size_t>(matrix.cols()));
  for (int j = 0; j < matrix.cols(); ++j)
    for (int i = 0; i < matrix.rows(); ++i)
      if (matrix(i, j) != 0.0) pattern.rows[j].push_back(i);
  return pattern;
}

template <class S, class Sparse>
JACULUS_WIDE void add_times_sparse(const std::type_identity_t<ConstRefOf<S>>& A,
                                   const Sparse& sparse, const ColumnPattern& pattern, double sign,
                                   std::type_identity_t<RefOf<S>> C) {
  const Index rows = C.rows(), stride = A.outerStride();
  assert(A.rows() == rows && A.cols() == sparse.rows() && C.cols() == sparse.cols());
  for (Index j = 0; j < C.cols(); ++j) {
    const auto* column = sparse.data() + j * sparse.rows();
    S* c = C.data() + j * C.outerStride();
    for (Index i = 0; i < rows; i += kSummedRows)
      add_columns(
          A.data() + i, stride, rows - i, pattern.rows[j],
          [&](int k) { return S(sign * column[k]); }, c + i);
  }
}

template <class S, class Sparse>
JACULUS_WIDE void add_sparse_transposed_times(const Sparse& sparse, const ColumnPattern& pattern,
                                              double sign,
                                              const std::type_identity_t<ConstRefOf<S>>& B,
                                              std::type_identity_t<RefOf<S>> C) {
  assert(C.rows() == sparse.cols() && B.rows() == sparse.rows() && C.cols() == B.cols());
  for (Index c = 0; c < C.cols(); ++c) {
    const S* b = B.data() + c * B.outerStride();
    S* out = C.data() + c * C.outerStride();
    for (Index j = 0; j < C.rows(); ++j) {
      const auto* column = sparse.data() + j * sparse.rows();
      S sum = S(0.0);
      for (const int i : pattern.rows[j]) sum += column[i] * b[i];
      out[j] += sign * sum;
    }
  }
}

template <class S, class Sparse>
JACULUS_WIDE void add_sparse_times(const Sparse& sparse, const ColumnPattern& pattern, double sign,
                                   const std::type_identity_t<ConstRefOf<S>>& B,
                                   std::type_identity_t<RefOf<S>> C) {
  assert(C.rows() == sparse.rows() && B.rows() == sparse.cols() && C.cols() == B.cols());
  for (Index c = 0; c < C.cols(); ++c) {
    const S* b = B.data() + c * B.outerStride();
    S* out = C.data() + c * C.outerStride();
    for (Index j = 0; j < B.rows(); ++j) {
      const auto* column = sparse.data() + j * sparse.rows();
      const S factor = sign * b[j];
      for (const int i : pattern.rows[j]) out[i] += column[i] * factor;
    }
  }
}

#define JACULUS_INSTANTIATE(S, Sparse)                                                          \
  template void add_times_sparse<S, Sparse>(const ConstRefOf<S>&, const Sparse&,                \
                                            const ColumnPattern&, double, RefOf<S>);            \
  template void add_sparse_transposed_times<S, Sparse>(const Sparse&, const ColumnPattern&,     \
                                                       double, const ConstRefOf<S>&, RefOf<S>); \
  template void add_sparse_times<S, Sparse>(const Sparse&, const ColumnPattern&, double,        \
                                            const ConstRefOf<S>&, RefOf<S>);

JACULUS_INSTANTIATE(double, Matrix)
JACULUS_INSTANTIATE(Lanes, Matrix)
JACULUS_INSTANTIATE(Lanes, MatrixOf<Lanes>)
#undef JACULUS_INSTANTIATE

}  // namespace jaculus
