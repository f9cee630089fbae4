// jaculus check on studies and on sliding coordinates: what is understood, and what is refused with
// place and units.

#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "cli/program.h"
#include "support/input_error.h"
#include "support/temporary_folder.h"

namespace jaculus::cli {
namespace {

using test::bytes_of;
using test::expect_refusal;
using test::holds;
using test::kProblems;
using test::Outcome;
using test::run_program;
using test::TemporaryFolder;

TEST(CheckStudy, SaysWhatEveryShippedStudyIs) {
  int studies = 0;
  for (const auto& entry : std::filesystem::directory_iterator(kProblems)) {
    if (entry.path().extension() != ".yaml" ||
        !holds(bytes_of(entry.path()), "format: jaculus-study/1"))
      continue;
    SCOPED_TRACE(entry.path().string());
    const Outcome outcome = run_program({"check", entry.path().string()});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_TRUE(outcome.out.starts_with("study " + entry.path().stem().string() + " ("))
        << outcome.out;
    ++studies;
  }
  EXPECT_GE(studies, 10);
}

TEST(CheckStudy, SpeaksJsonAndCountsPoints) {
  const Outcome outcome = run_program({"check", "--json", kProblems + "fig3_effectiveness.yaml"});
  const auto json = nlohmann::json::parse(outcome.out);
  ASSERT_EQ(json.size(), 1u);
  EXPECT_TRUE(holds(json[0]["study"].get<std::string>(), "183 points"));
}

struct Fault {
  const char *study, *from, *to;
  const char* place;    ///< "file:line" or the file
  const char* key;      ///< key or value it must name
  const char* allowed;  ///< allowed value, nearest name or reason
};

constexpr Fault kFaults[] = {
    {"self_righting", "format: jaculus-study/1", "format: jaculus-study/2", "bad.yaml:", "format",
     "jaculus-study/1"},
    {"self_righting", "kind: reorientation", "kind: reorient", "bad.yaml:", "kind",
     "reorientation"},
    {"self_righting", "inertia: 0.23 kg m^2", "inertia: 0 kg m^2", "bad.yaml:", "body.inertia",
     "allowed: 1e-12"},
    {"self_righting", "inertia: 0.23 kg m^2", "inertia: -1 kg m^2", "bad.yaml:", "body.inertia",
     "allowed: 1e-12"},
    {"self_righting", "mass: 7.3 kg}", "mas: 7.3 kg}", "bad.yaml:", "mas", "did you mean 'mass'?"},
    {"self_righting", "shaft: 0.6 m", "shaft: 1.6 m", "bad.yaml:", "shaft length is 1.6 m",
     "exceed"},
    {"self_righting", "gear: 4}", "gear: 0}", "bad.yaml:", "motor.gear", "allowed: 1e-12"},
    {"self_righting", "voltage: 16 V", "voltage: 0 V", "bad.yaml:", "motor.voltage",
     "allowed: 1e-12"},
    {"self_righting", "com: 0.629 m", "com: 0.1 m", "bad.yaml:", "tail.inertia", "or less"},
    {"self_righting", "motor.gear: 5", "motor.gaer: 5", "bad.yaml:", "motor.gaer", "motor.gear"},
    {"self_righting", "inertia_saved, added_mass", "inertia_savd, added_mass",
     "bad.yaml:", "inertia_savd", "inertia_saved"},
    {"self_righting", "where: {case: as built}", "where: {cse: as built}", "bad.yaml:", "cse",
     "case"},
    {"self_righting", "within: 0.004", "within: many", "bad.yaml:", "within", "number"},
    {"width_drag", "grid:", "grd:", "bad.yaml:", "grd", "'grid'"},
    {"fig4_shaft", "shaft_ratio", "shaft_ratoi", "bad.yaml:", "shaft_ratoi", "shaft_ratio"},
    {"drag_bench", "data: drag_bench.csv", "data: drag_bnch.csv", "bad.yaml:", "drag_bnch.csv",
     "not found"},
    {"tail_design", "limits: {mass: 120 g", "limits: {mass: 120 m", "bad.yaml:", "limits.mass",
     "kg"},
    {"leap_tail_length", "problem: leap_tail_as_published.yaml", "problem: leap_tial.yaml",
     "bad.yaml:", "leap_tial.yaml", "not found"},
    {"leap_tail_length", "link: tail", "link: tial", "bad.yaml:", "tial", "did you mean 'tail'?"},
};

TEST(CheckStudy, EveryFaultIsNamedWithItsPlace) {
  const TemporaryFolder folder;
  for (const char* file :
       {"leap_tail.yaml", "leap_tail_as_published.yaml", "drag_bench.csv"})  // that studies name
    std::filesystem::copy_file(kProblems + file, folder / file);
  for (const Fault& f : kFaults) {
    SCOPED_TRACE(std::string(f.study) + ": " + f.from + "  ->  " + f.to);
    std::string text = bytes_of(kProblems + f.study + ".yaml");
    const std::size_t at = text.find(f.from);
    ASSERT_NE(at, std::string::npos);
    folder.write("bad.yaml", text.replace(at, std::string(f.from).size(), f.to));
    const Outcome outcome = run_program({"check", "bad.yaml"}, folder.path());
    expect_refusal(outcome);
    EXPECT_TRUE(holds(outcome.err, f.place));
    EXPECT_TRUE(holds(outcome.err, f.key));
    EXPECT_TRUE(holds(outcome.err, f.allowed));
  }
}

// A joint may turn or slide: a message about its velocity speaks of the unit that was meant, and of
// both where none is near.
TEST(CheckSlidingJoint, SpeaksOfMetresASecond) {
  struct Case {
    const char *bounds, *message;
  };
  const TemporaryFolder folder;
  for (const Case& c : {
           Case{"velocity: {slide: [-5 rad/s, 5 rad/s]}", "allowed: a number in m/s, or"},
           Case{"velocity: {slide: [-5 m/s, 5 kg]}",
                "'5 kg' is in kg; allowed: a number in m/s, or"},
           Case{"velocity: {slide: [5 m/s, -5 m/s]}", "lower <= upper"},
           Case{"velocity: {slide: [-5 kg, 5 kg]}",
                "a number in rad/s where it turns or m/s where it slides"},
           Case{"velocity: {slide: [-5 rad/s, 5 kg]}",
                "'5 kg' is in kg; allowed: a number in rad/s, or"},
           Case{"position: {slide: [-1 kg, 2 kg]}",
                "a number in rad where it turns or m where it slides"},
           Case{"position: {slide: [-1 m, 2 m/s]}", "allowed: a number in m, or"},
       }) {
    SCOPED_TRACE(c.bounds);
    folder.write("bad.yaml", "format: jaculus-problem/1\nextends: " + kProblems +
                                 "double_integrator.yaml\nname: bad\nbounds:\n  " + c.bounds +
                                 "\n");
    const Outcome outcome = run_program({"check", "bad.yaml"}, folder.path());
    expect_refusal(outcome);
    EXPECT_TRUE(holds(outcome.err, c.message)) << outcome.err;
    EXPECT_TRUE(holds(outcome.err, "bad.yaml:5: bounds.")) << outcome.err;
  }
}

}  // namespace
}  // namespace jaculus::cli
