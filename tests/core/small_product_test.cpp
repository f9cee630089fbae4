// Products of small matrices against Eigen's, of every shape that a strip can be cut to.

#include "jaculus/core/small_product.h"

#include <gtest/gtest.h>

namespace jaculus {
namespace {

TEST(SmallProduct, AgreesWithEigenOnAllShapes) {
  for (int rows : {1, 2, 3, 4, 5, 8, 11, 12}) {
    for (int inner : {0, 1, 7, 48, 49, 100}) {
      for (int columns : {1, 2, 3, 4, 6, 9}) {
        const Matrix A = Matrix::Random(rows, inner), B = Matrix::Random(inner, columns);
        const Matrix start = Matrix::Random(rows, columns), AB = A * B;
        Matrix C = Matrix::Constant(rows, columns, kNaN);

        set_product(A, B, C);
        EXPECT_LT((C - AB).norm(), 1e-12) << rows << " x " << inner << " x " << columns;
        C = start;
        add_product(A, B, C);
        EXPECT_LT((C - start - AB).norm(), 1e-12);
        C = start;
        subtract_product(A, B, C);
        EXPECT_LT((C - start + AB).norm(), 1e-12);
      }
    }
  }
}

TEST(SmallProduct, WritesIntoPartsOfLargerMatrices) {
  const Matrix A = Matrix::Random(9, 6), B = Matrix::Random(9, 6);
  Matrix C = Matrix::Constant(8, 8, 7.0);
  set_product(A.block(1, 2, 5, 3), B.block(0, 1, 3, 2), C.block(2, 3, 5, 2));
  Matrix expected = Matrix::Constant(8, 8, 7.0);
  expected.block(2, 3, 5, 2) = A.block(1, 2, 5, 3) * B.block(0, 1, 3, 2);
  EXPECT_LT((C - expected).norm(), 1e-12);
}

TEST(SmallProduct, LowerTriangleIsWhole) {
  for (int size : {1, 4, 7, 21}) {
    const Matrix A = Matrix::Random(size, 5), B = Matrix::Random(5, size);
    Matrix C = Matrix::Ones(size, size);
    add_product_lower(A, B, C);
    const Matrix error = C - Matrix::Ones(size, size) - A * B;
    EXPECT_LT(Matrix(error.triangularView<Eigen::Lower>()).norm(), 1e-12) << size;
  }
}

}  // namespace
}  // namespace jaculus
