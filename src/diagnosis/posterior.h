#pragma once
// Posterior over fitted models; priors and form as selection.h says.

#include <cstddef>
#include <vector>

#include "jaculus/diagnosis/selection.h"

namespace jaculus {

/// Share of the log evidence that a model explains which every effect beyond the first must be worth, for its first one's form on
/// hardware may be another than the plant's.
constexpr double kFormMember = 0.01;

double log_prior(std::size_t members, std::size_t candidates);

/// log prior x evidence less form; -infinity for an invalid fit. `none`: log evidence of the model without effects.
double log_weight(const ModelFit& model, double none, double form_member = kFormMember);

/// Sets the probabilities of all models, and with them those of the selection; sorts them, most probable first. Structure counts
/// where it was tested.
void weigh(Selection& selection, double form_member = kFormMember);

/// The fitted model of some candidates; null where it was not fitted.
const ModelFit* find_model(const Selection& selection, const std::vector<int>& candidates);

/// The valid model of most prior x evidence, form aside; null where there is none.
const ModelFit* most_evident(const Selection& selection);

}  // namespace jaculus
