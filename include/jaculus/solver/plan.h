#pragma once
// From a problem to a plan: nonlinear program, guess, solve (from several starts where the problem
// asks for them), refinement of the mesh, verification, and the diagnosis where it fails.
//
// Sensitivities to limits. With f the minimised objective and L = f + lambda' g the Lagrangian of
// result.h, the envelope theorem gives df*/dp = dL/dp for a parameter p of the problem. Rows and
// bounds that share a parameter are summed:
//   voltage V       |U| <= V          -df*/dV  =  sum |lambda|
//   motor torque    |u| <= u(tau)     -df*/dtau = sum (z_l + z_u) du/dtau, or likewise by current
//                                     where that is the tighter
//   friction mu     mu f_z -+ f_x >= 0  -df*/dmu = -sum lambda f_z
//   normal force F  f_z >= n F        -df*/dF  =  sum lambda n     (n feet, left and right)
//   touchdown pitch                   -df*/dphi = lambda
// First order: valid for small changes while the same limits stay active, near the local optimum
// that was found.

#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "jaculus/solver/elastic.h"
#include "jaculus/solver/multi_start.h"
#include "jaculus/solver/verify.h"
#include "jaculus/solver/violations.h"
#include "jaculus/transcription/guess.h"

namespace jaculus::solver {

struct PlanOptions {
  int jobs = 1;  ///< processes at a time where there are several starts
  /// after every iteration; not from within several starts
  std::function<void(const IterationInfo&)> progress = {};
  /// after every start, where there are several
  std::function<void(const TaskProgress&)> starts_progress = {};
  std::function<void(const std::string&)> notice = {};  ///< as of TaskOptions, for several starts
  std::shared_ptr<const Executor> executor = {};        ///< as of TaskOptions, for several starts
  std::string stage = "starts";                         ///< as of TaskOptions
};

/// Where several starts were made: what came of them.
struct StartFigures {
  int count = 1;
  int ended = 1;  ///< that ran to their end; fewer where the solve was interrupted
  int converged = 0;
  int near_best = 0;  ///< converged and within 0.5 % of the best
  int best = 0;       ///< index of the one that was taken
  /// of better objective than that one, but not verified between nodes: indices, best first
  std::vector<int> passed_over;
};

/// A limit that holds the plan back in one phase: a path constraint, an input, a bound of a
/// coordinate or duration, an inequality at one node ("whole plan").
struct PlanLimit {
  std::string name;  ///< "front_a voltage"
  std::string phase;
  double from = 0.0, to = 0.0;  ///< first and last time at which it is active [s]
  /// number of collocation points (or intervals, for torques) at which it is active
  int nodes = 0;
};

/// What one unit more of a limit gains: the sensitivity of the objective to it.
struct PlanSensitivity {
  std::string limit;  ///< "voltage"
  std::string unit;   ///< of the limit: "V"
  /// improvement of the objective a unit [objective's unit over `unit`]; positive is better
  double gain = 0.0;
};

/// The plan on one mesh of a refinement.
struct MeshRound {
  std::vector<int> intervals;    ///< by phase
  double objective = kNaN;       ///< in the problem's sense
  double duration = kNaN;        ///< [s]
  double final_velocity = kNaN;  ///< v_x of the base at the end [m/s]; NaN where it has none
  double interval_error = kNaN;  ///< largest of all intervals, see interval_errors [-]
  int iterations = 0;            ///< of this round
};

/// A solved problem. `program` is the one on the last mesh; everything else refers to it.
struct Plan {
  std::unique_ptr<transcription::NonlinearProgram> program;
  NlpResult result;
  StartFigures starts;
  int refinements = 0;  ///< rounds of mesh refinement that were made
  /// where refinement was asked for: the first mesh, then each finer one
  std::vector<MeshRound> mesh_rounds;
  /// one sentence where a finer solve did not converge; empty otherwise
  std::string refinement_failure;
  std::vector<std::string> notes;  ///< on the guess: what an earlier plan lacks
  /// of the solution or of the last iterate; nothing where undefined there
  std::optional<trajectory::Trajectory> trajectory;
  std::optional<PlanVerification> verification;  ///< likewise
  std::vector<PlanLimit> limits;                 ///< where converged
  std::vector<PlanSensitivity> sensitivities;    ///< where converged
  std::string
      objective_unit;  ///< of `sensitivities`; empty where terms of several units are summed
  double objective_weight = 1.0;      ///< of the term in that unit; gains are divided by it
  std::vector<Violation> violations;  ///< after a failure, worst first
  std::optional<Conflict> conflict;   ///< after a failure: what can't hold together

  [[nodiscard]] bool converged() const { return result.converged(); }
};

/// Solves `problem` with `model` (overrides applied, nothing locked). Bad input is an InputError,
/// numerical failure a status.
Plan make_plan(const transcription::Problem& problem, const model::PlanarModel& model,
               const PlanOptions& options = {});

/// Limits that are active at a solution, by phase and name in the order of their rows.
std::vector<PlanLimit> active_limits(transcription::NonlinearProgram& program,
                                     const NlpResult& result);
/// Sensitivities to the limits at the top and of bounds on the state at the plan's end. Fills
/// objective_unit and objective_weight.
void find_sensitivities(Plan& plan);

/// solution.json: variables and multipliers by name, exact, and the trajectory.
nlohmann::ordered_json solution_json(const Plan& plan);

/// An earlier plan as a start for another one.
struct EarlierPlan {
  trajectory::Trajectory trajectory;
  std::vector<std::string> variables;  ///< empty where it comes from a CSV
  std::vector<std::string> rows;
  Vector x;
  std::optional<Duals> duals;

  /// Whether x and duals belong to a nonlinear program of these very variables and rows.
  [[nodiscard]] bool fits(const transcription::NonlinearProgram& program) const;
};

/// Reads a solution.json or a plan.csv; joints become coordinates by the joint map of `model`.
/// InputError where it is neither.
EarlierPlan read_earlier_plan(const std::filesystem::path& file, const model::PlanarModel& model);
/// Its trajectory alone.
trajectory::Trajectory read_trajectory(const std::filesystem::path& file,
                                       const model::PlanarModel& model);

}  // namespace jaculus::solver
