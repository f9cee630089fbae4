#include "jaculus/studies/study.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>
#include <thread>

#include "jaculus/core/error.h"
#include "jaculus/core/installation.h"
#include "jaculus/core/journal.h"

namespace jaculus::studies {
namespace {

namespace fs = std::filesystem;

const fs::path kProblems = source_folder() / "problems";

class Study : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::temp_directory_path() /
              ("jaculus_study_" + std::to_string(::getpid()) + "_" + info->name());
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  [[nodiscard]] fs::path write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }
  static std::string slurp(const fs::path& file) {
    std::ostringstream text;
    text << std::ifstream(file, std::ios::binary).rdbuf();
    return text.str();
  }

  fs::path folder_;
};

StudyResult run(const std::string& problem) { return run_study(kProblems / problem, {}, {}); }

double computed(const StudyResult& result, const std::string& quantity) {
  for (const StudyReference& r : result.references) {
    if (r.quantity == quantity) return r.computed.get<double>();
  }
  ADD_FAILURE() << "no reference " << quantity;
  return kNaN;
}

const StudyJson& row(const StudyResult& result, const std::string& name) {
  for (const StudyJson& r : result.rows) {
    if (r.at("case") == name) return r;
  }
  throw std::runtime_error("no case " + name);
}

TEST_F(Study, FigureThreeComesOut) {
  const StudyResult r = run("fig3_effectiveness.yaml");
  ASSERT_TRUE(r.complete);
  ASSERT_EQ(r.rows.size(), 183u);
  EXPECT_NEAR(computed(r, "2x tail, massless"), 0.631, 5e-4);
  EXPECT_NEAR(computed(r, "1x tail, massless"), 0.167, 5e-4);
  EXPECT_NEAR(computed(r, "2x tail over 1x tail, massless"), 3.8, 5e-2);
  EXPECT_NEAR(computed(r, "2x tail at normalised inertia 0.05"), 0.615, 5e-4);
  EXPECT_NEAR(computed(r, "2x tail at normalised inertia 0.204"), 0.564, 5e-4);
  EXPECT_NEAR(computed(r, "2x tail at normalised inertia 0.37"), 0.554, 5e-4);
  EXPECT_NEAR(computed(r, "2x tail at 0.37, with drag over without"), 1.50, 5e-3);
  EXPECT_NEAR(computed(r, "2x tail at normalised inertia 0.5"), 0.590, 5e-4);
  EXPECT_NEAR(computed(r, "inertial tail that matches the massless 2x tail"), 1.7, 5e-2);
  for (const StudyJson& point : r.rows) {
    EXPECT_NEAR(point.at("effectiveness_without_drag").get<double>(),
                point.at("normalised_inertia").get<double>(), 1e-9);
  }
}

TEST_F(Study, SelfRightingComesOut) {
  const StudyResult r = run("self_righting.yaml");
  const StudyJson& built = row(r, "as built");
  EXPECT_NEAR(built.at("time_to_90deg_s").get<double>(), 0.30485, 5e-6);
  EXPECT_NEAR(built.at("body_angle_at_end_deg").get<double>(), 93.701, 5e-4);
  EXPECT_NEAR(built.at("effectiveness").get<double>(), 0.5206, 5e-5);
  EXPECT_NEAR(built.at("stop_time_s").get<double>(), 0.17673, 5e-6);
  EXPECT_NEAR(built.at("body_angle_at_stop_deg").get<double>(), 55.248, 5e-4);
  EXPECT_EQ(built.at("gear").get<double>(), 4.0);
  const StudyJson& bare = row(r, "without drag");
  EXPECT_NEAR(bare.at("body_angle_at_end_deg").get<double>(), 36.250, 5e-4);
  EXPECT_TRUE(bare.at("time_to_90deg_s").is_null());
  EXPECT_NEAR(row(r, "gear 5").at("body_angle_at_end_deg").get<double>(), 97.061, 5e-4);
  // The inertial tail of the same effectiveness turns the body as far.
  EXPECT_NEAR(row(r, "equal inertial tail").at("body_angle_at_end_deg").get<double>(),
              built.at("body_angle_at_end_deg").get<double>(), 0.02);
  // Weaker springs, longer delays; heavier stops for heavier tails.
  EXPECT_LT(row(r, "root spring 150 N m/rad").at("delay_s").get<double>(),
            row(r, "root spring 50 N m/rad").at("delay_s").get<double>());
  EXPECT_GT(row(r, "equal inertial tail").at("stop_impulse_N_m_s").get<double>(),
            2.0 * built.at("stop_impulse_N_m_s").get<double>());
}

