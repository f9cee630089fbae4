#pragma once
// The report of a diagnosis: hardware and model over time, where the gap lies, which effects cause
// it, how far the model shrinks it on held-out data, what the data can't say.

#include "jaculus/diagnosis/diagnose.h"
#include "jaculus/report/report.h"

namespace jaculus::report {

/// Charts and animation need diagnosis.problem; without it (data that could not be used) the report
/// says why.
Report diagnosis_report(const diagnosis::Diagnosis& diagnosis, const std::string& title);

}  // namespace jaculus::report
