#pragma once
// Tables of the report of a diagnosis.

#include "jaculus/diagnosis/diagnosis.h"
#include "report/document/document.h"

namespace jaculus::report {

/// A number for people; a dash where there is none.
std::string shown(double value, int digits = 4);

/// Effects with their parameters and intervals.
ReportTable parameter_table(const diagnosis::Diagnosis& d);

/// Shares of the held-out gap's energy by effect; without rows where none can be told.
ReportTable share_table(const diagnosis::Diagnosis& d);

/// Pushes, each with its place, time and peak; without rows where there were none.
ReportTable event_table(const diagnosis::Diagnosis& d);

/// Held-out errors in the channels' units, and whether they are within the user's tolerances.
ReportTable physical_table(const diagnosis::Diagnosis& d);

}  // namespace jaculus::report
