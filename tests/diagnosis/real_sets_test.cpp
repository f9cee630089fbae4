// Real robots whose cause is known: what has been published of them must come back.

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "jaculus/diagnosis/diagnose.h"
#include "jaculus/trajectory/dataset.h"
#include "model/support.h"

namespace jaculus::test {
namespace {

const diagnosis::FoundParameter* find(const diagnosis::Diagnosis& diagnosis,
                                      const std::string& effect, const std::string& parameter) {
  for (const diagnosis::FoundEffect& found : diagnosis.effects)
    for (const diagnosis::FoundParameter& own : found.parameters)
      if (found.name == effect && own.name == parameter) return &own;
  return nullptr;
}

/// Janot, Gautier and Brunot (2019): 203.5 N s/m, 20.39 N and an offset of -3.165 N, which at a
/// moving joint is a friction that differs by direction.
TEST(RealSets, TheElectroMechanicalPositioningSystemHasItsPublishedFriction) {
  const std::filesystem::path folder = testing::data_folder();
  if (folder.empty()) {
    ASSERT_EQ(std::getenv("CI"), nullptr) << "the real data must be there: set JACULUS_DATA";
    GTEST_SKIP() << "no real data: set JACULUS_DATA or put it in ../shared/data";
  }
  const diagnosis::Diagnosis found =
      diagnosis::diagnose({trajectory::read_dataset(folder / "emps")});
  const auto* viscous = find(found, "joint_viscous_friction", "coefficient");
  const auto* dry = find(found, "joint_directional_friction", "torque");
  const auto* asymmetry = find(found, "joint_directional_friction", "asymmetry");
  ASSERT_TRUE(viscous != nullptr && dry != nullptr && asymmetry != nullptr);
  EXPECT_NEAR(viscous->value, 203.5, 0.1 * 203.5);
  EXPECT_TRUE(viscous->ci95.contains(203.5));
  EXPECT_NEAR(dry->value, 20.39, 0.15 * 20.39);
  EXPECT_NEAR(dry->value * asymmetry->value, -3.165, 0.3 * 3.165);
  EXPECT_GT(found.gap.shrink, 0.95);
}

}  // namespace
}  // namespace jaculus::test
