#pragma once
// Problems for tests: those of the problems folder with a coarse grid, and variations of them written as a few lines of YAML.

#include <string>
#include <vector>

#include "jaculus/transcription/guess.h"
#include "support/temporary_folder.h"

namespace jaculus::test {

inline std::filesystem::path problem_file(const std::string& name) {
  return std::filesystem::path(JACULUS_SOURCE_DIR) / "problems" / (name + ".yaml");
}

/// A problem that extends one of the problems folder by `lines`.
inline Problem extended_problem(const std::string& base, const std::string& lines) {
  const TemporaryFolder folder;
  return read_problem(folder.write("problem.yaml", "format: jaculus-problem/1\nname: variation\nextends: " +
                                                       problem_file(base).string() + "\n" + lines + "\n"));
}

/// Intervals of the phases, in order.
inline Problem on_grid(Problem problem, const std::vector<int>& intervals) {
  for (size_t p = 0; p < problem.phases.size(); ++p) {
    problem.phases[p].intervals = intervals.at(p);
    problem.phases[p].mesh.clear();
  }
  return problem;
}

/// The planar model that the problem plans with.
inline PlanarModel model_of(const Problem& problem) {
  const Robot robot = read_robot(problem.robot_folder, problem.overrides);
  check_problem(problem, robot.planar);
  return planning_model(problem, robot.planar);
}

inline Programme make_programme(const Problem& problem) { return Programme(problem, model_of(problem)); }

/// A guess from which the leap is known to converge on coarse grids: lines from the crouch to the push-off.
inline GuessSpec leap_guess() {
  GuessSpec guess;
  guess.kind = "line";
  guess.durations = {0.2, 0.01};
  guess.poses = {{{"front_extension", 1.0}, {"front_angle", 0.0}, {"rear_extension", 1.0}, {"rear_angle", 0.0}},
                 {{"x", 0.13},
                  {"z", 0.27},
                  {"pitch", -0.15},
                  {"front_extension", 2.6},
                  {"front_angle", 0.5},
                  {"rear_extension", 2.1},
                  {"rear_angle", 0.65}}};
  return guess;
}

}  // namespace jaculus::test
