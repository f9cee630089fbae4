// solve and compare, end to end on the built program.

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "cli/program.h"
#include "support/shared_data.h"
#include "support/temporary_folder.h"

namespace jaculus::test {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

Json json_of(const fs::path& file) { return Json::parse(bytes_of(file)); }

/// A leap as published, which stays on its mesh, with few intervals; `more` is appended.
fs::path coarse_leap(const TemporaryFolder& folder, const std::string& base,
                     const std::string& name, const std::string& more = "", int intervals = 5) {
  const std::string n = std::to_string(intervals);
  return folder.write(
      name + ".yaml",
      "format: jaculus-problem/1\nextends: " + kProblems + base +
          "_as_published.yaml\nname: " + name +
          "\nphases:\n  - {name: all_feet, contacts: [front_foot, rear_foot], intervals: " + n +
          ", duration: [1 ms, 500 ms]}\n  - {name: rear_feet, contacts: [rear_foot], "
          "intervals: " +
          n + ", duration: [1 ms, 500 ms]}\n" + more);
}

double price_of(const Json& summary, const std::string& limit) {
  for (const Json& price : summary.at("prices"))
    if (price.at("limit") == limit) return price.at("price").get<double>();
  ADD_FAILURE() << limit << " has no price";
  return 0.0;
}

TEST(Solve, DoubleIntegratorTakesTwoSeconds) {
  const TemporaryFolder folder;
  const std::string problem = folder.write(
      "tight.yaml", "format: jaculus-problem/1\nextends: " + kProblems +
                        "double_integrator.yaml\nname: tight\nsolver: {tolerance: 1e-8}\n");
  const Outcome run = run_program({"solve", problem, "--out", folder / "out"});
  ASSERT_EQ(run.exit_code, 0) << run.err << run.out;
  const Json summary = json_of(folder / "out/summary.json");
  EXPECT_NEAR(summary.at("duration_s").get<double>(), 2.0, 1e-6);
  // T = 2 sqrt(m d / F), so dT/dF = -T / (2 F) = -1 s/N.
  EXPECT_NEAR(price_of(summary, "motor torque"), 1.0, 1e-5);
  for (const char* file : {"plan.csv", "solution.json", "timing.json"})
    EXPECT_TRUE(fs::exists(folder / "out" / file));
}

TEST(View, FindsTheRobotThatStandsBesideItsProblem) {
  const TemporaryFolder folder;
  fs::copy(source_folder() / "models/slider", folder / "mine", fs::copy_options::recursive);
  std::ofstream(folder / "mine/leap.yaml") << "format: jaculus-problem/1\nextends: " << kProblems
                                           << "double_integrator.yaml\nname: leap\nrobot: .\n";
  run_program({"solve", folder / "mine/leap.yaml", "--out", folder / "plans/leap"});
  ASSERT_TRUE(fs::exists(folder / "plans/leap/plan.csv"));
  EXPECT_EQ(json_of(folder / "plans/leap/summary.json").at("robot_folder"), "../../mine");
  const Outcome run = run_program({"view", folder / "plans/leap", "--out", folder / "leap.html"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(fs::exists(folder / "leap.html"));
}

TEST(Solve, CoarseLeapIsSolvedTwiceToTheSameBytes) {
  const TemporaryFolder folder;
  const std::string problem = coarse_leap(folder, "leap_tail", "coarse");
  for (const char* out : {"one", "two"}) {
    const Outcome run = run_program({"solve", problem, "--out", folder / out});
    ASSERT_EQ(run.exit_code, 0) << run.err << run.out;
  }
  for (const std::string file : {"summary.json", "plan.csv", "solution.json"})
    EXPECT_EQ(bytes_of(folder / ("one/" + file)), bytes_of(folder / ("two/" + file))) << file;
  const Json summary = json_of(folder / "one/summary.json");
  EXPECT_GT(summary.at("average_acceleration_m_s2").get<double>(), 5.5);
  EXPECT_GE(summary.at("liftoff_velocity_m_s").get<double>(), 1.3 - 1e-6);
  EXPECT_GT(summary.at("tail_momentum_share").get<double>(), 0.0);
}

TEST(Solve, PriceOfVoltageIsTheSlopeBetweenTwoSolves) {
  const TemporaryFolder folder;
  double objective[2], price = 0.0;
  for (int k = 0; k < 2; ++k) {
    const std::string name = k == 0 ? "less" : "more";
    // From the same plan, so that both stay in its basin.
    const std::string guess =
        k == 0 ? ""
               : "guess: {kind: file, file: " + (folder / "less/solution.json").string() + "}\n";
    const std::string volts = k == 0 ? "7 V" : "7.01 V";
    const std::string problem =
        coarse_leap(folder, "leap_tail", name, "limits: {voltage: " + volts + "}\n" + guess);
    const Outcome run = run_program({"solve", problem, "--out", folder / name});
    ASSERT_EQ(run.exit_code, 0) << run.err << run.out;
    const Json summary = json_of(folder / (name + "/summary.json"));
    objective[k] = summary.at("objective").get<double>();
    price += 0.5 * price_of(summary, "voltage");
  }
  EXPECT_NEAR((objective[1] - objective[0]) / 0.01, price, 0.02 * price);
}

TEST(Solve, EarlierPlansServeAsGuessesOnOtherGridsAndFromTheirTable) {
  const TemporaryFolder folder;
  ASSERT_EQ(
      run_program({"solve", coarse_leap(folder, "leap_tail", "first"), "--out", folder / "first"})
          .exit_code,
      0);
  for (const std::string file : {"solution.json", "plan.csv"}) {
    const std::string guess =
        "guess: {kind: file, file: " + (folder / ("first/" + file)).string() + "}\n";
    const Outcome same = run_program(
        {"solve", coarse_leap(folder, "leap_tail", "same", guess), "--out", folder / "same"});
    ASSERT_EQ(same.exit_code, 0) << same.err << same.out;
    const Json first = json_of(folder / "first/summary.json"),
               again = json_of(folder / "same/summary.json");
    EXPECT_NEAR(again.at("objective").get<double>(), first.at("objective").get<double>(), 1e-4)
        << file;
    // Only a solution has multipliers, which make a warm start of it.
    if (file == "solution.json") {
      EXPECT_LT(again.at("iterations").get<int>(), 0.5 * first.at("iterations").get<int>());
    }
    const Outcome finer = run_program(
        {"solve", coarse_leap(folder, "leap_tail", "finer", guess, 7), "--out", folder / "finer"});
    EXPECT_EQ(finer.exit_code, 0) << finer.err << finer.out;
  }
}

TEST(Solve, AuthorsPlanServesAsGuess) {
  JACULUS_REQUIRE_SHARED_DATA(data);
  const TemporaryFolder folder;
  const std::string guess =
      "guess: {kind: file, file: " + (data / "plans/aerotail_V7.csv").string() + "}\n";
  const Outcome run = run_program(
      {"solve", coarse_leap(folder, "leap_tail", "theirs", guess), "--out", folder / "out"});
  EXPECT_EQ(run.exit_code, 0) << run.err << run.out;
}

TEST(Solve, ImpossibleProblemNamesItsCulprit) {
  const TemporaryFolder folder;
  // In 1 s at most 0.25 m are possible with 1 N on 1 kg from rest to rest.
  const std::string problem = folder.write(
      "impossible.yaml",
      "format: jaculus-problem/1\nextends: " + kProblems +
          "double_integrator.yaml\nname: impossible\nphases:\n  - {name: move, contacts: [], "
          "intervals: 8, duration: 1 s}\nguess: {kind: line, poses: [{slide: 0}, {slide: 1}], "
          "durations: [1 s]}\n");
  const Outcome run = run_program({"solve", problem, "--out", folder / "out"});
  EXPECT_EQ(run.exit_code, 1) << run.err << run.out;
  const Json summary = json_of(folder / "out/summary.json");
  EXPECT_FALSE(summary.at("converged").get<bool>());
  EXPECT_FALSE(summary.at("violated_rows").empty());
  const std::string conflict = summary.at("conflict").dump();
  EXPECT_NE(conflict.find("defect of slide"), std::string::npos) << conflict;
  EXPECT_NE(conflict.find("slide torque"), std::string::npos) << conflict;
  EXPECT_NE(run.out.find("can't hold together"), std::string::npos) << run.out;
  // the cause before all figures, then rows by kind
  const std::size_t cause = run.out.find(
      "no plan holds all limits: what binds is the limit on motor force of slide in move (at 1 N)");
  EXPECT_NE(cause, std::string::npos) << run.out;
  EXPECT_LT(cause, run.out.find("objective"));
  EXPECT_NE(run.out.find("equations of motion in move: "), std::string::npos) << run.out;
}

TEST(Solve, MissingEarlierPlanIsBadInput) {
  const TemporaryFolder folder;
  const std::string problem =
      coarse_leap(folder, "leap_tail", "lost", "guess: {kind: file, file: nowhere.json}\n");
  const Outcome run = run_program({"solve", problem, "--out", folder / "out"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_NE(run.err.find("nowhere.json"), std::string::npos) << run.err;
}

TEST(Solve, StartsAreTheSameWhateverTheNumberOfProcesses) {
  const TemporaryFolder folder;
  const std::string problem = coarse_leap(folder, "leap_tailless", "starts",
                                          "solver: {starts: 3, seed: 5, max_iterations: 200}\n");
  std::string first;
  for (const std::string jobs : {"1", "2"}) {
    const Outcome run = run_program({"solve", problem, "--jobs", jobs, "--out", folder / jobs});
    ASSERT_EQ(run.exit_code, 0) << run.err << run.out;
    if (jobs == "1") first = bytes_of(folder / "1/summary.json");
  }
  EXPECT_EQ(first, bytes_of(folder / "2/summary.json"));
}

TEST(Solve, RefinementSplitsIntervalsAndTightensThePlan) {
  const TemporaryFolder folder;
  const std::string refinement = "refinement: {max_rounds: 2, tolerance: 1e-4}\n";
  const std::string rough = coarse_leap(folder, "leap_tail", "rough");
  const std::string fine = coarse_leap(folder, "leap_tail", "fine", refinement);
  for (const std::string& problem : {rough, fine}) {
    const std::string out = folder / fs::path(problem).stem().string();
    const Outcome run = run_program({"solve", problem, "--out", out});
    ASSERT_EQ(run.exit_code, 0) << run.err << run.out;
  }
  const Json before = json_of(folder / "rough/summary.json"),
             after = json_of(folder / "fine/summary.json");
  EXPECT_GT(after.at("size").at("variables").get<int>(),
            before.at("size").at("variables").get<int>());
  const auto error = [](const Json& summary) {
    return summary.at("verification").at("reintegration_error").at("front_extension").get<double>();
  };
  EXPECT_LT(error(after), 0.5 * error(before));
}

TEST(Compare, TwoCoarseLeaps) {
  const TemporaryFolder folder;
  const std::string a = coarse_leap(folder, "leap_tailless", "without"),
                    b = coarse_leap(folder, "leap_tail", "with");
  const Outcome run = run_program({"compare", a, b, "--jobs", "2", "--out", folder / "out"});
  ASSERT_EQ(run.exit_code, 0) << run.err << run.out;
  const Json compare = json_of(folder / "out/compare.json");
  ASSERT_EQ(compare.at("problems").size(), 2u);
  const Json &without = compare["problems"][0], &with = compare["problems"][1];
  const double gain = with.at("average_acceleration_m_s2").get<double>() /
                          without.at("average_acceleration_m_s2").get<double>() -
                      1.0;
  EXPECT_NEAR(with.at("gain_over_tailless").at("average_acceleration").get<double>(), gain, 1e-12);
  EXPECT_GT(gain, 0.0);
  EXPECT_TRUE(fs::exists(folder / "out/with/plan.csv"));
  EXPECT_TRUE(fs::exists(folder / "out/compare.csv"));
  EXPECT_NE(run.out.find("without"), std::string::npos);
}

}  // namespace
}  // namespace jaculus::test
