#pragma once
// From datasets to a verdict: where the gap lies, which effect causes it, how far it shrinks.
//
//   data -> forward -> noise -> selection -> validation -> verdict -> where, what to do next
//
// Each step is a function from values to a value (folders of src/diagnosis; docs/diagnosis.md has
// the formulas). The verdict is the first rule that applies of one ordered table
// (src/diagnosis/verdict/rules.cpp); constants that decide are settings (settings.h). Probabilities
// as stated are shares of right verdicts on blinded cases (src/diagnosis/verdict/calibration.cpp);
// `reasons` says what makes one doubtful.

#include <vector>

#include "jaculus/diagnosis/diagnosis.h"
#include "jaculus/diagnosis/options.h"
#include "jaculus/trajectory/dataset.h"

namespace jaculus::diagnosis {

/// Diagnoses one or several datasets of one robot. Bad files are InputErrors of those who read
/// them; a robot that lacks what a plan commands, an InputError here; everything numerical is in
/// the verdict.
Diagnosis diagnose(const std::vector<trajectory::Dataset>& datasets,
                   const DiagnoseOptions& options = {});

/// The held-out gap with all of options.effects fitted, whether the data speak for them or not:
/// what a diagnosis could have reached that knew them. Invalid where they can't be fitted.
HeldOut held_out_with(const std::vector<trajectory::Dataset>& datasets,
                      const DiagnoseOptions& options);

/// The same as diagnose for any problem, for models that are no plant. Robot-specific parts (where,
/// next, shown parameters) stay empty.
Diagnosis diagnose_problem(const Problem& problem, const DiagnoseOptions& options = {});

}  // namespace jaculus::diagnosis
