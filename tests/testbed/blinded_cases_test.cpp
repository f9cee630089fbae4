#include "jaculus/testbed/blinded_cases.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <thread>

#include "jaculus/core/installation.h"
#include "jaculus/core/journal.h"
#include "jaculus/testbed/effects.h"
#include "jaculus/testbed/trials.h"
#include "jaculus/trajectory/dataset.h"
#include "support/input_error.h"
#include "support/temporary_folder.h"
#include "testbed/labels.h"

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

/// On a robot that is quick to play.
BlindingSpec small_batch(const fs::path& folder) {
  BlindingSpec spec;
  spec.none = 1;
  spec.outside = 2;
  spec.robots = {source_folder() / "models" / "pendulum"};
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

/// Cases without effect on a robot that is quick to play.
BlindingSpec quick_batch(const fs::path& folder) {
  BlindingSpec spec;
  spec.none = 4;
  spec.clutter = true;
  spec.robots = {source_folder() / "models" / "pendulum"};
  spec.seed = 3;
  spec.out = folder / "cases";
  spec.key = folder / "cases.key";
  spec.jobs = 1;
  return spec;
}

/// Kills a batch once two of its cases are finished.
void kill_midway(const BlindingSpec& spec) {
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    (void)blind_cases(spec);
    _exit(0);
  }
  const fs::path journal = spec.key.string() + ".journal";
  const auto finished = [&] {
    return fs::exists(journal) && read_journal(journal).finished.size() >= 2;
  };
  while (!finished() && ::waitpid(child, nullptr, WNOHANG) == 0)
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);
}

TEST_F(BlindedCases, ABatchThatWasKilledGoesOnToTheSameBytes) {
  BlindingSpec whole = quick_batch(folder_.path() / "whole");
  whole.out = folder_.path() / "cases";  // the journal is of a place, so one batch after the other
  blind_cases(whole);
  const auto files = datasets_of(whole.out);
  const auto labels = open_labels(whole.out, whole.key);
  fs::remove_all(whole.out);

  BlindingSpec killed = quick_batch(folder_.path());
  kill_midway(killed);
  ASSERT_FALSE(fs::exists(killed.out / "labels.sealed")) << "it was whole before it was killed";
  EXPECT_LT(datasets_of(killed.out).size(), files.size());
  for (const auto& entry : fs::recursive_directory_iterator(killed.out)) {
    if (entry.is_regular_file()) {
      EXPECT_EQ(bytes_of(entry.path()).find("strength"), std::string::npos);
    }
  }
  EXPECT_TRUE(holds(input_error_of([&] { blind_cases(killed); }), "--resume"));

  BlindingSpec other = killed;
  other.resume = true;
  other.seed = 4;
  EXPECT_NE(input_error_of([&] { blind_cases(other); }), "");
  killed.resume = true;
  // what a kill may leave of a case
  const std::string last = labels.back().case_id;
  fs::create_directories(killed.out / last / "trial_99");
  std::ofstream(killed.out / last / "trial_99" / "joints.csv") << "torn";
  blind_cases(killed);
  EXPECT_EQ(datasets_of(killed.out), files);
  EXPECT_FALSE(fs::exists(killed.key.string() + ".journal"));
  const auto again = open_labels(killed.out, killed.key);
  ASSERT_EQ(again.size(), labels.size());
  for (std::size_t i = 0; i < labels.size(); ++i)
    EXPECT_EQ(label_text(again[i]), label_text(labels[i]));
  EXPECT_TRUE(holds(input_error_of([&] { blind_cases(killed); }), "a whole batch"));
}

TEST_F(BlindedCases, AGroupIsOneRobotInOtherExperiments) {
  BlindingSpec spec = quick_batch(folder_.path());
  spec.none = 0;
  spec.groups = 1;
  spec.robots = {source_folder() / "models" / "double_pendulum"};
  spec.jobs = 2;
  const auto ids = blind_cases(spec);
  ASSERT_EQ(ids.size(), 1U);
  EXPECT_EQ(blinded_ids(spec.out), ids);
  const CaseLabel label = open_labels(spec.out, spec.key).front();
  EXPECT_EQ(label.kind, "single");
  EXPECT_EQ(label.effects.size(), 1U);

  const auto sets = case_datasets(spec.out / ids.front());
  EXPECT_EQ(count_of(sets), label.datasets);
  ASSERT_TRUE(label.datasets == 2 || label.datasets == 3) << label.datasets;
  EXPECT_EQ(sets.front().filename(), "set_1");
  std::set<std::string> outlines;
  int trials = 0;
  for (const fs::path& set : sets) {
    const trajectory::Dataset dataset = trajectory::read_dataset(set);
    EXPECT_EQ(dataset.robot, "double_pendulum");
    trials += count_of(dataset.trials);
    outlines.insert(std::string(name_of(dataset.controller.kind)) +
                    (dataset.controller.kp.empty() ? "" : " tracked"));
  }
  EXPECT_EQ(trials, label.trials);
  EXPECT_EQ(outlines.size(), sets.size()) << "every dataset is another experiment";
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
