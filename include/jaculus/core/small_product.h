#pragma once
// Products of small dense matrices, for code that makes many of some ten rows: Eigen's own unroll
// for sizes that are known when compiling, and pack for sizes of hundreds.
//
// Every element is a_i1 b_1j + a_i2 b_2j + ... from left to right. Where the processor has AVX2,
// four rows go at a time through the same products and sums (without fused ones), so that the bits
// are those of any other machine.

#include "jaculus/core/lanes.h"

namespace jaculus {

/// C = A B. No two may share memory.
void set_product(const ConstMatrixRef& A, const ConstMatrixRef& B, MatrixRef C);
/// C += A B.
void add_product(const ConstMatrixRef& A, const ConstMatrixRef& B, MatrixRef C);
/// C -= A B.
void subtract_product(const ConstMatrixRef& A, const ConstMatrixRef& B, MatrixRef C);
/// C += A B of a square C, the lower triangle at least; what stands above it is undefined.
void add_product_lower(const ConstMatrixRef& A, const ConstMatrixRef& B, MatrixRef C);
/// C += A^T B.
void add_transposed_product(const ConstMatrixRef& A, const ConstMatrixRef& B, MatrixRef C);

// The same of four matrices at once, lane by lane.
using ConstLanesRef = ConstRefOf<Lanes>;
using LanesRef = RefOf<Lanes>;
void set_product(const ConstLanesRef& A, const ConstLanesRef& B, LanesRef C);
void add_product(const ConstLanesRef& A, const ConstLanesRef& B, LanesRef C);
void subtract_product(const ConstLanesRef& A, const ConstLanesRef& B, LanesRef C);
void add_transposed_product(const ConstLanesRef& A, const ConstLanesRef& B, LanesRef C);
/// The lower triangle of a square C at least.
void add_transposed_product_lower(const ConstLanesRef& A, const ConstLanesRef& B, LanesRef C);

}  // namespace jaculus
