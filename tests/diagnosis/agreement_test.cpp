#include "diagnosis/validation/agreement.h"

#include <gtest/gtest.h>

#include "diagnosis/build_problem.h"
#include "diagnosis/toy.h"

namespace jaculus::test {
namespace {

using diagnosis::Agreement;

/// The toy in two datasets, bent by `second` this much in each, accounted for by that candidate.
Agreement agreement(double in_first, double in_second) {
  const auto problem = toy_problem(toy_truth(0.0, in_first));
  ToyData other;
  other.seed = 2;
  problem->observations.datasets.push_back(
      toy_problem(toy_truth(0.0, in_second), other)->observations.datasets[0]);
  for (diagnosis::ObservedDataset& observed : problem->observations.datasets)
    observed.dataset.folder = &observed == problem->observations.datasets.data() ? "one" : "two";

  const Vector nominal = Vector::Zero(4);
  Vector start = nominal;
  start[1] = 0.5 * (in_first + in_second);
  const diagnosis::Comparison comparison =
      comparison_about(*problem, with_random_effects(*problem, estimate_noise(*problem, start)));
  const diagnosis::Fit none = evaluate_model(*problem, comparison.whitening, nominal);
  return agreement_of(*problem, comparison, none, {}, {1}, start);
}

TEST(Agreement, OfOneCauseHoldsInEverySetThatItsFitNeverSaw) {
  const Agreement found = agreement(0.4, 0.4);
  ASSERT_EQ(found.sets.size(), 2U);
  for (const diagnosis::SetAgreement& set : found.sets) {
    EXPECT_TRUE(set.agrees) << set.dataset;
    EXPECT_TRUE(set.harmed_by.empty()) << set.dataset;
    EXPECT_GT(set.channels[0].stated, 10.0 * set.channels[0].held_out) << set.dataset;
  }
  EXPECT_EQ(found.sets[1].dataset, "two");
  EXPECT_GT(found.explained("a", &diagnosis::ChannelAgreement::held_out), 0.95);
}

TEST(Agreement, NamesTheCauseThatFitsOneSetAndHarmsAnother) {
  const Agreement found = agreement(0.4, -0.1);
  ASSERT_EQ(found.sets.size(), 2U);
  EXPECT_FALSE(found.sets[1].agrees);
  EXPECT_EQ(found.sets[1].harmed_by, std::vector<std::string>{"second"});
  EXPECT_TRUE(found.sets[0].harmed_by.empty());
}

TEST(Agreement, ExplainsTheShareOfEnergyThatAllSetsTogetherLose) {
  Agreement found;
  found.sets = {{"one", {{"mocap", "x", "m", 3.0, 2.0, 1.0, 2.0, 0.1}}, {}, true},
                {"two", {{"mocap", "x", "m", 4.0, 2.0, 0.0, 1.0, 0.1}}, {}, true}};
  EXPECT_DOUBLE_EQ(found.explained("x", &diagnosis::ChannelAgreement::account), 1.0 - 1.0 / 25.0);
  EXPECT_DOUBLE_EQ(found.explained("x", &diagnosis::ChannelAgreement::held_out), 1.0 - 5.0 / 25.0);
  EXPECT_TRUE(std::isnan(found.explained("z", &diagnosis::ChannelAgreement::held_out)));
}

}  // namespace
}  // namespace jaculus::test
