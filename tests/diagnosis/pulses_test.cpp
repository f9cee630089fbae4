// Forces that acted once: planted in noise, and not found where there is only noise.

#include "diagnosis/localise/events.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace jaculus::test {
namespace {

using diagnosis::ForceSeries;

/// Four trials of 10 s in boxes of 0.05 s.
std::vector<ForceSeries> noise(unsigned seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal(0.0, 0.1);
  std::vector<ForceSeries> series(4);
  for (ForceSeries& own : series)
    for (int i = 0; i < 200; ++i) {
      own.time.push_back(0.05 * (i + 0.5));
      own.force.push_back(normal(generator));
    }
  return series;
}

TEST(Events, ArePlantedPushesWithTheirSign) {
  std::vector<ForceSeries> series = noise(1);
  const auto push = [&](int trial, double middle, double peak) {
    for (int i = 0; i < 200; ++i)
      series[trial].force[i] +=
          peak * std::exp(-0.5 * std::pow((series[trial].time[i] - middle) / 0.1, 2));
  };
  push(0, 3.0, 0.7);
  push(2, 8.0, -0.6);
  const auto found = diagnosis::unusual_runs(series, 0.05);
  ASSERT_EQ(found.size(), 2U);
  for (const diagnosis::EventRun& run : found) {
    const double middle =
        0.5 * (series[run.series].time[run.first] + series[run.series].time[run.last]);
    EXPECT_TRUE(run.series == 0 || run.series == 2);
    EXPECT_NEAR(middle, run.series == 0 ? 3.0 : 8.0, 0.1);
    EXPECT_LT(0.05 * (run.last - run.first), 0.6);
  }
}

TEST(Events, AreNoRatesThatWereMeasuredWronglyAtOneInstant) {
  std::vector<ForceSeries> series = noise(2);
  series[1].force[100] += 2.0;
  series[1].force[101] -= 2.0;
  EXPECT_TRUE(diagnosis::unusual_runs(series, 0.05).empty());
}

TEST(Events, AreNotWhatAnotherTrialHasAtTheSameTime) {
  std::vector<ForceSeries> series = noise(3);
  for (const int trial : {0, 3})
    for (int i = 60; i < 66; ++i) series[trial].force[i] += 0.8;
  EXPECT_TRUE(diagnosis::unusual_runs(series, 0.05).empty());
}

TEST(Events, AreSeldomMadeByNoise) {
  int alarms = 0;
  for (unsigned seed = 0; seed < 100; ++seed)
    alarms += diagnosis::unusual_runs(noise(seed), 0.05).empty() ? 0 : 1;
  // At 5 % or less: 12 of 100 have a probability of 0.4 %.
  EXPECT_LT(alarms, 12);
}

}  // namespace
}  // namespace jaculus::test
