// Effects as users write them, and what is said where they can't be read.

#include "jaculus/effects/select.h"

#include <gtest/gtest.h>

#include <cmath>

#include "experiments.h"
#include "support/input_error.h"

namespace jaculus::effects {
namespace {

using test::tailed;

TEST(ReadEffect, TakesOwnAndShownNames) {
  const EffectValue shown =
      read_effect("tail_compliance:stiffness=80,damping_ratio=0.2", tailed(), "--effect");
  EXPECT_EQ(shown.effect->name, "tail_compliance");
  EXPECT_NEAR(shown.theta[0], 0.0125, 1e-15);
  EXPECT_EQ(shown.theta[1], 0.2);
  EXPECT_EQ(read_effect("tail_compliance:compliance=0.0125", tailed(), "--effect").theta[0],
            0.0125);
  EXPECT_EQ(read_effect("tail_compliance:stiffness=inf", tailed(), "--effect").theta[0], 0.0);
  const auto parameters = shown_parameters(*shown.effect, shown.theta);
  EXPECT_EQ(parameters[0].name, "stiffness");
  EXPECT_EQ(parameters[0].unit, "N m/rad");
  EXPECT_NEAR(parameters[0].value, 80.0, 1e-12);
}

TEST(ReadEffect, LeavesTheOthersNominal) {
  const EffectValue value = read_effect("payload:x=0.1,mass=0.5", tailed(), "--effect");
  const double height = tailed().bodies[0].com.y();  // what is not given is the centre of mass
  EXPECT_EQ(value.theta, (Vector(3) << 0.5, 0.1, height).finished());
  simulation::Plant plant = simulation::nominal_plant(tailed());
  const double before = plant.model.total_mass();
  apply_effects({value}, plant);
  EXPECT_NEAR(plant.model.total_mass(), before + 0.5, 1e-12);
}

TEST(ReadEffect, SaysWhatIsWrong) {
  const auto message = [](const std::string& text) {
    return test::input_error_of([&] { read_effect(text, tailed(), "--effect"); });
  };
  EXPECT_TRUE(
      test::holds(message("tail_complience:stiffness=80"), "did you mean 'tail_compliance'?"));
  EXPECT_TRUE(
      test::holds(message("joint_backlash:play=0.01"), "this robot can't have 'joint_backlash'"));
  EXPECT_TRUE(test::holds(message("tail_compliance"), "has no parameter"));
  EXPECT_TRUE(test::holds(message("tail_compliance:stifness=80"), "did you mean 'stiffness'?"));
  EXPECT_TRUE(test::holds(message("tail_compliance:stiffness"), "no value given"));
  EXPECT_TRUE(
      test::holds(message("tail_compliance:stiffness=stiff"), "'stiff' given; allowed: a number"));
  EXPECT_TRUE(test::holds(message("tail_compliance:stiffness=nan"), "'nan' given"));
  EXPECT_TRUE(
      test::holds(message("tail_compliance:stiffness=5"), "5 given; allowed: 20 to inf N m/rad"));
  EXPECT_TRUE(test::holds(message("tail_compliance:stiffness=80,compliance=0.01"), "given twice"));
  EXPECT_TRUE(test::holds(message("payload:mass=-1"), "-1 given; allowed: 0 to 3.4"));
}

/// Payload against the parallel-axis sum worked out by hand.
TEST(Inertia, PayloadMovesMassCentreAndInertia) {
  simulation::Plant plant = simulation::nominal_plant(tailed());
  const model::PlanarBody before = plant.model.bodies.front();
  find_effect("payload")->apply((Vector(3) << 0.8, 0.15, 0.05).finished(), plant);
  const model::PlanarBody& after = plant.model.bodies.front();
  const Vec2 place(0.15, 0.05),
      com = (before.mass * before.com + 0.8 * place) / (before.mass + 0.8);
  EXPECT_NEAR(after.mass, before.mass + 0.8, 1e-12);
  EXPECT_NEAR((after.com - com).norm(), 0.0, 1e-12);
  EXPECT_NEAR(after.inertia,
              before.inertia + before.mass * (before.com - com).squaredNorm() +
                  0.8 * (place - com).squaredNorm(),
              1e-12);
}

}  // namespace
}  // namespace jaculus::effects
