#include "diagnosis/selection/moves.h"

#include <algorithm>
#include <utility>

#include "diagnosis/selection/neighbouring_sets.h"

namespace jaculus::diagnosis {

std::vector<LinearSet> Surroundings::judged(std::vector<Members> sets) const {
  std::erase_if(sets, [&](const Members& set) {
    return set.empty() || holds_twice(problem.hypotheses, set);
  });
  std::vector<LinearSet> out =
      linear_sets(problem, whitening, about.fit, about.candidates, probes, std::move(sets));
  std::stable_sort(out.begin(), out.end(), [&](const LinearSet& a, const LinearSet& b) {
    return weight(a.log_evidence, a.members) > weight(b.log_evidence, b.members);
  });
  return out;
}

std::vector<LinearSet> Surroundings::best_of(std::vector<Members> sets, const FittedModels& models,
                                             int count) const {
  std::erase_if(sets, [&](const Members& set) { return !models.to_fit(set); });
  std::vector<LinearSet> best = judged(std::move(sets));
  if (count_of(best) > count) best.resize(count);
  return best;
}

double Surroundings::weight(double log_evidence, const Members& members) const {
  return log_evidence + log_prior(members.size(), probes.size(), problem.settings);
}

bool enlarge(const Surroundings& near, int largest, FittedModels& models) {
  const Settings& settings = near.problem.settings;
  if (!near.about.candidates.empty() && !leaves_more(near.problem, near.about.fit)) return false;
  const std::vector<Members> sets =
      larger_sets(near.about.candidates, count_of(near.probes), largest);
  std::vector<LinearSet> best = near.best_of(sets, models, settings.kept_pairs);
  const auto first = best.begin() + std::min<std::ptrdiff_t>(2, std::ssize(best));
  models.fit_sets(near.about, {best.begin(), first}, near.probes);
  const double lead = models.value(*models.leading()) - models.value(near.about);
  if (lead < settings.clear_lead) models.fit_sets(near.about, {first, best.end()}, near.probes);
  return models.leading()->candidates != near.about.candidates;
}

std::vector<LinearSet> two_at_once(const Surroundings& near, int largest,
                                   const FittedModels& models) {
  const int one_more = count_of(near.about.candidates) + 1;
  if (one_more >= largest || !near.whitening.random.blocks.empty()) return {};
  std::vector<LinearSet> best =
      near.judged(larger_sets(near.about.candidates, count_of(near.probes), largest));
  const auto led = std::find_if(best.begin(), best.end(), [&](const LinearSet& set) {
    return count_of(set.members) == one_more;
  });
  best.erase(led, best.end());
  std::erase_if(best, [&](const LinearSet& set) { return !models.to_fit(set.members); });
  const int most = near.problem.settings.kept_pairs;
  if (count_of(best) > most) best.resize(most);
  return best;
}

void exchange_members(const Surroundings& near, FittedModels& models) {
  const Settings& settings = near.problem.settings;
  const double least = near.about.fit.log_evidence - settings.far_behind;
  std::vector<LinearSet> chosen;
  for (const int c : near.about.candidates) {
    const auto others = exchanged_sets(near.about.candidates, c, count_of(near.probes));
    for (const LinearSet& set : near.best_of(others, models, settings.kept_rivals))
      if (set.log_evidence >= least) chosen.push_back(set);
  }
  models.fit_sets(near.about, chosen, near.probes);
}

void part_members(const Surroundings& near, int largest, FittedModels& models) {
  const Hypotheses& hypotheses = near.problem.hypotheses;
  std::vector<Members> sets = parted_sets(hypotheses, near.about.candidates, largest);
  const std::vector<Members> plainer = plainer_sets(hypotheses, near.about.candidates);
  sets.insert(sets.end(), plainer.begin(), plainer.end());
  models.fit_sets(near.about, near.best_of(sets, models, count_of(sets)), near.probes);
}

}  // namespace jaculus::diagnosis
