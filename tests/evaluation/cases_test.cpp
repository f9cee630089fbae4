// Cases diagnosed by a program of their own, here a script that stands in for jaculus and writes
// down what it can see.

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "evaluation/run_diagnosis.h"
#include "jaculus/effects/effect.h"
#include "jaculus/evaluation/score.h"
#include "jaculus/model/robot.h"
#include "jaculus/testbed/blinded_cases.h"
#include "jaculus/testbed/effects.h"
#include "sample_trials.h"
#include "support/input_error.h"
#include "support/temporary_folder.h"

namespace jaculus::evaluation {
namespace {

namespace fs = std::filesystem;

constexpr const char* kProgram = R"sh(#!/bin/sh
# $1 diagnose  $2 dataset  $3 --out  $4 answer ...
mkdir -p answer
{ echo "arguments: $*"; echo "folder: $(pwd)"; env; find . -type f; cat dataset/dataset.yaml; } )sh"
                                 R"sh(> answer/seen
cp answer/seen answer/augmented.yaml
case "$(cat dataset/dataset.yaml)" in
  *refuse*) echo "dataset.yaml:1: bad" >&2; exit 2 ;;
  *crash*) kill -SEGV $$ ;;
  *sleep*) exec sleep 30 ;;
  *garbage*) echo "{" > answer/diagnosis.json; exit 0 ;;
esac
echo '{"format": "jaculus-diagnosis/1", "verdict": "none", "effects": [], "ranking": []}' > )sh"
                                 R"sh(answer/diagnosis.json
)sh";

struct CaseFolder {
  CaseFolder() {
    program = folder.write("program", kProgram);
    fs::permissions(program, fs::perms::owner_all);
    fs::create_directories(folder / "cases");
    folder.write("cases/labels.sealed", "the label is tail_compliance");
  }
  void add(const std::string& id, const std::string& content) {
    fs::create_directories(folder / "cases" / id);
    folder.write("cases/" + id + "/dataset.yaml", content);
    ids.push_back(id);
  }
  [[nodiscard]] ScoreOptions options() const {
    ScoreOptions o;
    o.binary = program;
    o.out = folder / "out";
    o.baselines = false;
    o.jobs = 2;
    return o;
  }

  test::TemporaryFolder folder;
  fs::path program;
  std::vector<std::string> ids;
};

CaseTruth nothing(const std::string& id) {
  CaseTruth truth;
  truth.case_id = id;
  truth.kind = "none";
  return truth;
}

TEST(Catalogues, WhatIsOutsideOneIsNotInTheOther) {
  for (const char* robot : {"minitaur_tail", "minitaur", "pendulum"}) {
    for (const testbed::BenchEffect& effect :
         testbed::bench_effects(model::find_robot(robot, std::filesystem::current_path()))) {
      if (!effect.outside) continue;
      EXPECT_EQ(effects::find_effect(effect.name), nullptr) << effect.name;
    }
  }
}

TEST(RunDiagnosis, SeesTheDatasetAndNothingElse) {
  CaseFolder batch;
  batch.add("k3", "format: jaculus-dataset/1\n");
  ::setenv("JACULUS_LABEL_KEY", "open sesame", 1);
  const Prediction prediction = evaluation::run_diagnosis(
      {batch.program, batch.folder / "cases" / "k3", batch.folder / "kept", {}, 5, 60.0});
  ::unsetenv("JACULUS_LABEL_KEY");
  ASSERT_EQ(prediction.verdict, diagnosis::Verdict::none) << prediction.message;
  EXPECT_GT(prediction.seconds, 0.0);
  const std::string seen = test::bytes_of(batch.folder / "kept" / "augmented.yaml");
  EXPECT_NE(seen.find("arguments: diagnose dataset --out answer --seed 5"), std::string::npos)
      << seen;
  EXPECT_NE(seen.find("./dataset/dataset.yaml"), std::string::npos);
  for (const char* secret : {"sesame", "LABEL", "sealed", "tail_compliance", "k3"})
    EXPECT_EQ(seen.find(secret), std::string::npos) << secret << " in\n" << seen;
  EXPECT_EQ(seen.find(batch.folder.path().string()), std::string::npos) << seen;
  EXPECT_TRUE(fs::exists(batch.folder / "kept" / "diagnosis.json"));
}

