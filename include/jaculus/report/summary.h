#pragma once
// What a solve found, in figures: the value behind summary.json and what `jaculus solve` prints. Figures that don't apply
// (drag's share of a robot without a tail) are NaN and become null; averages of the base and of the centre of mass stand
// side by side, since the centre of mass is the slower of the two.

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "jaculus/core/types.h"
#include "jaculus/model/planar.h"
#include "jaculus/transcription/problem.h"

namespace jaculus {

struct ProblemSize {
  int variables = 0;
  int constraints = 0;
  int jacobian_nonzeros = 0;
  int hessian_nonzeros = 0;
};

struct PhaseFigures {
  std::string name;
  double duration = kNaN;  ///< [s]
  bool at_bound = false;   ///< its duration stands at one of its bounds
};

/// Largest absolute values of one motor over the plan, and what it may use. Torque before the gear.
struct MotorFigures {
  std::string motor;                 ///< joint that it turns
  int count = 1;                     ///< left and right: 2; figures are those of one
  bool slides = false;               ///< it moves along a line: its torques are forces [N]
  double joint_torque = kNaN;        ///< behind the gear [N m]
  double motor_torque = kNaN;        ///< before the gear [N m]
  double current = kNaN;             ///< [A]
  double voltage = kNaN;             ///< [V]
  double torque_limit = kInfinity;   ///< before the gear [N m]
  double current_limit = kInfinity;  ///< [A]
  double voltage_limit = kInfinity;  ///< [V]
  double gear = 1.0;                 ///< [-]
  double efficiency = 1.0;           ///< [-]
  double torque_constant = kNaN;     ///< [N m/A]
  double resistance = kNaN;          ///< [ohm]
  double saturation_linear = kNaN;   ///< [A/(N m)]
  double saturation_cubic = kNaN;    ///< [A/(N m)^3]
};

/// A limit that holds the plan back, and when.
struct ActiveLimit {
  std::string name;  ///< "front_a voltage"
  std::string phase;
  double from = kNaN;  ///< first time at which it is active [s]
  double to = kNaN;    ///< last one [s]
  int nodes = 0;       ///< at how many nodes between
};

/// What one unit more of a limit would gain, from the multipliers: first order, valid for small changes.
struct PriceFigure {
  std::string limit;    ///< "voltage"
  double price = kNaN;  ///< gain of the objective a unit of the limit, in the unit below; positive is better
  std::string unit;     ///< "m/s^2 per V"
};

struct RowFigure {
  std::string row;  ///< name of the row
  double value = kNaN;
  std::string unit;
};

/// How well the plan stands up to an independent integration and to its limits between nodes.
struct Verification {
  std::map<std::string, double> reintegration_error;  ///< largest error over all nodes by coordinate [rad or m]
  std::map<std::string, double> reintegration_velocity_error;  ///< [rad/s or m/s]
  RowFigure worst_violation;                                   ///< of any row at its node
  RowFigure off_node_violation;                                ///< of any limit between nodes
  double momentum_balance = kNaN;                              ///< largest imbalance over the plan's momentum [-]
  double energy_balance = kNaN;                                ///< largest imbalance over the plan's work [-]
  bool passed = false;
  std::vector<std::string> failures;  ///< one sentence each
};

struct Summary {
  std::string name;
  std::string caption;
  std::string status;  ///< as Status in solver/result.h
  bool converged = false;
  std::string message;  ///< how it ended, for users
  double objective = kNaN;
  int iterations = 0;
  ProblemSize size;
  double duration = kNaN;  ///< [s]
  std::vector<PhaseFigures> phases;
  double liftoff_velocity = kNaN;          ///< v_x of the base at the plan's end [m/s]
  double liftoff_velocity_com = kNaN;      ///< of the centre of mass [m/s]
  double average_acceleration = kNaN;      ///< base, v_x at the end over the duration [m/s^2]
  double average_acceleration_com = kNaN;  ///< centre of mass [m/s^2]
  double tail_momentum_share = kNaN;       ///< impulse of drag over the forward momentum at the end [-]
  std::vector<MotorFigures> motors;
  std::vector<ActiveLimit> active_limits;
  std::vector<PriceFigure> prices;
  Verification verification;
  std::vector<std::string> warnings;     ///< what to mind in this plan, one sentence each
  std::vector<RowFigure> violated_rows;  ///< after a failure, worst first
  std::vector<RowFigure>
      conflict;  ///< after a failure: rows that must give way for all others to hold, and by how much
  std::vector<std::string> conflict_against;  ///< limits that those rows strain against, strongest first
  std::string input_hold;                     ///< "held" or "linear"
  int seed = 0;
  std::map<std::string, double> reference;  ///< published figures, from the problem
  nlohmann::ordered_json problem;           ///< as understood: describe_problem()
};

/// The problem as understood, every default spelt out, SI values.
nlohmann::ordered_json describe_problem(const Problem& problem);
/// The same for people, with sizes of the robot; what `jaculus check` prints.
std::string describe_problem_text(const Problem& problem, const Robot& robot);

/// Limits and constants of the motors of a model, peaks left open.
std::vector<MotorFigures> motor_figures(const PlanarModel& model);

/// summary.json, keys as INTERFACES states them.
nlohmann::ordered_json to_json(const Summary& summary);
/// Reads back what to_json wrote, `file` for messages. InputError where it is something else.
Summary summary_from_json(const nlohmann::ordered_json& json, const std::string& file);
/// What `jaculus solve` prints. `colour` allows terminal colours.
std::string to_text(const Summary& summary, bool colour);

}  // namespace jaculus
