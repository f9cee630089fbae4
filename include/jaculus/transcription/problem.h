#pragma once
// A problem as the user wrote it: user input only, validated once against the robot into the
// executable form (layout.h, nlp.h).

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "jaculus/core/yaml.h"
#include "jaculus/model/robot.h"
#include "jaculus/transcription/key.h"

namespace jaculus::transcription {

/// One phase of the contact schedule.
struct PhaseSpec {
  std::string name;
  std::vector<std::string> contacts;  ///< feet on the ground
  int intervals = 0;                  ///< collocation intervals
  Bounds duration;                    ///< [s], both positive; equal where fixed
  std::vector<double> mesh;           ///< relative lengths of the intervals; empty: uniform
  std::vector<double> stated_mesh;  ///< those of the file where `mesh` is a refined one; else empty
  yaml::Node node;                  ///< its place in the file
};

/// Bounds at one end of the plan, by coordinate or joint name: position [rad or m] and velocity
/// [rad/s or m/s].
struct BoundarySpec {
  std::map<std::string, Bounds> position;
  std::map<std::string, Bounds> velocity;
  bool at_rest = false;  ///< all velocities zero
  /// "rest" or "stretched" (robot_size.h): values of joints that `position` doesn't name; may be
  /// empty
  std::string pose;
  /// feet whose legs have come to rest: zero rates of the coordinates that move them, base aside
  std::vector<std::string> legs_at_rest;
  yaml::Node node;
};

struct TermType;
/// The kinds of terms that a problem file may name (term.h).
using TermCatalogue = std::vector<TermType>;
const TermCatalogue& term_catalogue();

/// A constraint or cost of a problem.
struct TermSpec {
  std::string type;
  /// unique in the problem: the node's `name`, else its type; an extending problem replaces by it
  std::string name;
  /// costs only; negative where the file minimises the term within a maximised sum
  double weight = 1.0;
  std::shared_ptr<const TermType> declared;  ///< of the catalogue that the file was read with
  KeyValues values;                          ///< of the keys that the type declares
  yaml::Node node;
};

enum class Scheme { hermite_simpson, trapezoidal };
enum class InputHold { held, linear };

struct TranscriptionSpec {
  Scheme scheme = Scheme::hermite_simpson;
  InputHold inputs = InputHold::held;
  /// path constraints also at the end of every interval with that interval's input (false: at its
  /// start and middle only, as the authors' tool does)
  bool check_interval_end = true;
};

/// What the initial guess is made of.
struct GuessSpec {
  std::string kind = "static";  ///< middle | static | random | line | file
  std::filesystem::path file;   ///< solution.json of an earlier solve, for `file`
  /// coordinate or joint values along the plan, for `line`
  std::vector<std::map<std::string, double>> poses;
  /// values that replace the middle of the bounds in a static posture
  std::map<std::string, double> pose;
  /// "rest" or "stretched" for each of `poses`, and for `pose`: values of joints that it doesn't
  /// name; may be empty
  std::vector<std::string> legs_of_poses;
  std::string legs_of_pose;
  std::vector<double> durations;  ///< of the phases [s]; empty: the middle of their bounds
  yaml::Node node;
};

struct SolverSpec {
  double tolerance = 1e-6;  ///< of the scaled optimality error [-]
  int max_iterations = 1000;
  std::string linear_solver = "frontal";
  int seed = 0;    ///< of everything random in a solve
  int starts = 1;  ///< multi-start: the guess first, then starts - 1 smooth random ones
};

/// Mesh refinement on request: intervals are split where the local error exceeds the tolerance, or
/// where the motion between nodes passes a limit.
struct RefinementSpec {
  int max_rounds = 0;  ///< 0: none
  /// of the local error relative to each state's scale [-]; 0: every interval is halved
  double tolerance = 1e-4;
  /// by how much a limit may be passed between nodes, over its scale [-]; a plan that passes one by
  /// more fails its verification. 0: not asked for
  double limits = 0.0;
};

struct Problem {
  std::string name;
  std::string caption;  ///< one line for tables and reports; may be empty
  std::filesystem::path file;
  std::string robot;                   ///< as written
  std::filesystem::path robot_folder;  ///< found
  std::vector<model::Override> overrides;
  std::vector<std::pair<std::string, double>> locks;  ///< coordinates held fixed [rad or m]
  // What a plan may use of the robot; where absent the robot's own value counts.
  std::optional<double> voltage;   ///< [V]
  std::optional<double> torque;    ///< of motors of joints that turn, before the gear [N m]
  std::optional<double> force;     ///< of motors of joints that slide [N]
  std::optional<double> current;   ///< [A]
  std::optional<double> friction;  ///< [-]
  std::map<std::string, Bounds> position_bounds;  ///< by coordinate [rad or m]
  std::map<std::string, Bounds> velocity_bounds;  ///< by coordinate [rad/s or m/s]
  std::vector<PhaseSpec> phases;
  BoundarySpec initial;
  BoundarySpec final;
  std::vector<TermSpec> constraints;
  std::vector<TermSpec> objective;
  bool maximise = false;  ///< of the sum of weight * term
  TranscriptionSpec transcription;
  GuessSpec guess;
  SolverSpec solver;
  RefinementSpec refinement;
  /// published figures to print beside the result, by summary key
  std::map<std::string, double> reference;
  /// Where each named value stands, for messages: "bounds.position.x", "initial.velocity.tail",
  /// "lock.tail", "guess.pose.x".
  std::map<std::string, yaml::Node> places;
  yaml::Node node;
};

/// Reads and checks a problem file as far as that is possible without the robot; InputError with
/// file:line otherwise. A file that `extends` another starts from what that one says: maps are
/// merged key by key (a null drops the key), terms replace those of the same name, other lists
/// replace the base's. What concerns a locked coordinate is checked and left out. Terms are those
/// of the catalogue.
Problem read_problem(const std::filesystem::path& file,
                     const TermCatalogue& catalogue = term_catalogue());
Problem read_problem(const yaml::Node& node, const TermCatalogue& catalogue = term_catalogue());

/// What read_problem could not know: that every foot, coordinate, joint, motor and phase that the
/// problem names exists in `model` (overrides applied, nothing locked yet), that units fit, and
/// that bounds leave something. InputError with file:line.
void check_problem(const Problem& problem, const model::PlanarModel& model);

/// A problem with its robot.
struct LoadedProblem {
  Problem problem;
  model::Robot robot;  ///< overrides applied, nothing locked
};

/// Everything that is checked before a solve: reads the problem and its robot, checks one against
/// the other, and lays the nonlinear program out once, for what its terms refuse is bad input as
/// well. InputError with file:line.
LoadedProblem load_problem(const yaml::Node& node,
                           const TermCatalogue& catalogue = term_catalogue());

/// A motor of the robot with what the problem states in place of its own limits.
model::PlanarMotor limited_motor(const Problem& problem, const model::PlanarModel& model,
                                 const model::PlanarMotor& motor);

/// The model that a problem plans with: overrides applied (read_robot), its limits, then its locks.
model::PlanarModel planning_model(const Problem& problem, const model::PlanarModel& model);

/// Every key of a problem file with its meaning, unit and default, as `jaculus check --explain`
/// prints it.
std::string explain_problem(const TermCatalogue& catalogue = term_catalogue());

}  // namespace jaculus::transcription
