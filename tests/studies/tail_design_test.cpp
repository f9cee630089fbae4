#include "studies/tail_design.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "studies/search.h"
#include "studies/setup.h"

namespace jaculus::studies {
namespace {

ReorientationSetup paper_setup() {
  ReorientationSetup s;
  const ReorientationCase c = paper_case();
  s.body_inertia = c.body_inertia;
  s.tail_inertia = c.tail_inertia;
  s.tail_length = c.drag.end;
  s.tail_shaft = c.drag.start;
  s.tail_width = c.drag.width;
  s.drag_coefficient = c.drag.coefficient;
  s.air_density = c.drag.density;
  s.motor = c.motor;
  s.drop = 0.5;
  s.stroke = c.stroke;
  s.target = c.target_angle;
  return s;
}

TEST(Setup, DescribesThePaperCase) {
  const ReorientationSetup s = paper_setup();
  ASSERT_EQ(check_setup(s), "");
  EXPECT_EQ(simulate_reorientation(to_case(s)).body_angle,
            simulate_reorientation(paper_case()).body_angle);
}

TEST(Setup, AlternativesReplaceOneAnother) {
  ReorientationSetup s = paper_setup();
  const yaml::Node nowhere;
  find_parameter("tail.normalised_inertia", nowhere).set(s, 0.5);
  find_parameter("tail.shaft_ratio", nowhere).set(s, 0.25);
  EXPECT_NEAR(to_case(s).tail_inertia, 0.23, 1e-15);
  EXPECT_NEAR(to_case(s).drag.start, 0.25, 1e-15);
  find_parameter("tail.inertia", nowhere).set(s, 0.1);
  EXPECT_EQ(to_case(s).tail_inertia, 0.1);
}

TEST(Setup, EveryParameterReadsBackWhatWasSet) {
  for (const Parameter& p : setup_parameters()) {
    ReorientationSetup s = paper_setup();
    p.set(s, 0.75);
    EXPECT_EQ(p.get(s), 0.75) << p.name;
    EXPECT_TRUE(p.allowed.contains(0.75)) << p.name;
  }
}

TEST(Search, FindsTheBestIntegerAndSaysWhereItStopped) {
  const SearchResult inside =
      maximise({1.0, 50.0, true}, [](double x) { return -(x - 7.3) * (x - 7.3); });
  EXPECT_EQ(inside.argument, 7.0);
  EXPECT_EQ(inside.bound, "");
  EXPECT_EQ(maximise({1.0, 50.0, true}, [](double x) { return x; }).bound, "upper");
  EXPECT_EQ(maximise({1.0, 50.0, true}, [](double x) { return -x; }).bound, "lower");
  EXPECT_TRUE(std::isnan(maximise({1.0, 5.0, true}, [](double) { return kNaN; }).argument));
}

TEST(Search, RefinesAContinuousOptimum) {
  const SearchResult r =
      maximise({0.0, 10.0, false}, [](double x) { return std::sin(x) - 0.1 * x; });
  EXPECT_NEAR(r.argument, std::acos(0.1), 1e-6);
  EXPECT_EQ(r.bound, "");
  EXPECT_EQ(maximise({0.0, 1.0, false}, [](double x) { return x; }).bound, "upper");
}

TEST(TailDesign, MassAndInertiaAreThoseOfTubeAndScoop) {
  const TailMaterial m{0.057, 0.31, 0.01};
  // By sums of small pieces.
  const double length = 1.0, shaft = 0.6, width = 0.18;
  double mass = m.mount, inertia = 0.0;
  const int n = 20000;
  for (int i = 0; i < n; ++i) {
    const double l = length * (i + 0.5) / n;
    const double dm =
        length / n * (m.tube + (l > shaft ? m.film * 0.5 * std::numbers::pi * width : 0.0));
    mass += dm;
    inertia += dm * l * l;
  }
  const double disc = m.film * std::numbers::pi * width * width / 8.0;
  mass += 2.0 * disc;
  inertia += disc * (shaft * shaft + length * length);
  EXPECT_NEAR(tail_mass(m, length, shaft, width), mass, 1e-6);
  EXPECT_NEAR(tail_inertia(m, length, shaft, width), inertia, 1e-6);
}

TEST(TailDesign, EvaluationAgreesWithTheSimulation) {
  const TailMaterial m{0.057, 0.31, 0.0};
  const TailDesign d = evaluate_design(paper_setup(), m, 1.0, 0.6, 0.18, {1.0, 50.0, true});
  ReorientationCase c = paper_case();
  c.tail_inertia = d.inertia;
  double best = 0.0;
  for (int gear = 1; gear <= 50; ++gear) {
    c.motor.gear = gear;
    best = std::max(best, simulate_reorientation(c).effectiveness);
  }
  EXPECT_NEAR(d.effectiveness, best, 2e-5);
}

TailDesign design(double mass, double effectiveness, double length, double width) {
  TailDesign d;
  d.mass = mass;
  d.effectiveness = effectiveness;
  d.length = length;
  d.width = width;
  d.shaft = 0.1;
  return d;
}

TEST(TailDesign, TheFrontHoldsWhatNothingBeats) {
  const TailLimits limits{1.0, 1.0, 1.0};
  const std::vector<TailDesign> front = pareto_front(
      {
          // heavier and worse
          design(0.2, 0.3, 0.5, 0.5), design(0.1, 0.1, 0.5, 0.5), design(0.3, 0.25, 0.5, 0.5),
          // too long, lighter and better than the second
          design(0.9, 0.5, 0.5, 0.5), design(0.15, 0.35, 1.1, 0.5),
          design(0.95, 0.45, 0.5, 1.1),  // too wide, but no gain to any
          design(1.05, 0.6, 0.5, 0.5),   // too heavy, better than all
      },
      limits);
  ASSERT_EQ(front.size(), 3u);
  EXPECT_EQ(front[0].mass, 0.1);
  EXPECT_TRUE(front[0].binding.empty());
  EXPECT_EQ(front[1].binding, std::vector<std::string>{"stowed length"});
  EXPECT_EQ(front[2].binding, std::vector<std::string>{"mass budget"});
}

}  // namespace
}  // namespace jaculus::studies
