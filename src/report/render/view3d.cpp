#include "jaculus/report/view3d.h"

#include <fmt/format.h>

#include <fstream>
#include <sstream>

#include "jaculus/core/error.h"
#include "jaculus/core/yaml.h"
#include "jaculus/dynamics/loop_closure.h"
#include "report/document/html.h"
#include "report/document/json.h"
#include "report/render/assets.h"
#include "report/render/motion_channels.h"

namespace jaculus::report {
namespace {

constexpr int kMostFrames = 1000;

/// What robot.yaml says of the URDF: its file, and the joints of each pair.
struct UrdfNames {
  std::filesystem::path file;
  std::map<std::string, std::vector<std::string>> pairs;
};

UrdfNames urdf_names(const model::Robot& robot) {
  UrdfNames names{robot.folder / "robot.urdf", {}};
  if (!std::filesystem::exists(robot.folder / "robot.yaml")) return names;
  const yaml::Node node = yaml::Node::load(robot.folder / "robot.yaml");
  if (const auto urdf = node.find("urdf")) names.file = robot.folder / urdf->text();
  const auto pairs = node.find("pairs");
  const auto joints = pairs ? pairs->find("joints") : std::nullopt;
  if (!joints) return names;
  for (const auto& [name, list] : joints->entries()) names.pairs[name] = list.texts();
  return names;
}

std::string text_of(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream)
    throw InputError(fmt::format("{}: can't be read; allowed: the robot's URDF", file.string()));
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

/// Base and joints over frames; frames in which the robot's loops can't close are left out.
struct Frames {
  std::vector<double> time;
  std::vector<double> base[3];  ///< x, z [m], pitch [rad]
  std::map<std::string, std::vector<double>> joints;
};

Frames frames_of(const model::PlanarModel& model, const MotionChannels& channels) {
  const CoordinateFrames from = coordinate_frames(model, channels, kMostFrames);
  const dynamics::AbsoluteTree tree(model);

  dynamics::Motion motion(tree);
  Frames frames;
  for (Eigen::Index k = 0; k < from.q.cols(); ++k) {
    const Vector q = from.q.col(k);
    if (!q.allFinite() || !dynamics::set_configuration(tree, q, motion)) continue;
    double lift = 0.0;
    if (!from.height_known && !tree.feet.empty()) {
      lift = kInfinity;
      for (const dynamics::Path& foot : tree.feet)
        lift = std::min(lift, position(foot, motion.pose).y());
    }
    frames.time.push_back(from.time[k]);
    for (int i = 0; i < 3; ++i) frames.base[i].push_back(motion.pose.Y[i] - (i == 1 ? lift : 0.0));
    const Vector theta = dynamics::joint_positions(tree, q, motion);
    for (int b = 1; b < count_of(model.bodies); ++b)
      frames.joints[model.bodies[b].joint].push_back(theta[b]);
  }

  return frames;
}

std::string motion_page(const model::Robot& robot, const MotionChannels& channels,
                        const std::string& title) {
  const auto script = web_asset("view3d.js");
  const auto style = web_asset("view3d.css");
  if (!script || !style)
    throw InputError(
        "view: jaculus was built without its web assets; allowed: a build on a machine with npm");
  const Frames frames = frames_of(robot.planar, channels);
  if (frames.time.size() < 2) {
    throw InputError(
        fmt::format("{}: nothing in it tells where {} is; allowed: a plan or log with its "
                    "coordinates or joints",
                    title, robot.name));
  }

  const UrdfNames names = urdf_names(robot);
  NumberArrays arrays;
  Page page;
  page.title = fmt::format("{} \xC2\xB7 jaculus", title);
  page.script = *script;
  page.style = *style;
  page.data = {{"title", title},
               {"caption", robot.name},
               {"urdf", text_of(names.file)},
               {"time", arrays.add(frames.time)}};
  page.data["base"] = {{"x", arrays.add(frames.base[0])},
                       {"z", arrays.add(frames.base[1])},
                       {"pitch", arrays.add(frames.base[2])}};
  page.data["joints"] = nlohmann::ordered_json::object();
  for (const auto& [joint, values] : frames.joints) {
    const auto pair = names.pairs.find(joint);
    const std::vector<std::string> own =
        pair == names.pairs.end() ? std::vector<std::string>{joint} : pair->second;
    for (const std::string& name : own) page.data["joints"][name] = arrays.add(values);
  }

  page.data["arrays"] = arrays.list();
  page.body =
      "<noscript>This view needs JavaScript, which it brings along.</noscript>\n<main "
      "id=\"report\"></main>\n";

  return html_page(page);
}

}  // namespace

std::string view3d_html(const model::Robot& robot, const trajectory::Table& plan,
                        const std::string& title) {
  return motion_page(robot, motion_channels(plan), title);
}

std::string view3d_html(const model::Robot& robot, const trajectory::Trial& trial,
                        const std::string& title) {
  return motion_page(robot, motion_channels(trial), title);
}

}  // namespace jaculus::report
