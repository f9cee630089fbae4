#include "jaculus/model/robot.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdlib>
#include <optional>
#include <set>

#include "jaculus/core/installation.h"
#include "jaculus/model/urdf.h"
#include "model/attach.h"
#include "model/fields.h"
#include "model/sections.h"

namespace jaculus::model {
namespace {

namespace fs = std::filesystem;

const char* const kFormat = "jaculus-robot/1";

bool is_robot(const fs::path& folder) {
  std::error_code code;
  return fs::is_regular_file(folder / "robot.yaml", code) ||
         fs::is_regular_file(folder / "robot.urdf", code);
}

/// Where models stand: JACULUS_MODELS, then those that come with jaculus.
std::vector<fs::path> model_folders() {
  std::vector<fs::path> folders;
  if (const char* given = std::getenv("JACULUS_MODELS")) folders.emplace_back(given);
  for (const fs::path& folder : data_folders()) folders.push_back(folder / "models");
  return folders;
}

std::vector<std::string> known_robots() {
  std::set<std::string> names;
  for (const fs::path& folder : model_folders()) {
    std::error_code code;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, code)) {
      if (is_robot(entry.path())) names.insert(entry.path().filename().string());
    }
  }
  return {names.begin(), names.end()};
}

/// Read from robot.yaml, or what stands for it where there is none.
struct Description {
  yaml::Node node;
  bool stated = true;  ///< there is a robot.yaml
  fs::path urdf;       ///< file of the bodies and joints
};

/// A URDF without a robot.yaml is taken as it is: a fixed base, and a torque at every joint that
/// moves.
yaml::Node plain_robot(const fs::path& folder) {
  std::string text = fmt::format("format: {}\nbase: fixed\nmotors:\n", kFormat);
  for (const SpatialJoint& joint : read_urdf(folder / "robot.urdf").joints) {
    if (joint.kind != SpatialJointKind::fixed)
      text += fmt::format("  \"{}\": {{kind: ideal}}\n", joint.name);
  }
  if (text.ends_with("motors:\n")) text.resize(text.size() - std::string("motors:\n").size());
  return yaml::Node::parse(text, (folder / "robot.yaml").string());
}

void check_format(const yaml::Node& node) {
  yaml::refuse_other_kind(node, kFormat);
  node.only({"format", "urdf", "axes", "base_link", "base", "gravity", "friction", "pairs",
             "fixed_joints", "loops", "coordinates", "ranges", "rest_pose", "feet", "points",
             "motors", "drag", "attach", "tolerances"});
  (void)node.at("format").choice({kFormat});
}

Description read_description(const fs::path& folder) {
  std::error_code code;
  Description d;
  d.stated = fs::exists(folder / "robot.yaml", code);
  if (!d.stated && !fs::exists(folder / "robot.urdf", code)) {
    throw InputError(fmt::format(
        "{}: no robot here; allowed: a folder with robot.yaml and robot.urdf", folder.string()));
  }

  d.node = d.stated ? yaml::Node::load(folder / "robot.yaml") : plain_robot(folder);
  check_format(d.node);
  const auto urdf = d.node.find("urdf");
  d.urdf = folder / (urdf ? urdf->text() : "robot.urdf");
  return d;
}

void check_base(const yaml::Node& node, const PlanarModel& model) {
  const bool moves = model.base_free[0] || model.base_free[1] || model.base_free[2];
  if (moves && !(model.bodies.front().mass > 0.0)) {
    throw node.at("base").error(
        fmt::format("the base moves but its link '{}' has no mass; allowed: base: fixed, or "
                    "<inertial> in the URDF",
                    model.bodies.front().name));
  }
  if (model.size() == 0)
    throw node.at("base").error(
        "nothing of this robot can move; allowed: a free base or a joint that moves");
}

/// What an override is read by.
enum class Concern { attached, motor, value };

/// A motor anew is a map, {motors.hip: {kind: ...}}; with a further key it is one of its values.
Concern concern_of(const Override& o) {
  if (o.path.starts_with("attach.")) return Concern::attached;
  return o.path.starts_with("motors.") && o.value.is_map() ? Concern::motor : Concern::value;
}

std::vector<OverrideInput> concerning(const std::vector<Override>& overrides, Concern concern) {
  std::vector<OverrideInput> inputs;
  for (const Override& o : overrides)
    if (concern_of(o) == concern) inputs.push_back({o.path, o.value});
  return inputs;
}

/// The bodies in space, in the robot's axes, with what robot.yaml attaches.
struct Composed {
  SpatialTree tree;
  std::vector<Attachment> attachments;
  Absent absent;
  std::vector<std::string> notes;
};

Composed compose(const Description& d, const std::vector<Override>& overrides, Reading reading) {
  Composed c;
  c.tree = read_placement(d.node, read_urdf(d.urdf, reading), c.notes);
  c.attachments =
      read_attachments(d.node, concerning(overrides, Concern::attached), c.tree.total_mass());
  c.absent = remove_absent(reading, c.attachments);
  attach(c.attachments, reading, c.tree);
  for (const Attachment& a : c.attachments) c.notes.push_back(attached_note(a));
  return c;
}

