#include "jaculus/report/summary.h"

#include <gtest/gtest.h>

#include "jaculus/report/compare_report.h"
#include "jaculus/report/text_table.h"
#include "support/input_error.h"

namespace jaculus {
namespace {

using test::holds;

Summary sample() {
  Summary s;
  s.name = "leap";
  s.caption = "a leap";
  s.status = "optimal";
  s.converged = true;
  s.objective = 6.8;
  s.iterations = 42;
  s.size = {100, 120, 900, 400};
  s.duration = 0.19;
  s.phases = {{"all_feet", 0.184, false}, {"rear_feet", 0.006, true}};
  s.liftoff_velocity = 1.3;
  s.liftoff_velocity_com = 1.2;
  s.average_acceleration = 1.3 / 0.19;
  s.average_acceleration_com = 1.2 / 0.19;
  MotorFigures motor;
  motor.motor = "tail";
  motor.joint_torque = 8.0;
  motor.voltage = 6.99;
  motor.voltage_limit = 7.0;
  s.motors = {motor};
  s.active_limits = {{"tail voltage", "all_feet", 0.0, 0.1, 12}};
  s.prices = {{"voltage", 0.5, "m/s^2 per V"}};
  s.verification.passed = true;
  s.verification.reintegration_error = {{"x", 1e-4}, {"pitch", 2e-4}};
  s.verification.worst_violation = {"all_feet, node 3: friction", 1e-9, "N"};
  s.warnings = {"rear_feet: its duration stands at its bound"};
  s.input_hold = "held";
  s.seed = 3;
  s.reference = {{"average_acceleration_m_s2", 6.803}};
  s.problem = {{"name", "leap"}};
  return s;
}

TEST(Summary, HasTheKeysThatUsersRelyOn) {
  const auto json = to_json(sample());
  for (const char* key :
       {"status", "objective", "iterations", "size", "duration_s", "phases", "liftoff_velocity_m_s",
        "average_acceleration_m_s2", "tail_momentum_share", "verification", "seed", "version", "problem"}) {
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
  const auto json = to_json(sample());
  EXPECT_EQ(to_json(summary_from_json(json, "summary.json")).dump(), json.dump());
  EXPECT_EQ(summary_from_json(json, "f").motors[0].torque_limit, kInfinity);
}

TEST(Summary, RefusesJsonOfAnotherKind) {
  const std::string message = test::input_error_of([] {
    static_cast<void>(summary_from_json({{"status", "optimal"}}, "some.json"));
  });
  EXPECT_TRUE(holds(message, "some.json"));
}

TEST(Summary, TextSaysWhatWasFoundAndWhatToMind) {
  const std::string text = to_text(sample(), false);
  EXPECT_TRUE(holds(text, "6.842 m/s^2   (published: 6.803)"));
  EXPECT_TRUE(holds(text, "at its bound"));
  EXPECT_TRUE(holds(text, "verification: passed"));
  EXPECT_EQ(text.find('\x1b'), std::string::npos);
  EXPECT_NE(to_text(sample(), true).find('\x1b'), std::string::npos);
  Summary failed = sample();
  failed.converged = false;
  failed.verification.passed = false;
  EXPECT_TRUE(holds(to_text(failed, false), "not a solution"));
  EXPECT_TRUE(holds(to_text(failed, false), "NOT PASSED"));
}

TEST(Comparison, TableJsonAndCsvAgree) {
  Summary base = sample();
  base.name = "tailless";
  base.average_acceleration = 6.0;
  Summary tail = sample();
  tail.average_acceleration = 6.6;
  const std::vector<ComparisonRow> rows = {{base, TailKind::none, "a"}, {tail, TailKind::drag, "b"}};
  const std::string text = comparison_text(rows, false);
  EXPECT_TRUE(holds(text, "+10.0 % *"));
  EXPECT_TRUE(holds(text, "different conditions"));
  EXPECT_TRUE(holds(text, "6.803"));
  const auto json = comparison_json(rows);
  EXPECT_EQ(json["problems"].size(), 2u);
  EXPECT_EQ(json["problems"][1]["name"], "leap");
  EXPECT_NEAR(json["problems"][1]["gain_over_tailless"]["average_acceleration"].get<double>(), 0.1, 1e-12);
  EXPECT_EQ(json["reference"]["leap"]["average_acceleration_m_s2"], 6.803);
  const std::string csv = comparison_csv(rows);
  const auto commas = [](const std::string& line) { return std::count(line.begin(), line.end(), ','); };
  const std::size_t first = csv.find('\n');
  const std::size_t second = csv.find('\n', first + 1);
  EXPECT_EQ(commas(csv.substr(0, first)), commas(csv.substr(first + 1, second - first - 1)));
  EXPECT_TRUE(holds(csv, "tailless,none,optimal,6,"));
}

TEST(TextTable, AlignsByCharacters) {
  TextTable table({"name", "value"});
  table.row({"\xC3\xA4", "1.0"});
  table.row({"bb", "10.0"});
  EXPECT_EQ(table.text(), "name  value\n-----------\n\xC3\xA4       1.0\nbb     10.0\n");
  EXPECT_EQ(fixed(kNaN, 2), "-");
  EXPECT_EQ(percent(0.145), "+14.5 %");
}

}  // namespace
}  // namespace jaculus
