#pragma once
// The voltage that a plan's duty is a share of. A plan made for 7 V calls 7 V a duty of 1; a robot
// with 16 V on its bus that replays it has a duty of 7/16.
//
// With a motor's torque t before the gear, its current i = t (a + c t^2) and its rate w,
//     duty U = R i + k_t G w    =>    duty = (R/U) i + (1/U) k_t G w,
// two unknowns, R/U and 1/U, over all samples of all motors whose torque and rate the plan has. R
// is the plan's own, a warm winding's say, so that only k_t and the saturation are taken from the
// robot.

#include <filesystem>
#include <optional>

#include "jaculus/model/planar.h"
#include "jaculus/trajectory/csv.h"

namespace jaculus::simulation {

/// U [V]; nothing where the plan lacks a column, no joint moves, or its duty is not made of its
/// torques and rates by that law to within 1 % of the duty's size.
/// `file` stands for the plan in messages.
std::optional<double> plan_voltage(const trajectory::Table& plan, const model::PlanarModel& model,
                                   const std::filesystem::path& file);

}  // namespace jaculus::simulation
