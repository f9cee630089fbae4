#include "jaculus/report/version.h"

namespace jaculus {

std::string_view version() { return JACULUS_VERSION; }

}  // namespace jaculus
