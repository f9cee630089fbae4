#pragma once
// Reports that would grow too large.

#include "jaculus/report/report.h"

namespace jaculus {

/// The report with at most about `most` points a series: of each stretch of x its least and its largest value stay, so that no peak is
/// lost. A notice says so.
Report thinned(const Report& report, std::size_t most);

}  // namespace jaculus
