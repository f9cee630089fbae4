#include "transcription/problem_keys.h"

#include <fmt/format.h>

#include <array>

#include "jaculus/transcription/problem.h"

namespace jaculus {
namespace problem_keys {
namespace {

constexpr std::array kKeys = {
    // the file itself
    Key{"", "format", "", "required", "jaculus-problem/1"},
    Key{"", "extends", "", "none",
        "a problem file (relative to this one) to start from: maps are merged key by key, a null (~) drops a key, "
        "constraints and costs replace those of the same name, other lists replace the base's"},
    Key{"", "name", "", "required", "short name for tables and folders: letters, digits, _ and -; never inherited"},
    Key{"", "caption", "", "empty", "one line for people; never inherited"},
    Key{"", "robot", "", "required",
        "a folder with robot.urdf and robot.yaml, relative to this file, or a name under models/"},
    Key{"", "override", "", "none",
        "model values by path, {tail.drag.coefficient: 2.0}; `jaculus check ROBOT` lists the paths"},
    Key{"", "lock", "rad or m", "none", "coordinates held fixed, {tail: -90 deg}; the motor there does nothing"},
    Key{"", "limits", "", "the robot's own", "what a plan may use of the robot"},
    Key{"", "bounds", "", "the robot's ranges",
        "of coordinates over the whole plan; also the scale of each and the middle for guesses"},
    Key{"", "phases", "", "required", "the contact schedule, in order"},
    Key{"", "initial", "", "free", "state at the start"},
    Key{"", "final", "", "free", "state at the end"},
    Key{"", "constraints", "", "none",
        "a list of {type: ..., ...}; dynamics, stance, loop closure and impacts are implied"},
    Key{"", "objective", "", "required", "a weighted sum of costs"},
    Key{"", "transcription", "", "see there", "how the plan is cut into intervals"},
    Key{"", "guess", "", "see there", "where the solver starts"},
    Key{"", "solver", "", "see there", "tolerance, iterations, starts"},
    Key{"", "refinement", "", "none", "splitting of intervals where the local error is large"},
    Key{"", "reference", "", "none", "published figures to print beside the result"},
    // limits
    Key{"limits", "voltage", "V", "the robot's", "of the bus, for every motor"},
    Key{"limits", "torque", "N m", "the robot's", "of every motor, before its gear"},
    Key{"limits", "current", "A", "the robot's", "of every motor"},
    Key{"limits", "friction", "-", "the robot's", "Coulomb coefficient that a plan counts on"},
    // bounds
    Key{"bounds", "position", "rad or m", "the robot's", "[lower, upper] by coordinate"},
    Key{"bounds", "velocity", "rad/s or m/s", "none", "[lower, upper] by coordinate"},
    // phases
    Key{"phases[]", "name", "", "required", "unique in the file"},
    Key{"phases[]", "contacts", "", "required", "feet on the ground; [] is flight"},
    Key{"phases[]", "intervals", "-", "required", "collocation intervals, 1 to 10000"},
    Key{"phases[]", "duration", "s", "required", "[lower, upper], or one number where it is fixed; positive"},
    Key{"phases[]", "mesh", "-", "uniform", "relative lengths of the intervals, one each"},
    // initial and final
    Key{"initial", "at_rest", "-", "false", "all velocities zero"},
    Key{"initial", "position", "rad or m", "free", "by coordinate or joint: a number, or [lower, upper]"},
    Key{"initial", "velocity", "rad/s or m/s", "free", "by coordinate or joint: a number, or [lower, upper]"},
    Key{"final", "at_rest", "-", "false", "all velocities zero"},
    Key{"final", "position", "rad or m", "free", "as for initial"},
    Key{"final", "velocity", "rad/s or m/s", "free", "as for initial"},
    // objective
    Key{"objective", "maximise", "", "none", "a list of costs that shall be large"},
    Key{"objective", "minimise", "", "none",
        "a list of costs that shall be small; beside `maximise` they are subtracted"},
    // transcription
    Key{"transcription", "scheme", "", "hermite_simpson",
        "hermite_simpson (third-order defects, midpoints) or trapezoidal"},
    Key{"transcription", "inputs", "", "held", "held over an interval, or linear between its ends"},
    Key{"transcription", "check_interval_end", "-", "true",
        "limits also at the end of each interval with its own input, not only at its start and middle"},
    // guess
    Key{"guess", "kind", "", "static",
        "static (a standing posture), middle (of the bounds), random (smooth), line (between poses), file"},
    Key{"guess", "file", "", "required for file", "solution.json of an earlier solve, relative to this file"},
    Key{"guess", "poses", "rad or m", "required for line",
        "two or more poses, {coordinate or joint: value}, along the plan"},
    Key{"guess", "pose", "rad or m", "middle of bounds", "values of a static posture"},
    Key{"guess", "durations", "s", "middle of bounds", "of the phases, one each"},
    // solver
    Key{"solver", "tolerance", "-", "1e-6", "of the scaled optimality error"},
    Key{"solver", "max_iterations", "-", "1000", "a start"},
    Key{"solver", "linear_solver", "", "mumps", "mumps, ma27, ma57, ma86 or ma97 (HSL's where the user has libhsl)"},
    Key{"solver", "seed", "-", "0", "of everything random; --seed replaces it"},
    Key{"solver", "starts", "-", "1", "the guess first, then smooth random ones"},
    // refinement
    Key{"refinement", "max_rounds", "-", "0", "solves after the first"},
    Key{"refinement", "tolerance", "-", "1e-4",
        "of the local error, relative to each state's scale; 0 halves every interval in every round"},
    // reference: keys of summary.json, and what hardware did
    Key{"reference", "average_acceleration_m_s2", "m/s^2", "none",
        "v_x of the base at the end over the duration, as planned"},
    Key{"reference", "average_acceleration_com_m_s2", "m/s^2", "none", "the same of the centre of mass"},
    Key{"reference", "measured_acceleration_m_s2", "m/s^2", "none", "on hardware"},
    Key{"reference", "measured_duration_s", "s", "none", "published beside it"},
    Key{"reference", "duration_s", "s", "none", "of the whole plan"},
    Key{"reference", "first_phase_s", "s", "none", "of the first phase"},
    Key{"reference", "liftoff_velocity_m_s", "m/s", "none", "v_x of the base at the end"},
    Key{"reference", "tail_momentum_share", "-", "none", "share of the forward momentum that drag gave"},
    Key{"reference", "objective", "-", "none", "value of the objective"},
    // constraints
    Key{"constraints[]", "type", "", "required", "one of those below"},
    Key{"constraints[]", "name", "", "its type", "unique; only needed where a type occurs twice"},
    Key{"constraints: friction", "coefficient", "-", "limits.friction", "|f_x| <= coefficient f_z"},
    Key{"constraints: friction", "feet", "", "all", "list of feet"},
    Key{"constraints: friction", "phases", "", "all", "list of phases"},
    Key{"constraints: normal_force", "min", "N", "none",
        "least normal force of one foot, left or right; min or max must be there"},
    Key{"constraints: normal_force", "max", "N", "none", "largest normal force of one foot, left or right"},
    Key{"constraints: normal_force", "feet", "", "all", "list of feet"},
    Key{"constraints: normal_force", "phases", "", "all", "list of phases"},
    Key{"constraints: normal_force", "skip_first", "-", "0",
        "collocation points at the start of a phase that are left out, counted on the grid as stated, not as refined"},
    Key{"constraints: normal_force", "skip_last", "-", "0",
        "the same at its end: what lies between them in time stays left out on finer grids"},
    Key{"constraints: voltage", "motors", "", "all electric ones",
        "list of motors whose voltage stays within limits.voltage"},
    Key{"constraints: voltage", "phases", "", "all", "list of phases"},
    Key{"constraints: swing_clearance", "min", "m", "required",
        "least height over the ground while a foot is in the air"},
    Key{"constraints: swing_clearance", "feet", "", "all", "list of feet"},
    Key{"constraints: swing_clearance", "phases", "", "all", "list of phases"},
    Key{"constraints: joint_range", "phases", "", "all",
        "list of phases; keeps joints that are no coordinates in their range"},
    Key{"constraints: force_at_end", "phase", "", "required", "the phase at whose end it counts"},
    Key{"constraints: force_at_end", "foot", "", "required", "the foot"},
    Key{"constraints: force_at_end", "normal", "N", "required", "normal force of one foot there"},
    Key{"constraints: touchdown_pitch", "height", "m", "required", "base height of a ballistic landing after the plan"},
    Key{"constraints: touchdown_pitch", "pitch", "rad", "required", "pitch on landing, a number or [lower, upper]"},
    // costs
    Key{"objective.*[]", "type", "", "required", "one of those below"},
    Key{"objective.*[]", "name", "", "its type", "unique; only needed where a type occurs twice"},
    Key{"objective.*[]", "weight", "-", "1", "positive"},
    Key{"objective: mean_acceleration", "of", "", "base",
        "base or com: whose velocity at the end over the total duration"},
    Key{"objective: mean_acceleration", "direction", "", "x", "x or z"},
    Key{"objective: final_velocity", "of", "", "base", "base or com: whose velocity at the end"},
    Key{"objective: final_velocity", "direction", "", "x", "x or z"},
    Key{"objective: distance", "", "m", "", "x of the base, end less start"},
    Key{"objective: height", "", "m", "", "z of the base at the end"},
    Key{"objective: time", "", "s", "", "total duration"},
    Key{"objective: torque_squared", "", "N^2 m^2 s", "", "integral of the squared motor torques, summed over motors"},
    Key{"objective: electrical_energy", "", "J", "", "integral of voltage times current, summed over motors"},
};

}  // namespace

std::span<const Key> all() { return kKeys; }

std::vector<std::string> of(std::string_view section) {
  std::vector<std::string> names;
  for (const Key& key : kKeys) {
    if (key.section == section && !key.name.empty()) names.emplace_back(key.name);
  }
  return names;
}

}  // namespace problem_keys

namespace {

/// `text` in lines of at most 116 characters, those after the first indented.
std::string wrapped(const std::string& text, std::size_t indent) {
  constexpr std::size_t kWidth = 116;
  std::string result;
  std::string rest = text;
  while (rest.size() > kWidth) {
    const std::size_t space = rest.rfind(' ', kWidth);
    if (space == std::string::npos || space <= indent) break;
    result += rest.substr(0, space) + "\n";
    rest = std::string(indent, ' ') + rest.substr(space + 1);
  }
  return result + rest;
}

}  // namespace

std::string explain_problem() {
  std::string text =
      "A problem file (format jaculus-problem/1). Plain numbers are SI (rad, not degrees); a value may instead carry "
      "its\n"
      "unit: 7 V, 15 deg, 4 ms. Unknown keys, units of another dimension and values out of range are errors.\n";
  std::string_view section = "-";
  for (const problem_keys::Key& key : problem_keys::all()) {
    if (key.section != section) {
      section = key.section;
      text += section.empty() ? std::string("\nthe file\n") : fmt::format("\n{}\n", section);
    }
    if (key.name.empty()) {
      text += fmt::format("  {}{}\n", key.meaning, key.unit.empty() ? "" : fmt::format(" [{}]", key.unit));
      continue;
    }
    const std::string unit = key.unit.empty() ? "" : fmt::format(" [{}]", key.unit);
    const std::string fallback = key.fallback == "required" ? "required" : fmt::format("else: {}", key.fallback);
    constexpr std::size_t kIndent = 37;
    text +=
        wrapped(fmt::format("  {:<34} {} ({})", std::string(key.name) + unit, key.meaning, fallback), kIndent) + "\n";
  }
  return text;
}

}  // namespace jaculus
