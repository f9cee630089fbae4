#include "jaculus/model/tolerances.h"

#include <string>

namespace jaculus::model {

const std::vector<ToleranceKey>& tolerance_keys() {
  namespace d = dimension;
  using T = Tolerances;
  static const std::vector<ToleranceKey> keys = {
      {"mass", &T::mass, d::none, "of each link, share of it"},
      {"inertia", &T::inertia, d::none, "of each link about its centre of mass, share of it"},
      {"com", &T::com, d::length, "centre of mass of each link, along either axis"},
      {"length", &T::length, d::none, "from a joint to the next or to a foot, share of it"},
      {"torque_constant", &T::torque_constant, d::none, "of each motor, share of it"},
      {"resistance", &T::resistance, d::none, "of each motor, share of it"},
      {"joint_friction", &T::joint_friction, d::none,
       "dry, share of the largest torque at the joint"},
      {"encoder_zero", &T::encoder_zero, d::angle, "of each joint"},
      {"gain", &T::gain, d::none, "of each feedback gain, share of it"},
      {"floor_friction", &T::floor_friction, d::none, "share of the stated coefficient"},
      {"current_scale", &T::current_scale, d::none, "of logged current or torque, share of it"},
      {"current_filter", &T::current_filter, d::time,
       "low pass of logged current or torque, time constant"},
  };

  return keys;
}

Tolerances read_tolerances(const yaml::Node& robot) {
  Tolerances tolerances;
  const auto section = robot.find("tolerances");
  if (!section) return tolerances;

  std::vector<std::string> names;
  for (const ToleranceKey& key : tolerance_keys()) names.emplace_back(key.name);
  section->only(names);

  constexpr Bounds kAllowed{0.0, 0.5};
  for (const ToleranceKey& key : tolerance_keys()) {
    if (const auto value = section->find(std::string(key.name)))
      tolerances.*key.member = value->number(key.dimension, kAllowed);
  }

  return tolerances;
}

}  // namespace jaculus::model
