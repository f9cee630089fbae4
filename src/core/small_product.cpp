#include "jaculus/core/small_product.h"

#include <array>

#include "jaculus/core/wide.h"

namespace jaculus {
namespace {

using Eigen::Index;

// Four rows at once: a register of AVX2, or two of any x86-64. The compiler does the arithmetic of
// `Four` element by element; memory may hold it at any double.
constexpr Index kRows = 4;
using Four [[gnu::vector_size(kRows * sizeof(double)), gnu::aligned(alignof(double))]] = double;

constexpr Index kInner = 48;  // columns of A that one strip of four rows keeps at hand

struct Columns {
  double* data;
  Index stride;
};

/// Rows of A, one after the other of its columns, filled up with zeros.
using Strip = std::array<double, kRows * kInner>;

/// Four rows of `columns` columns of A B, added to C's or put in their place.
template <int columns>
JACULUS_INLINE void strip_times(const Strip& strip, Index inner, const double* B, Index stride_B,
                                const Columns& C, Index height, double sign, bool keep) {
  Four sum[columns] = {};
  for (Index k = 0; k < inner; ++k) {
    const Four a = *reinterpret_cast<const Four*>(strip.data() + kRows * k);
    for (int j = 0; j < columns; ++j) sum[j] += a * B[j * stride_B + k];
  }
  for (int j = 0; j < columns; ++j) {
    double* c = C.data + j * C.stride;
    for (Index i = 0; i < height; ++i) c[i] = (keep ? c[i] : 0.0) + sign * sum[j][i];
  }
}

JACULUS_INLINE void fill(const double* A, Index stride, Index inner, Index height, Strip& strip) {
  for (Index k = 0; k < inner; ++k)
    for (Index i = 0; i < kRows; ++i) strip[kRows * k + i] = i < height ? A[k * stride + i] : 0.0;
}

/// C = [C +] sign A B for at most kInner columns of A; with `lower`, blocks above the diagonal are
/// left out.
JACULUS_WIDE void multiply(const double* A, Index stride_A, const double* B, Index stride_B,
                           double* C, Index stride_C, Index rows, Index inner, Index columns,
                           double sign, bool keep, bool lower) {
  Strip strip;
  for (Index i = 0; i < rows; i += kRows) {
    const Index height = std::min(kRows, rows - i);
    const Index last = lower ? std::min(columns, i + kRows) : columns;
    fill(A + i, stride_A, inner, height, strip);

    for (Index j = 0; j < last; j += kRows) {
      const double* b = B + j * stride_B;
      const Columns c{C + i + j * stride_C, stride_C};
      switch (std::min(kRows, last - j)) {
        case 1:
          strip_times<1>(strip, inner, b, stride_B, c, height, sign, keep);
          break;
        case 2:
          strip_times<2>(strip, inner, b, stride_B, c, height, sign, keep);
          break;
        case 3:
          strip_times<3>(strip, inner, b, stride_B, c, height, sign, keep);
          break;
        default:
          strip_times<4>(strip, inner, b, stride_B, c, height, sign, keep);
      }
    }
  }
}

void multiply(const ConstMatrixRef& A, const ConstMatrixRef& B, MatrixRef& C, double sign,
              bool keep, bool lower) {
  assert(A.cols() == B.rows() && C.rows() == A.rows() && C.cols() == B.cols());
  if (A.cols() == 0 && !keep) C.setZero();
  for (Index k = 0; k < A.cols(); k += kInner)
    multiply(A.data() + k * A.outerStride(), A.outerStride(), B.data() + k, B.outerStride(),
             C.data(), C.outerStride(), A.rows(), std::min(kInner, A.cols() - k), B.cols(), sign,
             keep || k > 0, lower);
}

}  // namespace

void set_product(const ConstMatrixRef& A, const ConstMatrixRef& B, MatrixRef C) {
  multiply(A, B, C, 1.0, false, false);
}

void add_product(const ConstMatrixRef& A, const ConstMatrixRef& B, MatrixRef C) {
  multiply(A, B, C, 1.0, true, false);
}

void subtract_product(const ConstMatrixRef& A, const ConstMatrixRef& B, MatrixRef C) {
  multiply(A, B, C, -1.0, true, false);
}

void add_product_lower(const ConstMatrixRef& A, const ConstMatrixRef& B, MatrixRef C) {
  assert(C.rows() == C.cols());
  multiply(A, B, C, 1.0, true, true);
}

void add_transposed_product(const ConstMatrixRef& A, const ConstMatrixRef& B, MatrixRef C) {
  assert(A.rows() == B.rows() && C.rows() == A.cols() && C.cols() == B.cols());
  for (Index j = 0; j < C.cols(); ++j) {
    for (Index i = 0; i < C.rows(); ++i) {
      double sum = 0.0;
      for (Index k = 0; k < A.rows(); ++k) sum += A(k, i) * B(k, j);
      C(i, j) += sum;
    }
  }
}

}  // namespace jaculus
