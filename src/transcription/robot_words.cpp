// Words of a problem that only its robot gives a meaning: poses, legs at rest.

#include <fmt/format.h>

#include <optional>

#include "jaculus/transcription/robot_size.h"
#include "transcription/problem_read.h"

namespace jaculus::transcription {
namespace {

using yaml::Node;

/// What words of a problem mean for its robot, which is read where one is used.
class RobotWords {
  /// A fault of the robot is one of the word as well.
  template <class Ask>
  auto told(const Node& node, const std::string& word, Ask ask) {
    try {
      if (!robot_) robot_ = model::read_robot(problem_.robot_folder, problem_.overrides);
      return ask(*robot_);
    } catch (const InputError& error) {
      throw node.error(fmt::format("{} given: {}", word, error.what()));
    }
  }

 public:
  explicit RobotWords(const Problem& problem) : problem_(problem) {}

  const std::map<std::string, double>& pose(const std::string& name, const Node& node) {
    const auto [entry, is_new] = poses_.try_emplace(name);
    if (!is_new || name.empty()) return entry->second;
    entry->second = told(node, "pose: " + name, [&](const model::Robot& robot) {
      return name == "rest" ? rest_coordinates(robot) : stretched_coordinates(robot);
    });
    return entry->second;
  }

  std::vector<std::string> leg(const std::string& foot, const Node& node) {
    return told(node, "legs_at_rest: " + foot,
                [&](const model::Robot& robot) { return leg_coordinates(robot, foot); });
  }

 private:
  const Problem& problem_;
  std::optional<model::Robot> robot_;
  std::map<std::string, std::map<std::string, double>> poses_;
};

}  // namespace

void problem_read::apply_robot_words(Problem& problem) {
  RobotWords words(problem);
  for (BoundarySpec* spec : {&problem.initial, &problem.final}) {
    for (const auto& [name, value] : words.pose(spec->pose, spec->node))
      spec->position.try_emplace(name, Bounds{value, value});
    for (const std::string& foot : spec->legs_at_rest)
      for (const std::string& name : words.leg(foot, spec->node))
        spec->velocity.try_emplace(name, Bounds{0.0, 0.0});
  }

  // what the file states itself stays
  GuessSpec& guess = problem.guess;
  const auto add = [&](const std::string& name, std::map<std::string, double>& pose) {
    const std::map<std::string, double>& legs = words.pose(name, guess.node);
    pose.insert(legs.begin(), legs.end());
  };
  add(guess.legs_of_pose, guess.pose);
  for (std::size_t k = 0; k < guess.legs_of_poses.size(); ++k)
    add(guess.legs_of_poses[k], guess.poses[k]);
}

}  // namespace jaculus::transcription
