#include <gtest/gtest.h>

#include "jaculus/report/compare_report.h"
#include "jaculus/report/plan_report.h"
#include "report/document/text_table.h"
#include "support/input_error.h"
#include "support/sample_comparison.h"

namespace jaculus::report {
namespace {

using test::holds;

TEST(SummaryText, SaysWhatWasFoundAndWhatToMind) {
  const std::string text = summary_text(test::sample_summary(), false);
  EXPECT_TRUE(holds(text, "6.842 m/s^2   (published: 6.803)"));
  EXPECT_TRUE(holds(text, "at its bound"));
  EXPECT_TRUE(holds(text, "verification: passed"));
  EXPECT_EQ(text.find('\x1b'), std::string::npos);
  EXPECT_NE(summary_text(test::sample_summary(), true).find('\x1b'), std::string::npos);
  solver::Summary failed = test::sample_summary();
  failed.status = solver::Status::infeasible;
  failed.verification.passed = false;
  EXPECT_TRUE(holds(summary_text(failed, false), "not a solution"));

  failed.binds = "what binds is the limit on motor voltage of hip, knee in push (at 4 V)";
  failed.violated_rows = {{"push, node 2: knee voltage", -3.25, "V"},
                          {"push, node 1: hip voltage", 2.5, "V"},
                          {"push, interval 1: defect of z", 0.01, "m"}};
  const std::string told = summary_text(failed, false);
  EXPECT_LT(told.find("no plan holds all limits: what binds"), told.find("objective"));
  EXPECT_TRUE(
      holds(told, "  motor voltage in push: up to 3.25 V in 2 rows (most: knee, node 2)\n"));
  EXPECT_TRUE(holds(told, "  equations of motion in push: 0.01 m (z, interval 1)\n"));
  EXPECT_TRUE(holds(summary_text(failed, false), "NOT PASSED"));
}

TEST(Comparison, TextSaysWhatIsGainedAndUnderWhatConditions) {
  const std::string text = comparison_text(test::two_rows(), false);
  EXPECT_TRUE(holds(text, "+10.0 % *"));
  EXPECT_TRUE(holds(text, "different conditions"));
  EXPECT_TRUE(holds(text, "6.803"));
}

TEST(TextTable, AlignsByCharacters) {
  TextTable table({"name", "value"});
  table.row({"\xC3\xA4", "1.0"});
  table.row({"bb", "10.0"});
  EXPECT_EQ(table.text(), "name  value\n-----------\n\xC3\xA4       1.0\nbb     10.0\n");
  EXPECT_EQ(fixed(kNaN, 2), "-");
  EXPECT_EQ(percent(0.145), "+14.5 %");
  EXPECT_EQ(percent_or_change(0.145, 0.9, "m/s^2"), "+14.5 %");
  EXPECT_EQ(percent_or_change(kNaN, 0.0357, "m/s^2"), "+0.036 m/s^2");
  EXPECT_EQ(percent_or_change(kNaN, kNaN, "m/s^2"), "-");
}

}  // namespace
}  // namespace jaculus::report
