#include "cli/dataset_doubts.h"

#include <fmt/format.h>

#include <algorithm>

#include "jaculus/core/yaml.h"
#include "jaculus/simulation/experiment.h"
#include "jaculus/simulation/log_limits.h"
#include "jaculus/trajectory/log_checks.h"

namespace jaculus::cli {
namespace {

using trajectory::Quantity;

const std::vector<std::string> kOfNoJoint = {"x",   "y",     "z",         "roll",
                                             "yaw", "pitch", "imu_pitch", "bus"};

/// Whether a channel is of no joint, coordinate or foot of this robot.
bool is_strange(const std::string& channel, const model::PlanarModel& model) {
  const std::string of = trajectory::parse_channel(channel).of;
  const auto foot = [&](const model::PlanarPoint& own) { return own.name == of; };
  return !channel.ends_with("temperature") && model.body_of_joint(of) < 0 &&
         model.coordinate_index(of) < 0 &&
         std::find(kOfNoJoint.begin(), kOfNoJoint.end(), of) == kOfNoJoint.end() &&
         std::none_of(model.feet.begin(), model.feet.end(), foot);
}

/// "pendlum_torqe, did you mean 'pendulum_torque'?".
std::string with_nearest(const std::string& channel, const model::PlanarModel& model) {
  std::vector<std::string> channels;
  for (const model::PlanarBody& body : model.bodies) {
    if (body.joint.empty()) continue;
    channels.push_back(body.joint);
    for (const std::string& quantity : trajectory::quantity_names().names())
      if (quantity != name_of(Quantity::position)) channels.push_back(body.joint + "_" + quantity);
  }
  return channel + yaml::did_you_mean(channel, channels);
}

/// Channels that this robot can't have: the plan or the log is of another robot.
std::vector<std::string> strange_channels(const trajectory::Dataset& dataset,
                                          const model::PlanarModel& model) {
  std::vector<std::string> strange;
  for (const trajectory::Trial& trial : dataset.trials)
    for (const trajectory::Stream& stream : trial.streams)
      for (const std::string& channel : stream.channels) {
        const bool known = std::find(strange.begin(), strange.end(), channel) != strange.end();
        if (!known && is_strange(channel, model)) strange.push_back(channel);
      }
  return strange;
}

}  // namespace

DatasetDoubts dataset_doubts(const trajectory::Dataset& dataset, const model::Robot& robot) {
  const model::PlanarModel model = simulation::dataset_plant(dataset, robot.planar).model;
  DatasetDoubts doubts{strange_channels(dataset, model), {}, trajectory::rate_notes(dataset)};
  for (const std::string& channel : doubts.strange_channels)
    doubts.notes.push_back(
        fmt::format("channel of no joint or sensor of this robot, which nothing uses: {}",
                    with_nearest(channel, model)));
  for (const trajectory::RateContradiction& found : trajectory::rate_contradictions(dataset))
    doubts.contradictions.push_back(to_text(found));
  for (const simulation::OutOfReach& found : simulation::values_out_of_reach(dataset, model))
    (found.impossible ? doubts.contradictions : doubts.notes).push_back(found.text);
  return doubts;
}

std::string to_text(const DatasetDoubts& doubts) {
  std::string text;
  for (const std::string& note : doubts.notes) text += "  note: " + note + "\n";
  for (const std::string& found : doubts.contradictions) text += "  contradiction: " + found + "\n";
  return text;
}

}  // namespace jaculus::cli
