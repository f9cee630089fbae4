#include "simulation/control/plan_voltage.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "jaculus/trajectory/quantity.h"

namespace jaculus::simulation {
namespace {

using trajectory::Quantity;

/// Share of the duty's size that the law may leave: columns are rounded, laws are not approximate.
constexpr double kLeft = 0.01;

/// Sums of the normal equations [R/U, 1/U], and of duty^2.
struct Sums {
  Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
  Vec2 right = Vec2::Zero();
  double duty2 = 0.0;
};

/// Adds a motor's samples; false where the plan lacks a column of it.
bool add_motor(const trajectory::Table& plan, const model::PlanarMotor& motor,
               const std::filesystem::path& file, Sums& sums) {
  const auto samples = [&](Quantity q) {
    const std::string name = channel_name(motor.joint, q);
    return plan.column(name) < 0
               ? Vector()
               : trajectory::quantity(plan, name, trajectory::dimensions_of(q).front(), file);
  };
  const Vector torque = samples(Quantity::torque), rate = samples(Quantity::velocity),
               duty = samples(Quantity::duty);
  if (torque.size() == 0 || rate.size() == 0 || duty.size() == 0) return false;

  for (Eigen::Index k = 0; k < duty.size(); ++k) {
    const double t = torque[k] / (motor.gear * motor.efficiency);
    const double i = t * (motor.saturation_linear + motor.saturation_cubic * t * t);
    const Vec2 row(i, motor.torque_constant * motor.gear * rate[k]);
    sums.normal += row * row.transpose();
    sums.right += row * duty[k];
    sums.duty2 += duty[k] * duty[k];
  }
  return true;
}

}  // namespace

std::optional<double> plan_voltage(const trajectory::Table& plan, const model::PlanarModel& model,
                                   const std::filesystem::path& file) {
  Sums sums;
  for (const model::PlanarMotor& motor : model.motors) {
    // A geared motor's torque at the joint may hold a margin for losses that the robot lacks.
    if (motor.ideal() || motor.gear != 1.0) continue;
    if (!add_motor(plan, motor, file, sums)) return {};
  }
  if (!(sums.duty2 > 0.0)) return {};

  const Vec2 x = sums.normal.ldlt().solve(sums.right);
  const double left = sums.duty2 - x.dot(sums.right);
  const bool fits = left < kLeft * kLeft * sums.duty2;  // false for NaN too
  if (!fits || !(x[1] > 0.0) || !(x[0] > 0.0)) return {};
  return 1.0 / x[1];
}

}  // namespace jaculus::simulation
