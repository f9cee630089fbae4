// Two effects of which neither leads alone, behind others that each do a part of both.

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "diagnosis/selection/search.h"
#include "diagnosis/toy.h"

namespace jaculus::diagnosis {
namespace {

constexpr int kGain = 4;  // index of the nuisance
constexpr double kTrueSize = 0.02;
constexpr double kOfBoth = 0.7;  // of what both do, that a stand-in does at most
constexpr double kTwinLess = 0.97;

/// Effects 0 and 1 do nothing where the gain is 1, which is where 2 and 3 need it: about those
/// neither has a slope, and what both do is to be found from another single than the leading one.
std::shared_ptr<Problem> hidden_problem() {
  const auto predicted = [](double one, double other, double stand_in, double gain) {
    Prediction prediction = test::toy_prediction(Vector::Zero(4));
    const auto count = prediction.values.cols();
    for (Eigen::Index i = 0; i < count; ++i) {
      const double s = std::numbers::pi * static_cast<double>(i) / static_cast<double>(count - 1);
      const double hold = std::pow(1.0 - gain, 2);
      const double first = std::sin(s), second = std::sin(2.0 * s);
      const double by_gain = std::sin(3.0 * s);
      const double some = kTrueSize * std::tanh(stand_in / kTrueSize);
      const double does = some * (kOfBoth * (first + second) - by_gain);
      prediction.values(0, i) +=
          hold * (one * first + other * second) + does + kTrueSize * gain * by_gain;
    }
    return prediction;
  };

  auto problem = test::toy_problem(Vector::Zero(4));
  Hypotheses& hypotheses = problem->hypotheses;
  for (int k = 0; k < 4; ++k) hypotheses.parameters[k].bounds = {-1.0, 1.0};
  for (int k = 0; k < 4; ++k) hypotheses.parameters[k].scale = kTrueSize;
  hypotheses.parameters.push_back({"nuisance", "gain", "-", 0.0, 1.0, {-5.0, 5.0}});
  hypotheses.gains = {kGain};
  problem->forward = [predicted](int, int, const Vector& p) {
    return predicted(p[0], p[1], p[2] + kTwinLess * p[3], p[kGain]);
  };

  const Prediction clean = test::toy_prediction(Vector::Zero(4));
  const Prediction truth = predicted(kTrueSize, kTrueSize, 0.0, 0.0);
  for (Segment& segment : problem->observations.datasets[0].segments)
    for (Eigen::Index i = 0; i < segment.time[0].size(); ++i) {
      if (segment.time[0][i] < 0.0) continue;
      const auto k = static_cast<Eigen::Index>(std::lround(segment.time[0][i] / clean.step));
      segment.value[0][i] += truth.values(0, k) - clean.values(0, k);
    }
  return problem;
}

/// The effects of the most probable model, pairs being sought from so many singles.
std::vector<int> leading_set(int pair_roots) {
  const auto problem = hidden_problem();
  problem->settings.pair_roots = pair_roots;
  NoiseModel noise = estimate_noise(*problem, problem->hypotheses.nominal());
  const Comparison comparison =
      comparison_about(*problem, with_random_effects(*problem, std::move(noise)));
  const SearchResult search = select_models(*problem, comparison, {}).search;
  return most_probable_first(search.models).at(0)->candidates;
}

TEST(HiddenPair, IsSoughtFromSinglesThatNothingLeadsClearly) {
  EXPECT_EQ(leading_set(Settings().pair_roots), (std::vector<int>{0, 1}));
  EXPECT_EQ(leading_set(2), (std::vector<int>{2}));
}

}  // namespace
}  // namespace jaculus::diagnosis
