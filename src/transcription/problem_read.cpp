#include "transcription/problem_read.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <set>

#include "transcription/problem_keys.h"

namespace jaculus::transcription::problem_read {

using yaml::Node;

bool is_null(const Node& node) { return !node.is_map() && !node.is_list() && !node.is_scalar(); }

const Node& place_of(const Problem& problem, const std::string& name) {
  const auto found = problem.places.find(name);
  if (found != problem.places.end()) return found->second;
  return name.starts_with("initial.") ? problem.initial.node
         : name.starts_with("final.") ? problem.final.node
                                      : problem.node;
}

bool came_later(const Problem& problem, const Node& other, const Node& value) {
  return other.file() == problem.file && value.file() != problem.file;
}

std::string at_place(const Node& node) {
  return fmt::format("{}:{}", node.file().string(), node.line());
}

namespace {

/// Whether a number in `node` carries a unit that only the dimension `d` has.
bool has_unit_of(const Node& node, const Dimension& d, const Dimension& other) {
  if (node.is_list()) {
    const std::vector<Node> items = node.items();
    return std::any_of(items.begin(), items.end(),
                       [&](const Node& item) { return has_unit_of(item, d, other); });
  }
  const auto reads_as = [&node](const Dimension& dimension) {
    try {
      static_cast<void>(node.number(dimension));
      return true;
    } catch (const InputError&) {
      return false;
    }
  };
  return reads_as(d) && !reads_as(other);
}

/// A message about a number that is neither an angle's nor a length's: it names both units.
InputError in_either(const InputError& turning, const Dimension& angle, const Dimension& length) {
  std::string text = turning.fault();
  const std::string unit = "a number in " + unit_name(angle);
  if (const std::size_t at = text.find(unit); at != std::string::npos)
    text.insert(at + unit.size(),
                fmt::format(" where it turns or {} where it slides", unit_name(length)));
  return InputError(turning.place(), text);
}

/// Reads a value named after a coordinate or joint. Whether it is an angle or a length only the
/// robot knows (x and z aside), so both are tried here; check_problem() reads it again in the right
/// dimension. Where neither will do, the units that are there say which was meant.
template <typename Read>
auto by_name(const std::string& name, const Node& value, bool velocity, Read read) {
  const Dimension angle = velocity ? dimension::angular_velocity : dimension::angle;
  const Dimension length = velocity ? dimension::velocity : dimension::length;
  if (name == "x" || name == "z") return read(length);
  try {
    return read(angle);
  } catch (const InputError& turning) {
    if (name == "pitch") throw;
    try {
      return read(length);
    } catch (const InputError&) {
      if (has_unit_of(value, length, angle)) throw;
      if (has_unit_of(value, angle, length)) throw turning;
      throw in_either(turning, angle, length);
    }
  }
}

void named_bounds(std::map<std::string, Bounds>& values, Problem& problem, const Node& node,
                  const std::string& prefix, bool velocity) {
  if (is_null(node)) values.clear();
  if (is_null(node)) return;
  for (const auto& [name, value] : node.entries()) {
    if (is_null(value)) {
      values.erase(name);
      continue;
    }
    values[name] = by_name(name, value, velocity,
                           [&value = value](const Dimension& d) { return value.bounds(d); });
    problem.places[prefix + name] = value;
  }
}

/// `pose: rest` or `pose: stretched` of a map, empty where it says none.
std::string legs_of(const Node& node) {
  const auto word = node.find("pose");
  return word ? word->choice({"rest", "stretched"}) : "";
}

std::map<std::string, double> pose(Problem& problem, const Node& node, const std::string& prefix) {
  std::map<std::string, double> values;
  for (const auto& [name, value] : node.entries()) {
    if (name == "pose") continue;  // legs_of() reads it
    values[name] = by_name(name, value, false,
                           [&value = value](const Dimension& d) { return value.number(d); });
    problem.places[prefix + name] = value;
  }
  return values;
}

/// The poses of a guess along lines.
void read_poses(Problem& problem, const Node& node) {
  std::vector<std::map<std::string, double>>& poses = problem.guess.poses;
  for (const Node& item : node.items()) {
    poses.push_back(pose(problem, item, fmt::format("guess.poses[{}].", poses.size())));
    problem.guess.legs_of_poses.push_back(legs_of(item));
  }
  if (poses.size() < 2)
    throw node.error(fmt::format("{} given; allowed: two poses or more", poses.size()));
}

/// The file of a guess from an earlier plan.
std::filesystem::path earlier_plan(const Node& node) {
  std::filesystem::path file = node.text();
  if (file.is_relative()) file = node.file().parent_path() / file;
  if (!std::filesystem::is_regular_file(file))
    throw node.error(fmt::format(
        "file '{}' not found; allowed: the solution.json of an earlier solve", file.string()));
  return file;
}

PhaseSpec phase(const Node& node) {
  const KeyValues given(node, problem_keys::of("phases[]"));
  PhaseSpec spec;
  spec.node = node;
  spec.name = node.at("name").text();
  spec.intervals = given.integer("intervals");
  spec.duration = given.interval("duration");
  if (spec.duration.lower <= 0.0)
    throw node.at("duration")
        .error(fmt::format("{:g} s given; allowed: positive durations", spec.duration.lower));

  spec.contacts = node.at("contacts").texts();
  std::set<std::string> feet;
  for (const std::string& foot : spec.contacts)
    if (!feet.insert(foot).second)
      throw node.at("contacts")
          .error(fmt::format("'{}' given twice; allowed: each foot once", foot));

  if (const auto mesh = node.find("mesh")) {
    spec.mesh = mesh->numbers(dimension::none);
    if (count_of(spec.mesh) != spec.intervals)
      throw mesh->error(fmt::format("{} numbers given; allowed: {}, one an interval",
                                    spec.mesh.size(), spec.intervals));
    if (std::any_of(spec.mesh.begin(), spec.mesh.end(),
                    [](double length) { return length <= 0.0; }))
      throw mesh->error("a length that is not positive; allowed: positive relative lengths");
  }

  return spec;
}

void boundary(BoundarySpec& spec, Problem& problem, const Node& node, const std::string& section) {
  if (is_null(node)) {
    spec = BoundarySpec{};
    return;
  }
  node.only(problem_keys::names(problem_keys::of(section)));
  spec.node = node;
  if (const auto at_rest = node.find("at_rest")) spec.at_rest = at_rest->boolean();
  if (const auto pose = node.find("pose"))
    spec.pose = is_null(*pose) ? "" : pose->choice({"rest", "stretched"});
  if (const auto feet = node.find("legs_at_rest"))
    spec.legs_at_rest = is_null(*feet) ? std::vector<std::string>{} : feet->texts();
  if (const auto position = node.find("position")) {
    named_bounds(spec.position, problem, *position, section + ".position.", false);
  }
  if (const auto velocity = node.find("velocity")) {
    named_bounds(spec.velocity, problem, *velocity, section + ".velocity.", true);
  }
}

}  // namespace

void robot(Problem& problem, const Node& node) {
  problem.robot = node.text();
  try {
    problem.robot_folder = model::find_robot(problem.robot, node.file());
  } catch (const InputError& error) {
    throw node.error(error.what());
  }
}

void overrides(Problem& problem, const Node& node) {
  if (is_null(node)) problem.overrides.clear();
  if (is_null(node)) return;
  for (const auto& [path, value] : node.entries()) {
    std::erase_if(problem.overrides,
                  [&path = path](const model::Override& o) { return o.path == path; });
    if (!is_null(value)) problem.overrides.push_back({path, value});
  }
}

void locks(Problem& problem, const Node& node) {
  if (is_null(node)) problem.locks.clear();
  if (is_null(node)) return;
  for (const auto& [name, value] : node.entries()) {
    std::erase_if(problem.locks, [&name = name](const auto& lock) { return lock.first == name; });
    if (is_null(value)) continue;
    const double number = by_name(name, value, false,
                                  [&value = value](const Dimension& d) { return value.number(d); });
    problem.locks.emplace_back(name, number);
    problem.places["lock." + name] = value;
  }
}

void bounds(Problem& problem, const Node& node) {
  if (is_null(node)) {
    problem.position_bounds.clear();
    problem.velocity_bounds.clear();
    return;
  }
  node.only(problem_keys::names(problem_keys::of("bounds")));
  if (const auto position = node.find("position")) {
    named_bounds(problem.position_bounds, problem, *position, "bounds.position.", false);
  }
  if (const auto velocity = node.find("velocity")) {
    named_bounds(problem.velocity_bounds, problem, *velocity, "bounds.velocity.", true);
  }
}

void phases(Problem& problem, const Node& node) {
  problem.phases.clear();
  std::set<std::string> names;
  for (const Node& item : node.items()) {
    problem.phases.push_back(phase(item));
    const std::string& name = problem.phases.back().name;
    if (!names.insert(name).second) {
      throw item.at("name").error(
          fmt::format("'{}' names another phase already; allowed: unique names", name));
    }
  }
  if (problem.phases.empty()) throw node.error("no phases given; allowed: one or more");
}

void initial(Problem& problem, const Node& node) {
  boundary(problem.initial, problem, node, "initial");
}

void final(Problem& problem, const Node& node) { boundary(problem.final, problem, node, "final"); }

void guess(Problem& problem, const Node& node) {
  const KeyValues given(node, problem_keys::of("guess"));
  GuessSpec& spec = problem.guess;
  std::erase_if(problem.places,
                [](const auto& place) { return place.first.starts_with("guess."); });
  spec = GuessSpec{};  // its keys belong together, so a guess replaces the base's as a whole
  spec.node = node;
  spec.kind = given.choice("kind");

  const auto belongs = [&](const char* key, const char* kind) {
    if (const auto value = node.find(key); value && spec.kind != kind)
      throw value->error(
          fmt::format("given with kind: {1}; allowed: only with kind: {0}", kind, spec.kind));
  };
  belongs("file", "file");
  belongs("poses", "line");
  belongs("pose", "static");

  if (spec.kind == "file") spec.file = earlier_plan(node.at("file"));
  if (spec.kind == "line") read_poses(problem, node.at("poses"));
  if (const auto values = node.find("pose")) {
    spec.pose = pose(problem, *values, "guess.pose.");
    spec.legs_of_pose = legs_of(*values);
  }
  if (const auto durations = node.find("durations"))
    spec.durations = durations->numbers(dimension::time);
}

}  // namespace jaculus::transcription::problem_read
