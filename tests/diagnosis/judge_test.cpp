// What of held-out errors is the gap.

#include "diagnosis/validation/judge.h"

#include <gtest/gtest.h>

#include <cmath>

#include "diagnosis/toy.h"

namespace jaculus::diagnosis {
namespace {

/// Errors of two channels, of which the second is `far` noise floors off.
Errors errors_of(bool second_reads_drives, double far) {
  const auto problem = test::toy_problem(Vector::Zero(4));
  problem->observations.datasets[0].channels[1].zero_order_hold = second_reads_drives;
  Errors errors(*problem);
  errors.counts[0] << 10.0, 10.0;
  errors.squares[0] << 10.0 * 4.0, 10.0 * far * far;
  return errors;
}

TEST(Errors, OfAMotionAreNotWhatADrivesSensorReads) {
  EXPECT_DOUBLE_EQ(errors_of(true, 40.0).overall(), 2.0);
  EXPECT_DOUBLE_EQ(errors_of(false, 4.0).overall(), std::sqrt(0.5 * (4.0 + 16.0)));
}

TEST(Errors, AreThoseOfTheDrivesWhereNoMotionWasJudged) {
  Errors errors = errors_of(true, 40.0);
  errors.counts[0][0] = errors.squares[0][0] = 0.0;
  EXPECT_DOUBLE_EQ(errors.overall(), 40.0);
  errors.counts[0][1] = 0.0;
  EXPECT_TRUE(std::isnan(errors.overall()));
}

}  // namespace
}  // namespace jaculus::diagnosis