TEST(RunDiagnosis, FailuresAreAnswersThatSayWhy) {
  CaseFolder batch;
  for (const char* id : {"refuse", "crash", "sleep", "garbage"}) batch.add(id, id);
  const auto prediction = [&](const std::string& id) {
    return evaluation::run_diagnosis({batch.program,
                                      batch.folder / "cases" / id,
                                      batch.folder / "kept",
                                      {},
                                      1,
                                      id == "sleep" ? 0.3 : 60.0});
  };
  for (const std::string& id : batch.ids) EXPECT_FALSE(prediction(id).verdict) << id;
  EXPECT_TRUE(test::holds(prediction("refuse").message, "exit code 2: dataset.yaml:1: bad"));
  EXPECT_TRUE(test::holds(prediction("crash").message, "ended by signal 11"));
  EXPECT_TRUE(test::holds(prediction("sleep").message, "no answer within 0.3 s"));
  EXPECT_TRUE(test::holds(prediction("garbage").message, "is no JSON"));
}

TEST(ScoreCases, OpensTheLabelsAfterTheLastAnswerAndResumes) {
  CaseFolder batch;
  batch.add("a", "none\n");
  batch.add("b", "refuse\n");
  bool opened = false;
  const auto labels = [&] {
    for (const std::string& id : batch.ids) {
      EXPECT_TRUE(fs::exists(batch.folder / "out" / "answers" / id / "messages.txt")) << id;
    }
    opened = true;
    return std::vector<CaseTruth>{nothing("b"), nothing("a")};
  };
  const Score score = score_cases(batch.folder / "cases", batch.ids, labels, batch.options());
  ASSERT_TRUE(opened);
  EXPECT_EQ(score.truths[0].case_id, "a");
  EXPECT_EQ(score.metrics[0].scores[0].credit, 1.0);
  EXPECT_EQ(score.metrics[0].scores[1].credit, 0.0);
  EXPECT_EQ(score.metrics[0].by.at("no answer").value, 0.5);
  const std::string first = test::bytes_of(batch.folder / "out" / "score.json");

  // Again without --resume: refused. With it: no case is run again, which the kept messages would
  // show.
  EXPECT_TRUE(test::holds(test::input_error_of([&] {
                            score_cases(batch.folder / "cases", batch.ids, labels, batch.options());
                          }),
                          "allowed: --resume"));
  for (const std::string& id : batch.ids)
    std::ofstream(batch.folder / "out" / "answers" / id / "messages.txt") << "untouched";
  ScoreOptions again = batch.options();
  again.resume = true;
  score_cases(batch.folder / "cases", batch.ids, labels, again);
  EXPECT_EQ(test::bytes_of(batch.folder / "out" / "answers" / "a" / "messages.txt"), "untouched");
  EXPECT_EQ(test::bytes_of(batch.folder / "out" / "score.json"), first);
  EXPECT_EQ(first.find("seconds"), std::string::npos);  // would part equal answers

  std::ifstream timing(batch.folder / "out" / "timing.json");
  const auto seconds = nlohmann::json::parse(timing).at("seconds_a_case").at("diagnosis");
  EXPECT_GT(seconds.at("value").get<double>(), 0);
  EXPECT_EQ(seconds.at("cases"), 1);  // the refused one has no time
}

TEST(RunDiagnosis, DiagnosesTheDatasetsOfAGroupTogether) {
  CaseFolder batch;
  for (const char* set : {"set_1", "set_2", "set_3"}) {
    fs::create_directories(batch.folder / "cases" / "g" / set);
    batch.folder.write(std::string("cases/g/") + set + "/dataset.yaml", "one of three\n");
  }
  EXPECT_EQ(testbed::case_datasets(batch.folder / "cases" / "g").size(), 3u);
  const fs::path program = batch.folder.write(
      "group",
      "#!/bin/sh\nmkdir -p answer\n{ echo \"arguments: $*\"; find . -type f; } > "
      "answer/augmented.yaml\nexit 2\n");
  fs::permissions(program, fs::perms::owner_all);
  evaluation::run_diagnosis(
      {program, batch.folder / "cases" / "g", batch.folder / "kept", {}, 5, 60.0});
  const std::string seen = test::bytes_of(batch.folder / "kept" / "augmented.yaml");
  EXPECT_NE(seen.find("arguments: diagnose set_1 set_2 set_3 --out answer"), std::string::npos)
      << seen;
  EXPECT_NE(seen.find("./set_3/dataset.yaml"), std::string::npos) << seen;
}

