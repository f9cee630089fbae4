#include "jaculus/components/saddle.h"

namespace jaculus::components {
namespace {

using Eigen::Index;

constexpr Index kColumns = 4;  ///< right-hand sides at a time: what stays in registers

/// The lower triangle of A becomes L, its diagonal inverted.
template <class S>
JACULUS_INLINE void cholesky(MatrixOf<S>& A) {
  const Index n = A.rows();
  for (Index j = 0; j < n; ++j) {
    for (Index k = 0; k < j; ++k) {
      const S factor = A(j, k);
      for (Index i = j; i < n; ++i) A(i, j) -= A(i, k) * factor;
    }
    const S inverse = S(1.0) / root(A(j, j));
    A(j, j) = inverse;
    for (Index i = j + 1; i < n; ++i) A(i, j) *= inverse;
  }
}

/// x := L^-1 x of `columns` columns.
template <int columns, class S>
JACULUS_INLINE void substitute(const MatrixOf<S>& L, S* x, Index stride) {
  for (Index i = 0; i < L.rows(); ++i) {
    S sum[columns];
    for (int c = 0; c < columns; ++c) sum[c] = x[c * stride + i];
    for (Index k = 0; k < i; ++k) {
      const S factor = L(i, k);
      for (int c = 0; c < columns; ++c) sum[c] -= factor * x[c * stride + k];
    }
    for (int c = 0; c < columns; ++c) x[c * stride + i] = sum[c] * L(i, i);
  }
}

/// x := L^-T x of `columns` columns.
template <int columns, class S>
JACULUS_INLINE void substitute_back(const MatrixOf<S>& L, S* x, Index stride) {
  for (Index i = L.rows() - 1; i >= 0; --i) {
    S sum[columns];
    for (int c = 0; c < columns; ++c) sum[c] = x[c * stride + i];
    for (Index k = i + 1; k < L.rows(); ++k) {
      const S factor = L(k, i);
      for (int c = 0; c < columns; ++c) sum[c] -= factor * x[c * stride + k];
    }
    for (int c = 0; c < columns; ++c) x[c * stride + i] = sum[c] * L(i, i);
  }
}

/// y += sign * A x, or A^T x, of `columns` columns.
template <int columns, class S>
JACULUS_INLINE void add_times(const MatrixOf<S>& A, bool transposed, double sign, const S* x, S* y,
                              Index stride) {
  const Index rows = transposed ? A.cols() : A.rows(), inner = transposed ? A.rows() : A.cols();
  for (Index i = 0; i < rows; ++i) {
    S sum[columns];
    for (int c = 0; c < columns; ++c) sum[c] = y[c * stride + i];
    for (Index k = 0; k < inner; ++k) {
      const S factor = S(sign) * (transposed ? A(k, i) : A(i, k));
      for (int c = 0; c < columns; ++c) sum[c] += factor * x[c * stride + k];
    }
    for (int c = 0; c < columns; ++c) y[c * stride + i] = sum[c];
  }
}

/// One strip of right-hand sides.
template <int columns, class S>
JACULUS_INLINE void solve_strip(const MatrixOf<S>& L, const MatrixOf<S>& B, const MatrixOf<S>& L_s,
                                S* x, Index stride) {
  S* f = x + L.rows();
  substitute<columns>(L, x, stride);
  if (L_s.rows() > 0) {
    add_times<columns>(B, true, -1.0, x, f, stride);
    substitute<columns>(L_s, f, stride);
    substitute_back<columns>(L_s, f, stride);
    add_times<columns>(B, false, 1.0, f, x, stride);
  }
  substitute_back<columns>(L, x, stride);
}

template <class S>
JACULUS_WIDE void factorize_saddle(MatrixOf<S>& L, MatrixOf<S>& B, MatrixOf<S>& L_s) {
  cholesky(L);
  for (Index c = 0; c < B.cols(); ++c) substitute<1>(L, B.data() + c * B.rows(), B.rows());
  for (Index j = 0; j < B.cols(); ++j) {
    for (Index i = j; i < B.cols(); ++i) {
      S sum = S(0.0);
      for (Index k = 0; k < B.rows(); ++k) sum += B(k, i) * B(k, j);
      L_s(i, j) = sum;
    }
  }
  cholesky(L_s);
}

template <class S>
JACULUS_WIDE void solve_saddle(const MatrixOf<S>& L, const MatrixOf<S>& B, const MatrixOf<S>& L_s,
                               S* x, Index columns, Index stride) {
  Index c = 0;
  for (; c + kColumns <= columns; c += kColumns)
    solve_strip<kColumns>(L, B, L_s, x + c * stride, stride);
  for (; c < columns; ++c) solve_strip<1>(L, B, L_s, x + c * stride, stride);
}

}  // namespace

template <class S>
SaddleOf<S>::SaddleOf(int n, int m)
    : L_(MatrixOf<S>::Constant(n, n, 0.0)),
      B_(MatrixOf<S>::Constant(n, m, 0.0)),
      L_s_(MatrixOf<S>::Constant(m, m, 0.0)) {}

template <class S>
void SaddleOf<S>::factorize(const MatrixOf<S>& M, const MatrixOf<S>& J) {
  L_ = M;
  B_ = J.transpose();
  factorize_saddle(L_, B_, L_s_);
}

template <class S>
void SaddleOf<S>::solve(RefOf<S> rhs) const {
  assert(rhs.rows() == L_.rows() + L_s_.rows());
  solve_saddle(L_, B_, L_s_, rhs.data(), rhs.cols(), rhs.outerStride());
}

template <class S>
void SaddleOf<S>::solve_transposed(RefOf<S> rhs) const {
  rhs.bottomRows(L_s_.rows()) = -rhs.bottomRows(L_s_.rows());
  solve(rhs);
  rhs.bottomRows(L_s_.rows()) = -rhs.bottomRows(L_s_.rows());
}

template class SaddleOf<double>;
template class SaddleOf<Lanes>;

}  // namespace jaculus::components