const StudyReference& reference(const StudyResult& result, const std::string& quantity) {
  for (const StudyReference& r : result.references) {
    if (r.quantity == quantity) return r;
  }
  throw std::runtime_error("no reference " + quantity);
}

// Sections VI-A and VI-B by hand: inertias 0.23 and 0.058, rates of the body and of the tail to it
// from REFERENCE's section 2.
TEST_F(Study, TheStopAndWhatFollowsAreReportedBesideThePaper) {
  const StudyResult r = run("self_righting.yaml");
  const StudyJson& built = row(r, "as built");
  const double after = -10.07 + 0.058 / 0.288 * 25.28;
  EXPECT_NEAR(built.at("body_rate_after_stop_rad_s").get<double>(), after, 0.01);
  EXPECT_NEAR(computed(r, "impulse at the stop [N m s]"), 0.058 * (25.28 - 10.07 - after), 1e-3);
  EXPECT_NEAR(computed(r, "rotation that goes on after the stop [deg]"), 93.701 - 55.248, 1e-3);
  EXPECT_NEAR(computed(r, "torque that holds the tail level [N m]"), 0.110 * 9.81 * 0.629, 1e-3);
  EXPECT_NEAR(computed(r, "torque that holds the tail over that of the equal inertial tail"),
              0.110 * 0.629 / (0.26 * 0.97), 1e-9);
  EXPECT_LT(computed(r, "impulse at the stop over that of the equal inertial tail"), 1.0);
  EXPECT_NEAR(computed(r, "normalised inertia of the equal inertial tail"), 0.5206, 5e-5);
  EXPECT_EQ(row(r, "without drag").at("rotation_after_stop_deg").get<double>(), 0.0);
}

TEST_F(Study, DisagreementsWithThePaperAreNamed) {
  const StudyResult r = run("self_righting.yaml");
  const StudyReference& equal = reference(r, "normalised inertia of the equal inertial tail");
  EXPECT_TRUE(equal.disagrees);
  EXPECT_NEAR(equal.deviation, 0.5206 / 0.558 - 1.0, 1e-4);
  // 0.204 there, 0.058/0.288 here
  EXPECT_TRUE(reference(r, "normalised inertia as built").disagrees);
  EXPECT_TRUE(reference(r, "mass that the tail adds").disagrees);     // 0.10 there, 0.816/7.3 here
  EXPECT_FALSE(reference(r, "90 deg self-righting [s]").disagrees);   // 0.3049 of 0.302 +- 0.004
  EXPECT_FALSE(reference(r, "tail reaches its stop [s]").disagrees);  // 0.1767 of about 0.18
  EXPECT_FALSE(reference(r, "impulse at the stop [N m s]").disagrees);  // words there
  std::size_t named = 0, disagreeing = 0;
  for (const StudyReference& q : r.references) disagreeing += q.disagrees ? 1 : 0;
  for (const std::string& note : r.notes)
    named += note.starts_with("disagrees with the paper: ") ? 1 : 0;
  EXPECT_EQ(named, disagreeing);
  // 4 there, 5 here
  EXPECT_TRUE(reference(run("gear_search.yaml"), "best integer gear").disagrees);
  const StudyJson json = StudyJson::parse(study_json(r));
  EXPECT_TRUE(json.at("reference").at(5).at("disagrees").get<bool>());
  EXPECT_EQ(json.at("reference").at(5).at("quantity"), equal.quantity);
}

TEST_F(Study, TheDropsCourseEndsWhereTheStudyOfItSays) {
  const StudyResult r = run("fig6_drop.yaml");
  double last = kNaN, at_stop = 0.0;
  for (const StudyJson& sample : r.rows) {
    if (sample.at("case") != "as built") continue;
    last = sample.at("body_angle_deg").get<double>();
    if (sample.at("tail_angle_deg").get<double>() < 180.0 - 1e-9) at_stop = last;
  }
  EXPECT_NEAR(last, 93.701, 5e-4);
  EXPECT_LT(at_stop, 55.248);
  EXPECT_EQ(r.rows.front().at("body_angle_deg").get<double>(), 0.0);
}

TEST_F(Study, BestGearIsReportedNotBent) {
  const StudyResult r = run("gear_search.yaml");
  EXPECT_EQ(computed(r, "best integer gear"), 5.0);
  EXPECT_NEAR(computed(r, "rotation with gear 4 [deg]"), 93.701, 5e-4);
  EXPECT_NEAR(computed(r, "rotation with gear 5 [deg]"), 97.061, 5e-4);
}

TEST_F(Study, ShaftRatioFollowsTheFourthPower) {
  const StudyResult r = run("fig4_shaft.yaml");
  for (const StudyJson& point : r.rows) {
    EXPECT_NEAR(point.at("shaft_torque_ratio").get<double>(),
                1.0 - std::pow(point.at("shaft_ratio").get<double>(), 4), 1e-12);
  }
  EXPECT_NEAR(computed(r, "drag moment left at L0/L = 0.6"), 0.870, 5e-4);
}

