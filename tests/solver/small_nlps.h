#pragma once
// Small nonlinear programs with known answers. Derivatives are written by hand, patterns are
// dense.

#include <functional>
#include <string>
#include <vector>

#include "jaculus/transcription/nlp.h"

namespace jaculus::testing {

/// An Nlp from its data and four functions; the Jacobian is row-major [m x n], the Hessian dense,
/// its lower triangle used.
class DenseNlp : public transcription::Nlp {
 public:
  using Function = std::function<bool(const Vector& x, double& f)>;
  using Gradient = std::function<Vector(const Vector& x)>;
  using Rows = std::function<bool(const Vector& x, Vector& g)>;
  using Jacobian = std::function<Matrix(const Vector& x)>;
  using Hessian = std::function<Matrix(const Vector& x, double sigma, const Vector& lambda)>;

  DenseNlp(int n, int m)
      : x_lower(Vector::Constant(n, -kInfinity)),
        x_upper(Vector::Constant(n, kInfinity)),
        g_lower(Vector::Constant(m, -kInfinity)),
        g_upper(Vector::Constant(m, kInfinity)),
        x_scale(Vector::Ones(n)),
        g_scale(Vector::Ones(m)),
        x_unit(n, "m"),
        g_unit(m, "V") {
    for (int i = 0; i < m; ++i) {
      for (int j = 0; j < n; ++j) {
        jacobian_pattern.rows.push_back(i);
        jacobian_pattern.columns.push_back(j);
      }
    }
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j <= i; ++j) {
        hessian_pattern.rows.push_back(i);
        hessian_pattern.columns.push_back(j);
      }
    }
  }

  Function f;
  Gradient df;
  Rows g;
  Jacobian dg;
  Hessian h;
  Vector x_lower, x_upper, g_lower, g_upper, x_scale, g_scale;
  double f_scale = 1.0;
  std::vector<std::string> x_unit, g_unit;
  transcription::Sparsity jacobian_pattern, hessian_pattern;

  int variables() const override { return count_of(x_lower); }
  int rows() const override { return count_of(g_lower); }
  const Vector& variable_lower() const override { return x_lower; }
  const Vector& variable_upper() const override { return x_upper; }
  const Vector& row_lower() const override { return g_lower; }
  const Vector& row_upper() const override { return g_upper; }
  const Vector& variable_scale() const override { return x_scale; }
  const Vector& row_scale() const override { return g_scale; }
  double objective_scale() const override { return f_scale; }
  std::string variable_name(int i) const override { return "x" + std::to_string(i); }
  std::string row_name(int i) const override { return "row " + std::to_string(i); }
  std::string variable_unit(int i) const override { return x_unit[i]; }
  std::string row_unit(int i) const override { return g_unit[i]; }
  const transcription::Sparsity& jacobian_sparsity() const override { return jacobian_pattern; }
  const transcription::Sparsity& hessian_sparsity() const override { return hessian_pattern; }

  bool objective(const ConstVectorRef& x, double& value) override { return f(x, value); }
  bool gradient(const ConstVectorRef& x, VectorRef out) override {
    out = df(x);
    return true;
  }
  bool constraints(const ConstVectorRef& x, VectorRef values) override {
    if (rows() == 0) return true;
    Vector result(rows());
    const bool defined = g(x, result);
    values = result;
    return defined;
  }
  bool jacobian(const ConstVectorRef& x, VectorRef values) override {
    if (rows() == 0) return true;
    const Matrix j = dg(x);
    for (int k = 0; k < jacobian_pattern.size(); ++k) {
      values[k] = j(jacobian_pattern.rows[k], jacobian_pattern.columns[k]);
    }
    return true;
  }
  bool hessian(const ConstVectorRef& x, double sigma, const ConstVectorRef& lambda,
               VectorRef values) override {
    const Matrix full = h(x, sigma, lambda);
    for (int k = 0; k < hessian_pattern.size(); ++k) {
      values[k] = full(hessian_pattern.rows[k], hessian_pattern.columns[k]);
    }
    return true;
  }
};

