#pragma once
// The drag coefficient of a tail from a bench on which a motor spins it.
//
// Steady speed: what goes in is lost in the winding or in the air (section IV of Norby et al.
// 2021),
//   V i = R i^2 + tau omega      so      tau = (V i - R i^2) / omega
// Transient log (powered or coasting, V and i zero then): over a window from t1 to t2, I the
// inertia of all that turns,
//   Int (V i - R i^2) dt = I (omega2^2 - omega1^2)/2 + Int tau |omega| dt
// and with tau = b omega^2 + c |omega| + d (drag, viscous, Coulomb) both kinds are linear
// regressions:
//   y = b q + c v + d     steady: y = tau, q = omega^2, v = |omega|
//                         transient: y = (Int P dt - Delta E)/A, q = Int |omega|^3 dt/A,
//                                    v = Int omega^2 dt/A, A = Int |omega| dt,
//                                    P = V i - R i^2, Delta E = I (omega2^2 - omega1^2)/2
//   C_D = 8 b / (rho w (L^4 - L0^4))     (equation 2)
//
// Four models are fitted: drag alone, with viscous, with Coulomb, with both. They are ranked by the
// corrected information criterion AICc; those within 2 of the best can't be told apart by the data,
// and the simplest of them is taken. A model with a negative share is never taken. Intervals are
// Student's, for errors of equal size in y. Integrals are by the trapezoidal rule: the log must be
// sampled densely against the change of speed.

#include <string>
#include <vector>

#include "jaculus/core/types.h"

namespace jaculus::studies {

/// One steady point; speed of the tail.
struct BenchPoint {
  double voltage = 0.0;  ///< [V]
  double current = 0.0;  ///< [A]
  double speed = 0.0;    ///< [rad/s], not zero
};

/// One line of the regression.
struct DragObservation {
  double torque = 0.0;     ///< y [N m]
  double quadratic = 0.0;  ///< q [rad^2/s^2]
  double viscous = 0.0;    ///< v [rad/s]
};

/// A coefficient with its confidence interval; all NaN where the model hasn't got it.
struct Estimate {
  double value = kNaN;
  double low = kNaN;
  double high = kNaN;
};

struct DragFit {
  std::string model;   ///< "drag", "drag + viscous", "drag + Coulomb", "drag + viscous + Coulomb"
  Estimate quadratic;  ///< b [N m s^2/rad^2]
  Estimate viscous;    ///< c [N m s/rad]
  Estimate coulomb;    ///< d [N m]
  double r_squared = kNaN;  ///< about the mean of y
  double residual = kNaN;   ///< standard deviation of the residuals [N m]
  double aicc = kNaN;       ///< infinite where there are too few points for it
  double condition = kNaN;  ///< of the regression, columns scaled to unit length
  bool physical = true;     ///< no negative share
  bool plausible = false;   ///< within 2 of the best AICc
};

struct DragFits {
  /// those for which there are more points than unknowns, simplest first
  std::vector<DragFit> fits;
  int taken = -1;  ///< index into fits
  /// what the data can't tell, what is negative, what was left out
  std::vector<std::string> notes;
};

/// Steady points to observations. Each must have a speed and more power than loss (bench_fault).
std::vector<DragObservation> steady_observations(const std::vector<BenchPoint>& points,
                                                 double resistance);

/// Why a point can't be used, or empty.
std::string bench_fault(const BenchPoint& point, double resistance);

/// A transient log to observations, one a window of about `window` seconds [s]; windows in which
/// the tail turns round or rests are left out. `power` V i - R i^2 [W] as sampled; times rise.
std::vector<DragObservation> transient_observations(const std::vector<double>& time,
                                                    const std::vector<double>& speed,
                                                    const std::vector<double>& power,
                                                    double inertia, double window);

/// All models. Needs two observations or more and 0 < confidence < 1.
DragFits fit_drag(const std::vector<DragObservation>& observations, double confidence);

/// C_D of a fitted b for a tail of these dimensions.
Estimate drag_coefficient(const Estimate& quadratic, double density, double width, double shaft,
                          double length);

}  // namespace jaculus::studies
