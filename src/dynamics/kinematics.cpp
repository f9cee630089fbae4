#include "jaculus/dynamics/kinematics.h"

#include <cmath>

namespace jaculus::dynamics {

namespace {

template <class S>
struct Direction {
  S ex, ez;  // R(phi) r
  S px, pz;  // dR/dphi r
};

template <class S>
JACULUS_INLINE Direction<S> rotate(const Segment& s, const PoseOf<S>& pose) {
  const S c = pose.cosine[s.angle], n = pose.sine[s.angle];
  const S ex = c * s.vector.x() + n * s.vector.y();
  const S ez = c * s.vector.y() - n * s.vector.x();
  return {ex, ez, ez, -ex};
}

}  // namespace

template <class S>
void PointColumnsOf<S>::take_pattern(const PointColumnsOf& from) {
  count = from.count;
  for (int k = 0; k < count; ++k) {
    index[k] = from.index[k];
    x[k] = z[k] = S(0.0);
  }
}

template <class S>
JACULUS_WIDE Vec2Of<S> PointColumnsOf<S>::times(const VectorOf<S>& v) const {
  S sx = S(0.0), sz = S(0.0);
  for (int k = 0; k < count; ++k) {
    sx += x[k] * v[index[k]];
    sz += z[k] * v[index[k]];
  }
  return {sx, sz};
}

template <class S>
JACULUS_WIDE void PointColumnsOf<S>::add_transposed(const Vec2Of<S>& w, double scale,
                                                    VectorOf<S>& out) const {
  for (int k = 0; k < count; ++k) out[index[k]] += S(scale) * (x[k] * w.x() + z[k] * w.y());
}

template <class S>
void PoseOf<S>::set(const AbsoluteTree& tree) {
  // Angles and displacements share one vector; a displacement's sine is never read.
  for (int i = 2; i < tree.N; ++i) set_angle(i);
}

template <class S>
void PoseOf<S>::set_angle(int i) {
  for (int k = 0; k < lanes_of<S>; ++k) {
    set_lane(cosine[i], k, std::cos(lane(Y[i], k)));
    set_lane(sine[i], k, std::sin(lane(Y[i], k)));
  }
}

template <class S>
JACULUS_WIDE Vec2Of<S> position(const Path& path, const PoseOf<S>& pose) {
  S px = pose.Y[0], pz = pose.Y[1];
  for (const Segment& s : path) {
    const Direction<S> d = rotate(s, pose);
    const S l = s.slider < 0 ? S(1.0) : pose.Y[s.slider];
    px += l * d.ex;
    pz += l * d.ez;
  }
  return {px, pz};
}

template <class S>
JACULUS_WIDE void jacobian_columns(const Path& path, const PoseOf<S>& pose, PointColumnsOf<S>& J) {
  J.clear();
  J.add(0, S(1.0), S(0.0));
  J.add(1, S(0.0), S(1.0));
  for (const Segment& s : path) {
    const Direction<S> d = rotate(s, pose);
    if (s.slider < 0) {
      J.add(s.angle, d.px, d.pz);
    } else {
      const S l = pose.Y[s.slider];
      J.add(s.angle, l * d.px, l * d.pz);
      J.add(s.slider, d.ex, d.ez);
    }
  }
}

template <class S>
JACULUS_WIDE void add_D(const Path& path, const PoseOf<S>& pose, const VectorOf<S>& X, double scale,
                        PointColumnsOf<S>& out) {
  int k = 2;
  for (const Segment& s : path) {
    const Direction<S> d = rotate(s, pose);
    const S rate = S(scale) * X[s.angle];
    if (s.slider < 0) {
      out.x[k] -= rate * d.ex;
      out.z[k] -= rate * d.ez;
      ++k;
    } else {
      const S l = pose.Y[s.slider], slide = scale * X[s.slider];
      out.x[k] += -l * rate * d.ex + slide * d.px;
      out.z[k] += -l * rate * d.ez + slide * d.pz;
      out.x[k + 1] += rate * d.px;
      out.z[k + 1] += rate * d.pz;
      k += 2;
    }
  }
}

template <class S>
JACULUS_WIDE void add_E(const Path& path, const PoseOf<S>& pose, const VectorOf<S>& V, double scale,
                        PointColumnsOf<S>& out) {
  int k = 2;
  for (const Segment& s : path) {
    const Direction<S> d = rotate(s, pose);
    const S rate = V[s.angle], square = scale * rate * rate;
    if (s.slider < 0) {
      out.x[k] -= square * d.px;
      out.z[k] -= square * d.pz;
      ++k;
    } else {
      const S l = pose.Y[s.slider], cross = 2.0 * scale * rate * V[s.slider];
      out.x[k] += -l * square * d.px - cross * d.ex;
      out.z[k] += -l * square * d.pz - cross * d.ez;
      out.x[k + 1] -= square * d.ex;
      out.z[k + 1] -= square * d.ez;
      k += 2;
    }
  }
}

template <class S>
JACULUS_WIDE Vec2Of<S> quadratic(const Path& path, const PoseOf<S>& pose, const VectorOf<S>& V) {
  S sx = S(0.0), sz = S(0.0);
  for (const Segment& s : path) {
    const Direction<S> d = rotate(s, pose);
    const S rate = V[s.angle];
    const S l = s.slider < 0 ? S(1.0) : pose.Y[s.slider];
    const S cross = s.slider < 0 ? S(0.0) : 2.0 * rate * V[s.slider];
    sx += -l * rate * rate * d.ex + cross * d.px;
    sz += -l * rate * rate * d.ez + cross * d.pz;
  }
  return {sx, sz};
}

namespace {

template <class S>
JACULUS_INLINE void add_block(const Segment& s, const S& angle_angle, const S& angle_slider,
                              MatrixOf<S>& out) {
  out(s.angle, s.angle) += angle_angle;
  if (s.slider >= 0) {
    out(s.angle, s.slider) += angle_slider;
    out(s.slider, s.angle) += angle_slider;
  }
}

}  // namespace

template <class S>
JACULUS_WIDE void add_H(const Path& path, const PoseOf<S>& pose, Vec2Arg<S> w, MatrixOf<S>& out) {
  for (const Segment& s : path) {
    const Direction<S> d = rotate(s, pose);
    const S we = w.x() * d.ex + w.y() * d.ez, wp = w.x() * d.px + w.y() * d.pz;
    const S l = s.slider < 0 ? S(1.0) : pose.Y[s.slider];
    add_block(s, S(-l * we), wp, out);
  }
}

template <class S>
JACULUS_WIDE void add_T(const Path& path, const PoseOf<S>& pose, Vec2Arg<S> w, const VectorOf<S>& X,
                        MatrixOf<S>& out) {
  for (const Segment& s : path) {
    const Direction<S> d = rotate(s, pose);
    const S we = w.x() * d.ex + w.y() * d.ez, wp = w.x() * d.px + w.y() * d.pz;
    const S rate = X[s.angle];
    if (s.slider < 0) {
      add_block(s, S(-rate * wp), S(0.0), out);
    } else {
      add_block(s, S(-pose.Y[s.slider] * wp * rate - we * X[s.slider]), S(-we * rate), out);
    }
  }
}

template <class S>
JACULUS_WIDE void add_F(const Path& path, const PoseOf<S>& pose, Vec2Arg<S> w, const VectorOf<S>& V,
                        MatrixOf<S>& out) {
  for (const Segment& s : path) {
    const Direction<S> d = rotate(s, pose);
    const S we = w.x() * d.ex + w.y() * d.ez, wp = w.x() * d.px + w.y() * d.pz;
    const S rate = V[s.angle], square = rate * rate;
    if (s.slider < 0) {
      add_block(s, S(square * we), S(0.0), out);
    } else {
      add_block(s, S(pose.Y[s.slider] * we * square - 2.0 * wp * rate * V[s.slider]),
                S(-wp * square), out);
    }
  }
}

#define JACULUS_INSTANTIATE(S)                                                       \
  template struct PointColumnsOf<S>;                                                 \
  template struct PoseOf<S>;                                                         \
  template Vec2Of<S> position(const Path&, const PoseOf<S>&);                        \
  template void jacobian_columns(const Path&, const PoseOf<S>&, PointColumnsOf<S>&); \
  template void add_D(const Path&, const PoseOf<S>&, const VectorOf<S>&, double,     \
                      PointColumnsOf<S>&);                                           \
  template void add_E(const Path&, const PoseOf<S>&, const VectorOf<S>&, double,     \
                      PointColumnsOf<S>&);                                           \
  template Vec2Of<S> quadratic(const Path&, const PoseOf<S>&, const VectorOf<S>&);   \
  template void add_H(const Path&, const PoseOf<S>&, Vec2Arg<S>, MatrixOf<S>&);      \
  template void add_T(const Path&, const PoseOf<S>&, Vec2Arg<S>, const VectorOf<S>&, \
                      MatrixOf<S>&);                                                 \
  template void add_F(const Path&, const PoseOf<S>&, Vec2Arg<S>, const VectorOf<S>&, MatrixOf<S>&);

JACULUS_INSTANTIATE(double)
JACULUS_INSTANTIATE(Lanes)
#undef JACULUS_INSTANTIATE

}  // namespace jaculus::dynamics
