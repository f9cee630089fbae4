// Logged inputs: every motor's log drives the model, and windows are motions of their own.

#include "diagnosis/forward/measured_input.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "diagnosis/selection/structure.h"
#include "diagnosis/toy.h"
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
  const simulation::Controller controller = measured_controller(observed, segment);
  const simulation::Reference& reference = controller.reference;
  ASSERT_EQ(reference.motors, (std::vector<std::string>{"front_a", "rear_b"}));
  // Stamps of both logs; each log is linear in time, whichever stamps it had.
  EXPECT_EQ(reference.time[0], 0.0);
  for (Eigen::Index i = 1; i < reference.time.size() && reference.time[i] < 0.08; ++i)
    for (int m = 0; m < 2; ++m)
      EXPECT_NEAR(reference.feedforward(m, i), 10.0 * (0.02 + reference.time[i]), 1e-9);
}

/// Windows of a long record in which something is left, of a window's length, or nothing.
double structure_of_windows(double size) {
  const auto problem = test::toy_problem(Vector::Zero(4));
  ObservedDataset& observed = problem->observations.datasets[0];
  observed.measured_input = true;
  observed.window_start = 0.0;
  observed.window_end = 25.0;
  for (int s = 0; s < count_of(observed.segments); ++s) {
    Segment& segment = observed.segments[s];
    segment.start = 5.0 * s;
    for (int c = 0; c < 2; ++c) {
      for (Eigen::Index i = 0; i < segment.time[c].size(); ++i)
        if (segment.time[c][i] > 0.0)
          segment.value[c][i] +=
              (s % 2 == 0 ? size : -size) * std::sin(std::numbers::pi * segment.time[c][i] / 0.5);
      segment.time[c].array() += segment.start;
    }
  }

  const Vector p = Vector::Zero(4);
  const NoiseModel noise = estimate_noise(*problem, p);
  const Whitening whitening = whitening_of(*problem, noise);
  return structure_evidence(*problem, noise, whitening, evaluate_model(*problem, whitening, p));
}

TEST(MeasuredInput, WindowsAreMotionsOfTheirOwnForWhatIsLeft) {
  // Half a sine of a window's length, which no mode over the record's 25 s has.
  EXPECT_LT(structure_of_windows(0.0), 0.0);
  EXPECT_GT(structure_of_windows(5e-3), 100.0);
}

}  // namespace
}  // namespace jaculus::diagnosis
