#pragma once
// Unilateral contacts with Coulomb friction at the level of accelerations (forces) or of rates
// (impulses).
//
// With the rows J of c contacts (tangential, normal), Delassus' matrix A = J M^-1 J^T and b = what
// w would be without contact,
//     w = A lambda + b,   0 <= lambda_n, w_n - target >= 0, one of them zero,
//     stick:  w_t = 0, |lambda_t| <= mu lambda_n;
//     slip s:  lambda_t = -mu s lambda_n, s w_t >= 0.
// (Forces: w accelerations, and s is given where the point moves already. Impulses: w rates after
// the impact, target = -e times the rate before it; dissipative for e = 0, since lambda . w <= 0:
// Moreau's law.) A joint's stop is a contact without friction.
//
// Few contacts touch at a time, so the consistent assignment of modes is looked for by enumeration,
// the likely ones first: it finds one wherever there is one, and says so where there is none
// (Painleve) or several (the first is taken).
// Source: Stewart and Trinkle 1996; Brogliato, Nonsmooth Mechanics, ch. 5 and 6.

#include <vector>

namespace jaculus::simulation::detail {

enum class Touch : unsigned char { open, stick, slip_plus, slip_minus };

/// Tangential direction of motion: +1, -1, or 0.
constexpr double slip_sign(Touch touch) {
  return touch == Touch::slip_plus ? 1.0 : (touch == Touch::slip_minus ? -1.0 : 0.0);
}

inline constexpr int kMaxTouching = 8;  ///< contacts that take part at a time
inline constexpr int kStride = 2 * kMaxTouching;

/// The rows and data of the contacts that take part; index 2 i is the tangential row of contact i,
/// 2 i + 1 the normal one.
struct ContactSystem {
  int count = 0;
  const double* A = nullptr;                ///< column by column, with stride kStride
  double b[kStride];                        ///< w without contact
  double mu[kMaxTouching];                  ///< negative: no friction at all, a stop
  double target[kMaxTouching];              ///< least w_n
  bool moving[kMaxTouching];                ///< slides already: only open and slip by `direction`
  double direction[kMaxTouching];           ///< +1 or -1, of what is moving
  double lambda[kStride];                   ///< of the last solution
  double w[kStride];                        ///< of the last solution of solve_at()
  double scale_force = 1.0, scale_w = 1.0;  ///< what counts as zero is 1e-9 times these
};

/// Solves for lambda at given modes. False where the system is singular or a slipping contact is
/// jammed.
bool solve_forces(ContactSystem& system, const Touch* modes);
/// The same, and w.
bool solve_at(ContactSystem& system, const Touch* modes);
/// Whether the solution obeys the laws.
bool consistent(const ContactSystem& system, const Touch* modes);
/// Finds consistent modes, `modes` the first guess and then the result, never `excluded` (null:
/// nothing is) unless there is no other. False where there are none.
bool find_modes(ContactSystem& system, Touch* modes, const Touch* excluded, int excluded_contact);

}  // namespace jaculus::simulation::detail