/// Hock-Schittkowski 71: minimum 17.0140173 at (1, 4.7429994, 3.8211503, 1.3794082).
inline DenseNlp hs071() {
  DenseNlp nlp(4, 2);
  nlp.x_lower.setConstant(1.0);
  nlp.x_upper.setConstant(5.0);
  nlp.g_lower << 25.0, 40.0;
  nlp.g_upper << kInfinity, 40.0;
  nlp.f = [](const Vector& x, double& f) {
    f = x[0] * x[3] * (x[0] + x[1] + x[2]) + x[2];
    return true;
  };
  nlp.df = [](const Vector& x) -> Vector {
    return Eigen::Vector4d(x[3] * (2 * x[0] + x[1] + x[2]), x[0] * x[3], x[0] * x[3] + 1,
                           x[0] * (x[0] + x[1] + x[2]));
  };
  nlp.g = [](const Vector& x, Vector& g) {
    g[0] = x.prod();
    g[1] = x.squaredNorm();
    return true;
  };
  nlp.dg = [](const Vector& x) {
    Matrix j(2, 4);
    j << x[1] * x[2] * x[3], x[0] * x[2] * x[3], x[0] * x[1] * x[3], x[0] * x[1] * x[2], 2 * x[0],
        2 * x[1], 2 * x[2], 2 * x[3];
    return j;
  };
  nlp.h = [](const Vector& x, double s, const Vector& l) {
    Matrix h = Matrix::Zero(4, 4);
    h(0, 0) = s * 2 * x[3];
    h(1, 0) = s * x[3] + l[0] * x[2] * x[3];
    h(2, 0) = s * x[3] + l[0] * x[1] * x[3];
    h(2, 1) = l[0] * x[0] * x[3];
    h(3, 0) = s * (2 * x[0] + x[1] + x[2]) + l[0] * x[1] * x[2];
    h(3, 1) = s * x[0] + l[0] * x[0] * x[2];
    h(3, 2) = s * x[0] + l[0] * x[0] * x[1];
    h.diagonal().array() += 2 * l[1];
    return h;
  };
  return nlp;
}

inline const Vector kHs071Start = Eigen::Vector4d(1, 5, 5, 1);  ///< where it is started from

/// Rosenbrock's valley, no rows: minimum 0 at (1, 1).
inline DenseNlp rosenbrock() {
  DenseNlp nlp(2, 0);
  nlp.f = [](const Vector& x, double& f) {
    f = 100 * std::pow(x[1] - x[0] * x[0], 2) + std::pow(1 - x[0], 2);
    return true;
  };
  nlp.df = [](const Vector& x) -> Vector {
    const double d = x[1] - x[0] * x[0];
    return Eigen::Vector2d(-400 * x[0] * d - 2 * (1 - x[0]), 200 * d);
  };
  nlp.h = [](const Vector& x, double s, const Vector&) -> Matrix {
    Matrix h(2, 2);
    h << 1200 * x[0] * x[0] - 400 * x[1] + 2, -400 * x[0], -400 * x[0], 200;
    return s * h;
  };
  return nlp;
}

/// minimise 1/2 |x - target|^2  subject to  A x in its bounds.
inline DenseNlp projection(const Vector& target, const Matrix& a) {
  DenseNlp nlp(count_of(target), static_cast<int>(a.rows()));
  nlp.f = [target](const Vector& x, double& f) {
    f = 0.5 * (x - target).squaredNorm();
    return true;
  };
  nlp.df = [target](const Vector& x) -> Vector { return x - target; };
  nlp.g = [a](const Vector& x, Vector& g) {
    g = a * x;
    return true;
  };
  nlp.dg = [a](const Vector&) { return a; };
  nlp.h = [n = target.size()](const Vector&, double s, const Vector&) -> Matrix {
    return s * Matrix::Identity(n, n);
  };
  return nlp;
}

}  // namespace jaculus::testing
