#pragma once
// A report as JSON for its viewers (web/src, figures.py). Numbers of series and figures stand apart, in `arrays`: each is base64
// of little-endian single precision, and is referred to by its index; equal arrays (times, above all) are kept once.

#include <nlohmann/json.hpp>

#include "jaculus/report/report.h"

namespace jaculus {

nlohmann::ordered_json report_json(const Report& report);

}  // namespace jaculus
