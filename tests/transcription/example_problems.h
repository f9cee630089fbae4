#pragma once
// Problems for tests: those of the problems folder with a coarse grid, and variations of them
// written as a few lines of YAML.

#include <string>
#include <vector>

#include "jaculus/core/installation.h"
#include "jaculus/transcription/guess.h"
#include "support/temporary_folder.h"

namespace jaculus::test {

inline std::filesystem::path problem_file(const std::string& name) {
  return source_folder() / "problems" / (name + ".yaml");
}

/// A problem that extends one of the problems folder by `lines`.
inline transcription::Problem extended_problem(
    const std::string& base, const std::string& lines,
    const transcription::TermCatalogue& catalogue = transcription::term_catalogue()) {
  const TemporaryFolder folder;
  const std::string head = "format: jaculus-problem/1\nname: variation\nextends: ";
  return transcription::read_problem(
      folder.write("problem.yaml", head + problem_file(base).string() + "\n" + lines + "\n"),
      catalogue);
}

/// Intervals of the phases, in order; the mesh stays as it is.
inline transcription::Problem on_grid(transcription::Problem problem,
                                      const std::vector<int>& intervals) {
  for (std::size_t p = 0; p < problem.phases.size(); ++p) {
    problem.phases[p].intervals = intervals.at(p);
    problem.phases[p].mesh.clear();
  }
  problem.refinement = {};
  return problem;
}

/// The planar model that the problem plans with.
inline model::PlanarModel model_of(const transcription::Problem& problem) {
  const model::Robot robot = model::read_robot(problem.robot_folder, problem.overrides);
  transcription::check_problem(problem, robot.planar);
  return transcription::planning_model(problem, robot.planar);
}

inline transcription::NonlinearProgram make_program(const transcription::Problem& problem) {
  return transcription::NonlinearProgram(problem, model_of(problem));
}

/// A guess from which the leap is known to converge on coarse grids: lines from the crouch to the
/// push-off.
inline transcription::GuessSpec leap_guess() {
  transcription::GuessSpec guess;
  guess.kind = "line";
  guess.durations = {0.2, 0.01};
  guess.poses = {{{"front_extension", 1.0},
                  {"front_angle", 0.0},
                  {"rear_extension", 1.0},
                  {"rear_angle", 0.0}},
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
