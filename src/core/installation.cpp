#include "jaculus/core/installation.h"

namespace jaculus {

std::string_view version() { return JACULUS_VERSION; }
std::filesystem::path source_folder() { return JACULUS_SOURCE_DIR; }
std::filesystem::path share_folder() { return JACULUS_SHARE_DIR; }
std::filesystem::path built_web_folder() { return JACULUS_WEB_DIR; }

}  // namespace jaculus
