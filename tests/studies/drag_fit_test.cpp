#include "studies/drag_fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace jaculus::studies {
namespace {

constexpr double kResistance = 0.186;
constexpr double kTorqueConstant = 0.0954;

// A point of a motor that loses nothing but heat in its winding.
BenchPoint point(double speed, double torque) {
  const double current = torque / kTorqueConstant;
  return {kResistance * current + kTorqueConstant * speed, current, speed};
}

/// Torques with noise, which may take a small one below zero; a bench's own points may not.
std::vector<DragObservation> bench(double b, double c, double d, double noise, int count,
                                   double low, double high, unsigned seed) {
  std::mt19937 rng(seed);
  std::normal_distribution<double> error(0.0, 1.0);
  std::vector<DragObservation> observations;
  for (int i = 0; i < count; ++i) {
    const double w = low + (high - low) * i / (count - 1);
    observations.push_back({b * w * w + c * w + d + noise * error(rng), w * w, w});
  }
  return observations;
}

TEST(DragFit, PowerBalanceGivesTheTorque) {
  const std::vector<DragObservation> o =
      steady_observations({point(12.0, 0.7), point(-12.0, -0.7)}, kResistance);
  EXPECT_NEAR(o[0].torque, 0.7, 1e-12);
  EXPECT_NEAR(o[1].torque, 0.7, 1e-12);
  EXPECT_DOUBLE_EQ(o[1].quadratic, 144.0);
}

TEST(DragFit, ExactDataGiveExactShares) {
  const DragFits fits = fit_drag(bench(0.00514, 0.002, 0.03, 0.0, 12, 2.0, 25.0, 1), 0.95);
  ASSERT_EQ(fits.fits.size(), 4u);
  const DragFit& both = fits.fits[3];
  EXPECT_NEAR(both.quadratic.value, 0.00514, 1e-12);
  EXPECT_NEAR(both.viscous.value, 0.002, 1e-10);
  EXPECT_NEAR(both.coulomb.value, 0.03, 1e-9);
  EXPECT_EQ(fits.taken, 3);
  EXPECT_TRUE(std::isnan(fits.fits[0].viscous.value));
}

TEST(DragFit, DragAloneIsTakenWhereThereIsNothingElse) {
  int taken = 0;
  for (unsigned seed = 0; seed < 40; ++seed) {
    taken += fit_drag(bench(0.00514, 0.0, 0.0, 0.05, 16, 3.0, 24.0, seed), 0.95).taken == 0 ? 1 : 0;
  }
  EXPECT_GE(taken, 34);
}

TEST(DragFit, IntervalsCoverTheTruthAsOftenAsTheyClaim) {
  int covered = 0;
  const int runs = 1000;
  for (unsigned seed = 0; seed < runs; ++seed) {
    const DragFit fit = fit_drag(bench(0.00514, 0.0, 0.0, 0.08, 8, 3.0, 24.0, seed), 0.9).fits[0];
    covered += fit.quadratic.low <= 0.00514 && 0.00514 <= fit.quadratic.high ? 1 : 0;
  }
  EXPECT_NEAR(covered / static_cast<double>(runs), 0.9, 0.03);
}

TEST(DragFit, ANarrowRangeOfSpeedsCantTellViscousFromCoulomb) {
  const DragFits fits = fit_drag(bench(0.00514, 0.03, 0.0, 0.02, 12, 10.0, 16.0, 4), 0.95);
  EXPECT_TRUE(fits.fits[1].plausible && fits.fits[2].plausible);
  bool said = false;
  for (const std::string& note : fits.notes) said |= note.find("can't tell") != std::string::npos;
  EXPECT_TRUE(said);
}

TEST(DragFit, AWideRangeCan) {
  const DragFits fits = fit_drag(bench(0.00514, 0.0, 0.25, 0.01, 40, 0.5, 25.0, 4), 0.95);
  EXPECT_EQ(fits.fits[fits.taken].model, "drag + Coulomb");
  EXPECT_FALSE(fits.fits[1].plausible);
  const Estimate& d = fits.fits[2].coulomb;
  EXPECT_LT(d.low, 0.25);
  EXPECT_GT(d.high, 0.25);
}

TEST(DragFit, ANegativeShareIsNeverTaken) {
  const DragFits fits = fit_drag(bench(0.00514, -0.03, 0.0, 0.001, 30, 3.0, 25.0, 2), 0.95);
  EXPECT_EQ(fits.taken, 0);
  bool said = false;
  for (const std::string& note : fits.notes) said |= note.find("negative") != std::string::npos;
  EXPECT_TRUE(said);
}

TEST(DragFit, TooFewPointsLeaveModelsOut) {
  const DragFits fits = fit_drag(bench(0.005, 0.0, 0.0, 0.01, 2, 5.0, 20.0, 3), 0.95);
  EXPECT_EQ(fits.fits.size(), 1u);
  EXPECT_GE(fits.notes.size(), 3u);
}

TEST(DragFit, ACoastDownGivesTheDragThatSlowedIt) {
  // I w' = -b w^2 - d has w = sqrt(d/b) tan(atan(w0 sqrt(b/d)) - sqrt(b d) t / I).
  const double inertia = 0.02, b = 0.004, d = 0.02, start = 25.0;
  std::vector<double> time, speed;
  for (int i = 0; i < 1200; ++i) {
    time.push_back(0.001 * i);
    speed.push_back(std::sqrt(d / b) * std::tan(std::atan(start * std::sqrt(b / d)) -
                                                std::sqrt(b * d) * time.back() / inertia));
  }
  const std::vector<double> power(time.size(), 0.0);
  const DragFits fits = fit_drag(transient_observations(time, speed, power, inertia, 0.02), 0.95);
  ASSERT_EQ(fits.fits[2].model, "drag + Coulomb");
  EXPECT_NEAR(fits.fits[2].quadratic.value, b, 1e-6);
  EXPECT_NEAR(fits.fits[2].coulomb.value, d, 1e-4);
  EXPECT_FALSE(fits.fits[0].plausible);
}

TEST(DragFit, WindowsThatReverseAreLeftOut) {
  std::vector<double> time, speed;
  for (int i = 0; i <= 100; ++i) {
    time.push_back(0.01 * i);
    speed.push_back(5.0 - 0.1 * i);
  }
  const std::vector<double> power(time.size(), 0.0);
  for (const DragObservation& o : transient_observations(time, speed, power, 0.1, 0.1))
    EXPECT_TRUE(std::isfinite(o.torque));
  EXPECT_LT(transient_observations(time, speed, power, 0.1, 0.1).size(), 10u);
}

TEST(DragFit, CoefficientFollowsEquationTwo) {
  const Estimate c = drag_coefficient({0.125 * 1.225 * 2.0 * 0.18 * (1.0 - 0.1296), 0.0, 0.0},
                                      1.225, 0.18, 0.6, 1.0);
  EXPECT_NEAR(c.value, 2.0, 1e-12);
}

TEST(DragFit, FaultsOfPointsAreNamed) {
  EXPECT_EQ(bench_fault(point(10.0, 0.5), kResistance), "");
  EXPECT_NE(bench_fault({1.0, 1.0, 0.0}, kResistance).find("stands still"), std::string::npos);
  EXPECT_NE(bench_fault({1.0, 10.0, 5.0}, kResistance).find("lost in the winding"),
            std::string::npos);
  EXPECT_NE(bench_fault({kNaN, 10.0, 5.0}, kResistance).find("must all be there"),
            std::string::npos);
}

}  // namespace
}  // namespace jaculus::studies
