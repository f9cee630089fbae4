// Passive robots that are dropped anyhow never gain energy, nor go through the floor or their
// stops.

#include <gtest/gtest.h>

#include <random>

#include "jaculus/model/robot.h"
#include "simulation/support.h"
#include "support/sample_models.h"

namespace jaculus::simulation {
namespace {

using namespace test;

struct Drop {
  Plant plant;
  StartState start;
};

/// Lifts a robot so that its lowest contact point is `clearance` above the floor.
void lift_off(Drop& drop, double clearance) {
  const model::PlanarModel& model = drop.plant.model;
  const dynamics::AbsoluteTree tree(model);
  dynamics::Motion motion(tree);
  ASSERT_TRUE(dynamics::set_configuration(tree, drop.start.q, motion));
  double lowest = kInfinity;
  for (int f = 0; f < count_of(model.feet); ++f)
    lowest = std::min(lowest, dynamics::foot_position(tree, motion, f).y());
  drop.start.q[model.coordinate_index("z")] += clearance - lowest;
}

/// Energy at samples falls but for rounding; nothing is below the floor by more than the tolerance.
void expect_passive(const Drop& drop, const Simulation& s, double tolerance,
                    const std::string& what) {
  ASSERT_GT(s.time.size(), 1) << what;
  const model::PlanarModel& model = drop.plant.model;
  const dynamics::AbsoluteTree tree(model);
  dynamics::Motion motion(tree);
  double before = kInfinity;
  for (Eigen::Index k = 0; k < s.time.size(); ++k) {
    const double now = energy(model, s.q.col(k), s.v.col(k));
    ASSERT_LE(now, before + tolerance) << what << " at " << s.time[k];
    before = std::min(before, now);
    ASSERT_TRUE(dynamics::set_configuration(tree, s.q.col(k), motion));
    for (int f = 0; f < count_of(model.feet); ++f)
      ASSERT_GE(dynamics::foot_position(tree, motion, f).y(), -1e-6) << what << " at " << s.time[k];
  }
}

TEST(Energy, NeverRisesInAThousandRandomDropsOfABox) {
  std::mt19937 rng(7);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  int landed = 0, slid = 0, stuck = 0, unfinished = 0;
  for (int trial = 0; trial < 1000; ++trial) {
    const double a = 0.15 + 0.1 * unit(rng), b = 0.08 + 0.06 * unit(rng);
    Drop drop{plant_of(body_with_feet(1.0, 0.01 + 0.005 * unit(rng),
                                      {Vec2(-a, -b), Vec2(a, -b), Vec2(a, b), Vec2(-a, b)}),
                       0.5 + 0.5 * unit(rng)),
              start_at({0, 0, 3.0 * unit(rng)}, {2.0 * unit(rng), unit(rng), 10.0 * unit(rng)})};
    lift_off(drop, 0.05 + 0.05 * unit(rng));
    const Simulation s = simulate(drop.plant, no_controller(), drop.start, options_for(0.6, 61));
    unfinished += s.status == SimulationStatus::done ? 0 : 1;
    EXPECT_EQ(s.status, SimulationStatus::done) << trial << ": " << s.message;
    expect_passive(drop, s, 1e-6, "trial " + std::to_string(trial));
    for (const Event& event : s.events) {
      landed += event.kind == EventKind::land ? 1 : 0;
      slid += event.kind == EventKind::slip ? 1 : 0;
      stuck += event.kind == EventKind::stick ? 1 : 0;
    }
  }
  EXPECT_GT(landed, 2000);
  EXPECT_GT(slid, 100);
  EXPECT_GT(stuck, 100);
}

TEST(Energy, NeverRisesInRandomDropsOfMinitaurWithItsTailOnStops) {
  std::mt19937 rng(11);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const model::Robot robot = model::read_robot(model::find_robot("minitaur_tail", ""));
  for (int trial = 0; trial < 60; ++trial) {
    Drop drop{nominal_plant(robot.planar), {}};
    for (const char* joint : {"front_a", "front_b", "rear_a", "rear_b"})
      drop.plant.stops.push_back({joint, {0.4, 2.4}, 0.25 + 0.25 * unit(rng)});
    drop.plant.stops.push_back({"tail", {-1.6, 1.6}, 0.3});
    drop.start = start_at({0, 0, 0.4 * unit(rng), 1.4 + 0.4 * unit(rng), 0.3 * unit(rng),
                           1.4 + 0.4 * unit(rng), 0.3 * unit(rng), unit(rng)},
                          {unit(rng), unit(rng), unit(rng), 0, 0, 0, 0, 3.0 * unit(rng)});
    lift_off(drop, 0.1);
    const Simulation s = simulate(drop.plant, no_controller(), drop.start, options_for(0.4, 41));
    EXPECT_EQ(s.status, SimulationStatus::done) << trial << ": " << s.message;
    expect_passive(drop, s, 1e-5, "trial " + std::to_string(trial));
  }
}

}  // namespace
}  // namespace jaculus::simulation
