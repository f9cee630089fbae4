// jaculus robot: robot files of other people's into a folder that jaculus reads.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <charconv>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "cli/command.h"
#include "cli/robot_doubts.h"
#include "cli/robot_leap.h"
#include "cli/robot_tail.h"
#include "cli/robot_trial.h"
#include "cli/robot_xacro.h"
#include "jaculus/core/error.h"
#include "jaculus/model/describe.h"
#include "jaculus/model/mjcf.h"
#include "jaculus/model/propose.h"
#include "jaculus/trajectory/csv.h"

namespace jaculus::cli {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// Of --hold: all joints without a motor of their own with a stated limit.
constexpr const char* kPassive = "passive";

struct RobotOptions {
  Common common;
  std::string file, base, forward, up;
  std::string tail;  ///< its mass, "10 %"; empty: none
  std::string inertias = "file";
  std::vector<std::string> pose, hold;
  bool strict = false, apart = false, open = false, replace = false;
};

std::map<std::string, double> read_pose(const std::vector<std::string>& given) {
  std::map<std::string, double> pose;
  for (const std::string& text : given) {
    const std::size_t equals = text.find('=');
    const std::string name = text.substr(0, equals);
    if (equals == std::string::npos || name.empty())
      throw InputError(
          fmt::format("--pose: '{}' given; allowed: JOINT=VALUE, as in hip=20deg", text));
    // rad or m; the joint's kind isn't known here, so units are those of angles and lengths alike
    const yaml::Node node = yaml::Node::parse("{value: " + text.substr(equals + 1) + "}", "--pose");
    try {
      pose[name] = node.at("value").number(dimension::angle);
    } catch (const InputError&) {
      pose[name] = node.at("value").number(dimension::length);
    }
  }
  return pose;
}

/// A robot file as read.
struct Source {
  std::string urdf;  ///< text of the file to write; empty where the file itself is copied
  model::SpatialTree tree;
  std::vector<std::string> notes;
  std::map<std::string, double> pose, armature;
  std::vector<model::Surface> surfaces;
  std::optional<bool> floating;
};

Source read_source(const fs::path& file, model::Reading reading) {
  Source source;
  if (model::is_mjcf(file)) {
    model::MjcfRobot robot = model::read_mjcf(file, reading);
    source.urdf = model::write_urdf(robot.tree);
    source.tree = model::parse_urdf(source.urdf, file, reading);
    model::keep_friction(robot.tree, source.tree);
    source.notes = robot.notes;
    source.pose = robot.pose;
    source.armature = robot.armature;
    source.surfaces = robot.surfaces;
    // a fixed one may still carry its base on joints along x and z
    if (robot.floating) source.floating = true;
    return source;
  }
  if (file.extension() == ".xacro") source.urdf = expand_xacro(file);
  source.tree = source.urdf.empty() ? model::read_urdf(file, reading)
                                    : model::parse_urdf(source.urdf, file, reading);
  source.notes = source.tree.notes;
  return source;
}

/// Place holders for inertias replaced, in the tree and the file to write.
void take_inertias_of_shapes(Source& source, const fs::path& file, model::Reading reading) {
  const std::vector<std::string> names = model::take_inertias_of_shapes(source.tree);
  if (names.empty()) return;
  source.notes.push_back(fmt::format("assumed: inertias of {} links are those of their shapes: {}",
                                     names.size(), fmt::join(names, ", ")));
  source.urdf = model::write_urdf(source.tree);
  const model::SpatialTree written = std::move(source.tree);
  source.tree = model::parse_urdf(source.urdf, file, reading);
  model::keep_friction(written, source.tree);
}

model::ProposeOptions propose_options(const RobotOptions& options, const Source& source) {
  model::ProposeOptions propose;
  propose.pose = read_pose(options.pose);
  propose.file_pose = source.pose;
  for (const std::string& joint : options.hold)
    if (joint == kPassive)
      propose.hold_passive = true;
    else
      propose.hold.push_back(joint);
  propose.armature = source.armature;
  propose.surfaces = source.surfaces;
  propose.pairs = !options.apart;
  propose.loops = !options.open;
  propose.floating = source.floating;
  if (options.forward.empty() != options.up.empty())
    throw InputError("--forward and --up: one of them given; allowed: both or none");
  if (!options.forward.empty() && options.forward[1] == options.up[1]) {
    throw InputError(fmt::format("--forward {} and --up {} lie on one line; allowed: two axes",
                                 options.forward, options.up));
  }
  propose.forward = options.forward;
  propose.up = options.up;
  if (!options.base.empty()) propose.floating = options.base == "floating";
  return propose;
}

Json dropped_json(const model::Dropped& d) {
  return {{"mass_kg", d.mass},
          {"pitch_inertia_kg_m2", d.pitch_inertia},
          {"mass_off_plane_kg", d.mass_off_plane},
          {"com_off_plane_m", d.com_off_plane},
          {"inertia_moved_kg_m2", d.inertia_moved},
          {"coupling", d.coupling}};
}

std::string dropped_text(const model::Dropped& d) {
  return fmt::format(
      "kept of the file: {:.6g} kg, pitch inertia {:.6g} kg m^2 about the centre of mass\n"
      "dropped: sideways places of {:.4g} kg ({:.4g} kg m^2 of roll and yaw inertia), a centre of "
      "mass {},\n  products of inertia of pitch with roll and yaw of {:.2g} %\n",
      d.mass, d.pitch_inertia, d.mass_off_plane, d.inertia_moved, d.com_sideways(),
      1e2 * d.coupling);
}

/// What an import wrote.
struct Written {
  Source source;
  model::Proposal proposal;
  model::Robot robot;
  std::string trial, leap;  ///< files; empty where there is none
};

/// What the reduction to the plane assumed, beyond what reading the file did.
std::vector<std::string> assumed_of(const Written& w) {
  std::vector<std::string> assumed = w.robot.notes;
  std::erase_if(assumed, [&](const std::string& note) {
    const std::vector<std::string>& known = w.source.notes;
    return !note.starts_with("assumed:") ||
           std::find(known.begin(), known.end(), note) != known.end();
  });
  return assumed;
}

std::string written_text(const Written& w, const fs::path& out) {
  std::string text = model::size_line(w.robot);
  for (const std::string& note : w.source.notes) text += "  " + note + "\n";
  for (const std::string& note : w.proposal.notes) text += "  " + note + "\n";
  for (const std::string& note : assumed_of(w)) text += "  " + note + "\n";
  text += dropped_text(w.proposal.dropped);
  for (const std::string& line : w.proposal.missing) text += "to fill in: " + line + "\n";

  text += fmt::format("written to {}: robot.urdf, robot.yaml{}{}{}{}\n", out.string(),
                      w.trial.empty() ? "" : ", ", w.trial, w.leap.empty() ? "" : ", ", w.leap);
  const auto try_out = [&](const std::string& command, const std::string& file) {
    if (file.empty()) return;
    const std::string name = fs::path(file).stem().string() + "_result";
    text += fmt::format("try: jaculus {} {} --out {}\n", command, (out / file).string(),
                        (out / name).string());
  };
  try_out("simulate", w.trial);
  try_out("solve", w.leap);
  return text;
}

Json written_json(const Written& w) {
  return {{"robot", w.robot.name},
          {"planar", w.proposal.planar},
          {"floating", w.proposal.floating},
          {"bodies", w.robot.planar.bodies.size()},
          {"coordinates", w.robot.planar.size()},
          {"feet", w.robot.planar.feet.size()},
          {"notes", w.source.notes},
          {"decided", w.proposal.notes},
          {"assumed", assumed_of(w)},
          {"held", w.proposal.held},
          {"to_fill_in", w.proposal.missing},
          {"kept_and_dropped", dropped_json(w.proposal.dropped)},
          {"trial", w.trial},
          {"leap", w.leap}};
}

void write_urdf_file(const Source& source, const fs::path& file, const fs::path& target) {
  if (!source.urdf.empty()) {
    trajectory::write_file(target, source.urdf);
  } else if (!fs::exists(target) || !fs::equivalent(file, target)) {
    fs::copy_file(file, target, fs::copy_options::overwrite_existing);
  }
}

/// A folder that goes again where what it was made for fails.
class NewFolder {
 public:
  explicit NewFolder(fs::path folder) : folder_(std::move(folder)), fresh_(!fs::exists(folder_)) {
    prepare_folder(folder_);
  }
  ~NewFolder() {
    std::error_code code;
    if (fresh_) fs::remove_all(folder_, code);
  }
  NewFolder(const NewFolder&) = delete;
  NewFolder& operator=(const NewFolder&) = delete;
  void keep() { fresh_ = false; }

