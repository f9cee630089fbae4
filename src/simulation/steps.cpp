// Steps of a simulation: which method takes them, whether they are accepted, and their dense output.

#include <algorithm>
#include <cmath>

#include "simulation/simulator.h"

namespace jaculus::detail {

namespace {

constexpr double kShortestStep = 1e-13;   ///< [s]
constexpr double kMostEvaluations = 5e5;  ///< of the equations, and
constexpr double kMostRate = 4e6;         ///< so many more a second of motion: a thousand times what a leap takes
constexpr int kPause = 16;                ///< steps for which the short method rests after one that it could not take

}  // namespace

/// One accepted step that ends at `limit` or before, its events handled.
bool Simulator::step(double limit) {
  while (!attempt(limit)) {
    if (h_ >= kShortestStep) continue;
    return fail(broken_ ? SimulationStatus::singular : SimulationStatus::diverged,
                (broken_ ? "the equations of motion are singular" : "the motion diverges: no step is short enough") +
                    equations_.beyond_range(y_.data()));
  }
  if (static_cast<double>(equations_.evaluations) > kMostEvaluations + kMostRate * options_.duration)
    return fail(SimulationStatus::diverged,
                "the motion asks for ever shorter steps" + equations_.beyond_range(y_.data()));
  return handle_events();
}

bool Simulator::derive(double t, const State& y, State& dydt) {
  if (!broken_ && !equations_.evaluate(t, y.data(), dydt.data())) {
    broken_ = true;
    std::fill(dydt.begin(), dydt.end(), 0.0);
  }
  return !broken_;
}

/// Largest error of the step beside its tolerance.
double Simulator::worst_error() {
  double worst = 0.0;
  for (size_t i = 0; i < y_.size(); ++i) {
    const double size = std::max(std::abs(y_[i]), std::abs(y_new_[i]));
    worst = std::max(worst, std::abs(error_[i]) / (options_.absolute_tolerance + options_.relative_tolerance * size));
    if (!std::isfinite(error_[i]) || !std::isfinite(y_new_[i])) broken_ = true;
  }
  return worst;
}

/// Kutta's method over the whole of `step_`. False where it errs by more than the tolerance: nothing is lost but the time.
bool Simulator::attempt_short() {
  short_ = true;
  const double h = step_;
  const auto stage = [&](double share, const State& slope) {
    for (size_t i = 0; i < y_.size(); ++i) y_stage_[i] = y_[i] + share * h * slope[i];
  };
  stage(0.5, dydt_);
  if (!derive(t_ + 0.5 * h, y_stage_, k2_)) return false;
  stage(0.5, k2_);
  if (!derive(t_ + 0.5 * h, y_stage_, k3_)) return false;
  stage(1.0, k3_);
  if (!derive(t_ + h, y_stage_, k4_)) return false;
  for (size_t i = 0; i < y_.size(); ++i) y_new_[i] = y_[i] + h / 6.0 * (dydt_[i] + 2.0 * (k2_[i] + k3_[i]) + k4_[i]);
  if (!derive(t_ + h, y_new_, dydt_new_)) return false;
  for (size_t i = 0; i < y_.size(); ++i) error_[i] = h / 6.0 * (k4_[i] - dydt_new_[i]);
  return worst_error() <= 1.0 && !broken_;
}

bool Simulator::attempt(double limit) {
  const double left = limit - t_;
  const bool whole = h_ > 0.999 * left;
  step_ = whole ? left : (h_ > 0.5 * left ? 0.5 * left : h_);
  broken_ = false;
  if (whole && pause_ == 0) {
    if (attempt_short()) {
      t_new_ = limit;
      return true;
    }
    pause_ = kPause;
    broken_ = false;
  }
  pause_ = std::max(0, pause_ - 1);
  short_ = false;
  stepper_.do_step([this](const State& y, State& dydt, double t) { derive(t, y, dydt); }, y_, dydt_, t_, y_new_,
                   dydt_new_, step_, error_);
  const double worst = worst_error();
  if (broken_) {
    h_ = 0.2 * step_;
    return false;
  }
  const double factor = worst == 0.0 ? 5.0 : std::clamp(0.9 * std::pow(worst, -0.2), 0.2, 5.0);
  if (worst > 1.0) {
    h_ = step_ * std::min(0.9, factor);
    return false;
  }
  h_ = step_ < h_ ? std::max(h_, factor * step_) : factor * step_;
  t_new_ = whole ? limit : t_ + step_;
  return true;
}

/// Within the step: Dormand and Prince's interpolant of order four, or the cubic through both ends and their slopes.
void Simulator::dense(double t, State& out) {
  if (!short_) return stepper_.calc_state(t, out, y_, dydt_, t_, y_new_, dydt_new_, t_ + step_);
  const double s = (t - t_) / step_, c = 1.0 - s;
  const double to = s * s * (3.0 - 2.0 * s), slope = s * c * c * step_, slope_new = -s * s * c * step_;
  for (size_t i = 0; i < y_.size(); ++i)
    out[i] = y_[i] + to * (y_new_[i] - y_[i]) + slope * dydt_[i] + slope_new * dydt_new_[i];
}

}  // namespace jaculus::detail
