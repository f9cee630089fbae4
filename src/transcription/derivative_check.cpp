#include "jaculus/transcription/derivative_check.h"

#include <cmath>
#include <random>

namespace jaculus::transcription {

namespace {

Matrix dense(const Sparsity& s, const Vector& values, int rows, int columns, bool symmetric) {
  Matrix m = Matrix::Zero(rows, columns);
  for (int k = 0; k < s.size(); ++k) {
    const int i = s.rows[k], j = s.columns[k];
    m(i, j) += values[k];
    if (symmetric && i != j) m(j, i) += values[k];
  }
  return m;
}

class Checker {
 public:
  Checker(Nlp& nlp, double h, std::uint64_t seed) : nlp_(nlp), h_(h) {
    std::mt19937_64 rng(seed);
    lambda_ = Vector(nlp.rows());
    for (int i = 0; i < nlp.rows(); ++i)
      lambda_[i] = (static_cast<double>(rng() >> 11) * 0x1.0p-53 - 0.5) / nlp.row_scale()[i];
  }

  DerivativeReport run(const ConstVectorRef& x) {
    Vector gradient, g;
    Matrix J;
    if (!first(x, gradient, g, J)) return report_;

    Vector h_values = Vector::Constant(nlp_.hessian_sparsity().size(), kNaN);
    if (!nlp_.hessian(x, 1.0, lambda_, h_values)) return report_;
    const Matrix H =
        dense(nlp_.hessian_sparsity(), h_values, nlp_.variables(), nlp_.variables(), true);
    const Vector row_size = J.cwiseAbs().rowwise().maxCoeff(),
                 H_size = H.cwiseAbs().rowwise().maxCoeff();
    const double gradient_size = gradient.cwiseAbs().maxCoeff();

    for (int j = 0; j < nlp_.variables(); ++j) {
      const double step = h_ * nlp_.variable_scale()[j];
      double f[2] = {0.0, 0.0};
      Vector g_at[2], gradient_at[2];
      Matrix J_at[2];

      for (int side = 0; side < 2; ++side) {
        Vector moved = x;
        moved[j] += side == 0 ? -step : step;
        if (!first(moved, gradient_at[side], g_at[side], J_at[side]) ||
            !nlp_.objective(moved, f[side]))
          return report_;
      }

      compare(gradient[j], (f[1] - f[0]) / (2 * step), gradient_size, "objective", j,
              report_.gradient);
      for (int i = 0; i < nlp_.rows(); ++i)
        compare(J(i, j), (g_at[1][i] - g_at[0][i]) / (2 * step), row_size[i], nlp_.row_name(i), j,
                report_.jacobian);
      const Vector lagrangian =
          (gradient_at[1] - gradient_at[0] + (J_at[1] - J_at[0]).transpose() * lambda_) /
          (2 * step);
      for (int i = 0; i < nlp_.variables(); ++i)
        compare(H(i, j), lagrangian[i], H_size[i], nlp_.variable_name(i), j, report_.hessian);
    }

    report_.defined = true;
    return report_;
  }

 private:
  bool first(const ConstVectorRef& x, Vector& gradient, Vector& g, Matrix& J) {
    gradient = Vector::Constant(nlp_.variables(), kNaN);
    g = Vector::Constant(nlp_.rows(), kNaN);
    Vector values = Vector::Constant(nlp_.jacobian_sparsity().size(), kNaN);
    if (!nlp_.gradient(x, gradient) || !nlp_.constraints(x, g) || !nlp_.jacobian(x, values))
      return false;
    J = dense(nlp_.jacobian_sparsity(), values, nlp_.rows(), nlp_.variables(), false);
    return true;
  }

  void compare(double analytic, double difference, double size, const std::string& row, int column,
               DerivativeError& worst) {
    const double error = std::abs(analytic - difference) / (1.0 + size);
    if (error <= worst.error) return;  // a NaN is neither and is taken as the worst
    worst = {std::isnan(error) ? kInfinity : error, analytic, difference, row,
             nlp_.variable_name(column)};
  }

  Nlp& nlp_;
  double h_;
  Vector lambda_;
  DerivativeReport report_;
};

}  // namespace

DerivativeReport check_derivatives(Nlp& nlp, const ConstVectorRef& x, double h,
                                   std::uint64_t seed) {
  return Checker(nlp, h, seed).run(x);
}

Vector random_point(const Nlp& nlp, const ConstVectorRef& centre, double spread,
                    std::uint64_t seed) {
  std::mt19937_64 rng(seed);
  Vector x = centre;
  for (int i = 0; i < x.size(); ++i) {
    x[i] += spread * nlp.variable_scale()[i] * (static_cast<double>(rng() >> 11) * 0x1.0p-52 - 1.0);
    x[i] = std::min(std::max(x[i], nlp.variable_lower()[i]), nlp.variable_upper()[i]);
  }
  return x;
}

}  // namespace jaculus::transcription
