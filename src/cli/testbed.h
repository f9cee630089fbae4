#pragma once
// What the testbed's commands share.

#include "cli/command.h"

namespace jaculus::cli {

// What plays where no --robot is given: plans with a tail, plans without one.
inline constexpr const char* kRobotWithTail = "minitaur_tail";
inline constexpr const char* kRobotWithoutTail = "minitaur";

/// InputError where this build can't play.
void need_mujoco();

void add_seal(CLI::App& parent, Action& chosen);

}  // namespace jaculus::cli
