#pragma once
// Whether a plan can be trusted: its inputs are integrated anew, from the state of its first node
// to its end, by an adaptive Runge-Kutta-Fehlberg 7(8) method (Boost.Odeint) at 1e-10 absolute and
// relative, which shares no formula with the collocation. No step crosses an input switch or the
// border of a phase; feet that land go through Equations::evaluate_impact.
//
// Along that motion, at `samples` points an interval and its end, every limit of the problem is
// evaluated. Balances are sums over the whole plan, with impulses and work integrated as further
// states, P momentum, E kinetic and potential energy:
//   P_end - P_start = (gravity + feet + drag) dt + impacts
//     in the directions in which the base is free
//   E_end - E_start = sum of motors' work + drag's work + loss at impacts
// Each is stated twice: `..._balance` between the plan's own first and last node, which a poor plan
// misses, and `motion_..._balance` between the ends of the re-integrated motion, which only an
// error in the equations of motion could miss. Both are relative to the largest of the terms.
//
// Limits of validity: the equations are the plan's own, so that agreement says nothing about the
// model.

#include <string>
#include <vector>

#include "jaculus/transcription/nonlinear_program.h"

namespace jaculus::solver {

/// What a plan is held to; the defaults are those that the project promises at its default grid.
struct VerifyOptions {
  double length = 1e-3;                  ///< of any length coordinate at a node [m]
  double angle = 1.7453292519943296e-3;  ///< of any angular coordinate at a node: 0.1 deg [rad]
  double velocity = 0.02;                ///< of any length coordinate's velocity at a node [m/s]
  double rate = 0.2;      ///< of any angular coordinate's rate at a node: 0.02 m/s at 0.1 m [rad/s]
  double between = 0.25;  ///< of any limit between nodes, over its scale [-]
  double remark = 0.01;   ///< the same: from where on it is said in words [-]
  double slip = 1e-3;     ///< of a foot that stands, or below ground in the air, between nodes [m]
  double balance = 1e-3;  ///< of momentum and energy [-]
  double row = 1e-3;      ///< of any row or variable at the plan's own points, over its scale [-]
  double integration = 1e-10;  ///< absolute and relative tolerance of the integrator, SI units
  int samples = 20;  ///< points an interval at which limits are evaluated; its end comes on top
};

/// Largest difference between nodes and re-integrated motion in one coordinate.
struct CoordinateError {
  std::string coordinate;
  bool angular = true;
  double position = 0.0;      ///< [rad or m]
  double velocity = 0.0;      ///< [rad/s or m/s]
  std::string position_node;  ///< where it is largest: "all_feet, node 12"
  std::string velocity_node;
};

/// A limit that the re-integrated motion passes, where it does so most.
struct LimitExcess {
  /// "front_a voltage", "rear_foot slip", "front_foot below ground", "tail position"
  std::string name;
  std::string unit;
  std::string phase;
  double time = 0.0;     ///< from the plan's start [s]
  double value = 0.0;    ///< [unit]
  double limit = 0.0;    ///< that it passes [unit]
  double amount = 0.0;   ///< by how much, positive [unit]
  double scaled = 0.0;   ///< the same over the limit's scale [-]
  bool of_foot = false;  ///< a foot that slips, leaves the ground or goes below it
};

/// Outcome of verify_plan. NaN marks what does not apply (balances of momentum on a fixed base, a
/// share of nothing) or could not be computed because the integration ended early.
struct PlanVerification {
  bool passed = false;
  std::vector<std::string> failures;  ///< one sentence each; empty where passed
  /// what to mind without failing: limits passed between nodes, one sentence each
  std::vector<std::string> remarks;

  bool integrated = false;              ///< the motion could be integrated to its end
  std::vector<CoordinateError> errors;  ///< one a coordinate
  double length_error = kNaN;           ///< largest of all length coordinates [m]
  double angle_error = kNaN;            ///< of all angular ones [rad]
  double velocity_error = kNaN;  ///< of the velocities of length coordinates: the body's [m/s]
  double rate_error = kNaN;      ///< of the rates of angular ones [rad/s]
  std::string worst_node;        ///< the node that is farthest off, each coordinate over its scale

  /// limits passed between nodes, by falling scaled amount; empty where none is
  std::vector<LimitExcess> limits;
  /// largest scaled amount in each interval, over limits that are none of a foot [-]
  Vector interval_excess;
  /// row or variable that is worst at the plan's own points; empty where all hold
  std::string worst_row;
  std::string worst_row_unit;
  double worst_row_amount = 0.0;  ///< [unit]
  double worst_row_scaled = 0.0;  ///< over the row's scale [-]

  double momentum_balance = kNaN;         ///< see the top [-]
  double energy_balance = kNaN;           ///< [-]
  double motion_momentum_balance = kNaN;  ///< [-]
  double motion_energy_balance = kNaN;    ///< [-]
  Vec2 momentum_change = {kNaN, kNaN};    ///< of the re-integrated motion [N s]
  Vec2 gravity_impulse = {kNaN, kNaN};    ///< [N s]
  Vec2 feet_impulse = {kNaN, kNaN};       ///< impacts included [N s]
  Vec2 drag_impulse = {kNaN, kNaN};       ///< [N s]
  double energy_change = kNaN;            ///< [J]
  double motor_work = kNaN;               ///< at the joints, all motors, left and right [J]
  double drag_work = kNaN;                ///< [J]
  double impact_work = kNaN;              ///< negative: lost [J]
  /// of the horizontal momentum gained; NaN without drag surfaces [-]
  double drag_momentum_share = kNaN;

  int steps = 0;  ///< that the integrator took
};

/// Verifies the plan that x [variables()] stands for. Never throws on a bad plan: what went wrong
/// is in `failures`.
PlanVerification verify_plan(transcription::NonlinearProgram& program, const ConstVectorRef& x,
                             const VerifyOptions& options = {});

/// Error of each interval by itself: integrated from its own first node, compared with its last,
/// the largest over all positions and velocities relative to their scale [-]. Infinite where the
/// motion can't be integrated. What mesh refinement goes by.
Vector interval_errors(transcription::NonlinearProgram& program, const ConstVectorRef& x,
                       const VerifyOptions& options = {});

}  // namespace jaculus::solver
