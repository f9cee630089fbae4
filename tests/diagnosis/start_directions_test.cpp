// How far a start is free.

#include "diagnosis/forward/start_directions.h"

#include <gtest/gtest.h>

#include "simulation/support.h"

namespace jaculus::diagnosis {
namespace {

TEST(StartDirections, WhatSlidesIsFreeByTheArcAtATenthOfAMetre) {
  ObservedDataset observed;
  observed.measured_input = true;
  observed.model = test::mass_on_rail(95.0);
  observed.model.coordinates[0].angular = false;
  const Settings settings;
  const simulation::StartState start = test::start_at({0.0}, {0.0});
  const auto slides = start_directions(observed, start, settings);
  ASSERT_EQ(slides.size(), 2U);
  EXPECT_EQ(slides[1].unit, "m/s");
  EXPECT_DOUBLE_EQ(slides[0].scale, 0.1 * settings.start_angle);
  EXPECT_DOUBLE_EQ(slides[1].scale, 0.1 * settings.window_start_rate);

  observed.model.coordinates[0].angular = true;
  const auto turns = start_directions(observed, start, settings);
  EXPECT_EQ(turns[1].unit, "rad/s");
  EXPECT_DOUBLE_EQ(turns[1].scale, settings.window_start_rate);
}

}  // namespace
}  // namespace jaculus::diagnosis
