#include "diagnosis/remainder/place_patterns.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "diagnosis/forward/missing_forces.h"
#include "diagnosis/remainder/body_patterns.h"
#include "diagnosis/remainder/joint_patterns.h"
#include "effects/scope.h"
#include "jaculus/components/motor.h"
#include "jaculus/diagnosis/summary.h"

namespace jaculus::diagnosis {
namespace {

using model::PlanarModel;

constexpr double kWaveSpread = 0.05, kWaveRange = 0.2;   ///< of a period
constexpr double kSlackSpread = 0.5, kSlackRange = 3.0;  ///< of a slack; grids are 2 apart
constexpr double kLeastSlack = 0.1;                      ///< of the range, where it begins at once
constexpr double kWidthSpread = 0.5, kWidthRange = 3.0;  ///< of a width

PatternPlace joint_place(const PlanarModel& robot, const model::PlanarMotor& motor,
                         const UsualMotion& usual, const PatternSizes& sizes) {
  const int m = robot.motor_index(motor.joint);
  const bool turns = !robot.slides(motor);
  PatternPlace place{"joint", motor.joint, "{joint: " + motor.joint + "}"};
  place.key = turns ? "torque" : "force";
  place.force = turns ? "N m" : "N";
  place.metre = turns ? "rad" : "m";
  place.what = place.key + " at " + motor.joint;
  const double limit = components::largest_joint_torque(motor).value;
  place.limited = std::isfinite(limit);
  place.limit = place.limited ? limit : large_force(robot, motor, sizes.lever);
  place.large = sizes.prior * place.limit;
  place.speed = std::max(1e-3, usual.motors.speed[m]);
  place.rest = sizes.rest_speed * place.speed;
  place.duration = usual.duration;
  place.body = robot.bodies[motor.body].name;
  if (turns && !motor.ideal()) place.turn = 2.0 * std::numbers::pi / motor.gear;
  place.start = usual.motors.start[m];
  place.range = usual.motors.range[m];
  return place;
}

void add_all(const PatternMaker& maker, std::vector<PlacePattern>& all) {
  all.insert(all.end(), maker.made.begin(), maker.made.end());
}

/// The joints of a limb or of an arm together. Sizes are those of the motor that moves farthest;
/// forces are told in limits of each motor, where all have one.
void add_group(const std::vector<PatternPlace>& joints, const std::string& group,
               const std::string& at, double prior, std::vector<PlacePattern>& all) {
  const bool alike = std::all_of(joints.begin(), joints.end(), [&](const PatternPlace& p) {
    return p.key == joints.front().key;
  });
  if (joints.size() < 2 || !alike) return;
  PatternPlace together = *std::max_element(
      joints.begin(), joints.end(),
      [](const PatternPlace& a, const PatternPlace& b) { return a.range < b.range; });
  together.of_group = true;
  together.body = {};
  together.at = at;
  together.where = "{group: " + group + "}";
  together.what = together.key + " at " + (group == "legs" ? "every leg's joints" : in_words(at));
  if (std::all_of(joints.begin(), joints.end(), [](const PatternPlace& p) { return p.limited; })) {
    together.force = "1";
    together.large = prior;
    together.limit = 1.0;
  }
  PatternMaker maker(together);
  add_joint_patterns(maker);
  add_all(maker, all);
}

void add_joints(const PlanarModel& robot, const UsualMotion& usual, const PatternSizes& sizes,
                std::vector<PlacePattern>& all) {
  std::vector<PatternPlace> legs, others;
  const std::vector<std::string> leg_joints = effects::leg_scope().select(robot).joints,
                                 other_joints = effects::other_scope().select(robot).joints;
  for (const model::PlanarMotor& motor : robot.motors) {
    PatternMaker maker(joint_place(robot, motor, usual, sizes));
    add_joint_patterns(maker);
    add_all(maker, all);
    if (index_of(leg_joints, motor.joint) >= 0) legs.push_back(maker.at());
    if (index_of(other_joints, motor.joint) >= 0) others.push_back(maker.at());
  }
  add_group(legs, "legs", "legs", sizes.prior, all);
  const bool all_of_them = others.size() == robot.motors.size();
  add_group(others, "other", all_of_them ? "every_joint" : "other_joints", sizes.prior, all);
}

void add_body(const PlanarModel& robot, const UsualMotion& usual, const PatternSizes& sizes,
              std::vector<PlacePattern>& all) {
  const double weight = robot.total_mass() * robot.gravity;
  for (const std::string axis : {"x", "z", "pitch"}) {
    const int c = robot.coordinate_index(axis);
    if (c < 0) continue;
    PatternPlace place{"body", axis, base_place(robot)};
    const bool turns = axis == "pitch";
    place.force = turns ? "N m" : "N";
    place.metre = turns ? "rad" : "m";
    place.what = turns ? "moment on the body" : "force on the body along " + axis;
    place.large = sizes.prior * weight * (turns ? sizes.lever : 1.0);
    place.mass = sizes.prior * robot.total_mass();
    place.duration = usual.duration;
    place.speed = std::max(1e-3, usual.coordinates.speed[c]);
    place.start = usual.coordinates.start[c];
    place.range = usual.coordinates.range[c];
    PatternMaker maker(place);
    turns ? add_moment_patterns(maker) : add_body_patterns(maker, axis);
    add_all(maker, all);
  }
}

void add_feet(const PlanarModel& robot, const UsualMotion& usual, const PatternSizes& sizes,
              std::vector<PlacePattern>& all) {
  const double weight = robot.total_mass() * robot.gravity;
  const int x = robot.coordinate_index("x");
  for (const model::PlanarPoint& foot : robot.feet) {
    PatternPlace place{"feet", foot.name, "{point: " + foot.name + "}"};
    place.force = "N";
    place.metre = "m";
    place.what = "force at " + foot.name;
    place.large = sizes.prior * weight;
    place.speed = x < 0 ? 1.0 : std::max(1e-3, usual.coordinates.speed[x]);
    place.rest = sizes.rest_speed * place.speed;
    PatternMaker maker(place);
    add_foot_patterns(maker);
    add_all(maker, all);
  }
}

}  // namespace

std::string base_place(const PlanarModel& robot) {
  const model::PlanarBody& base = robot.bodies.front();
  return fmt::format("{{body: {}, point: [{:.6g}, {:.6g}]}}", base.name, base.com.x(),
                     base.com.y());
}

PatternShape period_shape(const std::string& unit, double period) {
  return {"period",
          unit,
          period,
          kWaveSpread * period,
          (1.0 - kWaveRange) * period,
          (1.0 + kWaveRange) * period};
}

PatternShape slack_shape(const std::string& unit, double slack, double range) {
  const double free = std::max(slack, kLeastSlack * range);
  return {"slack", unit, slack, kSlackSpread * free, 0.0, kSlackRange * free};
}

PatternShape width_shape(const std::string& unit, double width) {
  return {"width", unit, width, kWidthSpread * width, width / kWidthRange, kWidthRange * width};
}

std::vector<PlacePattern> place_patterns(const PlanarModel& robot, const UsualMotion& usual,
                                         const PatternSizes& sizes) {
  std::vector<PlacePattern> all;
  add_joints(robot, usual, sizes, all);
  add_body(robot, usual, sizes, all);
  add_feet(robot, usual, sizes, all);
  return all;
}

}  // namespace jaculus::diagnosis
