// Sections of a problem file that say how it is solved, not what it is.

#include "transcription/problem_keys.h"
#include "transcription/problem_read.h"

namespace jaculus::problem_read {

using yaml::Node;

void transcription(Problem& problem, const Node& node) {
  node.only(problem_keys::of("transcription"));
  TranscriptionSpec& spec = problem.transcription;
  if (const auto scheme = node.find("scheme")) {
    spec.scheme = scheme->choice({"hermite_simpson", "trapezoidal"}) == "trapezoidal" ? Scheme::trapezoidal
                                                                                      : Scheme::hermite_simpson;
  }
  if (const auto inputs = node.find("inputs")) {
    spec.inputs = inputs->choice({"held", "linear"}) == "linear" ? InputHold::linear : InputHold::held;
  }
  if (const auto check = node.find("check_interval_end")) spec.check_interval_end = check->boolean();
}

void solver(Problem& problem, const Node& node) {
  node.only(problem_keys::of("solver"));
  SolverSpec& spec = problem.solver;
  if (const auto value = node.find("tolerance")) spec.tolerance = value->number(dimension::none, {1e-14, 1e-1});
  if (const auto value = node.find("max_iterations")) spec.max_iterations = value->integer(1, 1000000);
  if (const auto value = node.find("linear_solver")) {
    spec.linear_solver = value->choice({"mumps", "ma27", "ma57", "ma86", "ma97"});
  }
  if (const auto value = node.find("seed")) spec.seed = value->integer(0, 2147483647);
  if (const auto value = node.find("starts")) spec.starts = value->integer(1, 10000);
}

void refinement(Problem& problem, const Node& node) {
  node.only(problem_keys::of("refinement"));
  RefinementSpec& spec = problem.refinement;
  if (const auto value = node.find("max_rounds")) spec.max_rounds = value->integer(0, 50);
  if (const auto value = node.find("tolerance")) spec.tolerance = value->number(dimension::none, {0.0, 1.0});
}

void reference(Problem& problem, const Node& node) {
  if (is_null(node)) problem.reference.clear();
  if (is_null(node)) return;
  node.only(problem_keys::of("reference"));
  static const std::map<std::string, Dimension> units = {{"average_acceleration_m_s2", dimension::acceleration},
                                                         {"average_acceleration_com_m_s2", dimension::acceleration},
                                                         {"measured_acceleration_m_s2", dimension::acceleration},
                                                         {"measured_duration_s", dimension::time},
                                                         {"duration_s", dimension::time},
                                                         {"first_phase_s", dimension::time},
                                                         {"liftoff_velocity_m_s", dimension::velocity}};
  for (const auto& [key, value] : node.entries()) {
    problem.reference.erase(key);
    const auto unit = units.find(key);
    if (!is_null(value)) problem.reference[key] = value.number(unit == units.end() ? dimension::none : unit->second);
  }
}

}  // namespace jaculus::problem_read
