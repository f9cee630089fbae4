#include "simulation/contact/contact_law.h"

#include <algorithm>
#include <cmath>

namespace jaculus::simulation::detail {

namespace {

constexpr double kZero = 1e-9;

/// Gaussian elimination with partial pivoting in place; false where a pivot vanishes beside the
/// matrix.
bool eliminate(double* K, double* x, int size, double scale) {
  double inverse[kStride];  // of the pivots
  for (int j = 0; j < size; ++j) {
    int pivot = j;
    for (int i = j + 1; i < size; ++i)
      if (std::abs(K[j * kStride + i]) > std::abs(K[j * kStride + pivot])) pivot = i;
    if (!(std::abs(K[j * kStride + pivot]) > 1e-13 * scale)) return false;
    if (pivot != j) {
      for (int k = j; k < size; ++k) std::swap(K[k * kStride + j], K[k * kStride + pivot]);
      std::swap(x[j], x[pivot]);
    }
    inverse[j] = 1.0 / K[j * kStride + j];
    for (int i = j + 1; i < size; ++i) {
      const double factor = K[j * kStride + i] * inverse[j];
      if (factor == 0.0) continue;
      for (int k = j + 1; k < size; ++k) K[k * kStride + i] -= factor * K[k * kStride + j];
      x[i] -= factor * x[j];
    }
  }

  for (int j = size - 1; j >= 0; --j) {
    for (int k = j + 1; k < size; ++k) x[j] -= K[k * kStride + j] * x[k];
    x[j] *= inverse[j];
  }

  return true;
}

/// Unknown forces of the modes and the rows that they meet: a normal force each, a tangential one
/// where it sticks.
int unknown_rows(const ContactSystem& s, const Touch* modes, int* rows) {
  int size = 0;
  for (int i = 0; i < s.count; ++i) {
    if (modes[i] == Touch::open) continue;
    if (modes[i] == Touch::stick && s.mu[i] >= 0.0) rows[size++] = 2 * i;
    rows[size++] = 2 * i + 1;
  }
  return size;
}

/// The equations of these rows, K x = ... ; returns the largest diagonal of A, or -1 where a
/// slipping contact is jammed.
double fill_equations(const ContactSystem& s, const Touch* modes, const int* rows, int size,
                      double* K, double* x) {
  double scale = 0.0;
  for (int k = 0; k < size; ++k) {
    const int column = rows[k], i = column / 2;
    const double friction = column % 2 == 1 && s.mu[i] >= 0.0 ? s.mu[i] * slip_sign(modes[i]) : 0.0;
    const double* a = s.A + column * kStride;
    for (int r = 0; r < size; ++r)
      K[k * kStride + r] =
          friction == 0.0 ? a[rows[r]] : a[rows[r]] - friction * a[rows[r] - kStride];
    x[k] = (column % 2 == 1 ? s.target[i] : 0.0) - s.b[column];
    scale = std::max(scale, std::abs(a[column]));
    if (friction != 0.0 && K[k * kStride + k] <= 0.0) return -1.0;
  }
  return scale;
}

}  // namespace

bool solve_forces(ContactSystem& s, const Touch* modes) {
  int rows[kStride];
  const int size = unknown_rows(s, modes, rows);
  double K[kStride * kStride], x[kStride];
  double scale = fill_equations(s, modes, rows, size, K, x);
  if (scale < 0.0) return false;
  if (!eliminate(K, x, size, scale)) {
    // More contacts than the robot has freedom: the forces are not unique, a slight compliance
    // chooses among them.
    scale = fill_equations(s, modes, rows, size, K, x);
    for (int k = 0; k < size; ++k) K[k * kStride + k] += 1e-10 * scale;
    if (!eliminate(K, x, size, 0.0)) return false;
  }

  std::fill(s.lambda, s.lambda + 2 * s.count, 0.0);
  for (int k = 0; k < size; ++k) {
    const int i = rows[k] / 2;
    s.lambda[rows[k]] = x[k];
    if (rows[k] % 2 == 1 && slip_sign(modes[i]) != 0.0)
      s.lambda[2 * i] = -s.mu[i] * slip_sign(modes[i]) * x[k];
  }

  for (int r = 0; r < 2 * s.count; ++r)
    if (!std::isfinite(s.lambda[r])) return false;
  return true;
}

bool solve_at(ContactSystem& s, const Touch* modes) {
  if (!solve_forces(s, modes)) return false;
  for (int r = 0; r < 2 * s.count; ++r) {
    double sum = s.b[r];
    for (int k = 0; k < 2 * s.count; ++k) sum += s.A[k * kStride + r] * s.lambda[k];
    s.w[r] = sum;
  }
  return true;
}

bool consistent(const ContactSystem& s, const Touch* modes) {
  const double force = kZero * s.scale_force, rate = kZero * s.scale_w;
  for (int i = 0; i < s.count; ++i) {
    const double normal = s.lambda[2 * i + 1], tangential = s.lambda[2 * i];
    if (modes[i] == Touch::open) {
      if (s.w[2 * i + 1] < s.target[i] - rate) return false;
      continue;
    }
    if (normal < -force) return false;
    // contacts at odds with each other
    if (std::abs(s.w[2 * i + 1] - s.target[i]) > 1e3 * rate) return false;
    if (s.mu[i] < 0.0) continue;
    if (modes[i] == Touch::stick) {
      if (std::abs(tangential) > s.mu[i] * normal + force) return false;
    } else if (!s.moving[i] && slip_sign(modes[i]) * s.w[2 * i] < -rate) {
      return false;
    }
  }

  return true;
}

bool find_modes(ContactSystem& s, Touch* modes, const Touch* excluded, int excluded_contact) {
  static constexpr Touch kOrder[4] = {Touch::stick, Touch::slip_plus, Touch::slip_minus,
                                      Touch::open};
  const auto allowed = [&](int i, Touch mode) {
    if (s.mu[i] < 0.0) return mode == Touch::open || mode == Touch::stick;
    if (!s.moving[i]) return true;
    return mode == Touch::open || slip_sign(mode) == s.direction[i];
  };
  const auto barred = [&](const Touch* m) {
    return excluded != nullptr && m[excluded_contact] == *excluded;
  };

  const auto try_at = [&](const Touch* m) { return solve_at(s, m) && consistent(s, m); };
  bool valid = true;
  for (int i = 0; i < s.count; ++i) valid = valid && allowed(i, modes[i]);
  if (valid && !barred(modes) && try_at(modes)) return true;

  long combinations = 1;
  for (int i = 0; i < s.count; ++i) combinations *= 4;
  for (int pass = 0; pass < (excluded == nullptr ? 1 : 2); ++pass) {
    for (long code = 0; code < combinations; ++code) {
      Touch trial[kMaxTouching] = {};
      bool fits = true;
      long rest = code;
      for (int i = 0; i < s.count && fits; ++i, rest /= 4) {
        trial[i] = kOrder[rest % 4];
        fits = allowed(i, trial[i]);
      }
      // excluded ones come in the second pass
      if (!fits || barred(trial) != (pass == 1) || !try_at(trial)) continue;
      std::copy(trial, trial + s.count, modes);
      return true;
    }
  }

  return false;
}

}  // namespace jaculus::simulation::detail
