// Clocks that stand apart from a misfit: the same numbers in white rows, and no cheaper for what a
// model lacks.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

#include "diagnosis/noise/whitening.h"
#include "diagnosis/toy.h"

namespace jaculus::diagnosis {
namespace {

struct Whitened {
  std::shared_ptr<Problem> problem = test::toy_problem(test::toy_truth(0.0, 0.0));
  NoiseModel plain = estimate_noise(*problem, problem->hypotheses.nominal());
  NoiseModel noise = with_random_effects(*problem, plain);
  Whitening together = whitening_of(*problem, plain), apart = whitening_of(*problem, noise);
};

TEST(WhiteningApart, KeepsTheSumsOfSquares) {
  const Whitened w;
  ASSERT_GT(w.apart.apart, 0);
  EXPECT_EQ(w.apart.rows, w.together.rows + w.apart.apart);
  // A misfit a channel, each with its own rows, less what its nuisances hold apart.
  ASSERT_EQ(w.apart.random.misfits.size(), 2U);
  double rows = 0.0;
  for (const Misfit& misfit : w.apart.random.misfits) {
    EXPECT_LT(misfit.rows, 0.5 * w.together.rows);
    rows += misfit.rows;
  }
  EXPECT_NEAR(rows, w.together.rows - w.apart.apart, 1e-9 * rows);
  for (int seed = 0; seed < 3; ++seed) {
    std::srand(static_cast<unsigned>(seed));
    const Vector raw = Vector::Random(w.together.measured[0].size());
    const double squares = w.together.apply({raw}).squaredNorm();
    const Vector white = w.apart.apply({raw});
    EXPECT_NEAR(white.squaredNorm(), squares, 1e-9 * squares);
    EXPECT_TRUE(w.apart.in_rows(white).isApprox(w.together.apply({raw}), 1e-9));
  }
}

TEST(WhiteningApart, HasAClocksWholeDepartureOutsideOfTheMisfit) {
  const Whitened w;
  const SegmentNuisances& own = w.noise.datasets[0].nuisances[1];
  const auto clock =
      std::find_if(own.names.begin(), own.names.end(),
                   [](const std::string& name) { return name.starts_with("shift of"); }) -
      own.names.begin();
  Vector raw = Vector::Zero(w.together.measured[0].size());
  raw.segment(own.first, own.count) = 2.0 * own.scale[clock] * own.columns.col(clock);

  const Vector white = w.apart.apply({raw});
  const auto rows = w.apart.rows - w.apart.apart;
  EXPECT_LT(white.head(rows).norm(), 0.05 * white.norm());

  // Two deviations of a clock cost what they cost, however large the misfit.
  Vector scales = complete_scales(w.apart.random);
  for (const double misfit : {0.3, 30.0}) {
    for (const Misfit& own : w.apart.random.misfits) scales[own.group] = misfit;
    const Products products = products_of(w.apart.random, white);
    EXPECT_NEAR(weigh(w.apart.random, products, scales).gram(0, 0), 4.0, 0.2) << misfit;
  }
}

TEST(WhiteningMisfits, HaveTheSameGroupsWhateverTakesPart) {
  // The second dataset measures what the first doesn't: sizes fitted to both have to be theirs
  // where one is left out.
  const auto problem = test::toy_problem(test::toy_truth(0.0, 0.0));
  std::vector<ObservedDataset>& datasets = problem->observations.datasets;
  datasets.push_back(datasets.front());
  datasets[1].channels[0].name = "b_velocity";
  datasets[1].channels[1].name = "a1";
  const Vector nominal = problem->hypotheses.nominal();
  const NoiseModel noise = with_random_effects(*problem, estimate_noise(*problem, nominal));
  const RandomEffects all = whitening_of(*problem, noise).random;

  const std::vector<std::string> names = {"misfit of a", "misfit of a1", "misfit of b"};
  const std::vector<int> measured_by = {1, 1, 2};
  ASSERT_EQ(all.groups.size(), names.size());
  for (std::size_t g = 0; g < names.size(); ++g) {
    EXPECT_EQ(all.groups[g].name, names[g]);
    EXPECT_EQ(all.misfits[g].values, problem->settings.discrepancy_modes * measured_by[g]);
  }

  const std::size_t segments = datasets[0].segments.size();
  const SegmentMask first = {std::vector<bool>(segments, true), std::vector<bool>(segments, false)};
  const RandomEffects part = whitening_of(*problem, noise, first).random;
  ASSERT_EQ(part.groups.size(), names.size());
  for (std::size_t g = 0; g < names.size(); ++g) EXPECT_EQ(part.groups[g].name, names[g]);
  EXPECT_EQ(part.misfits[1].rows, 0.0);
  EXPECT_EQ(part.misfits[1].variance(3.0), 1.0);
  EXPECT_NEAR(part.misfits[0].rows, all.misfits[0].rows, 1e-9);
}

TEST(WhiteningApart, APartOfTheSegmentsHasTheirRows) {
  const Whitened w;
  std::vector<bool> mask(w.problem->observations.datasets[0].segments.size(), true);
  ASSERT_GT(mask.size(), 2U);
  mask[1] = false;
  const Whitening part = whitening_of(*w.problem, w.noise, {mask});
  ASSERT_LT(part.rows, w.apart.rows);
  ASSERT_GT(part.apart, 0);

  std::srand(5);
  const Vector raw = Vector::Random(w.together.measured[0].size());
  const Vector white = w.apart.apply({raw}), of_part = part.apply({raw});
  EXPECT_TRUE(Vector(white(rows_of_part(w.apart, part))).isApprox(of_part, 1e-12));
}

}  // namespace
}  // namespace jaculus::diagnosis
