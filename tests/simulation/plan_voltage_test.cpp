#include "simulation/control/plan_voltage.h"

#include <gtest/gtest.h>

#include <cmath>

#include "jaculus/model/robot.h"
#include "jaculus/simulation/controller.h"
#include "support/shared_data.h"

namespace jaculus::simulation {
namespace {

using trajectory::Table;

model::PlanarModel minitaur() {
  return model::read_robot(model::find_robot("minitaur", "")).planar;
}

/// A made-up motion of all motors, its duty by R = 0.3 ohm as a share of `volts`.
Table plan_of(const model::PlanarModel& model, double volts) {
  Table plan;
  plan.columns.push_back({"time", "s"});
  const Vector time = Vector::LinSpaced(21, 0.0, 0.2);
  plan.values = time;
  const auto add = [&](const std::string& name, const std::string& unit, const Vector& values) {
    plan.columns.push_back({name, unit});
    plan.values.conservativeResize(Eigen::NoChange, plan.values.cols() + 1);
    plan.values.rightCols(1) = values;
  };
  for (const model::PlanarMotor& m : model.motors) {
    const Vector torque = 2.0 * (20.0 * time.array()).cos(), rate = 100.0 * time;
    const Vector current =
        torque.array() * (m.saturation_linear + m.saturation_cubic * torque.array().square());
    add(m.joint, "rad", 50.0 * time.array().square() + 1.0);
    add(m.joint + "_velocity", "rad/s", rate);
    add(m.joint + "_torque", "N m", torque);
    add(m.joint + "_duty", "-", (0.3 * current + m.torque_constant * rate) / volts);
  }
  return plan;
}

TEST(PlanVoltage, FollowsFromDutyTorqueAndRateWhateverTheWindingsResistance) {
  const model::PlanarModel model = minitaur();
  for (const double volts : {7.0, 12.0})
    EXPECT_NEAR(plan_voltage(plan_of(model, volts), model, "plan.csv").value_or(0.0), volts, 1e-9);
}

TEST(PlanVoltage, IsUnknownWithoutTorquesOrWhereTheLawDoesNotHold) {
  const model::PlanarModel model = minitaur();
  Table plan = plan_of(model, 7.0);
  const int torque = plan.column("rear_a_torque"), duty = plan.column("rear_a_duty");
  plan.values(5, duty) += 0.2;
  EXPECT_FALSE(plan_voltage(plan, model, "plan.csv"));
  plan = plan_of(model, 7.0);
  plan.columns[torque].name = "something_else";
  EXPECT_FALSE(plan_voltage(plan, model, "plan.csv"));
}

TEST(PlanVoltage, MakesDutyAShareOfTheBusAndLeavesThatOfThisBusAlone) {
  const model::PlanarModel model = minitaur();
  const Table plan = plan_of(model, 7.0);
  const auto replayed = [&](double bus) {
    return plan_reference(plan, model, Quantity::duty, bus, "plan.csv").feedforward;
  };
  const Matrix own = replayed(7.0), other = replayed(14.0);
  EXPECT_EQ(own(0, 3), plan.values(3, plan.column("front_a_duty")));
  EXPECT_TRUE(other.isApprox(0.5 * own, 1e-9));
}

TEST(PlanVoltage, OfTheAuthorsPlansIsSevenVolts) {
  JACULUS_REQUIRE_SHARED_DATA(folder);
  const Table plan = trajectory::read_csv(folder / "plans" / "notail_V7.csv");
  EXPECT_NEAR(plan_voltage(plan, minitaur(), "plan.csv").value_or(0.0), 7.0, 0.002);
}

}  // namespace
}  // namespace jaculus::simulation
