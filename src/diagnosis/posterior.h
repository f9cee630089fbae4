#pragma once
// Posterior over fitted models; priors and form as selection.h says.

#include <cstddef>

#include "jaculus/diagnosis/selection.h"

namespace jaculus {

/// Share of the log evidence that a model explains which every effect beyond the first must be worth, for its first one's form on
/// hardware may be another than the plant's.
constexpr double kFormMember = 0.01;

double log_prior(std::size_t members, std::size_t candidates);

/// log prior x evidence less form; -infinity for an invalid fit. `none`: log evidence of the model without effects.
double log_weight(const ModelFit& model, double none, double form_member = kFormMember);

/// Sets the probabilities of all models, and with them those of the selection; sorts them, most probable first. Structure of the leading
/// models must be known.
void weigh(Selection& selection, double form_member = kFormMember);

}  // namespace jaculus
