#pragma once

#include <string_view>

namespace jaculus {

/// Version of jaculus, as the project in CMakeLists.txt has it.
std::string_view version();

}  // namespace jaculus
