#pragma once
// The first thing to try with a robot that was imported: an experiment that needs no plan.

#include <filesystem>
#include <map>
#include <string>

#include "jaculus/model/robot.h"

namespace jaculus::cli {

/// Writes stand.yaml (a robot with feet, held at `rest` by joint PD for half a second), fall.yaml
/// (the same without feet) or swing.yaml (a robot on a fixed base, a tenth of each motor's torque)
/// beside it and returns its name; empty where nothing can be commanded.
std::string write_first_trial(const model::Robot& robot, const std::map<std::string, double>& rest,
                              const std::filesystem::path& folder);

}  // namespace jaculus::cli
