#pragma once
// What a solve found, in figures: the value behind summary.json and behind what `jaculus solve`
// prints. Figures that don't apply (drag's share of a robot without a tail) are NaN and become
// null; averages of the base and of the centre of mass stand side by side, since the centre of mass
// is the slower of the two.

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "jaculus/core/types.h"
#include "jaculus/model/planar.h"
#include "jaculus/solver/plan.h"
#include "jaculus/solver/result.h"
#include "jaculus/transcription/describe.h"
#include "jaculus/transcription/problem.h"

namespace jaculus::solver {

/// Whether first-order conditions hold: what ended so is a solution.
inline bool converged(Status status) {
  return status == Status::optimal || status == Status::acceptable;
}

/// Of the nonlinear program on the last mesh.
struct ProblemSize {
  int variables = 0;
  int constraints = 0;        ///< rows, bounds not among them
  int jacobian_nonzeros = 0;  ///< entries of its sparsity pattern
  int hessian_nonzeros = 0;   ///< likewise, lower triangle
};

struct PhaseFigures {
  std::string name;
  double duration = kNaN;  ///< [s]
  bool at_bound = false;   ///< its duration stands at one of its bounds
};

/// Largest absolute values of one motor over the plan, and what it may use. Torque before the gear.
struct MotorFigures {
  std::string joint;  ///< that it turns
  int count = 1;      ///< left and right: 2; figures are those of one
  /// joints of the robot's file that it stands for, left first; empty where they are not known
  std::vector<model::FileJoint> file_joints = {};
  bool slides = false;               ///< it moves along a line: its torques are forces [N]
  double joint_torque = kNaN;        ///< behind the gear [N m]
  double motor_torque = kNaN;        ///< before the gear [N m]
  double current = kNaN;             ///< [A]
  double voltage = kNaN;             ///< [V]
  double torque_limit = kInfinity;   ///< before the gear [N m]
  double current_limit = kInfinity;  ///< [A]
  double voltage_limit = kInfinity;  ///< [V]
  double speed_limit = kInfinity;    ///< before the gear [rad/s]
  double gear = 1.0;                 ///< [-]
  double efficiency = 1.0;           ///< [-]
  double torque_constant = kNaN;     ///< [N m/A]
  double resistance = kNaN;          ///< [ohm]
  double saturation_linear = kNaN;   ///< [A/(N m)]
  double saturation_cubic = kNaN;    ///< [A/(N m)^3]
  double dry_friction = 0.0;         ///< at the joint, made up for by the motor's torque [N m or N]
};

/// A PlanSensitivity with the unit of its gain: first order, valid for small changes.
struct LimitGain {
  std::string limit;  ///< "voltage"
  /// improvement of the objective for one unit more of the limit [unit]; positive is better
  double gain = kNaN;
  std::string unit;  ///< "m/s^2 per V"
};

/// By how much a row of the nonlinear program fails to hold.
struct RowFigure {
  std::string row;      ///< its name; empty where there is none to speak of
  double value = kNaN;  ///< [unit]
  std::string unit;     ///< of the row
};

/// How well the plan stands up to an independent integration and to its limits between nodes.
struct VerificationFigures {
  /// largest error over all nodes by coordinate [rad or m]
  std::map<std::string, double> reintegration_error;
  std::map<std::string, double> reintegration_velocity_error;  ///< [rad/s or m/s]
  RowFigure worst_violation;                                   ///< of any row at its node
  RowFigure off_node_violation;                                ///< of any limit between nodes
  double momentum_balance = kNaN;  ///< largest imbalance over the plan's momentum [-]
  double energy_balance = kNaN;    ///< largest imbalance over the plan's work [-]
  bool passed = false;
  std::vector<std::string> failures;  ///< one sentence each
};

struct Summary {
  std::string name;                ///< of the problem
  std::string caption;             ///< of the problem, one sentence or nothing
  Status status = Status::failed;  ///< how the solve ended
  std::string message;             ///< how it ended, for users
  double objective = kNaN;         ///< in the problem's sense, maximised or minimised
  int iterations = 0;
  ProblemSize size;
  double duration = kNaN;  ///< [s]
  std::vector<PhaseFigures> phases;
  double liftoff_velocity = kNaN;          ///< v_x of the base at the plan's end [m/s]
  double liftoff_velocity_com = kNaN;      ///< of the centre of mass [m/s]
  double liftoff_rise_com = kNaN;          ///< its upward velocity at the plan's end [m/s]
  double average_acceleration = kNaN;      ///< base, v_x at the end over the duration [m/s^2]
  double average_acceleration_com = kNaN;  ///< centre of mass [m/s^2]
  double tail_momentum_share = kNaN;  ///< impulse of drag over the forward momentum at the end [-]
  std::vector<MotorFigures> motors;
  /// joints of the robot's file that stand still in the plan
  std::vector<model::HeldJoint> held_joints;
  std::vector<PlanLimit> active_limits;  ///< that hold the plan back, and when
  std::vector<LimitGain> gains;          ///< what a unit more of a limit would gain
  VerificationFigures verification;
  std::vector<std::string> warnings;     ///< what to mind in this plan, one sentence each
  std::string binds;                     ///< after a failure: the limits that bind, one sentence
  std::vector<RowFigure> violated_rows;  ///< after a failure, worst first
  /// after a failure: rows that must give way for all others to hold, and by how much
  std::vector<RowFigure> conflict;
  /// limits that those rows strain against, strongest first
  std::vector<std::string> conflict_against;
  transcription::InputHold input_hold = transcription::InputHold::held;  ///< of the plan's torques
  int seed = 0;                             ///< of everything random in the solve
  std::map<std::string, double> reference;  ///< published figures, from the problem
  /// Where the robot was found, in summary.json from that file's folder; empty: by a name that is
  /// installed.
  std::string robot_folder;
  nlohmann::ordered_json problem;  ///< as understood: transcription::describe_problem()

  [[nodiscard]] bool converged() const { return solver::converged(status); }
};

/// The figures of a plan of `problem`.
Summary summarise(const Plan& plan, const transcription::Problem& problem);

/// Limits and constants of the motors of a model, peaks left open.
std::vector<MotorFigures> motor_figures(const model::PlanarModel& model);

/// A published figure of the problem; NaN where it has none of that name.
double published(const Summary& summary, const std::string& figure);

/// Largest of a figure over all motors, &MotorFigures::voltage or the like; NaN without motors.
double largest(const std::vector<MotorFigures>& motors, double MotorFigures::*figure);

/// summary.json.
nlohmann::ordered_json to_json(const Summary& summary);

/// Reads back what to_json wrote, `file` for messages. InputError where it is something else.
Summary summary_from_json(const nlohmann::ordered_json& json, const std::string& file);

/// Reads a summary.json. InputError where it can't be read or is something else.
Summary read_summary(const std::filesystem::path& file);

}  // namespace jaculus::solver
