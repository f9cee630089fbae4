#include "diagnosis/forward/prediction_memory.h"

#include <gtest/gtest.h>

#include <memory>

namespace jaculus::diagnosis {
namespace {

/// Predicts the sum of its parameters, and counts what it was asked for.
struct Counted {
  std::shared_ptr<int> asked = std::make_shared<int>(0);
  ForwardModel model = [asked = asked](int dataset, int segment, const Vector& p) {
    ++*asked;
    Prediction prediction;
    prediction.valid = true;
    prediction.values = Matrix::Constant(1, 100, p.sum() + 10.0 * dataset + 100.0 * segment);
    return prediction;
  };
};

Vector three(double a, double b, double c) { return Eigen::Vector3d(a, b, c); }

Hypotheses of_owners(const std::vector<std::string>& owners) {
  Hypotheses hypotheses;
  for (const std::string& owner : owners) {
    FreeParameter parameter;
    parameter.owner = owner;
    hypotheses.parameters.push_back(parameter);
  }
  return hypotheses;
}

TEST(PredictionMemory, WhatIsKnownIsNotSimulatedAgain) {
  const Counted counted;
  const ForwardModel model = remembering(counted.model, three(0, 0, 0), 1.0);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(model(0, 0, three(1, 2, 0)).values(0, 7), 3.0);
  EXPECT_EQ(*counted.asked, 1);

  // Neither the same sum nor the same parameters of another simulation are the same.
  EXPECT_EQ(model(0, 0, three(2, 1, 0)).values(0, 0), 3.0);
  EXPECT_EQ(model(1, 0, three(1, 2, 0)).values(0, 0), 13.0);
  EXPECT_EQ(model(0, 1, three(1, 2, 0)).values(0, 0), 103.0);
  EXPECT_EQ(*counted.asked, 4);
}

TEST(PredictionMemory, IsFullAtItsSizeAndKeepsWhatCameFirst) {
  const Counted counted;
  const ForwardModel model = remembering(counted.model, three(0, 0, 0), 2.5e-3);  // one of 1.8 kB
  for (int i = 0; i < 2; ++i)
    for (const double a : {1.0, 2.0}) EXPECT_EQ(model(0, 0, three(a, 0, 0)).values(0, 0), a);
  EXPECT_EQ(*counted.asked, 3) << "the second is simulated twice";

  const Counted every;
  const ForwardModel none = remembering(every.model, three(0, 0, 0), 0.0);
  for (int i = 0; i < 2; ++i) none(0, 0, three(1, 0, 0));
  EXPECT_EQ(*every.asked, 2);
}

TEST(PredictionMemory, LeavesWhatNoAddedEffectMovesToTheModelBefore) {
  const Counted few, more;
  const Problem before{{}, of_owners({"friction", "start"}), few.model, {}, {}};
  const ForwardModel model = beside(more.model, of_owners({"friction", "push", "start"}), before);
  EXPECT_EQ(model(0, 0, three(1, 0, 4)).values(0, 0), 5.0);
  EXPECT_EQ(*few.asked, 1);
  EXPECT_EQ(*more.asked, 0);
  EXPECT_EQ(model(0, 0, three(1, 1e-300, 4)).values(0, 0), 5.0);
  EXPECT_EQ(*few.asked, 1);
  EXPECT_EQ(*more.asked, 1);
}

}  // namespace
}  // namespace jaculus::diagnosis
