#pragma once
// What first and second derivatives of the equations share.

#include "jaculus/components/equations.h"

namespace jaculus::components {

/// Columns of base translation, the first ones of J, are zero in D and E.
inline constexpr int kTranslation = 2;

/// out += scale * a^T b over the sparse columns of two points, from the given ones on.
template <class S>
JACULUS_INLINE void add_outer(const dynamics::PointColumnsOf<S>& a, int first_a,
                              const dynamics::PointColumnsOf<S>& b, int first_b, double scale,
                              MatrixOf<S>& out) {
  for (int j = first_b; j < b.count; ++j) {
    const S bx = S(scale) * b.x[j], bz = S(scale) * b.z[j];
    S* column = out.col(b.index[j]).data();
    for (int i = first_a; i < a.count; ++i) column[a.index[i]] += a.x[i] * bx + a.z[i] * bz;
  }
}

template <class S>
JACULUS_INLINE void put_rows(const dynamics::PointColumnsOf<S>& c, int row, MatrixOf<S>& out) {
  for (int k = 0; k < c.count; ++k) {
    out(row, c.index[k]) += c.x[k];
    out(row + 1, c.index[k]) += c.z[k];
  }
}

/// Columns of d(pdd)/dY = D(A) + E(V) and d(pdd)/dV = 2 D(V); an impact has no terms in the rates.
/// p.J holds the path's own columns.
template <class S>
JACULUS_INLINE void acceleration_columns(const dynamics::Path& path, const VectorOf<S>& A,
                                         EquationsPointOf<S>& p) {
  p.PY.take_pattern(p.J);
  p.PV.take_pattern(p.J);
  dynamics::add_D(path, p.motion.pose, A, 1.0, p.PY);
  if (p.impact) return;
  dynamics::add_E(path, p.motion.pose, p.motion.V, 1.0, p.PY);
  dynamics::add_D(path, p.motion.pose, p.motion.V, 2.0, p.PV);
}

template <class S>
JACULUS_INLINE Vec2Of<S> acceleration(const dynamics::Path& path, const EquationsPointOf<S>& p,
                                      const VectorOf<S>& A) {
  Vec2Of<S> sum = p.J.times(A);
  if (!p.impact) sum += dynamics::quadratic(path, p.motion.pose, p.motion.V);
  return sum;
}

/// The force on a body that goes with its acceleration: m (pdd - g).
template <class S>
JACULUS_INLINE Vec2Of<S> weight(const dynamics::AbsoluteTree& tree, std::size_t body,
                                const EquationsPointOf<S>& p) {
  Vec2Of<S> sum = acceleration(tree.com[body], p, p.A);
  if (!p.impact) sum.y() += S(tree.gravity);
  return S(tree.mass[body]) * sum;
}

}  // namespace jaculus::components
