#include "diagnosis/posterior.h"

#include <algorithm>
#include <cmath>

namespace jaculus {
namespace {

constexpr double kPriorNone = 0.5, kPriorSingle = 0.38, kPriorPair = 0.09, kPriorTriple = 0.02, kPriorUnknown = 1e-3;
constexpr double kFormLeft =
    0.025;  // share of what a model explains that its form may leave, before something unknown is at work

double explained(const ModelFit& model, double none) { return std::max(0.0, model.fit.log_evidence - none); }

}  // namespace

double log_prior(std::size_t members, std::size_t candidates) {
  const auto n = static_cast<double>(candidates);
  if (members == 0) return std::log(kPriorNone);
  if (members == 1) return std::log(kPriorSingle / n);
  if (members == 2) return std::log(kPriorPair / std::max(1.0, n * (n - 1.0) / 2.0));
  return std::log(kPriorTriple / std::max(1.0, n * (n - 1.0) * (n - 2.0) / 6.0));
}

double log_weight(const ModelFit& model, double none, double form_member) {
  if (!model.fit.valid) return -kInfinity;
  const double further = model.candidates.empty() ? 0.0 : static_cast<double>(model.candidates.size() - 1);
  return model.log_prior + model.fit.log_evidence - form_member * further * explained(model, none);
}

void weigh(Selection& selection, double form_member) {
  auto& models = selection.models;
  const ModelFit* without = find_model(selection, {});
  const double none = without == nullptr ? 0.0 : without->fit.log_evidence;
  const auto known = [&](const ModelFit& m) { return log_weight(m, none, form_member); };
  const auto unknown = [&](const ModelFit& m) {
    return known(m) + std::log(kPriorUnknown) + m.structure - kFormLeft * explained(m, none);
  };
  double largest = -kInfinity;
  for (const ModelFit& m : models) largest = std::max({largest, known(m), unknown(m)});
  double sum = 0.0;
  for (ModelFit& m : models) {
    m.probability = std::exp(known(m) - largest);
    m.unknown_probability = std::exp(unknown(m) - largest);
    sum += m.probability + m.unknown_probability;
  }
  selection.involved.assign(selection.probes.size(), 0.0);
  selection.none = selection.unexplained = 0.0;
  for (ModelFit& m : models) {
    m.probability /= sum;
    m.unknown_probability /= sum;
    selection.unexplained += m.unknown_probability;
    if (m.candidates.empty()) selection.none += m.probability;
    for (const int c : m.candidates) selection.involved[static_cast<std::size_t>(c)] += m.probability;
  }
  std::stable_sort(models.begin(), models.end(), [](const ModelFit& a, const ModelFit& b) {
    return std::max(a.probability, a.unknown_probability) > std::max(b.probability, b.unknown_probability);
  });
}

const ModelFit* find_model(const Selection& selection, const std::vector<int>& candidates) {
  for (const ModelFit& model : selection.models)
    if (model.candidates == candidates && model.fit.valid) return &model;
  return nullptr;
}

const ModelFit* most_evident(const Selection& selection) {
  const ModelFit* best = nullptr;
  for (const ModelFit& model : selection.models)
    if (model.fit.valid &&
        (best == nullptr || model.log_prior + model.fit.log_evidence > best->log_prior + best->fit.log_evidence))
      best = &model;
  return best;
}

}  // namespace jaculus