TEST_F(Study, AnIsometricBodyWithASimilarMotorFallsAlikeAtAnySize) {
  const StudyResult r = run("scaling.yaml");
  EXPECT_NEAR(computed(r, "drag moment factor at scale 2 over scale 1 (isometric)"), 32.0, 1e-9);
  EXPECT_NEAR(computed(r, "the same at fixed width"), 16.0, 1e-9);
  double least = 1.0, most = 0.0;
  for (const StudyJson& point : r.rows) {
    const double e = point.at("effectiveness").get<double>();
    if (point.at("case") == "isometric") {
      EXPECT_NEAR(e, 0.52056, 1e-5);
    }
    if (point.at("case") != "fixed tail") continue;
    least = std::min(least, e);
    most = std::max(most, e);
  }
  EXPECT_GT(most, least + 0.2);
}

TEST_F(Study, ShippedStudiesRunAndHaveTheirColumns) {
  for (const char* name :
       {"airspeed.yaml", "width_drag.yaml", "tail_design.yaml", "drag_bench.yaml"}) {
    const StudyResult r = run(name);
    EXPECT_TRUE(r.complete) << name;
    ASSERT_FALSE(r.rows.empty()) << name;
    for (const StudyJson& point : r.rows) {
      for (const std::string& column : r.columns)
        EXPECT_TRUE(point.contains(column)) << name << " " << column;
    }
  }
}

TEST_F(Study, FilesAreTheSameBytesWhateverTheWorkers) {
  std::vector<std::string> csv, json;
  for (int jobs : {1, 3}) {
    const fs::path out = folder_ / std::to_string(jobs);
    fs::create_directories(out);
    StudyOptions options;
    options.jobs = jobs;
    run_study(kProblems / "airspeed.yaml", out, options);
    csv.push_back(slurp(out / "study.csv"));
    json.push_back(slurp(out / "study.json"));
    EXPECT_FALSE(fs::exists(out / "study.journal"));
  }
  EXPECT_EQ(csv[0], csv[1]);
  EXPECT_EQ(json[0], json[1]);
  EXPECT_NE(csv[0].find("forward_speed_m_s,gear,"), std::string::npos);
}

std::string with(const std::string& from, const std::string& to) {
  std::ostringstream text;
  text << std::ifstream(kProblems / "fig3_effectiveness.yaml").rdbuf();
  std::string t = text.str();
  const std::size_t at = t.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return t.replace(at, from.size(), to);
}

TEST_F(Study, BadInputIsNamedWithItsPlace) {
  struct Fault {
    const char *from, *to, *message;
  };
  for (const Fault& f : {
           Fault{"inertia: 0.23 kg m^2", "inertia: 0 kg m^2", "body.inertia"},
           Fault{"inertia: 0.23 kg m^2", "inertia: 0.23 kg", "body.inertia"},
           Fault{"inertia: 0.23 kg m^2", "inerta: 0.23 kg m^2", "inertia"},
           Fault{"shaft: 0 m", "shaft: 2 m", "shaft length is 2 m"},
           Fault{"integers: [1, 50]", "integers: [0, 50]", "gear"},
           Fault{"integers: [1, 50]", "integers: [1.2, 1.8]", "no integer"},
           Fault{"voltage: 16 V", "voltage: 0 V", "voltage"},
           Fault{"[0.5 m, 0.75 m, 1 m]", "[]", "empty"},
           Fault{"[0.5 m, 0.75 m, 1 m]", "[0.5 m, 0.5 m]", "twice"},
           Fault{"tail.length:", "tail.lenght:", "tail.length"},
           Fault{"from: 0.01, to: 0.6", "from: 0.6, to: 0.01", "below"},
           Fault{"count: 60", "count: 1", "count"},
           Fault{"kind: reorientation", "kind: reorientaton", "reorientation"},
           Fault{"effectiveness_without_drag, aero", "effectiveness_without_drg, aero",
                 "effectiveness_without_drag"},
           Fault{"stroke: 180 deg, ", "", "task.stroke is missing"},
           Fault{"stroke: 180 deg", "stroke: .nan", "stroke"},
           Fault{"where: {tail_length_m: 1,", "where: {tail_len: 1,", "tail_len"},
           Fault{"target: 90 deg", "target: 80 deg", "time_to_target_s"},
           Fault{"maximise: effectiveness", "maximise: everything", "maximise"},
           Fault{"drop: 0.5 m,", "drop: 0.5 m, duration: 1 s,", "task.duration"},
           Fault{"drag: rotation}", "drag: rotation, initial_angle: 4 m}", "initial_angle"},
           Fault{"drag: rotation}", "drag: rotation, mass: 0.1 kg, com: 0.6 m}", "tail.inertia is"},
           Fault{"drag: rotation}", "drag: rotation, mass: 9 kg, com: 0.6 m}", "tail.inertia is"},
           Fault{"paper: almost 4,", "paper: almost 4, within: 0.1,", "no number"},
           Fault{"paper: almost 4,", "paper: 4, within: -0.1,", "within"},
       }) {
    const fs::path file = write("bad.yaml", with(f.from, f.to));
    try {
      check_study(file);
      ADD_FAILURE() << "accepted: " << f.to;
    } catch (const InputError& error) {
      const std::string what = error.what();
      EXPECT_NE(what.find(f.message), std::string::npos) << what;
      EXPECT_NE(what.find("bad.yaml:"), std::string::npos) << what;
    }
  }
}

