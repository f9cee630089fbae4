// Adds a constraint of one's own: a limit on how fast the body may pitch. Problem files know it as
// {type: pitch_rate, limit: 10 deg/s}.
//
//   own_term own_term/jump.yaml

#include <cstdio>

#include "jaculus/core/error.h"
#include "jaculus/model/robot.h"
#include "jaculus/solver/plan.h"
#include "jaculus/transcription/term.h"

using namespace jaculus;

// The row at one collocation point: -limit <= rate <= limit.
transcription::PathTerm pitch_rate_row(int pitch, double limit) {
  transcription::PathTerm term;
  term.name = "pitch rate";
  term.rows.push_back({term.name, "rad/s", {-limit, limit}, limit});
  term.reads.velocity = true;  // sparsity follows from this

  // Value, Jacobian (where asked for), and no second derivatives: the row is linear.
  term.evaluate = [pitch](const transcription::PointView& view, VectorRef values, Matrix* J,
                          const ConstVectorRef*, Matrix*) {
    values[0] = view.point.v[pitch];
    if (J != nullptr) (*J)(0, view.v_at() + pitch) = 1.0;
  };
  return term;
}

// What a problem file calls it, and its keys.
transcription::TermType pitch_rate() {
  transcription::TermType type;
  type.name = "pitch_rate";
  type.meaning = "how fast the body may pitch";
  type.keys = {{"limit", transcription::key::Number{dimension::angular_velocity, {1e-3, 100.0}},
                "largest rate either way"}};
  type.example = "limit: 300 deg/s";

  type.make = [](const transcription::TermSpec& spec, transcription::TermContext& context) {
    const int pitch = context.model().coordinate_index("pitch");
    for (std::vector<transcription::PathTerm>& phase : context.path)
      phase.push_back(pitch_rate_row(pitch, spec.values.number("limit")));
  };
  return type;
}

int main(int argc, char** argv) try {
  if (argc != 2) {
    std::puts("usage: own_term PROBLEM.yaml");
    return 2;
  }

  // The library's terms and this one. Everything else goes as with any other problem.
  transcription::TermCatalogue catalogue = transcription::term_catalogue();
  catalogue.push_back(pitch_rate());
  const transcription::Problem problem = transcription::read_problem(argv[1], catalogue);
  const model::Robot robot = model::read_robot(problem.robot_folder, problem.overrides);
  transcription::check_problem(problem, robot.planar);

  const solver::Plan plan = solver::make_plan(problem, robot.planar);
  if (!plan.converged()) {
    std::printf("%s\n", plan.result.message.c_str());
    return 1;
  }

  // The plan keeps to it at every node, and the solver says where the limit is active.
  const int pitch = robot.planar.coordinate_index("pitch");
  const double fastest = plan.trajectory->velocity.row(pitch).cwiseAbs().maxCoeff();
  std::printf("objective %.4f, largest pitch rate %.4f rad/s\n", plan.result.objective, fastest);
  for (const solver::PlanLimit& limit : plan.limits)
    std::printf("  active: %s from %.3f to %.3f s\n", limit.name.c_str(), limit.from, limit.to);
  return 0;
} catch (const InputError& error) {
  std::printf("%s\n", error.what());
  return 2;
}
