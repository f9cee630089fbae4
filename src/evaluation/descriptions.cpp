#include "evaluation/descriptions.h"

#include <algorithm>

namespace jaculus::evaluation {
namespace {

const std::vector<RightDescription> kRight = {
    // What pulls or pushes the body.
    {"tether",
     {"body"},
     "",
     {"position"},
     "a cable from the world to the base: beyond its slack its pull grows with the way"},
    {"loose_battery",
     {"body"},
     "",
     {"acceleration", "other acceleration"},
     "a mass on a spring in the base pulls back where the base accelerates"},
    {"tilted_floor",
     {"body", "feet"},
     "",
     {"constant", "gravity direction"},
     "seen from a level floor, gravity has a constant part along it"},
    {"push", {"body"}, "", {"event", "time"}, "a hand on the base for 20 ms"},
    {"base_push", {"body"}, "", {"event"}, "a half sine of force on the base"},
    {"shaking_support",
     {"body", "joint"},
     "",
     {"time", "periodic in time"},
     "seen from what sways, all masses feel a sine of time; without a base that moves joints do"},
    // What is at the feet.
    {"sticky_floor",
     {"feet"},
     "rear",
     {"constant", "position"},
     "a pull on feet within 4 mm of the floor, less with their height"},
    {"bent_leg",
     {"feet"},
     "rear",
     {"constant", "position"},
     "a toe that reaches further meets the floor earlier: force from a place on"},
    // What rubs.
    {"hysteresis",
     {"joint"},
     "",
     {"sign of speed", "position"},
     "elastic for small motion, against the motion beyond (Dahl)"},
    {"tight_spot", {"joint"}, "", {"sign of speed"}, "dry friction, at some angles"},
    {"stiff_grease",
     {"joint"},
     "",
     {"sign of speed", "time"},
     "dry friction that fades with the way travelled"},
    {"square_drag", {"joint"}, "!tail", {"speed squared"}, "its own law"},
    // What pulls or pushes joints at some angles.
    {"joint_cable", {"joint"}, "", {"position"}, "a spring on one side"},
    {"early_stop", {"joint"}, "", {"position"}, "a stiff spring on one side"},
    {"tail_cable", {"joint"}, "tail", {"position"}, "a spring that hardens with the cube"},
    {"catch",
     {"joint"},
     "",
     {"position", "periodic in position"},
     "a well of magnets: a spring near its middle, one wave over the angles"},
    {"torque_ripple", {"joint"}, "!tail", {"periodic in position"}, "14 waves a turn of the motor"},
    // What becomes of a motor's torque.
    {"magnet_saturation",
     {"joint"},
     "",
     {"motor torque"},
     "a share of the torque that the current stands for, more at large ones"},
    {"gear_runout",
     {"joint"},
     "",
     {"motor torque", "periodic in position"},
     "a share of the torque that goes with a sine of the motor's angle"},
    {"thermal_derating",
     {"joint"},
     "front",
     {"motor torque", "time"},
     "a share of the torque is lost from a time on"},
    {"slipping_belt",
     {"joint"},
     "rear",
     {"motor torque"},
     "what the torque has above a limit is lost"},
    {"command_dropout",
     {"joint", "commands"},
     "rear",
     {"motor torque", "time"},
     "all of the torque is lost for a while"},
    // What becomes of commands; the joint is where it is felt.
    {"driver_dead_band",
     {"joint", "commands"},
     "",
     {"motor torque"},
     "a part of each command, with its sign, is lost"},
    {"coarse_commands",
     {"joint", "commands"},
     "",
     {"motor torque"},
     "what rounding leaves out of a command is a function of it"},
    {"command_slew",
     {"joint", "commands"},
     "",
     {"motor torque", "time"},
     "a command's change arrives later"},
    {"lost_packets",
     {"joint", "commands"},
     "",
     {"motor torque", "time"},
     "the last command goes on while packets are lost"},
    // What is at the mount or the last link.
    {"compliant_mount",
     {"body", "joint"},
     "",
     {"acceleration", "other acceleration"},
     "a base that yields moves as the links accelerate; without coordinates of its own joints feel "
     "it"},
    {"sliding_load",
     {"joint"},
     "",
     {"acceleration", "gravity direction"},
     "a mass whose lever varies: more or less inertia and weight of the last link"},
    // What a sensor reads.
    {"encoder_runout",
     {"sensor"},
     "",
     {"periodic in position"},
     "a reading that is off by a sine of the angle"},
    {"joint_push", {"joint"}, "", {"event"}, "a half sine of torque at one joint"}};

bool has(const std::vector<std::string>& list, const std::string& what) {
  return std::find(list.begin(), list.end(), what) != list.end();
}

bool at_right_place(const RightDescription& right, const SaidPart& part) {
  if (!has(right.places, part.place)) return false;
  if (right.limb.empty() || part.place == "body" || part.place == "commands") return true;
  if (right.limb.front() == '!') return !part.at.starts_with(right.limb.substr(1));
  return part.at.starts_with(right.limb);
}

bool is_event_kind(const RightDescription& right) { return has(right.families, "event"); }

/// The parts that are judged, the leading one first. Events count for kinds that are pushes alone.
std::vector<SaidPart> judged_parts(const RightDescription& right, const Prediction& prediction) {
  std::vector<SaidPart> parts;
  if (is_event_kind(right))
    for (const SaidEvent& event : prediction.events)
      parts.push_back({event.joint == "base" ? "body" : "joint", event.joint, "event", kInfinity});
  parts.insert(parts.end(), prediction.described.begin(), prediction.described.end());
  std::stable_sort(parts.begin(), parts.end(),
                   [](const SaidPart& a, const SaidPart& b) { return a.weight > b.weight; });
  return parts;
}

}  // namespace

const std::vector<RightDescription>& right_descriptions() { return kRight; }

const RightDescription* right_description(const std::string& name) {
  const std::string kind = name.substr(0, name.find('@'));
  const auto found = std::find_if(kRight.begin(), kRight.end(),
                                  [&](const RightDescription& r) { return r.kind == kind; });
  return found == kRight.end() ? nullptr : &*found;
}

const RightDescription* described_kind(const CaseTruth& truth) {
  if (truth.kind == "outside" && !truth.effects.empty())
    return right_description(truth.effects.front());
  if (truth.kind == "mixed" && !truth.beside.empty())
    return right_description(truth.beside.front());
  return nullptr;
}

bool place_right(const RightDescription& right, const Prediction& prediction) {
  const std::vector<SaidPart> parts = judged_parts(right, prediction);
  return !parts.empty() && at_right_place(right, parts.front());
}

double family_credit(const RightDescription& right, const Prediction& prediction) {
  const std::vector<SaidPart> parts = judged_parts(right, prediction);
  for (std::size_t i = 0; i < parts.size(); ++i)
    if (at_right_place(right, parts[i]) && has(right.families, parts[i].family))
      return i == 0 ? 1.0 : 1.0 / static_cast<double>(parts.size());
  return 0.0;
}

}  // namespace jaculus::evaluation
