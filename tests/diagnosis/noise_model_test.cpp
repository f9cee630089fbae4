#include "diagnosis/noise/noise_model.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "diagnosis/forward/plant_forward.h"
#include "diagnosis/forward/sensitivities.h"
#include "diagnosis/noise/whitening.h"
#include "diagnosis/selection/fit.h"
#include "diagnosis/toy.h"
#include "jaculus/core/installation.h"
#include "jaculus/effects/select.h"
#include "jaculus/simulation/experiment.h"

namespace jaculus::test {
namespace {

// 6 per second at most: 1.8 noise floors in 0.3 ms
double wave(double t) { return 0.05 * std::sin(120.0 * t); }

/// The toy with waves in both channels, the second one logged 0.3 ms later than the first; chi2 a
/// row at the truth.
double misfit_of_late_second(bool held) {
  const auto problem = toy_problem(Vector::Zero(4));
  diagnosis::ObservedDataset& dataset = problem->observations.datasets[0];
  dataset.channels[1].zero_order_hold = held;
  std::mt19937 generator(7);
  std::normal_distribution<double> normal(0.0, 1e-3);
  for (auto& segment : dataset.segments)
    for (std::size_t c = 0; c < 2; ++c)
      for (Eigen::Index i = 0; i < segment.time[c].size(); ++i)
        segment.value[c][i] =
            wave(std::max(0.0, segment.time[c][i] - (c == 1 ? 3e-4 : 0.0))) + normal(generator);
  problem->forward = [](int, int, const Vector&) {
    diagnosis::Prediction prediction;
    prediction.valid = true;
    prediction.values.resize(2, 531);
    for (int c = 0; c < 2; ++c)
      for (int i = 0; i < 531; ++i) prediction.values(c, i) = wave(1e-3 * i);
    return prediction;
  };
  diagnosis::NoiseModel about = diagnosis::estimate_noise(*problem, Vector::Zero(4));
  for (diagnosis::ChannelNoise& channel : about.datasets[0].channels) channel.noise_floor = 1e-3;
  const diagnosis::Whitening space = diagnosis::whitening_of(*problem, about);
  return diagnosis::evaluate_model(*problem, space, Vector::Zero(4)).chi2 / space.rows;
}

TEST(NoiseModel, LeavesThePhaseOfALogWithinTheLoopsPeriodFree) {
  EXPECT_LT(misfit_of_late_second(true), 1.1);
  EXPECT_GT(misfit_of_late_second(false), 1.3);  // what no loop holds has no such freedom
}

TEST(NoiseModel, ADifferenceThereAndBackCancels) {
  const simulation::Experiment experiment =
      simulation::read_experiment(source_folder() / "problems" / "leap_trials.yaml");
  const model::PlanarModel robot = simulation::dataset_robot(experiment.setup).planar;
  const simulation::Controller controller = simulation::experiment_controller(experiment, robot);
  const simulation::Plant plant = simulation::dataset_plant(experiment.setup, robot);
  trajectory::Dataset dataset = experiment.setup;
  for (int k = 0; k < 3; ++k)
    dataset.trials.push_back(simulation::run_trial(experiment, plant, controller, k, 1).trial);

  const diagnosis::Observations observations = diagnosis::observe({dataset}, {robot});
  const diagnosis::PlantForward forward =
      diagnosis::plant_forward(observations, {effects::find_effect("tail_coulomb_friction")}, {});
  const diagnosis::Problem problem{observations, forward.hypotheses, forward.predict};
  const Vector p = problem.hypotheses.nominal();
  const std::vector<diagnosis::Alignment> alignments{
      diagnosis::unaligned(observations.datasets[0])};
  const std::vector<Vector> rows =
      diagnosis::rows_of(problem, alignments, diagnosis::predict_all(problem, p));

  const int friction = problem.hypotheses.candidates[0].parameters[0];
  const double step = 0.1 * problem.hypotheses.parameters[friction].scale;
  const auto there = diagnosis::difference_at(problem, alignments, p, rows, friction, step);
  ASSERT_TRUE(there);
  EXPECT_GT(there->rows.front().norm(), 0.0);

  // From nominal, which is 0, so that p returns to the same bits.
  Vector moved = p;
  moved[friction] += step;
  const std::vector<Vector> moved_rows =
      diagnosis::rows_of(problem, alignments, diagnosis::predict_all(problem, moved));
  const auto back =
      diagnosis::difference_at(problem, alignments, moved, moved_rows, friction, -step);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->rows.front(), -there->rows.front());
}

TEST(NoiseModel, KeepsRowsEnoughForTheNoiseFloorWhereImpactsComeEarly) {
  // Twelve rows a segment, an impact after four of them; start, shift and offset of every segment
  // leave nothing of four.
  const auto problem = toy_problem(Vector::Zero(4));
  diagnosis::ObservedDataset& dataset = problem->observations.datasets[0];
  dataset.channels[0].name = "x";
  dataset.channels[1].name = "z";
  for (auto& segment : dataset.segments)
    for (std::size_t c = 0; c < 2; ++c) {
      Vector time(12), value(12);
      for (Eigen::Index i = 0; i < 12; ++i) {
        time[i] = segment.time[c][10 + 8 * i];
        value[i] = segment.value[c][10 + 8 * i];
      }
      segment.time[c] = time;
      segment.value[c] = value;
    }
  const diagnosis::ForwardModel smooth = problem->forward;
  problem->forward = [smooth](int c, int r, const Vector& p) {
    diagnosis::Prediction prediction = smooth(c, r, p);
    prediction.impacts = {0.15};
    return prediction;
  };
  problem->hypotheses.starts = {0, 1};
  const diagnosis::NoiseModel noise = diagnosis::estimate_noise(*problem, Vector::Zero(4));
  for (const diagnosis::ChannelNoise& channel : noise.datasets[0].channels) {
    EXPECT_GT(channel.noise_floor, 3e-4);
    EXPECT_LT(channel.noise_floor, 3e-3);
  }
}

TEST(NoiseModel, IsNotMisalignedByAnImpactThatIsNotWhereItWasPredicted) {
  // Smooth at first; at 0.3 s the prediction stops dead, the data 8 ms later. Every segment's
  // clock is off by its own.
  const auto problem = toy_problem(Vector::Zero(4));
  diagnosis::ObservedDataset& dataset = problem->observations.datasets[0];
  const auto stopped = [](std::size_t c, double t, double stop) {
    return c == 0 ? std::pow(std::clamp(t, 0.0, stop), 2) : (t > 0.0 && t < stop ? 2.0 * t : 0.0);
  };
  std::mt19937 generator(3);
  std::normal_distribution<double> normal(0.0, 1e-4);
  std::vector<double> late;
  for (std::size_t r = 0; r < dataset.segments.size(); ++r) {
    auto& segment = dataset.segments[r];
    late.push_back(1e-3 * (static_cast<double>(r) - 2.0));
    for (std::size_t c = 0; c < 2; ++c)
      for (Eigen::Index i = 0; i < segment.time[c].size(); ++i)
        segment.value[c][i] = stopped(c, segment.time[c][i] - late[r], 0.308) + normal(generator);
  }
  problem->forward = [&stopped](int, int, const Vector&) {
    diagnosis::Prediction prediction;
    prediction.valid = true;
    prediction.impacts = {0.3};
    prediction.values.resize(2, 531);
    for (std::size_t c = 0; c < 2; ++c)
      for (int i = 0; i < 531; ++i)
        prediction.values(static_cast<Eigen::Index>(c), i) = stopped(c, 1e-3 * i, 0.3);
    return prediction;
  };
  const diagnosis::NoiseModel noise = diagnosis::estimate_noise(*problem, Vector::Zero(4));
  for (std::size_t r = 0; r < late.size(); ++r)
    EXPECT_NEAR(noise.alignments[0].segments[r].shift[0], late[r], 5e-4) << r;
}

TEST(NoiseModel, DatesAClockByAModelThatFitsAndHardlyByOneThatDoesNot) {
  // All clocks are 6 ms late. A motion that is 30 % too large looks late by more than that.
  for (const double size : {1.0, 0.7}) {
    const auto problem = toy_problem(Vector::Zero(4));
    diagnosis::ObservedDataset& dataset = problem->observations.datasets[0];
    std::mt19937 generator(3);
    std::normal_distribution<double> normal(0.0, 1e-4);
    for (auto& segment : dataset.segments)
      for (std::size_t c = 0; c < 2; ++c)
        for (Eigen::Index i = 0; i < segment.time[c].size(); ++i)
          segment.value[c][i] =
              size * std::pow(std::max(0.0, segment.time[c][i] - 6e-3), 2) + normal(generator);
    problem->forward = [](int, int, const Vector&) {
      diagnosis::Prediction prediction;
      prediction.valid = true;
      prediction.values.resize(2, 531);
      for (int i = 0; i < 531; ++i) prediction.values.col(i).setConstant(std::pow(1e-3 * i, 2));
      return prediction;
    };
    const diagnosis::NoiseModel noise = diagnosis::estimate_noise(*problem, Vector::Zero(4));
    for (const auto& segment : noise.alignments[0].segments) {
      if (size == 1.0) {
        EXPECT_NEAR(segment.shift[0], 6e-3, 5e-4);
        continue;
      }
      // Free of a prior it would be the largest that is allowed, 30 ms.
      EXPECT_LT(segment.shift[0], 8e-3);
    }
  }
}

TEST(NoiseModel, KnowsALateCommandFromALateClockByItsPriorAlone) {
  // A command that is late by p is the same motion later: free clocks make every p alike but for
  // what they cost.
  const auto problem = toy_problem(Vector::Zero(4));
  diagnosis::ObservedDataset& dataset = problem->observations.datasets[0];
  for (auto& segment : dataset.segments)
    for (std::size_t c = 0; c < 2; ++c)
      for (Eigen::Index i = 0; i < segment.time[c].size(); ++i)
        segment.value[c][i] = wave(std::max(0.0, segment.time[c][i]));
  problem->forward = [](int, int, const Vector& p) {
    diagnosis::Prediction prediction;
    prediction.valid = true;
    prediction.late.assign(2, p[0]);
    prediction.values.resize(2, 531);
    for (int c = 0; c < 2; ++c)
      for (int i = 0; i < 531; ++i) prediction.values(c, i) = wave(std::max(0.0, 1e-3 * i - p[0]));
    return prediction;
  };
  diagnosis::NoiseModel about = diagnosis::estimate_noise(*problem, Vector::Zero(4));
  for (diagnosis::ChannelNoise& channel : about.datasets[0].channels) channel.noise_floor = 1e-3;
  const diagnosis::Whitening space = diagnosis::whitening_of(*problem, about);
  const auto chi2 = [&](double late) {
    return diagnosis::evaluate_model(*problem, space, Vector::Unit(4, 0) * late).chi2;
  };
  // A quarter of the wave's rise, 13 ms, is far beyond the reach of a slope; the clocks' price is
  // (late/s)^2 a segment.
  const double s =
      2e-3 * std::sqrt(2.0 / (2.0 + static_cast<double>(dataset.segments.size()) - 1.0));
  const double price = static_cast<double>(dataset.segments.size()) * std::pow(5e-3 / s, 2);
  EXPECT_NEAR(chi2(5e-3) - chi2(0.0), price, 0.15 * price);
}

/// What the shipped leap is observed by.
std::vector<diagnosis::Channel> channels_of_leap(
    const std::function<void(trajectory::Dataset&)>& change) {
  const simulation::Experiment experiment =
      simulation::read_experiment(source_folder() / "problems" / "leap_trials.yaml");
  const model::Robot robot = simulation::dataset_robot(experiment.setup);
  trajectory::Dataset dataset = experiment.setup;
  dataset.trials.push_back(
      simulation::run_trial(experiment, simulation::dataset_plant(experiment.setup, robot.planar),
                            simulation::experiment_controller(experiment, robot.planar), 0, 1)
          .trial);
  for (trajectory::Stream& stream : dataset.trials.front().streams)
    for (std::string& name : stream.channels)
      if (name == "tail_current") name = "tail_duty";
  change(dataset);
  const diagnosis::Observations observed = diagnosis::observe({dataset}, {robot.planar});
  for (const diagnosis::Segment& segment : observed.datasets.front().segments)
    for (std::size_t c = 0; c < segment.time.size(); ++c) {
      const bool held =
          observed.datasets.front().channels[c].zero_order_hold && segment.time[c].size() > 0;
      // before, what held the robot, not the command
      EXPECT_GE(held ? segment.time[c][0] : 1.0, 4.9e-3);
    }
  return observed.datasets.front().channels;
}

bool has(const std::vector<diagnosis::Channel>& channels, const std::string& name) {
  return std::any_of(channels.begin(), channels.end(),
                     [&](const diagnosis::Channel& channel) { return channel.name == name; });
}

TEST(Observe, ADutyIsEvidenceOnlyWhereATorqueWasAskedFor) {
  EXPECT_TRUE(has(channels_of_leap([](trajectory::Dataset&) {}), "tail_duty"));
  EXPECT_FALSE(has(channels_of_leap([](trajectory::Dataset& d) {
                     d.controller.quantity = trajectory::Quantity::duty;
                   }),
                   "tail_duty"));
  EXPECT_FALSE(
      has(channels_of_leap([](trajectory::Dataset& d) { d.controller.quantity_stated = false; }),
          "tail_duty"));
}

}  // namespace
}  // namespace jaculus::test
