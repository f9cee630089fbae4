#include "jaculus/transcription/describe.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "jaculus/core/json.h"

namespace jaculus::transcription {
namespace {

using Json = nlohmann::ordered_json;

Json bounds(const Bounds& b) {
  if (b.fixed()) return b.lower;
  return Json::array({json_number(b.lower), json_number(b.upper)});
}

Json bounds_map(const std::map<std::string, Bounds>& values) {
  Json json = Json::object();
  for (const auto& [name, value] : values) json[name] = bounds(value);
  return json;
}

Json boundary(const BoundarySpec& spec) {
  return {{"at_rest", spec.at_rest},
          {"position", bounds_map(spec.position)},
          {"velocity", bounds_map(spec.velocity)}};
}

Json optional_number(const std::optional<double>& value) {
  return value ? Json(*value) : Json("the robot's");
}

/// A node as JSON: maps, lists, and scalars as they were written.
Json plain(const yaml::Node& node) {
  if (node.is_map()) {
    Json json = Json::object();
    for (const auto& [key, value] : node.entries()) json[key] = plain(value);
    return json;
  }
  if (node.is_list()) {
    Json json = Json::array();
    for (const yaml::Node& item : node.items()) json.push_back(plain(item));
    return json;
  }
  return node.dump();
}

Json terms_json(const std::vector<TermSpec>& specs, bool weighted) {
  Json json = Json::array();
  for (const TermSpec& spec : specs) {
    Json term = plain(spec.node);
    if (weighted) term["weight"] = spec.weight;
    json.push_back(term);
  }
  return json;
}

Json phases(const Problem& problem) {
  Json json = Json::array();
  for (const PhaseSpec& p : problem.phases) {
    Json phase = {{"name", p.name},
                  {"contacts", p.contacts},
                  {"intervals", p.intervals},
                  {"duration", bounds(p.duration)}};
    if (!p.mesh.empty()) phase["mesh"] = p.mesh;
    json.push_back(phase);
  }
  return json;
}

Json guess(const GuessSpec& spec) {
  Json json = {{"kind", spec.kind}};
  if (!spec.file.empty()) json["file"] = spec.file.filename().string();
  if (!spec.poses.empty()) json["poses"] = spec.poses;
  if (!spec.pose.empty()) json["pose"] = spec.pose;
  if (!spec.durations.empty()) json["durations"] = spec.durations;
  return json;
}

std::string interval(const Bounds& b) {
  return b.fixed() ? fmt::format("{:g}", b.lower) : fmt::format("{:g} to {:g}", b.lower, b.upper);
}

std::string values(const std::map<std::string, Bounds>& map) {
  std::vector<std::string> parts;
  for (const auto& [name, value] : map) parts.push_back(name + " " + interval(value));
  return fmt::format("{}", fmt::join(parts, ", "));
}

std::string boundary_text(const BoundarySpec& spec) {
  std::vector<std::string> parts;
  if (spec.at_rest) parts.emplace_back("at rest");
  if (!spec.position.empty()) parts.push_back(values(spec.position));
  if (!spec.velocity.empty()) parts.push_back("velocity " + values(spec.velocity));
  return parts.empty() ? "free" : fmt::format("{}", fmt::join(parts, "; "));
}

std::string term_text(const TermSpec& spec) {
  std::vector<std::string> parts;
  for (const auto& [key, value] : spec.node.entries()) {
    if (key != "type" && key != "weight") parts.push_back(key + " " + value.dump());
  }
  return parts.empty() ? spec.type : fmt::format("{} ({})", spec.type, fmt::join(parts, ", "));
}

std::string robot_text(const model::Robot& robot) {
  const model::PlanarModel& m = robot.planar;
  std::vector<std::string> coordinates;
  for (const model::Coordinate& c : m.coordinates) coordinates.push_back(c.name);
  std::vector<std::string> motors;
  for (const model::PlanarMotor& motor : m.motors) {
    motors.push_back(motor.count > 1 ? fmt::format("{} (x{})", motor.joint, motor.count)
                                     : motor.joint);
  }
  std::vector<std::string> feet;
  for (const model::PlanarPoint& foot : m.feet) feet.push_back(foot.name);
  return fmt::format(
      "  robot         {}: {} planar bodies, {:.4g} kg, {} loops\n  coordinates   {}\n  motors     "
      "   {}\n  feet       "
      "   {}\n",
      robot.name, m.bodies.size(), m.total_mass(), m.loops.size(), fmt::join(coordinates, ", "),
      motors.empty() ? "none" : fmt::format("{}", fmt::join(motors, ", ")),
      feet.empty() ? "none" : fmt::format("{}", fmt::join(feet, ", ")));
}

std::string plan_text(const Problem& problem) {
  std::string text;
  for (const PhaseSpec& p : problem.phases) {
    text += fmt::format(
        "  phase         {}: {}, {} intervals, {} s\n", p.name,
        p.contacts.empty() ? "flight" : fmt::format("{}", fmt::join(p.contacts, " and ")),
        p.intervals, interval(p.duration));
  }
  text += fmt::format("  start         {}\n  end           {}\n", boundary_text(problem.initial),
                      boundary_text(problem.final));
  for (const TermSpec& spec : problem.constraints)
    text += fmt::format("  constraint    {}\n", term_text(spec));
  for (const TermSpec& spec : problem.objective) {
    const bool large = problem.maximise == (spec.weight > 0.0);
    text += fmt::format("  {}      {:g} x {}\n", large ? "maximise" : "minimise",
                        std::abs(spec.weight), term_text(spec));
  }
  return text;
}

}  // namespace

const NameTable<InputHold>& input_holds() {
  static const NameTable<InputHold> table(
      {{InputHold::held, "held"}, {InputHold::linear, "linear"}});
  return table;
}

const char* name_of(InputHold hold) { return input_holds().name(hold); }

Json describe_problem(const Problem& problem) {
  Json json = {{"name", problem.name}, {"robot", problem.robot}};
  json["override"] = Json::object();
  for (const model::Override& o : problem.overrides) json["override"][o.path] = plain(o.value);
  json["lock"] = Json::object();

  for (const auto& [name, value] : problem.locks) json["lock"][name] = value;
  json["limits"] = {{"voltage", optional_number(problem.voltage)},
                    {"torque", optional_number(problem.torque)},
                    {"force", optional_number(problem.force)},
                    {"current", optional_number(problem.current)},
                    {"friction", optional_number(problem.friction)}};
  json["bounds"] = {{"position", bounds_map(problem.position_bounds)},
                    {"velocity", bounds_map(problem.velocity_bounds)}};
  json["phases"] = phases(problem);
  json["initial"] = boundary(problem.initial);
  json["final"] = boundary(problem.final);
  json["constraints"] = terms_json(problem.constraints, false);
  json["objective"] = {{"sense", problem.maximise ? "maximise" : "minimise"},
                       {"terms", terms_json(problem.objective, true)}};
  const TranscriptionSpec& t = problem.transcription;
  json["transcription"] = {
      {"scheme", t.scheme == Scheme::trapezoidal ? "trapezoidal" : "hermite_simpson"},
      {"inputs", name_of(t.inputs)},
      {"check_interval_end", t.check_interval_end}};
  json["guess"] = guess(problem.guess);
  json["solver"] = {{"tolerance", problem.solver.tolerance},
                    {"max_iterations", problem.solver.max_iterations},
                    {"linear_solver", problem.solver.linear_solver},
                    {"seed", problem.solver.seed},
                    {"starts", problem.solver.starts}};
  json["refinement"] = {{"max_rounds", problem.refinement.max_rounds},
                        {"tolerance", problem.refinement.tolerance},
                        {"limits", problem.refinement.limits}};

  return json;
}

std::string describe_problem_text(const Problem& problem, const model::Robot& robot) {
  std::string text = problem.name + (problem.caption.empty() ? "" : ": " + problem.caption) + "\n" +
                     robot_text(robot);
  for (const model::Override& o : problem.overrides)
    text += fmt::format("  override      {} = {}\n", o.path, o.value.dump());
  for (const auto& [name, value] : problem.locks)
    text += fmt::format("  lock          {} at {:g}\n", name, value);
  const auto limit = [](const std::optional<double>& value, const char* unit) {
    return value ? fmt::format("{:g}{}", *value, unit) : std::string("the robot's");
  };

  text += fmt::format("  limits        voltage {}, torque {}{}, current {}, friction {}\n",
                      limit(problem.voltage, " V"), limit(problem.torque, " N m"),
                      problem.force ? fmt::format(" (force {:g} N)", *problem.force) : "",
                      limit(problem.current, " A"), limit(problem.friction, ""));
  text += plan_text(problem);
  const TranscriptionSpec& t = problem.transcription;
  text += fmt::format("  transcription {}, inputs {}; guess {}; tolerance {:g}, {} start{}\n",
                      t.scheme == Scheme::trapezoidal ? "trapezoidal" : "Hermite-Simpson",
                      name_of(t.inputs), problem.guess.kind, problem.solver.tolerance,
                      problem.solver.starts, problem.solver.starts == 1 ? "" : "s");

  return text;
}

}  // namespace jaculus::transcription