 private:
  fs::path folder_;
  bool fresh_ = true;
};

/// The robot just written. The file goes again where it is refused, so that the message says whose
/// line it quotes.
model::Robot read_written(const fs::path& out, model::Reading reading) {
  try {
    return model::read_robot(out, {}, reading);
  } catch (const InputError& error) {
    if (reading == model::Reading::lenient) throw;
    throw InputError(fmt::format("--strict: of what would be written, {}", error.what()));
  }
}

Written write_robot(const RobotOptions& options, const fs::path& out) {
  const auto reading = options.strict ? model::Reading::strict : model::Reading::lenient;
  Written w;
  w.source = read_source(options.file, reading);
  if (options.inertias == "shapes") take_inertias_of_shapes(w.source, options.file, reading);
  w.proposal = model::propose_robot(w.source.tree, propose_options(options, w.source));

  NewFolder folder(out);
  write_urdf_file(w.source, options.file, out / "robot.urdf");
  trajectory::write_file(out / "robot.yaml", w.proposal.yaml);
  w.robot = read_written(out, reading);
  if (!options.tail.empty()) {
    w.proposal.yaml += tail_section(w.robot, options.tail);
    trajectory::write_file(out / "robot.yaml", w.proposal.yaml);
    w.robot = read_written(out, reading);
  }

  for (const std::string& line : doubtful_limits(w.robot)) w.proposal.missing.push_back(line);

  w.trial = write_first_trial(w.robot, w.proposal.rest, out);
  w.leap = write_first_leap(w.robot, w.proposal, out);
  folder.keep();
  return w;
}

int run_robot_import(const RobotOptions& options) {
  if (options.common.out.empty())
    throw InputError("--out: missing; allowed: the folder of the robot to write");
  const fs::path out = options.common.out;
  if (fs::exists(out / "robot.yaml") && !options.replace) {
    throw InputError(fmt::format(
        "--out {}: has a robot.yaml already; allowed: another folder, or --replace", out.string()));
  }
  check_tail_mass(options.tail);

  const Written w = write_robot(options, out);
  if (options.common.json) {
    print(written_json(w).dump(1) + "\n");
  } else if (!options.common.quiet) {
    print(written_text(w, out));
  }
  return kDone;
}

struct UrdfOptions {
  Common common;
  std::string robot;
};

int run_robot_urdf(const UrdfOptions& options) {
  if (options.common.out.empty())
    throw InputError("--out: missing; allowed: the URDF file to write");
  const fs::path folder = model::find_robot(options.robot, "");
  const model::Robot robot = model::read_robot(folder);
  model::SpatialTree tree = model::read_tree(folder);
  state_limits(robot.planar, tree);
  trajectory::write_file(options.common.out, model::write_urdf(tree));
  if (!options.common.quiet) print(fmt::format("written to {}\n", options.common.out));
  return kDone;
}

void add_robot_urdf(CLI::App& robot, Action& chosen) {
  auto options = std::make_shared<UrdfOptions>();
  CLI::App* urdf = robot.add_subcommand(
      "urdf", "Writes one URDF of a robot and what its robot.yaml attaches, for other programs.");
  urdf->footer("Example:\n  jaculus robot urdf my_a1 --out a1_with_tail.urdf");
  urdf->add_option("robot", options->robot, "a robot's folder or name")->required();
  urdf->add_option("--out", options->common.out, "file");
  urdf->add_flag("--quiet", options->common.quiet, "print nothing but errors");
  urdf->callback([options, &chosen] { chosen = [options] { return run_robot_urdf(*options); }; });
}

/// What the robot is, beyond what its file says.
void add_statements(CLI::App& import, RobotOptions& options) {
  import.add_option("--pose", options.pose,
                    "JOINT=VALUE of joints that are held, or of the pose at rest; 0 where absent");
  import.add_option(
      "--hold", options.hold,
      "joints that are held though they turn in the plane; `passive`: all without a "
      "motor of their own with a stated limit, as springy spines and tails have them");
  import.add_option("--base", options.base, "floating or fixed; default: told by the limbs")
      ->check(one_of({"floating", "fixed"}));

  const std::vector<std::string> axes = {"+x", "-x", "+y", "-y", "+z", "-z"};
  import.add_option("--forward", options.forward, "axis of the file; default: told by names")
      ->check(one_of(axes));
  import.add_option("--up", options.up, "axis of the file; default: told by joints")
      ->check(one_of(axes));

  import
      .add_option("--inertias", options.inertias,
                  "file, or shapes: of links whose inertia is a place holder that of their shapes")
      ->check(one_of({"file", "shapes"}));
  import.add_option("--tail", options.tail,
                    "adds a tail of this mass (1.2 kg, or 10 % of the robot's) to robot.yaml");
  import.add_flag("--apart", options.apart, "left and right are joints of their own, no pairs");
  import.add_flag("--open", options.open, "two chains from one hip stay apart, no five-bars");
}

void add_robot_import(CLI::App& robot, Action& chosen) {
  auto options = std::make_shared<RobotOptions>();
  CLI::App* import = robot.add_subcommand(
      "import", "Proposes robot.yaml for a robot file; prints what was assumed and dropped.");
  import->footer("Example:\n  jaculus robot import a1.urdf --out models/a1");
  import->add_option("file", options->file, "URDF, MJCF, or xacro where ROS's tool is there")
      ->required();
  import->add_option("--out", options->common.out, "folder of the robot");
  add_statements(*import, *options);

  import->add_flag("--strict", options->strict, "refuse what would be assumed");
  import->add_flag("--replace", options->replace, "write over a robot.yaml that is there");
  import->add_flag("--quiet", options->common.quiet, "print nothing but errors");
  import->add_flag("--json", options->common.json,
                   "machine-readable result on standard output, nothing else there");
  import->callback([options, &chosen] { chosen = [options] { return run_robot_import(*options);
};
}  // namespace
);
}  // namespace jaculus::cli

}  // namespace

void add_robot(CLI::App& app, Action& chosen) {
  CLI::App* robot = app.add_subcommand("robot", "Robots from files of other people's.");
  robot->require_subcommand(1);
  add_robot_import(*robot, chosen);
  add_robot_urdf(*robot, chosen);
}

}  // namespace jaculus::cli
