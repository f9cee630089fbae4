#include "jaculus/solver/summary.h"

#include <gtest/gtest.h>

#include "jaculus/core/error.h"
#include "support/input_error.h"
#include "support/sample_summary.h"

namespace jaculus::solver {
namespace {

using test::holds;

TEST(Summary, HasTheKeysThatUsersRelyOn) {
  const auto json = to_json(test::sample_summary());
  for (const char* key : {"status", "objective", "iterations", "size", "duration_s", "phases",
                          "liftoff_velocity_m_s", "average_acceleration_m_s2",
                          "tail_momentum_share", "verification", "seed", "version", "problem"}) {
    EXPECT_TRUE(json.contains(key)) << key;
  }
  for (const char* key : {"variables", "constraints", "jacobian_nonzeros", "hessian_nonzeros"}) {
    EXPECT_TRUE(json["size"].contains(key)) << key;
  }
  EXPECT_EQ(json["phases"][0]["name"], "all_feet");
  EXPECT_EQ(json["phases"][0]["duration_s"], 0.184);
  EXPECT_EQ(json["verification"]["worst_violation"]["row"], "all_feet, node 3: friction");
  EXPECT_EQ(json["verification"]["reintegration_error"]["x"], 1e-4);
  EXPECT_TRUE(json["tail_momentum_share"].is_null());
  EXPECT_FALSE(json["version"].get<std::string>().empty());
}

TEST(Summary, ReadsBackToTheSameBytes) {
  const auto json = to_json(test::sample_summary());
  EXPECT_EQ(to_json(summary_from_json(json, "summary.json")).dump(), json.dump());
  EXPECT_EQ(summary_from_json(json, "f").motors[0].torque_limit, kInfinity);
}

TEST(Summary, OfAnEarlierVersionHasNoJointsOfTheFile) {
  auto json = to_json(test::sample_summary());
  json.erase("held_joints");
  json["motors"][0].erase("joints");
  json["motors"][0].erase("slides");
  const Summary summary = summary_from_json(json, "summary.json");
  EXPECT_TRUE(summary.motors[0].file_joints.empty());
  EXPECT_TRUE(summary.held_joints.empty());
}

TEST(Summary, RefusesJsonOfAnotherKind) {
  const std::string message = test::input_error_of([] {
    static_cast<void>(summary_from_json({{"status", "optimal"}}, "some.json"));
  });
  EXPECT_TRUE(holds(message, "some.json"));
}

}  // namespace
}  // namespace jaculus::solver
