#include "diagnosis/validation/subset_fit.h"

#include <algorithm>

namespace jaculus::diagnosis {

ModelFit fitted_subset(const Problem& problem, const Comparison& comparison,
                       const Posterior& posterior, const ModelFit& model,
                       const std::vector<int>& members) {
  if (members == model.candidates) return model;
  if (const ModelFit* known = posterior.find(members)) return *known;

  ModelFit less;
  less.candidates = members;
  Vector p = model.fit.p;
  for (const int c : model.candidates) {
    if (std::binary_search(members.begin(), members.end(), c)) continue;
    for (const int i : problem.hypotheses.candidates[c].parameters)
      p[i] = problem.hypotheses.parameters[i].nominal;
  }
  FitOptions options;
  options.scales = model.fit.scales;
  less.fit =
      fit_model(problem, comparison.whitening, problem.hypotheses.freed_by(members), {p}, options);
  less.log_prior =
      log_prior(members.size(), problem.hypotheses.candidates.size(), problem.settings);
  return less;
}

}  // namespace jaculus::diagnosis
