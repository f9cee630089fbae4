// What stands in the way of a problem without a plan: limits by kind, strongest first.

#include "solver/failure.h"

#include <gtest/gtest.h>

#include "solver/row_words.h"
#include "support/input_error.h"

namespace jaculus::solver {
namespace {

using test::holds;

TEST(RowWords, PartsPhasePlaceAndKind) {
  const RowWords voltage = row_words("rear_feet, node 7: front_a voltage");
  EXPECT_EQ(voltage.phase, "rear_feet");
  EXPECT_EQ(voltage.place, "node 7");
  EXPECT_EQ(voltage.kind, "motor voltage");
  EXPECT_EQ(voltage.of, "front_a");
  const RowWords defect = row_words("stand, interval 3: defect of pitch velocity");
  EXPECT_EQ(defect.kind, "equations of motion");
  EXPECT_EQ(defect.of, "pitch velocity");
  const RowWords impact = row_words("impact at the start of landing: jump of the rate of x");
  EXPECT_EQ(impact.phase, "landing");
  EXPECT_EQ(impact.kind, "impact");
  EXPECT_EQ(impact.of, "x");
  EXPECT_EQ(row_words("push, node 1: front_foot friction forward").kind, "friction");
  const RowWords end = row_words("touchdown pitch");
  EXPECT_EQ(end.phase, "");
  EXPECT_EQ(end.kind, "touchdown pitch");
  EXPECT_EQ(end.of, "");
}

/// A limit of weight 1 that the sum of slacks depends on.
LimitSensitivity limit(bool is_row, int index, const std::string& name, const std::string& unit,
                       Side side, double value) {
  return {is_row, index, name, unit, side, value, 1.0, 1.0};
}

TEST(BindingSentence, NamesTheVoltageBesideTheTorque) {
  Conflict conflict;
  conflict.relaxed = {{4, "push, node 1: hip voltage", "V", 2.5, 0.6},
                      {5, "push, node 2: knee voltage", "V", -3.25, 0.8}};
  conflict.limits = {limit(true, 4, "push, node 1: hip voltage", "V", Side::upper, 4.0),
                     limit(true, 5, "push, node 2: knee voltage", "V", Side::lower, -4.0),
                     limit(false, 9, "push, interval 1: hip torque", "N m", Side::upper, 3.0),
                     limit(true, 8, "push, interval 1: defect of z", "m", Side::fixed, 0.0)};
  EXPECT_EQ(binding_sentence(conflict, {}),
            "what binds is the limit on motor voltage of hip, knee in push (at 4 V, short by up to "
            "3.2 V), then on motor torque of hip in push (at 3 N m)");
}

TEST(BindingSentence, IsSilentWhereNothingIsKnown) {
  EXPECT_EQ(binding_sentence({}, {}), "");
  Conflict feasible;
  feasible.feasible = true;
  EXPECT_EQ(binding_sentence(feasible, {}), "");
}

}  // namespace
}  // namespace jaculus::solver
