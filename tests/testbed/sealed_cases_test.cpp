#include "jaculus/testbed/sealed_cases.h"

#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <sstream>

#include "jaculus/testbed/effects.h"
#include "jaculus/testbed/trials.h"
#include "jaculus/trajectory/dataset.h"
#include "support/input_error.h"
#include "support/temporary_folder.h"

namespace jaculus::testbed {
namespace {

namespace fs = std::filesystem;
using test::holds;
using test::input_error_of;

std::string bytes_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream out;
  out << in.rdbuf();
  return out.str();
}

/// Every file of a batch but the sealed labels, which hold fresh random numbers.
std::map<std::string, std::string> datasets_of(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file() || entry.path().parent_path() == folder) continue;
    files[fs::relative(entry.path(), folder).string()] = bytes_of(entry.path());
  }
  return files;
}

SealSpec small_batch(const fs::path& folder) {
  SealSpec spec;
  spec.none = 1;
  spec.outside = 2;
  spec.plans = {fs::path(JACULUS_SOURCE_DIR) / "problems" / "leap_tail_plan.csv"};
  spec.seed = 11;
  spec.out = folder / "cases";
  spec.key = folder / "cases.key";
  spec.provenance = "a test";
  return spec;
}

class SealedCases : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!available()) GTEST_SKIP() << "built without MuJoCo";
  }
  test::TemporaryFolder folder_;
};

TEST_F(SealedCases, SameSeedSameBytesAndNoLabelInThem) {
  SealSpec spec = small_batch(folder_.path());
  const auto ids = seal_cases(spec);
  EXPECT_EQ(ids.size(), 3U);
  EXPECT_EQ(ids, sealed_ids(spec.out));
  const auto files = datasets_of(spec.out);
  std::vector<std::string> words = {"single", "outside", "pair"};
  for (const BenchEffect& effect : bench_effects()) words.push_back(effect.name);
  for (const auto& [name, text] : files) {
    if (!name.ends_with(".yaml")) continue;
    for (const std::string& word : words) EXPECT_EQ(text.find(word), std::string::npos) << name << " says " << word;
  }
  for (const std::string& id : ids)
    EXPECT_EQ(read_dataset(spec.out / id).provenance, "a sealed case of the MuJoCo testbed");
  SealSpec again = spec;
  again.out = folder_.path() / "again";
  again.key = folder_.path() / "again.key";
  seal_cases(again);
  EXPECT_EQ(files, datasets_of(again.out));
  const auto labels = open_labels(spec.out, spec.key);
  ASSERT_EQ(labels.size(), 3U);
  int outside = 0;
  for (const CaseLabel& label : labels) {
    outside += label.kind == "outside" ? 1 : 0;
    EXPECT_EQ(label.effects.size(), label.kind == "none" ? 0U : 1U);
    if (label.kind == "outside") {
      EXPECT_GE(label.strength_in_noise_floors, 0.7);
    }
  }
  EXPECT_EQ(outside, 2);
}

TEST_F(SealedCases, AlteredLabelsKeysAndCommitmentsAreRefused) {
  const SealSpec spec = [&] {
    SealSpec s = small_batch(folder_.path());
    s.outside = 0;
    return s;
  }();
  seal_cases(spec);
  const fs::path sealed = spec.out / "labels.sealed", commitment = spec.out / "commitment.txt";
  const std::string labels = bytes_of(sealed), promised = bytes_of(commitment), key = bytes_of(spec.key);
  const auto write = [](const fs::path& file, const std::string& text) {
    std::ofstream(file, std::ios::binary) << text;
  };
  std::string altered = labels;
  altered[100] = altered[100] == '0' ? '1' : '0';
  write(sealed, altered);
  EXPECT_TRUE(holds(input_error_of([&] { open_labels(spec.out, spec.key); }), "altered"));
  write(sealed, labels);
  altered = promised;
  altered[3] = altered[3] == '0' ? '1' : '0';
  write(commitment, altered);
  EXPECT_TRUE(holds(input_error_of([&] { open_labels(spec.out, spec.key); }), "not those committed to"));
  write(commitment, promised);
  altered = key;
  altered[0] = altered[0] == '0' ? '1' : '0';
  write(spec.key, altered);
  EXPECT_TRUE(holds(input_error_of([&] { open_labels(spec.out, spec.key); }), "another key"));
  write(spec.key, "no key");
  EXPECT_TRUE(holds(input_error_of([&] { open_labels(spec.out, spec.key); }), "no key"));
  write(spec.key, key);
  EXPECT_EQ(open_labels(spec.out, spec.key).size(), 1U);
}

TEST_F(SealedCases, PlacesThatWouldGiveLabelsAwayAreRefused) {
  SealSpec spec = small_batch(folder_.path());
  spec.key = spec.out / "labels.key";
  EXPECT_TRUE(holds(input_error_of([&] { seal_cases(spec); }), "lies in the cases' folder"));
  spec = small_batch(folder_.path());
  fs::create_directories(spec.out);
  std::ofstream(spec.out / "file") << "x";
  EXPECT_TRUE(holds(input_error_of([&] { seal_cases(spec); }), "not empty"));
}

TEST(SealedSeed, DerivesFromTheWholeHash) {
  const std::string hash(40, 'a');
  std::string other = hash;
  other[39] = 'b';
  EXPECT_EQ(seed_of_commit(hash), seed_of_commit(hash));
  EXPECT_NE(seed_of_commit(hash), seed_of_commit(other));
  EXPECT_TRUE(holds(input_error_of([] { seed_of_commit("abc"); }), "40 hexadecimal digits"));
}

}  // namespace
}  // namespace jaculus::testbed
