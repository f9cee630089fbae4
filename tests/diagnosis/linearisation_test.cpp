#include "jaculus/diagnosis/linearisation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "diagnosis/localise_rows.h"
#include "diagnosis/toy.h"
#include "jaculus/diagnosis/evidence_space.h"
#include "jaculus/diagnosis/fit.h"
#include "jaculus/effects/select.h"
#include "jaculus/simulation/experiment.h"

namespace jaculus::test {
namespace {

double wave(double t) { return 0.05 * std::sin(120.0 * t); }  // 6 per second at most: 1.8 noise floors in 0.3 ms

/// The toy with waves in both channels, the second one logged 0.3 ms later than the first; chi2 a row at the truth.
double misfit_of_late_second(bool held) {
  const auto problem = toy_problem(Vector::Zero(4));
  Condition& condition = problem->observations.conditions[0];
  condition.channels[1].held = held;
  std::mt19937 generator(7);
  std::normal_distribution<double> normal(0.0, 1e-3);
  for (auto& run : condition.runs)
    for (std::size_t c = 0; c < 2; ++c)
      for (Eigen::Index i = 0; i < run.time[c].size(); ++i)
        run.value[c][i] = wave(std::max(0.0, run.time[c][i] - (c == 1 ? 3e-4 : 0.0))) + normal(generator);
  problem->forward = [](int, int, const Vector&) {
    Prediction prediction;
    prediction.valid = true;
    prediction.values.resize(2, 531);
    for (int c = 0; c < 2; ++c)
      for (int i = 0; i < 531; ++i) prediction.values(c, i) = wave(1e-3 * i);
    return prediction;
  };
  Linearisation about = linearise(*problem, Vector::Zero(4));
  for (Channel& channel : condition.channels) channel.noise_floor = 1e-3;
  const EvidenceSpace space = evidence_space(*problem, about);
  return evaluate_model(*problem, space, Vector::Zero(4)).chi2 / space.rows;
}

TEST(Linearisation, LeavesThePhaseOfALogWithinTheLoopsPeriodFree) {
  EXPECT_LT(misfit_of_late_second(true), 1.1);
  EXPECT_GT(misfit_of_late_second(false), 1.3);  // what no loop holds has no such freedom
}

TEST(Linearisation, ChangedByNothingIsUnchanged) {
  const Experiment experiment =
      read_experiment(std::filesystem::path(JACULUS_SOURCE_DIR) / "problems" / "leap_trials.yaml");
  const Robot robot = dataset_robot(experiment.setup);
  const Controller controller = experiment_controller(experiment, robot.planar);
  Dataset dataset = experiment.setup;
  for (int k = 0; k < 3; ++k)
    dataset.trials.push_back(
        run_trial(experiment, dataset_plant(experiment.setup, robot.planar), controller, k, 1).trial);
  DiagnosisProblem problem;
  problem.observations = observe({dataset}, {robot.planar});
  const PlantForward forward = plant_forward(problem.observations, {find_effect("tail_coulomb_friction")});
  problem.hypotheses = forward.hypotheses;
  problem.forward = forward.predict;
  const Vector p = problem.hypotheses.nominal();
  Vector changed;
  ASSERT_TRUE(predict_changed(
      problem, forward, 0, p, [](RunSetup&) {}, changed));
  EXPECT_EQ(changed, rows_of(problem, predict_all(problem, p)).front());
}

TEST(Linearisation, KeepsRowsEnoughForTheNoiseFloorWhereImpactsComeEarly) {
  // Twelve rows a run, an impact after four of them; start, shift and offset of every run leave nothing of four.
  const auto problem = toy_problem(Vector::Zero(4));
  Condition& condition = problem->observations.conditions[0];
  condition.channels[0].name = "x";
  condition.channels[1].name = "z";
  for (auto& run : condition.runs)
    for (std::size_t c = 0; c < 2; ++c) {
      Vector time(12), value(12);
      for (Eigen::Index i = 0; i < 12; ++i) {
        time[i] = run.time[c][10 + 8 * i];
        value[i] = run.value[c][10 + 8 * i];
      }
      run.time[c] = time;
      run.value[c] = value;
    }
  const ForwardModel smooth = problem->forward;
  problem->forward = [smooth](int c, int r, const Vector& p) {
    Prediction prediction = smooth(c, r, p);
    prediction.impacts = {0.15};
    return prediction;
  };
  problem->hypotheses.starts = {0, 1};
  linearise(*problem, Vector::Zero(4));
  for (const Channel& channel : condition.channels) {
    EXPECT_GT(channel.noise_floor, 3e-4) << channel.name;
    EXPECT_LT(channel.noise_floor, 3e-3) << channel.name;
  }
}

TEST(Linearisation, IsNotMisalignedByAnImpactThatIsNotWhereItWasPredicted) {
  // Smooth at first; at 0.3 s the prediction stops dead, the data 8 ms later. Clocks are off by run.
  const auto problem = toy_problem(Vector::Zero(4));
  Condition& condition = problem->observations.conditions[0];
  const auto stopped = [](std::size_t c, double t, double stop) {
    return c == 0 ? std::pow(std::clamp(t, 0.0, stop), 2) : (t > 0.0 && t < stop ? 2.0 * t : 0.0);
  };
  std::mt19937 generator(3);
  std::normal_distribution<double> normal(0.0, 1e-4);
  std::vector<double> late;
  for (std::size_t r = 0; r < condition.runs.size(); ++r) {
    auto& run = condition.runs[r];
    late.push_back(1e-3 * (static_cast<double>(r) - 2.0));
    for (std::size_t c = 0; c < 2; ++c)
      for (Eigen::Index i = 0; i < run.time[c].size(); ++i)
        run.value[c][i] = stopped(c, run.time[c][i] - late[r], 0.308) + normal(generator);
  }
  problem->forward = [&stopped](int, int, const Vector&) {
    Prediction prediction;
    prediction.valid = true;
    prediction.impacts = {0.3};
    prediction.values.resize(2, 531);
    for (std::size_t c = 0; c < 2; ++c)
      for (int i = 0; i < 531; ++i) prediction.values(static_cast<Eigen::Index>(c), i) = stopped(c, 1e-3 * i, 0.3);
    return prediction;
  };
  linearise(*problem, Vector::Zero(4));
  for (std::size_t r = 0; r < late.size(); ++r) EXPECT_NEAR(condition.runs[r].shift[0], late[r], 5e-4) << r;
}

TEST(Linearisation, KnowsALateCommandFromALateClockByItsPriorAlone) {
  // A command that is late by p is the same motion later: free clocks make every p alike but for what they cost.
  const auto problem = toy_problem(Vector::Zero(4));
  Condition& condition = problem->observations.conditions[0];
  for (auto& run : condition.runs)
    for (std::size_t c = 0; c < 2; ++c)
      for (Eigen::Index i = 0; i < run.time[c].size(); ++i) run.value[c][i] = wave(std::max(0.0, run.time[c][i]));
  problem->forward = [](int, int, const Vector& p) {
    Prediction prediction;
    prediction.valid = true;
    prediction.late.assign(2, p[0]);
    prediction.values.resize(2, 531);
    for (int c = 0; c < 2; ++c)
      for (int i = 0; i < 531; ++i) prediction.values(c, i) = wave(std::max(0.0, 1e-3 * i - p[0]));
    return prediction;
  };
  Linearisation about = linearise(*problem, Vector::Zero(4));
  for (Channel& channel : condition.channels) channel.noise_floor = 1e-3;
  const EvidenceSpace space = evidence_space(*problem, about);
  const auto chi2 = [&](double late) { return evaluate_model(*problem, space, Vector::Unit(4, 0) * late).chi2; };
  // A quarter of the wave's rise, 13 ms, is far beyond the reach of a slope; the clocks' price is (late/s)^2 a run.
  const double s = 2e-3 * std::sqrt(2.0 / (2.0 + static_cast<double>(condition.runs.size()) - 1.0));
  const double price = static_cast<double>(condition.runs.size()) * std::pow(5e-3 / s, 2);
  EXPECT_NEAR(chi2(5e-3) - chi2(0.0), price, 0.15 * price);
}

/// What the shipped leap is observed by.
std::vector<Channel> channels_of_leap(const std::function<void(Dataset&)>& change) {
  const Experiment experiment =
      read_experiment(std::filesystem::path(JACULUS_SOURCE_DIR) / "problems" / "leap_trials.yaml");
  const Robot robot = dataset_robot(experiment.setup);
  Dataset dataset = experiment.setup;
  dataset.trials.push_back(run_trial(experiment, dataset_plant(experiment.setup, robot.planar),
                                     experiment_controller(experiment, robot.planar), 0, 1)
                               .trial);
  for (Stream& stream : dataset.trials.front().streams)
    for (std::string& name : stream.channels)
      if (name == "tail_current") name = "tail_duty";
  change(dataset);
  const Observations observed = observe({dataset}, {robot.planar});
  for (const Run& run : observed.conditions.front().runs)
    for (std::size_t c = 0; c < run.time.size(); ++c) {
      const bool held = observed.conditions.front().channels[c].held && run.time[c].size() > 0;
      EXPECT_GE(held ? run.time[c][0] : 1.0, 4.9e-3);  // before, what held the robot, not the command
    }
  return observed.conditions.front().channels;
}

bool has(const std::vector<Channel>& channels, const std::string& name) {
  return std::any_of(channels.begin(), channels.end(), [&](const Channel& channel) { return channel.name == name; });
}

TEST(Observe, ADutyIsEvidenceOnlyWhereATorqueWasAskedFor) {
  EXPECT_TRUE(has(channels_of_leap([](Dataset&) {}), "tail_duty"));
  EXPECT_FALSE(has(channels_of_leap([](Dataset& d) { d.controller.quantity = "duty"; }), "tail_duty"));
  EXPECT_FALSE(has(channels_of_leap([](Dataset& d) { d.controller.quantity_stated = false; }), "tail_duty"));
}

}  // namespace
}  // namespace jaculus::test
