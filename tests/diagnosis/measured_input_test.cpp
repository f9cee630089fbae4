// Logged inputs: every motor's log drives the model, and windows are motions of their own.

#include "diagnosis/forward/measured_input.h"

#include <gtest/gtest.h>

#include <cmath>

#include "diagnosis/build_problem.h"
#include "diagnosis/logged_trials.h"
#include "jaculus/core/installation.h"
#include "jaculus/model/robot.h"

namespace jaculus::diagnosis {
namespace {

/// A trial in which two motors of Minitaur were logged, each with stamps of its own.
ObservedDataset two_logs() {
  ObservedDataset observed;
  observed.model = model::read_robot(source_folder() / "models" / "minitaur").planar;
  observed.measured_input = true;
  observed.dataset.controller.kind = trajectory::ControllerKind::measured;
  observed.dataset.controller.input = trajectory::Quantity::torque;
  const auto stream = [](const std::string& name, const std::string& channel, double from) {
    trajectory::Stream s{name,      100.0,   Vector::LinSpaced(11, from, from + 0.1),
                         {channel}, {"N m"}, Matrix(1, 11)};
    s.values.row(0) = (10.0 * s.time.array()).matrix().transpose();
    return s;
  };
  observed.dataset.trials = {
      {"trial_01", {stream("one", "front_a_torque", 0.0), stream("two", "rear_b_torque", 0.005)}}};
  return observed;
}

TEST(MeasuredInput, DrivesEveryMotorThatWasLogged) {
  const ObservedDataset observed = two_logs();
  Segment segment;
  segment.start = 0.02;
  const simulation::Controller controller = measured_controller(observed, segment, 1e-4);
  const simulation::Reference& reference = controller.reference;
  ASSERT_EQ(reference.motors, (std::vector<std::string>{"front_a", "rear_b"}));
  // Stamps of both logs; each log is linear in time, whichever stamps it had.
  EXPECT_EQ(reference.time[0], 0.0);
  for (Eigen::Index i = 1; i < reference.time.size() && reference.time[i] < 0.08; ++i)
    for (int m = 0; m < 2; ++m)
      EXPECT_NEAR(reference.feedforward(m, i), 10.0 * (0.02 + reference.time[i]), 1e-9);
}

TEST(MeasuredInput, AveragesADenseLogAndKeepsItsLine) {
  const ObservedDataset observed = two_logs();
  Segment segment;
  segment.start = 0.0;
  const simulation::Reference fine = measured_controller(observed, segment, 1e-4).reference,
                              thin = measured_controller(observed, segment, 0.025).reference;
  EXPECT_LT(thin.time.size(), fine.time.size());
  for (Eigen::Index i = 1; i + 1 < thin.time.size(); ++i)
    EXPECT_NEAR(thin.feedforward(0, i), 10.0 * thin.time[i], 1e-9);
}

TEST(MeasuredInput, ALateLogBeginsWithWhatWasLoggedBefore) {
  const ObservedDataset observed = two_logs();
  Segment segment;
  segment.start = 0.05;
  const simulation::Reference late = measured_controller(observed, segment, 1e-4, 0.02).reference;
  EXPECT_NEAR(late.feedforward(0, 0), 10.0 * 0.03, 1e-9);
}

TEST(MeasuredInput, AnEarlyLogActsAheadOfItsStamps) {
  const ObservedDataset observed = two_logs();
  Segment segment;
  segment.start = 0.02;
  const simulation::Reference early = measured_controller(observed, segment, 1e-4, -0.02).reference;
  for (Eigen::Index i = 0; i < early.time.size() && early.time[i] < 0.05; ++i)
    EXPECT_NEAR(early.feedforward(0, i), 10.0 * (0.04 + early.time[i]), 1e-9) << early.time[i];
}

/// A dataset of windows that begin at 0, 1, 2, ... s.
ObservedDataset windows(int count, bool measured_input) {
  ObservedDataset observed;
  observed.measured_input = measured_input;
  for (int s = 0; s < count; ++s) {
    observed.segments.emplace_back();
    observed.segments.back().start = s;
  }
  return observed;
}

/// A group holds a plan of two seconds beside windows of half of one: what windows lack is made of
/// the same boxes and bands as it is without the plan.
TEST(ForcesOfWindows, AreTheSameBesideAPlan) {
  const std::string experiment = "double_pendulum_trials.yaml";
  const trajectory::Dataset log = test::logged(experiment, {}, {}, 2, 3),
                            plan = test::planned(experiment, {}, {}, 2, 4);
  DiagnoseOptions options;
  options.effects = {effects::find_effect("joint_viscous_friction")};
  const auto boxes = [&](const std::vector<trajectory::Dataset>& datasets) {
    const BuiltProblem built = build_problem(datasets, options);
    std::vector<int> counts;
    for (const ForceGroup& force : built.problem->hypotheses.forces)
      counts.push_back(count_of(force.boxes));
    return counts;
  };
  const std::vector<int> alone = boxes({log}), beside = boxes({log, plan}), planned = boxes({plan});
  ASSERT_EQ(alone.size(), 2U);
  EXPECT_EQ(beside, alone);
  EXPECT_GT(planned.front(), alone.front()) << "a plan alone is longer than a window";
}

/// A log in another unit diverges in every window and is left out; the plan beside it stays, in
/// which forces reach farther than they did in windows.
TEST(ForcesOfWindows, LeaveAPlanWhereTheLogIsLeftOut) {
  const std::string experiment = "double_pendulum_trials.yaml";
  trajectory::Dataset log = test::logged(experiment, {}, {}, 2, 3);
  const trajectory::Dataset plan = test::planned(experiment, {}, {}, 3, 4);
  for (trajectory::Trial& trial : log.trials)
    for (trajectory::Stream& stream : trial.streams)
      for (int c = 0; c < count_of(stream.channels); ++c)
        if (stream.units[c] == "rad" || stream.units[c] == "rad/s") stream.values.row(c) *= 1e7;
  DiagnoseOptions options;
  options.effects = {effects::find_effect("joint_viscous_friction")};
  const Prepared prepared = prepare(build_problem({log, plan}, options), builder_of(options));
  EXPECT_TRUE(prepared.reasons.empty()) << prepared.reasons.front();
  ASSERT_EQ(prepared.built.problem->observations.datasets.size(), 1U);
  EXPECT_EQ(prepared.noise.p.size(), count_of(prepared.built.problem->hypotheses.parameters));
}

TEST(WindowsOfAPart, AreSpreadEvenlyOverEachDataset) {
  const Observations all{{windows(40, true), windows(8, true), windows(5, false)}, {}, {}};
  EXPECT_EQ(windows_of(all), 48);

  const Observations part = with_windows(all, 12);
  ASSERT_EQ(part.datasets.size(), 3U);
  ASSERT_EQ(part.datasets[0].segments.size(), 10U);
  // One of each four, and of four windows a trial each at least twice.
  std::vector<int> places(4, 0);
  for (int k = 0; k < 10; ++k) {
    const int start = static_cast<int>(part.datasets[0].segments[k].start);
    EXPECT_EQ(start / 4, k);
    ++places[start % 4];
  }
  for (const int times : places) EXPECT_GE(times, 2);
  ASSERT_EQ(part.datasets[1].segments.size(), 2U);
  EXPECT_LT(part.datasets[1].segments[0].start, 4);
  EXPECT_GE(part.datasets[1].segments[1].start, 4);
  EXPECT_EQ(part.datasets[2].segments.size(), 5U);  // a plan's: no windows
  EXPECT_EQ(windows_of(with_windows(all, 48)), 48);
}

}  // namespace
}  // namespace jaculus::diagnosis
