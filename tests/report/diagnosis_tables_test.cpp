#include "report/diagnosis_tables.h"

#include <gtest/gtest.h>

namespace jaculus::report {
namespace {

TEST(EventTable, SaysWhereWhenAndHowLarge) {
  diagnosis::Diagnosis d;
  EXPECT_TRUE(event_table(d).rows.empty());

  diagnosis::ForceEvent push;
  push.joint = "base";
  push.along = "x";
  push.from = 0.213;
  push.to = 0.282;
  push.peak = -131.0;
  push.peak_ci95 = {-144.0, -122.0};
  push.unit = "N";
  diagnosis::ForceEvent caught;
  caught.trial = "trial_02";
  caught.joint = "elbow";
  caught.from = 4.35;
  caught.to = 4.55;
  caught.peak = 0.499;
  caught.unit = "N m";
  d.events = {push, caught};

  using Row = std::vector<std::string>;
  const ReportTable table = event_table(d);
  ASSERT_EQ(table.rows.size(), 2U);
  EXPECT_EQ(table.rows[0], (Row{"each", "base x", "0.213", "0.282", "-131", "-144", "-122", "N"}));
  EXPECT_EQ(table.rows[1], (Row{"trial 02", "elbow", "4.35", "4.55", "0.499", "–", "–", "N m"}));
  for (const Row& row : table.rows) EXPECT_EQ(row.size(), table.columns.size());
}

}  // namespace
}  // namespace jaculus::report