/// The bodies that move, and how robot.yaml names what they carry.
void read_bodies(const yaml::Node& node, const Composed& composed,
                 const std::vector<OverrideInput>& motors, Reading reading, Robot& robot) {
  const SpatialTree& tree = composed.tree;
  Absent absent = composed.absent;
  const std::vector<PairSpec> joints = read_pairs(node, "joints", tree, absent);
  const std::vector<PairSpec> links = read_pairs(node, "links", tree, absent);
  check_carriers(composed.attachments, joints, tree);
  const Reduction reduction =
      reduce(tree, joints, links, read_held(node, tree, joints, absent), reading);
  robot.notes.insert(robot.notes.end(), reduction.notes.begin(), reduction.notes.end());

  PlanarModel& model = robot.planar;
  model.bodies = reduction.bodies;
  model.held = reduction.held;
  read_loops(node, reduction, model);
  read_coordinates(node, reduction, absent, model);
  model.feet = read_points(node, "feet", reduction, model, absent);
  model.points = read_points(node, "points", reduction, model, absent);
  read_motors(node, absent, model);
  replace_motors(motors, model);  // before a tail takes one like them
  read_drags(node, reduction, absent, model);
  add_attached_parts(composed.attachments, model);
  replace_motors(motors, model);
  check_replaced(motors, absent, model);
  robot.rest_pose = read_rest_pose(node, model, absent);
}

/// The model as the files give it, before overrides of its values.
Robot read_files(const fs::path& folder, const Description& described,
                 const std::vector<Override>& overrides, Reading reading) {
  const yaml::Node& node = described.node;
  const Composed composed = compose(described, overrides, reading);
  const SpatialTree& tree = composed.tree;
  Robot robot;
  robot.name = tree.name;
  robot.folder = folder;
  robot.urdf = described.urdf;
  robot.notes = composed.notes;
  if (!described.stated)
    robot.notes.push_back(
        "no robot.yaml: the base is taken as fixed, every moving joint has an ideal motor");
  robot.notes.insert(robot.notes.end(), tree.notes.begin(), tree.notes.end());

  PlanarModel& model = robot.planar;
  read_base(node, model);
  read_bodies(node, composed, concerning(overrides, Concern::motor), reading, robot);
  const Bounds not_negative{0.0, kInfinity};
  if (const auto gravity = node.find("gravity"))
    model.gravity = gravity->number(dimension::acceleration, not_negative);
  if (!model.feet.empty() || node.has("friction"))
    model.friction = node.at("friction").number(dimension::none, not_negative);
  check_base(node, model);
  robot.tolerances = read_tolerances(node);
  return robot;
}

/// The folder of a robot under models/; nothing where none has that name.
std::optional<fs::path> installed_folder(const std::string& name) {
  for (const fs::path& folder : model_folders())
    if (is_robot(folder / name)) return (folder / name).lexically_normal();
  return {};
}

}  // namespace

fs::path find_robot(const std::string& name, const fs::path& relative_to) {
  std::error_code code;
  const fs::path beside =
      fs::is_directory(relative_to, code) ? relative_to : relative_to.parent_path();
  if (!name.empty()) {
    if (is_robot(beside / name)) return (beside / name).lexically_normal();
    if (auto installed = installed_folder(name)) return *std::move(installed);
  }
  const std::vector<std::string> known = known_robots();
  throw InputError(
      fmt::format("unknown robot '{}'{}; allowed: a folder with robot.yaml and robot.urdf "
                  "(relative to '{}'), or one of {}",
                  name, yaml::did_you_mean(name, known), beside.empty() ? "." : beside.string(),
                  fmt::join(known, ", ")));
}

bool is_installed(const std::string& name) {
  return fs::path(name).filename() == name && name != "." && name != ".." && installed_folder(name);
}

Robot read_robot(const fs::path& folder, const std::vector<Override>& overrides, Reading reading) {
  const Description described = read_description(folder);
  Robot robot = read_files(folder, described, overrides, reading);
  const std::vector<OverrideInput> values = concerning(overrides, Concern::value);
  apply_overrides(robot.planar, values);
  check_drags(described.node, values, robot.planar);
  return robot;
}

SpatialTree read_tree(const fs::path& folder, const std::vector<Override>& overrides) {
  SpatialTree tree = compose(read_description(folder), overrides, Reading::lenient).tree;
  tree.links[tree.root].R_BL = Mat3::Identity();
  tree.links[tree.root].p_BL = Vec3::Zero();
  place_links(tree);
  return tree;
}

std::vector<std::string> override_paths(const fs::path& folder) {
  const Description described = read_description(folder);
  Robot robot = read_files(folder, described, {}, Reading::lenient);
  std::vector<std::string> lines = attach_paths(described.node);
  for (const PlanarMotor& motor : robot.planar.motors)
    lines.push_back(fmt::format("motors.{} = {}", motor.joint, motor_text(motor, robot.planar)));
  for (const Field& field : model_fields(robot.planar))
    lines.push_back(field.path + " = " + field.shown());
  return lines;
}

}  // namespace jaculus::model
