#pragma once
// From datasets to a problem in which models can be compared, and fits of given sets of effects in it.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "jaculus/diagnosis/diagnose.h"
#include "jaculus/diagnosis/forward.h"

namespace jaculus {

/// Datasets as a problem over options.effects (none named: the catalogue); no forward model where observation already found them
/// insufficient.
struct Posed {
  std::shared_ptr<DiagnosisProblem> problem = std::make_shared<DiagnosisProblem>();
  std::optional<PlantForward> forward;
};
Posed pose(const std::vector<Dataset>& datasets, const DiagnoseOptions& options);

/// Tells options.progress.
void tell(const DiagnoseOptions& options, const std::string& what);

/// Aligned, noise known, one-off disturbances cut; false where the data can't go on, with the reasons in `out`.
bool prepare(DiagnosisProblem& problem, Linearisation& about, const DiagnoseOptions& options, Diagnosis& out);

/// The space in which models are compared; condition-wide nuisances are fitted first, and everything is linearised about them.
EvidenceSpace compare_in(DiagnosisProblem& problem, Linearisation& about, const DiagnoseOptions& options);

/// Nuisances act differently once an effect is there (a shift on a tail that swings, the clocks by which an impact is dated):
/// everything is linearised about a leading model, which is fitted again from there until it stays.
void settle(DiagnosisProblem& problem, Fit& leader, Linearisation& about, EvidenceSpace& space);

/// All of some candidates fitted, one joining the others after another; p: where the rest stays.
Fit fit_members(const DiagnosisProblem& problem, const EvidenceSpace& space, const Vector& p,
                const std::vector<int>& members);

}  // namespace jaculus
