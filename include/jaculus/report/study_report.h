#pragma once
// The report of studies: their plots with the source's figures marked, the source's figures beside
// the computed ones, all rows. And what `jaculus study` prints of one.

#include <string>
#include <vector>

#include "jaculus/report/report.h"
#include "jaculus/studies/study.h"

namespace jaculus::report {

/// One section a study. Not empty.
Report study_report(const std::vector<studies::StudyResult>& studies);

/// A study for people: its first rows, and the source's figures beside the computed ones.
std::string study_text(const studies::StudyResult& result);

}  // namespace jaculus::report
