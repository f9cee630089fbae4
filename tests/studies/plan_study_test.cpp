// Sweeps of optimised plans, on grids small enough for a test: two lengths of the tail at 6 + 4
// intervals.

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <thread>

#include "jaculus/core/error.h"
#include "jaculus/core/installation.h"
#include "jaculus/core/journal.h"
#include "jaculus/studies/study.h"
#include "support/temporary_folder.h"

namespace jaculus::studies {
namespace {

namespace fs = std::filesystem;

const fs::path kTailLengths = source_folder() / "problems" / "leap_tail_length.yaml";

/// problems/leap_tail_length.yaml with fewer factors, on the leap with fewer intervals.
std::string small_study(const std::string& factors) {
  std::string text = test::bytes_of(kTailLengths);
  const auto replace = [&text](const std::string& key, const std::string& line) {
    const std::size_t at = text.find("\n" + key) + 1;
    EXPECT_NE(at, 0u) << key;
    text.replace(at, text.find('\n', at) - at, line);
  };
  replace("problem:", "problem: small.yaml");
  replace("stretch:", "stretch: {link: tail, factors: " + factors + "}");
  return text;
}

std::string small_leap() {
  return "format: jaculus-problem/1\nextends: " +
         (kTailLengths.parent_path() / "leap_tail_as_published.yaml").string() +
         "\nname: small\nphases:\n"
         "  - {name: all_feet, contacts: [front_foot, rear_foot], intervals: 6, mesh: [1, 1, 1, 1, "
         "1, 0.4], duration: "
         "[1 ms, 500 ms]}\n"
         "  - {name: rear_feet, contacts: [rear_foot], intervals: 4, duration: [1 ms, 500 ms]}\n";
}

class PlanStudy : public ::testing::Test {
 protected:
  void SetUp() override { folder_.write("small.yaml", small_leap()); }
  fs::path study(const std::string& factors) {
    folder_.write("study.yaml", small_study(factors));
    return folder_ / "study.yaml";
  }
  fs::path out(const std::string& name) {
    fs::create_directories(folder_ / name);
    return folder_ / name;
  }
  test::TemporaryFolder folder_;
};

TEST_F(PlanStudy, ShippedSweepOverTheTailsLengthIsGoodInput) {
  EXPECT_NE(check_study(kTailLengths).find("11 plans of leap_tail"), std::string::npos);
}

TEST_F(PlanStudy, SweepsTheTailsLengthOverOptimisedLeaps) {
  const StudyResult r = run_study(study("[1, 1.5]"), out("sweep"));
  ASSERT_TRUE(r.complete);
  ASSERT_EQ(r.rows.size(), 2u);
  for (const StudyJson& row : r.rows) {
    EXPECT_EQ(row.at("status"), "optimal");
    // the leap is one of least time
    EXPECT_NEAR(row.at("liftoff_velocity_m_s").get<double>(), 1.3, 1e-5);
    EXPECT_NEAR(
        row.at("average_acceleration_m_s2").get<double>() * row.at("duration_s").get<double>(),
        row.at("liftoff_velocity_m_s").get<double>(), 1e-12);
    EXPECT_GT(row.at("drag_momentum_share").get<double>(), 0.0);
  }
  const auto at = [&r](int i, const char* column) { return r.rows[i].at(column).get<double>(); };
  EXPECT_NEAR(at(1, "link_mass_kg"), 1.5 * at(0, "link_mass_kg"), 1e-12);
  EXPECT_NEAR(at(1, "link_inertia_about_joint_kg_m2"),
              1.5 * 1.5 * 1.5 * at(0, "link_inertia_about_joint_kg_m2"), 1e-12);
  EXPECT_NEAR(at(1, "total_mass_kg") - at(0, "total_mass_kg"), 0.5 * at(0, "link_mass_kg"), 1e-12);
  EXPECT_NE(at(1, "average_acceleration_m_s2"), at(0, "average_acceleration_m_s2"));
  EXPECT_TRUE(fs::exists(folder_ / "sweep" / "study.csv"));
  EXPECT_FALSE(fs::exists(folder_ / "sweep" / "study.journal"));
}

// A worker for the test below, which starts this very program again: run by hand it does nothing.
TEST(DISABLED_PlanStudyWorker, Run) {
  const char* file = std::getenv("JACULUS_TEST_PLAN_STUDY");
  const char* out = std::getenv("JACULUS_TEST_PLAN_STUDY_OUT");
  if (file == nullptr || out == nullptr) GTEST_SKIP();
  StudyOptions options;
  options.jobs = 1;
  run_study(file, out, options);
}

pid_t start_worker(const fs::path& file, const fs::path& out) {
  const pid_t child = ::fork();
  if (child != 0) return child;
  ::setenv("JACULUS_TEST_PLAN_STUDY", file.c_str(), 1);
  ::setenv("JACULUS_TEST_PLAN_STUDY_OUT", out.c_str(), 1);
  if (std::freopen("/dev/null", "w", stdout) == nullptr) ::_exit(126);
  ::execl("/proc/self/exe", "test_studies", "--gtest_also_run_disabled_tests",
          "--gtest_filter=DISABLED_PlanStudyWorker.Run", nullptr);
  ::_exit(127);
}

TEST_F(PlanStudy, GoesOnWhereItWasKilled) {
  const fs::path file = study("[1, 1.25, 1.5]");
  const fs::path calm = out("calm"), killed = out("killed");
  run_study(file, calm);
  const pid_t child = start_worker(file, killed);
  const auto finished = [&killed] {
    const fs::path journal = killed / "study.journal";
    return fs::exists(journal) ? read_journal(journal).finished.size() : 0u;
  };
  int status = 0;
  while (finished() == 0 && ::waitpid(child, &status, WNOHANG) == 0)
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  ::kill(child, SIGKILL);
  ::waitpid(child, &status, 0);
  ASSERT_TRUE(WIFSIGNALED(status)) << "it ended before it could be killed";
  const std::size_t kept = finished();
  ASSERT_GE(kept, 1u);
  StudyOptions options;
  options.resume = true;
  int first_seen = -1;
  options.progress = [&first_seen](const TaskProgress& p) {
    first_seen = first_seen < 0 ? p.done : first_seen;
  };
  EXPECT_TRUE(run_study(file, killed, options).complete);
  EXPECT_GE(first_seen, static_cast<int>(kept));  // what was finished is not computed again
  EXPECT_EQ(test::bytes_of(killed / "study.csv"), test::bytes_of(calm / "study.csv"));
  EXPECT_EQ(test::bytes_of(killed / "study.json"), test::bytes_of(calm / "study.json"));
}

TEST_F(PlanStudy, BadInputIsNamedWithItsPlace) {
  struct Fault {
    const char *from, *to, *message;
  };
  for (const Fault& f : {
           Fault{"link: tail", "link: tial", "did you mean 'tail'?"},
           Fault{"link: tail", "link: front_a_upper", "carries others"},
           Fault{"[1, 1.5]", "[]", "an empty list"},
           Fault{"[1, 1.5]", "[1, 1]", "a factor that is there already"},
           Fault{"[1, 1.5]", "[1, 0]", "factors[1]"},
           Fault{"[1, 1.5]", "[1, 1.5 m]", "factors[1]"},
           Fault{"problem: small.yaml", "problem: smal.yaml", "smal.yaml"},
           Fault{"problem: small.yaml", "problm: small.yaml", "did you mean 'problem'?"},
           Fault{"x: stretch", "x: strech", "stretch"},
       }) {
    SCOPED_TRACE(f.to);
    std::string text = small_study("[1, 1.5]");
    const std::size_t at = text.find(f.from);
    ASSERT_NE(at, std::string::npos);
    folder_.write("bad.yaml", text.replace(at, std::string(f.from).size(), f.to));
    try {
      static_cast<void>(check_study(folder_ / "bad.yaml"));
      ADD_FAILURE() << "accepted";
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(f.message), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace jaculus::studies
