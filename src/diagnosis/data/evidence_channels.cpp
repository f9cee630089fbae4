#include "diagnosis/data/evidence_channels.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <set>

#include "diagnosis/data/partings.h"

namespace jaculus::diagnosis {
namespace {

using model::PlanarModel;
using model::PlanarMotor;
using trajectory::Dataset;
using trajectory::Quantity;
using trajectory::StatedController;
using trajectory::Stream;
using trajectory::Trial;

/// Whether a channel is one that the plant predicts; `held` where it follows the loop in steps.
bool is_predicted(const PlanarModel& model, const std::string& name, bool& zero_order_hold) {
  static const std::set<std::string> plain{
      "x", "z", "pitch", "imu_pitch", "imu_pitch_velocity", "bus_voltage"};
  zero_order_hold = name == "bus_voltage";
  if (name == "x" || name == "z" || name == "pitch") return model.coordinate_index(name) >= 0;
  if (name == "imu_pitch" || name == "imu_pitch_velocity")
    return model.coordinate_index("pitch") >= 0;
  if (name == "bus_voltage") return !model.motors.empty() && !model.motors.front().ideal();

  for (const PlanarMotor& motor : model.motors) {
    if (name == motor.joint) return true;
    const trajectory::ChannelName parts = trajectory::parse_channel(name);
    if (parts.of != motor.joint) continue;
    if (parts.quantity == Quantity::velocity) return true;
    const bool electric = parts.quantity == Quantity::current ||
                          parts.quantity == Quantity::voltage || parts.quantity == Quantity::duty;
    zero_order_hold = parts.quantity == Quantity::torque || (electric && !motor.ideal());
    if (zero_order_hold) return true;
  }

  return false;
}

/// A command is what was asked for, not what happened: the quantity that drove the joint. A duty
/// happens only to a driver that was asked for a torque, and shows by which voltage the windings
/// were brought to it; else it is the command.
bool is_command(const Dataset& dataset, const std::string& name) {
  const StatedController& controller = dataset.controller;
  const Quantity shown = trajectory::parse_channel(name).quantity;
  const Quantity asked = dataset.script ? dataset.script->quantity : controller.quantity;
  if (controller.kind == trajectory::ControllerKind::measured)
    return shown == Quantity::duty || shown == controller.input;
  if (shown == Quantity::duty)
    return asked != Quantity::torque || !(dataset.script || controller.quantity_stated);
  return dataset.script && shown == asked;
}

}  // namespace

void select_channels(ObservedDataset& observed, const std::string& label,
                     std::vector<std::string>& notes) {
  std::vector<std::string> unused;
  std::set<std::string> seen;

  for (const Trial& trial : observed.dataset.trials) {
    for (const Stream& stream : trial.streams) {
      if (observed.stream_index(stream.name) < 0) observed.streams.push_back(stream.name);
      for (std::size_t c = 0; c < stream.channels.size(); ++c) {
        Channel channel{stream.name, stream.channels[c], stream.units[c]};
        if (!seen.insert(stream.name + "." + channel.name).second ||
            is_command(observed.dataset, channel.name))
          continue;
        if (is_predicted(observed.model, channel.name, channel.zero_order_hold)) {
          observed.channels.push_back(channel);
        } else if (!tells_of_plane(observed.model, stream.name, channel.name)) {
          unused.push_back(channel.name);
        }
      }
    }
  }

  if (!unused.empty()) {
    notes.push_back(fmt::format("{}: not used, as the plant does not predict them: {}", label,
                                fmt::join(unused, ", ")));
  }
}

}  // namespace jaculus::diagnosis
