#pragma once
// Four numbers that go through the same arithmetic: the scalar of code that is a template of it, so
// that four points of a plan are evaluated at once. Every operation is that of doubles, lane by
// lane, without fused ones: the bits are those of any machine, whether four lanes are one register
// (AVX2) or two.
//
// Code that knows no lanes takes them one at a time, by lane() and set_lane(), which of a double
// are the double itself.

#include <cmath>
#include <type_traits>

#include "jaculus/core/types.h"
#include "jaculus/core/wide.h"

namespace jaculus {

inline constexpr int kLanes = 4;

/// kLanes doubles. In memory an array, so that it is passed alike by code for any processor.
struct Lanes {
  double value[kLanes];

  Lanes() = default;
  JACULUS_INLINE Lanes(double all);  // NOLINT(google-explicit-constructor): a constant in formulae
  // By the whole register: what compilers copy in halves is slow to read back at once.
  JACULUS_INLINE Lanes(const Lanes& from);
  JACULUS_INLINE Lanes& operator=(const Lanes& from);
};

/// A register of them, or two; memory may hold it at any double.
using LanesRegister [[gnu::vector_size(kLanes * sizeof(double)), gnu::aligned(alignof(double))]] =
    double;

JACULUS_INLINE LanesRegister& as_register(Lanes& x) {
  return *reinterpret_cast<LanesRegister*>(x.value);
}
JACULUS_INLINE const LanesRegister& as_register(const Lanes& x) {
  return *reinterpret_cast<const LanesRegister*>(x.value);
}

JACULUS_INLINE Lanes::Lanes(const Lanes& from) { as_register(*this) = as_register(from); }
JACULUS_INLINE Lanes& Lanes::operator=(const Lanes& from) {
  as_register(*this) = as_register(from);
  return *this;
}
JACULUS_INLINE Lanes::Lanes(double all) { as_register(*this) = LanesRegister{} + all; }

JACULUS_INLINE Lanes operator+(const Lanes& a, const Lanes& b) {
  Lanes c;
  as_register(c) = as_register(a) + as_register(b);
  return c;
}
JACULUS_INLINE Lanes operator-(const Lanes& a, const Lanes& b) {
  Lanes c;
  as_register(c) = as_register(a) - as_register(b);
  return c;
}
JACULUS_INLINE Lanes operator*(const Lanes& a, const Lanes& b) {
  Lanes c;
  as_register(c) = as_register(a) * as_register(b);
  return c;
}
JACULUS_INLINE Lanes operator/(const Lanes& a, const Lanes& b) {
  Lanes c;
  as_register(c) = as_register(a) / as_register(b);
  return c;
}
JACULUS_INLINE Lanes operator-(const Lanes& a) {
  Lanes c;
  as_register(c) = -as_register(a);
  return c;
}
JACULUS_INLINE Lanes& operator+=(Lanes& a, const Lanes& b) { return a = a + b; }
JACULUS_INLINE Lanes& operator-=(Lanes& a, const Lanes& b) { return a = a - b; }
JACULUS_INLINE Lanes& operator*=(Lanes& a, const Lanes& b) { return a = a * b; }

/// How many numbers a scalar stands for.
template <class S>
inline constexpr int lanes_of = 1;
template <>
inline constexpr int lanes_of<Lanes> = kLanes;

JACULUS_INLINE double lane(double x, int) { return x; }
JACULUS_INLINE double lane(const Lanes& x, int k) { return x.value[k]; }
JACULUS_INLINE void set_lane(double& x, int, double value) { x = value; }
JACULUS_INLINE void set_lane(Lanes& x, int k, double value) { x.value[k] = value; }

/// A function of doubles, of every lane.
template <class S, class Function>
JACULUS_INLINE S by_lane(const S& x, Function&& function) {
  S result;
  for (int k = 0; k < lanes_of<S>; ++k) set_lane(result, k, function(lane(x, k)));
  return result;
}

template <class S>
JACULUS_INLINE S root(const S& x) {
  return by_lane(x, [](double value) { return std::sqrt(value); });
}

template <class S>
[[nodiscard]] bool all_finite(const S& x) {
  for (int k = 0; k < lanes_of<S>; ++k)
    if (!std::isfinite(lane(x, k))) return false;
  return true;
}

template <class S>
using Vec2Of = Eigen::Matrix<S, 2, 1>;
template <class S>
using VectorOf = Eigen::Matrix<S, Eigen::Dynamic, 1>;
template <class S>
using MatrixOf = Eigen::Matrix<S, Eigen::Dynamic, Eigen::Dynamic>;
template <class S>
using RefOf = Eigen::Ref<MatrixOf<S>>;
template <class S>
using ConstRefOf = Eigen::Ref<const MatrixOf<S>>;
/// A vector that does not settle what S is.
template <class S>
using VectorArg = const std::type_identity_t<Eigen::Ref<const VectorOf<S>>>&;

}  // namespace jaculus

namespace Eigen {

template <>
struct NumTraits<jaculus::Lanes> : GenericNumTraits<jaculus::Lanes> {
  using Real = jaculus::Lanes;
  using NonInteger = jaculus::Lanes;
  using Nested = jaculus::Lanes;
  using Literal = double;
  enum {
    IsComplex = 0,
    IsInteger = 0,
    IsSigned = 1,
    RequireInitialization = 0,
    ReadCost = 1,
    AddCost = 1,
    MulCost = 1
  };
};

}  // namespace Eigen
