#pragma once
// The report of a preflight.

#include "jaculus/diagnosis/preflight.h"
#include "jaculus/report/report.h"

namespace jaculus::report {

Report preflight_report(const diagnosis::Preflight& preflight);

}  // namespace jaculus::report
