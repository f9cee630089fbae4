// Solves a problem, says what limits it, and writes torques for the robot.
//
//   solve hopper/jump.yaml torques.csv

#include <cstdio>
#include <string>

#include "jaculus/core/error.h"
#include "jaculus/export/export.h"
#include "jaculus/model/robot.h"
#include "jaculus/solver/plan.h"
#include "jaculus/solver/plan_files.h"
#include "jaculus/transcription/problem.h"

using namespace jaculus;

int main(int argc, char** argv) try {
  if (argc != 3) {
    std::puts("usage: solve PROBLEM.yaml TORQUES.csv");
    return 2;
  }

  // A problem file names its robot; the problem may override values of it.
  const transcription::Problem problem = transcription::read_problem(argv[1]);
  const model::Robot robot = model::read_robot(problem.robot_folder, problem.overrides);
  transcription::check_problem(problem, robot.planar);

  // A numerical failure is a status, never an exception: ask before you use the plan.
  const solver::Plan plan = solver::make_plan(problem, robot.planar);
  if (!plan.converged()) {
    std::printf("%s: %s\n", to_string(plan.result.status).c_str(), plan.result.message.c_str());
    return 1;
  }

  // The figures of the plan, as `jaculus solve` prints them.
  const solver::SolvedPlan solved = solver::solved_plan(plan, problem);
  std::printf("%s: objective %.4f, %.3f s, verification %s\n", solved.summary.name.c_str(),
              solved.summary.objective, solved.summary.duration,
              solved.summary.verification.passed ? "passed" : "failed");
  for (const solver::PlanLimit& limit : solved.summary.active_limits)
    std::printf("  held back by %s from %.3f to %.3f s\n", limit.name.c_str(), limit.from,
                limit.to);

  // Torques at 1 kHz, held from sample to sample, checked against the limits again.
  const exporting::Export torques =
      exporting::resample(exporting::source(solved), 1000.0, exporting::Side::joint);
  trajectory::write_file(argv[2], exporting::to_csv(torques));
  for (const exporting::LimitCheck& check : torques.checks) {
    if (check.exceeded)
      std::printf("  %s %s reaches %.2f of %.2f %s between samples\n", check.joint.c_str(),
                  name_of(check.quantity), check.peak, check.limit, check.unit.c_str());
  }
  return 0;
} catch (const InputError& error) {
  std::printf("%s\n", error.what());  // file:line, what was given, what is allowed
  return 2;
}
