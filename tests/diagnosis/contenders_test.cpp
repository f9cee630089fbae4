// Probabilities over the spaces of contenders: means by hand, and a search that doesn't change
// where one model leads.

#include "diagnosis/selection/contenders.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/selection/search.h"
#include "diagnosis/toy.h"

namespace jaculus::diagnosis {
namespace {

using test::toy_problem;
using test::toy_truth;

SpaceWeight of(double probability, double shift = 0.0) {
  return {-kInfinity, std::log(probability) + shift};
}

double probability(const SpaceWeight& weight) {
  return std::exp(weight.complete) + std::exp(weight.lacking);
}

TEST(Contenders, HaveTheMeansOfTheirProbabilitiesWhateverASpaceIsWorth) {
  // The second space is 300 nats better in all: it counts as much as the first.
  const std::vector<SpaceWeight> here = {of(0.1), of(0.6), of(0.3)};
  const std::vector<SpaceWeight> mean =
      over_spaces(here, {{of(0.2), of(0.7), of(0.1)}, {of(0.1, 300), of(0.1, 300), of(0.8, 300)}});

  ASSERT_EQ(mean.size(), 3u);
  EXPECT_NEAR(probability(mean[0]), 0.15, 1e-12);
  EXPECT_NEAR(probability(mean[1]), 0.40, 1e-12);
  EXPECT_NEAR(probability(mean[2]), 0.45, 1e-12);
}

TEST(Contenders, KeepTheSumOfTheSearchAndWhatLacksApart) {
  const std::vector<SpaceWeight> here = {{std::log(2.0), std::log(6.0)}, {-kInfinity, 0.0}};
  const std::vector<SpaceWeight> mean =
      over_spaces(here, {{SpaceWeight{std::log(0.5), std::log(0.25)}, of(0.25)}});

  EXPECT_NEAR(std::exp(mean[0].lacking), 4.5, 1e-12);
  EXPECT_NEAR(std::exp(mean[0].complete), 2.25, 1e-12);
  EXPECT_NEAR(std::exp(mean[1].complete), 2.25, 1e-12);
  EXPECT_EQ(mean[1].lacking, -kInfinity);
}

TEST(Contenders, LeaveOthersAsFarBehindWhatLeadsAsTheyWere) {
  // Of the search: 1 : 4 : 2. There the last leads by 9, so that the first is a half of it.
  const std::vector<SpaceWeight> here = {of(1.0), of(4.0), of(2.0)};
  const std::vector<SpaceWeight> mean = over_spaces(here, {{std::nullopt, of(1.0), of(9.0)}});

  const double all = 9.0 / 4.0 + 1.0 + 9.0;
  EXPECT_NEAR(probability(mean[0]), 7.0 * 9.0 / 4.0 / all, 1e-12);
  EXPECT_NEAR(probability(mean[2]), 7.0 * 9.0 / all, 1e-12);
}

TEST(Contenders, AreAsTheyWereWithoutASpaceOfTheirOwn) {
  const std::vector<SpaceWeight> here = {of(0.25), {std::log(0.5), std::log(0.25)}};
  const std::vector<SpaceWeight> mean = over_spaces(here, {});
  EXPECT_EQ(mean[0].complete, here[0].complete);
  EXPECT_EQ(mean[1].lacking, here[1].lacking);
}

/// Singles of the toy, searched twice in one space: the second time contenders are pooled.
SearchResult searched(const Problem& problem) {
  const Vector nominal = problem.hypotheses.nominal();
  const Comparison comparison =
      comparison_about(problem, with_random_effects(problem, estimate_noise(problem, nominal)));
  const SearchResult first =
      search_models(problem, comparison, {1, nullptr, false, {}, {}, {}, {}});
  return search_models(problem, comparison, {1, &first, false, {}, {}, {}, {}});
}

int contenders_of(const SearchResult& search) {
  double best = -kInfinity;
  for (const ModelFit& model : search.models) best = std::max(best, model.log_weight_there());
  return static_cast<int>(
      std::count_if(search.models.begin(), search.models.end(), [best](const ModelFit& model) {
        return model.log_weight_there() >= best - Settings{}.clear_lead;
      }));
}

TEST(Contenders, ThatAreOneModelByTwoNamesStayAsProbableAsEachOther) {
  const SearchResult found = searched(*toy_problem(toy_truth(0.08, 0.0)));
  ASSERT_EQ(contenders_of(found), 2);  // `first` and `twin`, whose spaces are the same
  const Posterior posterior = posterior_of(found, Settings{});
  const ModelFit* first = posterior.find({0});
  const ModelFit* twin = posterior.find({2});
  ASSERT_TRUE(first != nullptr && twin != nullptr);

  const double here = first->log_weight_there() - twin->log_weight_there();
  EXPECT_NEAR(first->log_weight() - twin->log_weight(), here, 0.1);
  EXPECT_NEAR(first->probability() + twin->probability(), 1.0, 1e-6);
}

TEST(Contenders, TellNoiseThatMovesThemLittleWhereOneIsTrue) {
  // So small that none contends: about none the effect is left in the rows, about it, it is not.
  const SearchResult found = searched(*toy_problem(toy_truth(1.5e-3, 0.0)));
  ASSERT_GT(contenders_of(found), 2);
  bool moved = false;
  for (const ModelFit& model : found.models) {
    if (!model.fit.valid) continue;
    moved = moved || model.moved != 0.0;
    EXPECT_LT(std::abs(model.moved), 1.0);
  }
  EXPECT_TRUE(moved);
}

TEST(Contenders, OfWhichThereIsOneAloneKeepWhatTheSearchGaveThem) {
  const SearchResult found = searched(*toy_problem(toy_truth(0.0, 0.2)));
  ASSERT_EQ(contenders_of(found), 1);
  for (const ModelFit& model : found.models) {
    EXPECT_EQ(model.moved, 0.0);
    EXPECT_EQ(model.moved_complete, 0.0);
  }
}

}  // namespace
}  // namespace jaculus::diagnosis
