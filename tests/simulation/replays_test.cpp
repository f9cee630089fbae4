// Replays draw uncertain model values about those that the experiment's robot has.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "jaculus/core/installation.h"
#include "jaculus/model/robot.h"
#include "jaculus/model/values.h"
#include "jaculus/simulation/experiment.h"
#include "support/temporary_folder.h"

namespace jaculus::simulation {
namespace {

constexpr const char* kMass = "bodies.bob.mass";

/// The bob's mass in every drawn replay, which the robot played there has, too.
std::vector<double> drawn_masses(const std::string& override, const std::string& name,
                                 const std::string& spread, int count = 3) {
  const test::TemporaryFolder folder;
  const auto file = folder.write("swing.yaml",
                                 "format: jaculus-experiment/1\n"
                                 "name: swing\n"
                                 "experiment: pendulum\n"
                                 "robot: pendulum\n"
                                 "controller: {kind: torque}\n"
                                 "initial: {swing: 0}\n"
                                 "input: {torque: {swing: [[0, 1 N m], [0.1, 0]]}}\n"
                                 "override: {" +
                                     override +
                                     "}\n"
                                     "uncertainties: {" +
                                     name + ": " + spread + "}\n");

  std::vector<double> played, drawn;
  const auto note = [&](const Plant& plant) {
    for (const model::ModelValue& value : model::model_values(plant.model))
      if (value.path == kMass) played.push_back(value.value);
  };
  const std::vector<Replay> all = replays(read_experiment(file), count, 1, note);

  EXPECT_TRUE(all.front().values.empty());
  for (std::size_t i = 1; i < all.size(); ++i) {
    EXPECT_EQ(all[i].margins.status, SimulationStatus::done);
    drawn.push_back(all[i].values.at(kMass));
    EXPECT_NEAR(played.at(i), drawn.back(), 1e-12);
  }
  EXPECT_EQ(drawn.size(), static_cast<std::size_t>(count));
  return drawn;
}

TEST(Replays, DrawAboutTheOverriddenValueHoweverItIsWritten) {
  const std::vector<double> drawn = drawn_masses("bodies.bob.mass: 3", kMass, "10 %");
  EXPECT_NE(drawn[0], 3.0);
  EXPECT_NE(drawn[0], drawn[1]);

  EXPECT_EQ(drawn_masses("bodies.bob.mass: 3 kg", kMass, "10 %"), drawn);  // with a unit
  EXPECT_EQ(drawn_masses("bodies.*.mass: 3", kMass, "10 %"), drawn);       // by a pattern
  EXPECT_EQ(drawn_masses("bob.mass: 3", kMass, "10 %"), drawn);            // by the shorter path
  EXPECT_EQ(drawn_masses("bob.mass: 3", "bob.mass", "10 %"), drawn);
}

TEST(Replays, DrawInProportionToTheSpread) {
  const auto of_three = [](const std::string& spread) {
    return drawn_masses("bodies.bob.mass: 3", kMass, spread);
  };
  const std::vector<double> none = of_three("0 %"), tenth = of_three("10 %"),
                            fifth = of_three("20 %"), absolute = of_three("0.3 kg"),
                            of_six = drawn_masses("bodies.bob.mass: 6", kMass, "10 %");

  for (std::size_t i = 0; i < tenth.size(); ++i) {
    EXPECT_EQ(none[i], 3.0);
    EXPECT_NEAR(fifth[i] - 3.0, 2.0 * (tenth[i] - 3.0), 1e-12);
    EXPECT_NEAR(absolute[i], tenth[i], 1e-12);
    EXPECT_NEAR(of_six[i], 2.0 * tenth[i], 1e-12);
  }
}

TEST(Replays, AreTheSameInWhateverProcesses) {
  const Experiment leap = read_experiment(source_folder() / "problems/leap_trials.yaml");
  const auto text = [](const Replay& replay) {
    const Margins& m = replay.margins;
    return fmt::format("{} {} {} {} {} {} {} {}", status_name(m.status), m.friction_share,
                       m.slip_time, m.voltage_share, m.torque_share, m.current_share,
                       m.landing_pitch, m.speed);
  };
  const auto here = replays(leap, 3, 1);
  const auto there = replays(leap, 3, 1, {}, {.workers = 2, .isolate = true});
  ASSERT_EQ(here.size(), 4U);
  ASSERT_EQ(there.size(), 4U);
  for (std::size_t i = 0; i < here.size(); ++i) {
    EXPECT_EQ(here[i].values, there[i].values);
    EXPECT_EQ(text(here[i]), text(there[i]));
    EXPECT_EQ(text(here[i]) == text(here[0]), i == 0);
  }
}

TEST(Replays, DrawWithTheDeviationOfTheSpread) {
  constexpr int kCount = 24;
  double sum = 0.0, squares = 0.0;
  for (const double mass : drawn_masses("bodies.bob.mass: 3", kMass, "10 %", kCount)) {
    const double normal = (mass - 3.0) / 0.3;
    sum += normal;
    squares += normal * normal;
  }

  // Four standard deviations of a mean, and of a root mean square, of so many normal draws.
  EXPECT_NEAR(sum / kCount, 0.0, 4.0 / std::sqrt(kCount));
  EXPECT_NEAR(std::sqrt(squares / kCount), 1.0, 4.0 / std::sqrt(2.0 * kCount));
}

TEST(Replays, ModelValuesAreTheNumbersOfTheModel) {
  const auto folder = model::find_robot("minitaur_tail", "");
  const model::PlanarModel nominal = model::read_robot(folder).planar;
  const std::vector<model::ModelValue> values = model_values(nominal);
  EXPECT_GT(values.size(), 40U);

  for (const model::ModelValue& value : values) {
    const double changed = value.value == 0.0 ? 1e-3 : 0.99 * value.value;
    const auto node = yaml::Node::parse(fmt::format("{}", changed), "test");
    const model::PlanarModel other = model::read_robot(folder, {{value.path, node}}).planar;
    int differing = 0;
    for (const model::ModelValue& now : model_values(other)) {
      const bool own = now.path == value.path;
      EXPECT_NEAR(now.value, own ? changed : now.value, 1e-15) << value.path;
      for (const model::ModelValue& was : values)
        differing += was.path == now.path && was.value != now.value ? 1 : 0;
    }
    EXPECT_EQ(differing, 1) << value.path;
  }
}

}  // namespace
}  // namespace jaculus::simulation
