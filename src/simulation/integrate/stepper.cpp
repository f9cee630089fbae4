#include "simulation/integrate/stepper.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "jaculus/core/types.h"

namespace jaculus::simulation::detail {

namespace {

constexpr double kShortestStep = 1e-13;  ///< [s]
constexpr double kRestart = 1e-4;        ///< length to start with after an event [s]
/// Dormand and Prince's method is stable up to this length times the fastest rate (Hairer and
/// Wanner II, section IV.2).
constexpr double kStable = 3.3;
/// Of the first difference of slopes, beyond which the second one is no smooth motion's: a tenth of
/// what an explicit method is stable for.
constexpr double kSmooth = 0.15;
constexpr double kDormandPrince = 6.0;  ///< evaluations of a step
/// Steps for which the implicit method rests after one that did not pay: what settles after inputs
/// have jumped takes explicit ones as many. Measured: of 2, 4, 8, 16, 32 the evaluations of a leap
/// with dry friction are least by 2 and 4 (a tenth less than by 32).
constexpr int kImplicitPause = 4;
/// steps for which Kutta's method rests after one that it could not take
constexpr int kPause = 16;
/// Rates, in widths of the smoothed sign, beyond which it is 1 but for 1e-5; and by how many it may
/// move within a step on this side of it.
constexpr double kEdge = 6.0, kWidths = 2.0;

}  // namespace

Stepper::Stepper(double relative_tolerance, double absolute_tolerance, int coordinates, int states,
                 FastSlopes slopes)
    : relative_tolerance_(relative_tolerance),
      absolute_tolerance_(states, absolute_tolerance),
      slopes_(std::move(slopes)) {
  for (int i = coordinates; i < 2 * coordinates; ++i)
    absolute_tolerance_[i] *= ImplicitMethod::kGrantedRate;
  for (State* s : {&error_, &y_stage_, &k2_, &k3_, &k4_}) s->assign(states, 0.0);
}

void Stepper::restart() {
  next_length_ = std::max(next_length_, kRestart);
  implicit_length_ = std::max(implicit_length_, kRestart);
}

StepResult Stepper::take(const RightHandSide& f, double limit, Step& step) {
  step.y_end.resize(step.y.size());
  step.dydt_end.resize(step.y.size());
  // Once the equations have failed, the attempt is lost and the rest of its stages without use.
  const RightHandSide guarded = [&](double t, const State& y, State& dydt) {
    if (!broken_ && !f(t, y, dydt)) {
      broken_ = true;
      std::fill(dydt.begin(), dydt.end(), 0.0);
    }
    return !broken_;
  };

  while (!attempt(guarded, limit, step))
    if (next_length_ < kShortestStep)
      return broken_ ? StepResult::equations_fail : StepResult::no_step_is_short_enough;
  return StepResult::accepted;
}

/// Largest error of the step beside its tolerance.
double Stepper::worst_error(const Step& step) {
  double worst = 0.0;
  for (std::size_t i = 0; i < step.y.size(); ++i) {
    const double size = std::max(std::abs(step.y[i]), std::abs(step.y_end[i]));
    worst = std::max(worst,
                     std::abs(error_[i]) / (absolute_tolerance_[i] + relative_tolerance_ * size));
    if (!std::isfinite(error_[i]) || !std::isfinite(step.y_end[i])) broken_ = true;
  }
  return worst;
}

/// Whether the second slope at the middle of a step differs from the first by more than a smooth
/// motion's does, which is of the next order: a joint that breaks away or turns back within a step
/// may show in neither of the two slopes that the error is told by.
bool Stepper::bends(const Step& step) const {
  if (fast_ == nullptr || fast_->parts.empty()) return false;
  for (std::size_t i = 0; i < step.y.size(); ++i) {
    const double first = std::abs(k2_[i] - step.dydt[i]), second = std::abs(k3_[i] - k2_[i]);
    const double granted = absolute_tolerance_[i] + relative_tolerance_ * std::abs(step.y[i]);
    if (second > kSmooth * first && step.length / 6.0 * second > granted) return true;
  }
  return false;
}

/// Over the whole of the step's length. False where it errs by more than the tolerance: nothing is
/// lost but the time.
bool Stepper::attempt_kutta(const RightHandSide& f, Step& step) {
  step.method = Method::kutta;
  const double t = step.t, h = step.length;
  const State &y = step.y, &k1 = step.dydt;
  const auto stage = [&](double share, const State& slope) {
    for (std::size_t i = 0; i < y.size(); ++i) y_stage_[i] = y[i] + share * h * slope[i];
  };

  stage(0.5, k1);
  if (!f(t + 0.5 * h, y_stage_, k2_)) return false;
  stage(0.5, k2_);
  if (!f(t + 0.5 * h, y_stage_, k3_) || bends(step)) return false;
  stage(1.0, k3_);
  if (!f(t + h, y_stage_, k4_)) return false;
  for (std::size_t i = 0; i < y.size(); ++i)
    step.y_end[i] = y[i] + h / 6.0 * (k1[i] + 2.0 * (k2_[i] + k3_[i]) + k4_[i]);
  if (!f(t + h, step.y_end, step.dydt_end)) return false;

  for (std::size_t i = 0; i < y.size(); ++i) error_[i] = h / 6.0 * (k4_[i] - step.dydt_end[i]);
  return worst_error(step) <= 1.0 && !broken_;
}

/// Sets the step's length: all that is left, half of it, or the next one.
bool Stepper::set_length(double next, double left, Step& step) {
  const bool whole = next > 0.999 * left;
  step.length = whole ? left : (next > 0.5 * left ? 0.5 * left : next);
  return whole;
}

/// Length from which an implicit step takes fewer evaluations than the explicit ones that are
/// stable.
double Stepper::paying_length() const {
  return ImplicitMethod::kEvaluations / kDormandPrince * kStable / fastest_rate_;
}

/// Steps that don't pay are left to the explicit methods for a while.
bool Stepper::attempt_implicit(const RightHandSide& f, double limit, double least, Step& step) {
  step.method = Method::implicit;
  const bool whole = set_length(std::max(least, implicit_length_), limit - step.t, step);
  implicit_.take(f, *fast_, slopes_, step, error_);
  const bool accepted = accept(3.0, implicit_length_, step);
  if (implicit_length_ < least) implicit_pause_ = kImplicitPause;
  if (accepted) step.end = whole ? limit : step.t + step.length;
  return accepted;
}

/// The longest step that ends where a joint's dry friction begins to turn, or within which it turns
/// by a part: what lies beyond does not show in slopes on this side. The joint's acceleration where
/// the step starts tells.
double Stepper::turning_length(const Step& step) const {
  double longest = kInfinity;
  if (fast_ == nullptr) return longest;
  for (const FastPart& part : fast_->parts) {
    if (part.width == 0.0) continue;
    const double acceleration = dot(part.row, step.dydt.data() + fast_->size, fast_->size);
    const double beyond = std::abs(part.speed) - kEdge * part.width;
    if (beyond > 0.0 && acceleration * part.speed >= 0.0) continue;
    const double way = std::max(beyond, 0.0) + kWidths * part.width;
    longest = std::min(longest, way / std::abs(acceleration));
  }
  return longest;
}

bool Stepper::attempt(const RightHandSide& f, double limit, Step& step) {
  broken_ = false;
  const double least = paying_length(), left = limit - step.t;
  if (implicit_pause_ == 0 && least < left) return attempt_implicit(f, limit, least, step);

  implicit_pause_ = std::max(0, implicit_pause_ - 1);
  const bool whole = set_length(std::min(next_length_, turning_length(step)), left, step);
  if (whole && pause_ == 0) {
    if (attempt_kutta(f, step)) {
      step.end = limit;
      return true;
    }
    pause_ = kPause;
    broken_ = false;
  }

  pause_ = std::max(0, pause_ - 1);
  step.method = Method::dormand_prince;
  dopri5_.do_step([&](const State& y, State& dydt, double t) { f(t, y, dydt); }, step.y, step.dydt,
                  step.t, step.y_end, step.dydt_end, step.length, error_);
  if (!accept(5.0, next_length_, step)) return false;
  step.end = whole ? limit : step.t + step.length;
  return true;
}

/// Whether error_ is within the tolerance; sets how long the next step of a method of this order
/// may be.
bool Stepper::accept(double order, double& next, const Step& step) {
  const double worst = worst_error(step);
  if (broken_) {
    next = 0.2 * step.length;
    return false;
  }

  const double factor =
      worst == 0.0 ? 5.0 : std::clamp(0.9 * std::pow(worst, -1.0 / order), 0.2, 5.0);
  if (worst > 1.0) {
    next = step.length * std::min(0.9, factor);
    return false;
  }

  // A step that a limit cut short says little about the next.
  const bool cut = step.length < next;
  next = cut ? std::max(next, factor * step.length) : factor * step.length;
  return true;
}

void Stepper::state_at(const RightHandSide& f, const Step& step, double t, State& out) {
  if (step.method != Method::implicit || t <= step.t) {
    dense(step, t, out);
    return;
  }
  Step part = step;
  part.length = t - step.t;
  implicit_.take(f, *fast_, slopes_, part, error_);
  out = part.y_end;
}

/// The interpolant of the step's method; Kutta's is the cubic through both ends and their slopes.
void Stepper::dense(const Step& step, double t, State& out) {
  if (step.method == Method::implicit) {
    implicit_.dense(step, t, out);
    return;
  }
  if (step.method == Method::dormand_prince) {
    dopri5_.calc_state(t, out, step.y, step.dydt, step.t, step.y_end, step.dydt_end,
                       step.t + step.length);
    return;
  }

  const double s = (t - step.t) / step.length, c = 1.0 - s;
  const double to = s * s * (3.0 - 2.0 * s), slope = s * c * c * step.length,
               slope_end = -s * s * c * step.length;
  for (std::size_t i = 0; i < step.y.size(); ++i)
    out[i] = step.y[i] + to * (step.y_end[i] - step.y[i]) + slope * step.dydt[i] +
             slope_end * step.dydt_end[i];
}

}  // namespace jaculus::simulation::detail
