// What a problem says, held against the robot that it names.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "jaculus/transcription/nonlinear_program.h"
#include "jaculus/transcription/problem.h"
#include "model/fields.h"
#include "transcription/problem_read.h"

namespace jaculus::transcription {
namespace {

using problem_read::at_place;
using yaml::Node;
using Names = std::vector<std::string>;

[[noreturn]] void unknown(const Node& node, const std::string& what, const std::string& given,
                          const Names& allowed) {
  throw node.error(
      fmt::format("unknown {} '{}'{}; allowed: {}", what, given, yaml::did_you_mean(given, allowed),
                  allowed.empty() ? "none" : fmt::format("{}", fmt::join(allowed, ", "))));
}

void require(const Node& node, const std::string& what, const std::string& given,
             const Names& allowed) {
  if (std::find(allowed.begin(), allowed.end(), given) == allowed.end())
    unknown(node, what, given, allowed);
}

Names foot_names(const model::PlanarModel& model) {
  Names names;
  for (const model::PlanarPoint& foot : model.feet) names.push_back(foot.name);
  return names;
}

Names motor_names(const model::PlanarModel& model) {
  Names names;
  for (const model::PlanarMotor& motor : model.motors) names.push_back(motor.joint);
  return names;
}

Names coordinate_names(const model::PlanarModel& model) {
  Names names;
  for (const model::Coordinate& coordinate : model.coordinates) names.push_back(coordinate.name);
  return names;
}

/// Coordinates, then joints that are no coordinates themselves.
Names coordinate_and_joint_names(const model::PlanarModel& model) {
  Names names = coordinate_names(model);
  for (std::size_t body = 1; body < model.bodies.size(); ++body) {
    const std::string& joint = model.bodies[body].joint;
    if (!joint.empty() && std::find(names.begin(), names.end(), joint) == names.end())
      names.push_back(joint);
  }
  return names;
}

bool angular(const model::PlanarModel& model, const std::string& name) {
  if (const int i = model.coordinate_index(name); i >= 0) return model.coordinates[i].angular;
  const int body = model.body_of_joint(name);
  return body < 0 || model.bodies[body].kind == model::JointKind::revolute;
}

/// The last part of "bounds.position.front_angle".
std::string name_of(const std::string& place) { return place.substr(place.rfind('.') + 1); }

/// Names and units of all values by coordinate or joint.
void check_places(const Problem& problem, const model::PlanarModel& model) {
  const Names coordinates = coordinate_names(model);
  const Names both = coordinate_and_joint_names(model);
  for (const auto& [place, node] : problem.places) {
    if (place.starts_with("limits.")) continue;
    const std::string name = name_of(place);
    const bool only_coordinates = place.starts_with("bounds.") || place.starts_with("lock.");

    // What a base file says of a coordinate may have been dropped since; only what still counts is
    // checked.
    const bool velocity = place.find(".velocity.") != std::string::npos;
    const auto counts = [&](const BoundarySpec& s) {
      return (velocity ? s.velocity : s.position).contains(name);
    };

    if (place.starts_with("initial.") && !counts(problem.initial)) continue;
    if (place.starts_with("final.") && !counts(problem.final)) continue;
    if (place.starts_with("bounds.") &&
        !(velocity ? problem.velocity_bounds : problem.position_bounds).contains(name)) {
      continue;
    }
    if (place.starts_with("lock.") &&
        std::none_of(problem.locks.begin(), problem.locks.end(),
                     [&](const auto& l) { return l.first == name; })) {
      continue;
    }

    require(node, only_coordinates ? "coordinate" : "coordinate or joint", name,
            only_coordinates ? coordinates : both);
    const bool angle = angular(model, name);
    static_cast<void>(node.bounds(velocity
                                      ? (angle ? dimension::angular_velocity : dimension::velocity)
                                      : (angle ? dimension::angle : dimension::length)));
  }
}

/// The override of one of these paths in the file that is read, where `value` stands in one that it
/// extends: a contradiction of the two came about there.
const Node* later_override(const Problem& problem, const Node& value, const Names& paths) {
  for (const model::Override& o : problem.overrides) {
    const auto meant = [&o](const std::string& path) { return model::matches(o.path, path); };
    if (problem_read::came_later(problem, o.value, value) &&
        std::any_of(paths.begin(), paths.end(), meant))
      return &o.value;
  }
  return nullptr;
}

/// Values that leave nothing of the robot's own range.
void check_ranges(const Problem& problem, const model::PlanarModel& model) {
  const auto check = [&](const std::map<std::string, Bounds>& values, const std::string& prefix) {
    for (const auto& [name, bounds] : values) {
      const int i = model.coordinate_index(name);
      if (i < 0) continue;
      const Bounds& range = model.coordinates[i].range;
      if (bounds.lower <= range.upper && bounds.upper >= range.lower) continue;
      const Node& value = problem_read::place_of(problem, prefix + name);
      if (const Node* later = later_override(problem, value, {"ranges." + name}))
        throw later->error(fmt::format(
            "[{:g}, {:g}] leaves nothing of [{:g}, {:g}] ({}); allowed: a range that holds some of "
            "it",
            range.lower, range.upper, bounds.lower, bounds.upper, at_place(value)));
      throw value.error(fmt::format(
          "[{:g}, {:g}] lies outside the robot's own range; allowed: within [{:g}, {:g}]",
          bounds.lower, bounds.upper, range.lower, range.upper));
    }
  };
  check(problem.position_bounds, "bounds.position.");
  check(problem.initial.position, "initial.position.");
  check(problem.final.position, "final.position.");
}

/// A plan may use less than the robot has, not more: that would be another robot, which `override`
/// makes.
void check_limit(const Problem& problem, const std::string& key, const std::optional<double>& limit,
                 double robots, const std::string& motor, const char* unit) {
  if (!limit || *limit <= robots) return;
  const Node& value = problem.places.at("limits." + key);
  const std::string of_motor = "motors." + motor,
                    figure = key == "voltage" ? ".voltage" : "." + key + "_limit";
  if (const Node* later = later_override(problem, value, {of_motor + figure, of_motor}))
    throw later->error(fmt::format(
        "{:g} {} of motor '{}' is less than the {:g} {} that the plan may use ({}); allowed: at "
        "least that, or a lower limits.{} in this file",
        robots, unit, motor, *limit, unit, at_place(value), key));
  throw value.error(
      fmt::format("{:g} {} given; allowed: at most {:g} {}, what motor '{}' has "
                  "(override the robot to give it more)",
                  *limit, unit, robots, unit, motor));
}

/// A limit in N m is of joints that turn, one in N of those that slide; the robot must have such.
void check_limit_unit(const Problem& problem, const model::PlanarModel& model) {
  if (problem.torque.has_value() == problem.force.has_value()) return;
  const auto slides = [&](const model::PlanarMotor& motor) { return model.slides(motor); };
  const auto sliding = std::count_if(model.motors.begin(), model.motors.end(), slides);
  const bool any = problem.force ? sliding > 0 : sliding < std::ssize(model.motors);
  if (any || model.motors.empty()) return;
  throw problem.places.at("limits.torque")
      .error(fmt::format("{} given, but every motor of this robot {}; allowed: a number in {}",
                         problem.force ? "a force" : "a torque",
                         problem.force ? "turns its joint" : "slides its joint",
                         problem.force ? "N m" : "N"));
}

void check_against(const Problem& problem, const model::PlanarModel& model) {
  const Names feet = foot_names(model);
  for (const PhaseSpec& phase : problem.phases) {
    for (const Node& contact : phase.node.at("contacts").items())
      require(contact, "foot", contact.text(), feet);
  }
  check_places(problem, model);
  check_ranges(problem, model);
  for (const auto* terms : {&problem.constraints, &problem.objective}) {
    for (const TermSpec& term : *terms) {
      term.values.check_names(key::Of::foot, feet);
      term.values.check_names(key::Of::motor, motor_names(model));
    }
  }

  check_limit_unit(problem, model);
  for (const model::PlanarMotor& motor : model.motors) {
    check_limit(problem, "voltage", problem.voltage, motor.voltage, motor.joint, "V");
    const bool slides = model.slides(motor);
    check_limit(problem, "torque", slides ? problem.force : problem.torque, motor.torque_limit,
                motor.joint, slides ? "N" : "N m");
    check_limit(problem, "current", problem.current, motor.current_limit, motor.joint, "A");
  }
}

}  // namespace

void check_problem(const Problem& problem, const model::PlanarModel& model) {
  try {
    check_against(problem, model);
  } catch (const InputError& error) {
    // What a base says is right for the base's own robot; this file names another.
    const std::string& file = error.place().file;
    const auto robot = problem.node.is_map() ? problem.node.find("robot") : std::nullopt;
    if (file.empty() || file == problem.file.string() || !robot) throw;
    throw robot->error(
        fmt::format("what this file extends is not for '{}': {}", problem.robot, error.what()));
  }
}

model::PlanarMotor limited_motor(const Problem& problem, const model::PlanarModel& model,
                                 const model::PlanarMotor& motor) {
  model::PlanarMotor limited = motor;
  const bool slides = model.slides(motor);
  const std::optional<double>& torque = slides ? problem.force : problem.torque;
  if (problem.voltage) limited.voltage = *problem.voltage;
  if (torque) limited.torque_limit = *torque;
  if (problem.current) limited.current_limit = *problem.current;
  return limited;
}

model::PlanarModel planning_model(const Problem& problem, const model::PlanarModel& model) {
  model::PlanarModel planned = model;
  for (model::PlanarMotor& motor : planned.motors) motor = limited_motor(problem, model, motor);
  if (problem.friction) planned.friction = *problem.friction;
  for (const auto& [name, value] : problem.locks) planned = model::lock(planned, name, value);
  return planned;
}

LoadedProblem load_problem(const Node& node, const TermCatalogue& catalogue) {
  LoadedProblem loaded;
  loaded.problem = read_problem(node, catalogue);
  loaded.robot = model::read_robot(loaded.problem.robot_folder, loaded.problem.overrides);
  check_problem(loaded.problem, loaded.robot.planar);
  static_cast<void>(
      NonlinearProgram(loaded.problem, planning_model(loaded.problem, loaded.robot.planar)));
  return loaded;
}

}  // namespace jaculus::transcription
