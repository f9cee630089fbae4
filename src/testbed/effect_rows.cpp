#include "testbed/effect_rows.h"

namespace jaculus::testbed {

std::vector<BenchEffect> bench_effects(const RobotFiles& robot) {
  EffectRows rows(robot);
  add_transmission(rows);
  add_friction(rows);
  add_actuation(rows);
  add_air(rows);
  add_masses(rows);
  add_contact(rows);
  add_sensing(rows);
  add_bias(rows);
  add_one_joint(rows);
  add_outside(rows);
  add_outside_anywhere(rows);
  add_pushes(rows);
  return rows.all;
}

std::vector<BenchEffect> bench_effects(const std::filesystem::path& robot_folder) {
  return bench_effects(read_robot_files(robot_folder));
}

}  // namespace jaculus::testbed
