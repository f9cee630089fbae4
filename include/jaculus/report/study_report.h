#pragma once
// The report of studies: their plots with the source's figures marked, the source's figures beside
// the computed ones, all rows.

#include <vector>

#include "jaculus/report/report.h"
#include "jaculus/studies/study.h"

namespace jaculus::report {

/// One section a study. Not empty.
Report study_report(const std::vector<studies::StudyResult>& studies);

}  // namespace jaculus::report
