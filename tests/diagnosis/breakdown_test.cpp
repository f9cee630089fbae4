// A model as stated that can't be simulated to the end of the data.

#include <gtest/gtest.h>

#include "diagnosis/build_problem.h"
#include "diagnosis/toy.h"

namespace jaculus::test {
namespace {

/// The toy, whose simulation breaks down at `reached` unless the observations end before.
diagnosis::Prepared prepared(double reached) {
  const auto toy = toy_problem(toy_truth(0.0, 0.2));
  const diagnosis::ForwardModel whole = toy->forward;
  const diagnosis::ProblemBuilder build = [=](diagnosis::Observations observations) {
    auto problem = std::make_shared<diagnosis::Problem>(*toy);
    const double end = observations.datasets[0].window_end;
    problem->observations = std::move(observations);
    problem->forward = [=](int dataset, int segment, const Vector& p) {
      diagnosis::Prediction prediction = whole(dataset, segment, p);
      prediction.valid = end < reached;
      prediction.reached = reached;
      if (!prediction.valid) prediction.message = "the equations of motion are singular";
      return prediction;
    };
    return diagnosis::BuiltProblem{problem, {}};
  };
  return prepare(build(toy->observations), build);
}

TEST(Breakdown, LeavesOutTheDataBeyondAndSaysSo) {
  const diagnosis::Prepared out = prepared(0.4);
  EXPECT_TRUE(out.reasons.empty());
  ASSERT_FALSE(out.notes.empty());
  EXPECT_NE(out.notes[0].find("singular"), std::string::npos) << out.notes[0];
  const diagnosis::ObservedDataset& kept = out.built.problem->observations.datasets.at(0);
  EXPECT_EQ(kept.segments.size(), 5U);
  for (const diagnosis::Segment& segment : kept.segments) {
    EXPECT_LT(segment.end(), 0.4 - out.built.problem->settings.simulated_beyond);
    EXPECT_GT(segment.end(), 0.36);
  }
}

TEST(Breakdown, BeforeAnythingIsPredictedEndsTheDiagnosis) {
  const diagnosis::Prepared out = prepared(-0.04);
  ASSERT_EQ(out.reasons.size(), 1U);
  EXPECT_NE(out.reasons[0].find("singular"), std::string::npos) << out.reasons[0];
}

}  // namespace
}  // namespace jaculus::test
