#include "jaculus/testbed/blinded_cases.h"

#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <sstream>

#include "jaculus/core/installation.h"
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

/// Every file of a batch but the encrypted labels, which hold fresh random numbers.
std::map<std::string, std::string> datasets_of(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file() || entry.path().parent_path() == folder) continue;
    files[fs::relative(entry.path(), folder).string()] = bytes_of(entry.path());
  }
  return files;
}

BlindingSpec small_batch(const fs::path& folder) {
  BlindingSpec spec;
  spec.none = 1;
  spec.outside = 2;
  spec.robots = {source_folder() / "models" / "minitaur_tail"};
  spec.plans = {source_folder() / "problems" / "leap_tail_plan.csv"};
  spec.seed = 11;
  spec.out = folder / "cases";
  spec.key = folder / "cases.key";
  spec.provenance = "a test";
  return spec;
}

class BlindedCases : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!available()) GTEST_SKIP() << "built without MuJoCo";
  }
  test::TemporaryFolder folder_;
};

TEST_F(BlindedCases, SameSeedSameBytesAndNoLabelInThem) {
  BlindingSpec spec = small_batch(folder_.path());
  const auto ids = blind_cases(spec);
  EXPECT_EQ(ids.size(), 3U);
  EXPECT_EQ(ids, blinded_ids(spec.out));
  const auto files = datasets_of(spec.out);
  std::vector<std::string> words = {"single", "outside", "pair"};
  for (const BenchEffect& effect : bench_effects(spec.robots.front())) words.push_back(effect.name);
  for (const auto& [name, text] : files) {
    if (!name.ends_with(".yaml")) continue;
    for (const std::string& word : words)
      EXPECT_EQ(text.find(word), std::string::npos) << name << " says " << word;
  }
  for (const std::string& id : ids)
    EXPECT_EQ(trajectory::read_dataset(spec.out / id).provenance,
              "a blinded case of the MuJoCo testbed");
  BlindingSpec again = spec;
  again.out = folder_.path() / "again";
  again.key = folder_.path() / "again.key";
  blind_cases(again);
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

TEST_F(BlindedCases, AlteredLabelsKeysAndCommitmentsAreRefused) {
  const BlindingSpec spec = [&] {
    BlindingSpec s = small_batch(folder_.path());
    s.outside = 0;
    return s;
  }();
  blind_cases(spec);
  const fs::path encrypted = spec.out / "labels.sealed", commitment = spec.out / "commitment.txt";
  const std::string labels = bytes_of(encrypted), promised = bytes_of(commitment),
                    key = bytes_of(spec.key);
  const auto write = [](const fs::path& file, const std::string& text) {
    std::ofstream(file, std::ios::binary) << text;
  };
  std::string altered = labels;
  altered[100] = altered[100] == '0' ? '1' : '0';
  write(encrypted, altered);
  EXPECT_TRUE(holds(input_error_of([&] { open_labels(spec.out, spec.key); }), "altered"));
  write(encrypted, labels);
  altered = promised;
  altered[3] = altered[3] == '0' ? '1' : '0';
  write(commitment, altered);
  EXPECT_TRUE(
      holds(input_error_of([&] { open_labels(spec.out, spec.key); }), "not those committed to"));
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

TEST_F(BlindedCases, PlacesThatWouldGiveLabelsAwayAreRefused) {
  BlindingSpec spec = small_batch(folder_.path());
  spec.key = spec.out / "labels.key";
  EXPECT_TRUE(holds(input_error_of([&] { blind_cases(spec); }), "lies in the cases' folder"));
  spec = small_batch(folder_.path());
  fs::create_directories(spec.out);
  std::ofstream(spec.out / "file") << "x";
  EXPECT_TRUE(holds(input_error_of([&] { blind_cases(spec); }), "not empty"));
}

TEST_F(BlindedCases, ClutterMakesOtherLogsAndWithheldKindsAreNotDrawn) {
  BlindingSpec plain = small_batch(folder_.path());
  plain.outside = 0;
  plain.plans.clear();
  BlindingSpec off = plain;
  off.out = folder_.path() / "off";
  off.key = folder_.path() / "off.key";
  off.clutter = true;
  (void)blind_cases(plain);
  (void)blind_cases(off);
  EXPECT_NE(datasets_of(plain.out), datasets_of(off.out));

  BlindingSpec unknown = plain;
  unknown.out = folder_.path() / "unknown";
  unknown.withheld = {"no_such_thing"};
  EXPECT_TRUE(holds(input_error_of([&] { blind_cases(unknown); }), "--withhold 'no_such_thing'"));
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