TEST_F(Study, ASearchOnItsBoundIsReported) {
  const fs::path file = write("bound.yaml", with("integers: [1, 50]", "integers: [1, 3]"));
  const StudyResult r = run_study(file, {}, {});
  ASSERT_FALSE(r.notes.empty());
  EXPECT_NE(r.notes[0].find("ended on its bound"), std::string::npos);
}

TEST_F(Study, AReferenceThatPicksNoRowKeepsTheRows) {
  const fs::path file =
      write("where.yaml", with("where: {tail_length_m: 1, normalised_inertia: 0.05}",
                               "where: {tail_length_m: 1, normalised_inertia: 0.055}"));
  const StudyResult r = run_study(file, {}, {});
  EXPECT_EQ(r.rows.size(), 183u);
  ASSERT_EQ(r.notes.size(), 1u);
  EXPECT_NE(r.notes[0].find("picks 0 rows"), std::string::npos);
}

// A worker for the test below, which starts this very program again: run by hand it does nothing.
TEST(DISABLED_StudyWorker, Run) {
  const char* out = std::getenv("JACULUS_TEST_STUDY_OUT");
  if (out == nullptr) GTEST_SKIP();
  StudyOptions options;
  options.jobs = 2;
  run_study(kProblems / "fig3_effectiveness.yaml", out, options);
}

pid_t start_worker(const fs::path& out) {
  const pid_t child = ::fork();
  if (child == 0) {
    ::setenv("JACULUS_TEST_STUDY_OUT", out.c_str(), 1);
    if (std::freopen("/dev/null", "w", stdout) == nullptr) ::_exit(126);
    ::execl("/proc/self/exe", "test_studies", "--gtest_also_run_disabled_tests",
            "--gtest_filter=DISABLED_StudyWorker.Run", nullptr);
    ::_exit(127);
  }
  return child;
}

TEST_F(Study, KilledTwentyTimesEndsWithTheSameBytes) {
  const fs::path calm = folder_ / "calm";
  const fs::path killed = folder_ / "killed";
  fs::create_directories(calm);
  fs::create_directories(killed);
  int status = -1;
  const auto began = std::chrono::steady_clock::now();
  ::waitpid(start_worker(calm), &status, 0);
  ASSERT_EQ(status, 0);
  const std::chrono::duration<double, std::milli> whole = std::chrono::steady_clock::now() - began;
  std::mt19937 rng(9);
  std::uniform_int_distribution<int> wait_ms(
      1, std::max(60, static_cast<int>(whole.count())));  // slow machines start late
  std::size_t finished = 0;
  int interrupted = 0;
  for (int i = 0; i < 200 && interrupted < 20; ++i) {
    const pid_t child = start_worker(killed);
    std::this_thread::sleep_for(std::chrono::milliseconds(wait_ms(rng)));
    ::kill(child, SIGKILL);
    ::waitpid(child, &status, 0);
    // not yet begun, or already at its end: the next one begins anew
    if (!fs::exists(killed / "study.journal")) {
      finished = 0;
      continue;
    }
    ++interrupted;
    const std::size_t now = read_journal(killed / "study.journal").finished.size();
    EXPECT_GE(now, finished);  // nothing that was finished is lost
    finished = now;
  }
  EXPECT_EQ(interrupted, 20);
  ::waitpid(start_worker(killed), &status, 0);
  ASSERT_EQ(status, 0);
  EXPECT_EQ(slurp(killed / "study.csv"), slurp(calm / "study.csv"));
  EXPECT_EQ(slurp(killed / "study.json"), slurp(calm / "study.json"));
  EXPECT_GT(slurp(calm / "study.csv").size(), 1000u);
}

}  // namespace
}  // namespace jaculus::studies
