#pragma once
// What the testbed's experiments share: tables of commands, gains as stated, a robot's name.

#include <filesystem>
#include <string>

#include "jaculus/trajectory/dataset.h"
#include "testbed/robot_files.h"

namespace jaculus::testbed {

/// Adds a column or replaces it; `values` has the table's rows.
void set_column(trajectory::Table& table, const std::string& name, const std::string& unit,
                const Vector& values);

/// By which a dataset names a robot: one of models/ by its name, another by its place.
std::string robot_name(const std::filesystem::path& folder);

/// Feed-forward and PD in `quantity` on every motor, with the gains of a replay.
void state_gains(trajectory::Dataset& dataset, const RobotFiles& files,
                 trajectory::Quantity quantity);

}  // namespace jaculus::testbed
