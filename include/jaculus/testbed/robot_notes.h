#pragma once
// What the testbed takes of a robot's files that they don't say.

#include <filesystem>
#include <string>
#include <vector>

namespace jaculus::testbed {

/// A line each: which fixed links are left and right of one where names don't tell. InputError as
/// of anything that reads the robot.
std::vector<std::string> notes_on_robot(const std::filesystem::path& robot_folder);

}  // namespace jaculus::testbed
