// Dry friction is one law, whoever states it.

#include <gtest/gtest.h>

#include <algorithm>

#include "diagnosis/build_problem.h"
#include "diagnosis/effects_by_name.h"
#include "diagnosis/logged_trials.h"
#include "jaculus/diagnosis/diagnose.h"

namespace jaculus::diagnosis {
namespace {

int index_of_parameter(const Hypotheses& hypotheses, const std::string& owner,
                       const std::string& name) {
  const auto found =
      std::find_if(hypotheses.parameters.begin(), hypotheses.parameters.end(),
                   [&](const FreeParameter& p) { return p.owner == owner && p.name == name; });
  EXPECT_NE(found, hypotheses.parameters.end()) << owner << "." << name;
  return static_cast<int>(found - hypotheses.parameters.begin());
}

TEST(RestRates, AnEffectsFrictionAndATolerancesAreTheSameOnASlowRobot) {
  // An effect's friction once held slow joints below a slower rate than a tolerance's, and one of
  // 0.09 N m within tolerance was told from none by 28 nats.
  const trajectory::Dataset dataset =
      test::logged("double_pendulum_trials.yaml", {}, {"joint_coulomb_friction:torque=0.09"}, 1, 3);
  const DiagnoseOptions options =
      test::among({"joint_coulomb_friction", "joint_stribeck_friction"});
  const auto problem = build_problem({dataset}, options).problem;
  const Hypotheses& h = problem->hypotheses;

  const Vector nominal = h.nominal();
  Vector by_tolerance = nominal, by_effect = nominal, by_one = nominal;
  // Half a percent of 12 N m is a deviation.
  for (const char* joint : {"shoulder", "elbow"})
    by_tolerance[index_of_parameter(h, "tolerance", std::string("friction of ") + joint)] = 1.5;
  by_effect[index_of_parameter(h, "joint_coulomb_friction", "torque")] = 0.09;
  for (const char* joint : {"shoulder", "elbow"})
    by_one[index_of_parameter(h, std::string("joint_coulomb_friction@") + joint, "torque")] = 0.09;

  const ObservedDataset& observed = problem->observations.datasets[0];
  double moved = 0.0;
  for (int s = 0; s < std::min(4, count_of(observed.segments)); ++s) {
    const auto values = [&](const Vector& p) { return problem->forward(0, s, p).values; };
    const Matrix there = values(by_tolerance);
    moved = std::max(moved, (there - values(nominal)).cwiseAbs().maxCoeff());
    EXPECT_LT((values(by_effect) - there).cwiseAbs().maxCoeff(), 1e-7) << s;
    EXPECT_LT((values(by_one) - there).cwiseAbs().maxCoeff(), 1e-7) << s;
  }
  EXPECT_GT(moved, 1e-3) << "friction moves the joints";
}

TEST(RestRates, FrictionWithinToleranceIsNoEffect) {
  // The model without effects has to find what tolerances can be: the friction that an effect finds
  // first, by another name.
  const trajectory::Dataset dataset =
      test::logged("double_pendulum_trials.yaml", {}, {"joint_coulomb_friction:torque=0.09"}, 3, 3);
  const DiagnoseOptions options = test::among({"joint_coulomb_friction", "joint_viscous_friction"});
  const Diagnosis d = diagnose({dataset}, options);
  EXPECT_EQ(d.verdict, Verdict::none) << to_text(d.verdict);
  EXPECT_LT(d.gap.adjusted, 1.2);
}

}  // namespace
}  // namespace jaculus::diagnosis