TEST(ScoreCases, AFirstPartSaysSoAndTheRestGoesOn) {
  CaseFolder batch;
  for (const char* id : {"a", "b", "c"}) batch.add(id, "none\n");
  const auto labels = [&] {
    return std::vector<CaseTruth>{nothing("a"), nothing("b"), nothing("c")};
  };
  ScoreOptions options = batch.options();
  options.limit = 2;
  const Score part = score_cases(batch.folder / "cases", batch.ids, labels, options);
  EXPECT_EQ(part.truths.size(), 2u);
  EXPECT_EQ(part.sealed, 3);
  EXPECT_TRUE(test::holds(test::bytes_of(batch.folder / "out" / "score.txt"), "2 of 3 sealed"));
  EXPECT_FALSE(fs::exists(batch.folder / "out" / "answers" / "c"));

  std::ofstream(batch.folder / "out" / "answers" / "a" / "messages.txt") << "untouched";
  options.limit.reset();
  options.resume = true;
  const Score whole = score_cases(batch.folder / "cases", batch.ids, labels, options);
  EXPECT_EQ(whole.truths.size(), 3u);
  EXPECT_EQ(test::bytes_of(batch.folder / "out" / "answers" / "a" / "messages.txt"), "untouched");
  EXPECT_TRUE(test::holds(test::bytes_of(batch.folder / "out" / "score.txt"), "3 cases"));
}

TEST(ScoreCases, SaysWhetherHeldOutTrialsTellTheTruth) {
  CaseFolder batch;
  batch.add("a", "");
  fs::remove_all(batch.folder / "cases" / "a");
  fs::rename(trials_with(batch.folder, "joint_coulomb_friction:torque=0.4"),
             batch.folder / "cases" / "a");
  CaseTruth truth = nothing("a");
  truth.kind = "single";
  truth.effects = {"joint_coulomb_friction"};
  const auto labels = [&] { return std::vector<CaseTruth>{truth}; };
  const auto written = [&] {
    return nlohmann::json::parse(test::bytes_of(batch.folder / "out" / "score.json"))["cases"][0];
  };

  const Score score = score_cases(batch.folder / "cases", batch.ids, labels, batch.options());
  ASSERT_TRUE(score.truths[0].possible);
  const PossibleGap& gap = *score.truths[0].possible;
  EXPECT_LT(gap.after, 0.5 * gap.tolerances);
  EXPECT_GT(gap.log_gain, 10.0);
  EXPECT_EQ(written()["told"], true);
  EXPECT_NEAR(written()["possible"]["after_gap"].get<double>(), gap.after, 1e-6 * gap.after);
  EXPECT_NEAR(written()["possible"]["tolerances_gap"].get<double>(), gap.tolerances,
              1e-6 * gap.tolerances);

  // Nothing is fitted where kept answers are scored, so that nothing is said of it.
  ScoreOptions kept = batch.options();
  kept.answers = batch.folder / "out" / "answers";
  kept.resume = true;
  EXPECT_FALSE(score_cases(batch.folder / "cases", batch.ids, labels, kept).truths[0].possible);
  EXPECT_TRUE(written()["told"].is_null());
}

TEST(ScoreCases, BadInputIsNamed) {
  CaseFolder batch;
  const auto none = [] { return std::vector<CaseTruth>(); };
  const auto message = [&] {
    return test::input_error_of(
        [&] { score_cases(batch.folder / "cases", batch.ids, none, batch.options()); });
  };
  EXPECT_TRUE(test::holds(message(), "no case"));
  batch.add("a", "none\n");
  EXPECT_TRUE(test::holds(message(), "none for case 'a'"));
  batch.ids.push_back("missing");
  EXPECT_TRUE(test::holds(message(), "no dataset.yaml"));
}

}  // namespace
}  // namespace jaculus::evaluation
