// Products of small matrices of lanes: blocks of the result stay in registers, sixteen of which
// AVX2 has.

#include "jaculus/core/small_product.h"

namespace jaculus {
namespace {

using Eigen::Index;

/// Where the element (i, k) of a factor stands: i * along + k * across.
struct Factor {
  const Lanes* data;
  Index along, across;
};

/// sum_k A(i, k) B(k, j) of a block of rows and columns, from left to right.
template <int rows, int columns>
JACULUS_INLINE void sum_block(const Factor& A, const Lanes* B, Index stride_B, Index inner,
                              Lanes (&sum)[rows][columns]) {
  for (int i = 0; i < rows; ++i)
    for (int j = 0; j < columns; ++j) sum[i][j] = Lanes(0.0);

  for (Index k = 0; k < inner; ++k) {
    Lanes b[columns];
    for (int j = 0; j < columns; ++j) b[j] = B[j * stride_B + k];
    for (int i = 0; i < rows; ++i) {
      const Lanes a = A.data[i * A.along + k * A.across];
      for (int j = 0; j < columns; ++j) sum[i][j] += a * b[j];
    }
  }
}

enum class Put { set, add, subtract };

template <int rows, int columns, Put put>
JACULUS_INLINE void block(const Factor& A, const Lanes* B, Index stride_B, Index inner, Lanes* C,
                          Index stride_C) {
  Lanes sum[rows][columns];
  sum_block<rows, columns>(A, B, stride_B, inner, sum);
  for (int j = 0; j < columns; ++j) {
    for (int i = 0; i < rows; ++i) {
      Lanes& c = C[i + j * stride_C];
      if constexpr (put == Put::set) c = sum[i][j];
      if constexpr (put == Put::add) c += sum[i][j];
      if constexpr (put == Put::subtract) c -= sum[i][j];
    }
  }
}

/// Two columns (or the last one) of C.
template <int columns, Put put>
JACULUS_INLINE void strip(const Factor& A, Index first, Index rows, const Lanes* B, Index stride_B,
                          Index inner, Lanes* C, Index stride_C) {
  Index i = first;
  for (; i + 4 <= rows; i += 4)
    block<4, columns, put>({A.data + i * A.along, A.along, A.across}, B, stride_B, inner, C + i,
                           stride_C);
  for (; i < rows; ++i)
    block<1, columns, put>({A.data + i * A.along, A.along, A.across}, B, stride_B, inner, C + i,
                           stride_C);
}

template <Put put>
JACULUS_INLINE void multiply(const Factor& A, const ConstLanesRef& B, bool lower, LanesRef& C) {
  const Index inner = B.rows(), rows = C.rows();
  Index j = 0;
  for (; j + 2 <= C.cols(); j += 2)
    strip<2, put>(A, lower ? j : 0, rows, B.data() + j * B.outerStride(), B.outerStride(), inner,
                  C.data() + j * C.outerStride(), C.outerStride());
  if (j < C.cols())
    strip<1, put>(A, lower ? j : 0, rows, B.data() + j * B.outerStride(), B.outerStride(), inner,
                  C.data() + j * C.outerStride(), C.outerStride());
}

JACULUS_INLINE Factor as_it_is(const ConstLanesRef& A) { return {A.data(), 1, A.outerStride()}; }

}  // namespace

JACULUS_WIDE void set_product(const ConstLanesRef& A, const ConstLanesRef& B, LanesRef C) {
  assert(A.cols() == B.rows() && C.rows() == A.rows() && C.cols() == B.cols());
  multiply<Put::set>(as_it_is(A), B, false, C);
}

JACULUS_WIDE void add_product(const ConstLanesRef& A, const ConstLanesRef& B, LanesRef C) {
  assert(A.cols() == B.rows() && C.rows() == A.rows() && C.cols() == B.cols());
  multiply<Put::add>(as_it_is(A), B, false, C);
}

JACULUS_WIDE void subtract_product(const ConstLanesRef& A, const ConstLanesRef& B, LanesRef C) {
  assert(A.cols() == B.rows() && C.rows() == A.rows() && C.cols() == B.cols());
  multiply<Put::subtract>(as_it_is(A), B, false, C);
}

JACULUS_WIDE void add_transposed_product(const ConstLanesRef& A, const ConstLanesRef& B,
                                         LanesRef C) {
  assert(A.rows() == B.rows() && C.rows() == A.cols() && C.cols() == B.cols());
  multiply<Put::add>({A.data(), A.outerStride(), 1}, B, false, C);
}

JACULUS_WIDE void add_transposed_product_lower(const ConstLanesRef& A, const ConstLanesRef& B,
                                               LanesRef C) {
  assert(A.rows() == B.rows() && C.rows() == A.cols() && C.cols() == B.cols());
  multiply<Put::add>({A.data(), A.outerStride(), 1}, B, true, C);
}

}  // namespace jaculus
