#include "diagnosis/search_with_forces.h"

#include <algorithm>
#include <numeric>
#include <optional>

#include "diagnosis/established_forces.h"
#include "diagnosis/forward/prediction_memory.h"
#include "diagnosis/pattern_scan.h"
#include "diagnosis/pushed_windows.h"
#include "diagnosis/selection/push_scan.h"

namespace jaculus::diagnosis {
namespace {

/// A search on a part of the windows; nothing where that is more than half of them, so that it
/// doesn't pay, or where nothing can be fitted there.
std::optional<SearchResult> searched_in_part(const Prepared& prepared,
                                             const ProblemBuilder& rebuild,
                                             const DiagnoseOptions& options) {
  const Problem& problem = *prepared.built.problem;
  if (!prepared.built.forward || !in_windows(problem)) return {};
  Observations some = with_windows(problem.observations, problem.settings.search_windows);
  if (windows_of(problem.observations) < 2 * windows_of(some)) return {};

  const BuiltProblem part = rebuild(std::move(some));
  const std::vector<FreeParameter>& parameters = part.problem->hypotheses.parameters;
  if (parameters.size() != problem.hypotheses.parameters.size()) return {};
  NoiseModel noise = estimate_noise(*part.problem, part.problem->hypotheses.nominal());
  if (!noise.valid()) return {};
  Selection found = select_models(*part.problem, first_comparison(*part.problem, std::move(noise)),
                                  options.progress);
  if (found.search.models.empty()) return {};
  return std::move(found.search);
}

Selection selected(const Prepared& prepared, const DiagnoseOptions& options,
                   std::vector<ModelFit> known = {}) {
  const Problem& problem = *prepared.built.problem;
  return select_models(problem, first_comparison(problem, prepared.noise), options.progress,
                       std::move(known));
}

/// A search on a part of the windows where there are enough, else on all data.
struct FirstSearch {
  std::optional<SearchResult> part{};
  Selection whole{};  ///< no models where a part was searched

  [[nodiscard]] const SearchResult& found() const { return part ? *part : whole.search; }
};
FirstSearch first_search(const Prepared& prepared, const ProblemBuilder& rebuild,
                         const DiagnoseOptions& options) {
  if (auto part = searched_in_part(prepared, rebuild, options)) return {std::move(part), {}};
  return {{}, selected(prepared, options)};
}

/// Adds notes that are not there yet.
void add_new(std::vector<std::string> more, std::vector<std::string>& notes) {
  for (std::string& note : more)
    if (index_of(notes, note) < 0) notes.push_back(std::move(note));
}

/// Data with a first search of them.
struct FirstSearched {
  Prepared prepared;
  FirstSearch first;
};
/// The same beside pushes of one trial that a first search of windows tells of; nothing where it
/// tells of none, or nothing can be fitted beside them.
std::optional<FirstSearched> beside_pushes_of(const FirstSearched& known,
                                              const ProblemBuilder& rebuild,
                                              const DiagnoseOptions& options) {
  const Problem& problem = *known.prepared.built.problem;
  const SearchResult& found = known.first.found();
  if (!known.prepared.built.forward || !in_windows(problem) || found.models.empty()) return {};
  if (options.progress) options.progress("pushes in the windows");
  auto beside = beside_pushes(problem, leading(found), options);
  if (!beside) return {};

  FirstSearched again{prepare(rebuild(std::move(beside->observations)), rebuild), {}};
  if (!again.prepared.reasons.empty()) return {};
  again.first = first_search(again.prepared, rebuild, options);
  if (again.first.found().models.empty()) return {};
  std::vector<std::string> notes = known.prepared.notes;
  add_new(std::move(again.prepared.notes), notes);
  add_new(std::move(beside->notes), notes);
  again.prepared.notes = std::move(notes);
  return again;
}

/// The search among effects alone. Where it tells of pushes that one trial had, it is made again
/// beside these.
Searched search_among_effects(Prepared prepared, const ProblemBuilder& rebuild,
                              const DiagnoseOptions& options) {
  FirstSearched searched{std::move(prepared), {}};
  searched.first = first_search(searched.prepared, rebuild, options);
  if (auto again = beside_pushes_of(searched, rebuild, options)) searched = std::move(*again);
  auto& [data, first] = searched;
  if (!first.part) return {std::move(data), std::move(first.whole), {}};

  const Problem& all = *data.built.problem;
  Selection found = select_models_from(all, first_comparison(all, data.noise),
                                       std::move(*first.part), options.progress);
  return {std::move(data), std::move(found), {}};
}

/// Whether the leading model leaves more, or needs several effects: one force that no effect is may
/// be what these stand in for, however little they leave.
bool forces_sought(const Prepared& prepared, const Selection& selection) {
  const Problem& problem = *prepared.built.problem;
  if (!prepared.built.forward || in_windows(problem) || problem.observations.datasets.size() != 1 ||
      selection.search.models.empty())
    return false;
  const ModelFit& lead = leading(selection.search);
  return lead.candidates.size() > 1 || leaves_more(problem, lead.fit);
}

/// Adds pushes, of each coordinate the one that gains more.
void add_pushes(const std::vector<LikelyPush>& more, std::vector<LikelyPush>& pushes) {
  for (const LikelyPush& push : more) {
    const auto same = std::find_if(pushes.begin(), pushes.end(), [&](const LikelyPush& p) {
      return p.coordinate == push.coordinate;
    });
    if (same == pushes.end())
      pushes.push_back(push);
    else if (push.gain > same->gain)
      *same = push;
  }
}

/// The space about the model without effects, as the search had it or worked out here; nothing
/// where that model can't be fitted.
std::optional<Relinearised> about_no_effect(const Prepared& prepared, const Selection& found) {
  if (found.about_none) return found.about_none;
  const Problem& problem = *prepared.built.problem;
  return relinearise_about_none(problem, first_comparison(problem, prepared.noise), {});
}

/// Pushes that may have acted, as effects: about the model without effects, for a push may be what
/// makes an effect lead, and about the leading one, without whose effects their own misfit would
/// look like pushes.
std::vector<effects::Effect> likely_push_effects(const Prepared& prepared,
                                                 const Selection& effects_alone,
                                                 const DiagnoseOptions& options) {
  const Problem& problem = *prepared.built.problem;
  if (problem.settings.pushes_tried == 0) return {};
  DiagnoseOptions narrow = options;
  narrow.settings.force_box = scanned_box(problem);
  const BuiltProblem scanned = builder_of(narrow)(problem.observations);
  const int most = problem.settings.pushes_tried;

  std::vector<LikelyPush> likely;
  const ModelFit& leader = leading(effects_alone.search);
  if (!leader.candidates.empty())
    likely = likely_pushes(problem, *scanned.problem, effects_alone.comparison, leader.fit, most);
  if (const auto about = about_no_effect(prepared, effects_alone))
    add_pushes(likely_pushes(problem, *scanned.problem, about->comparison, about->fit, most),
               likely);

  std::vector<effects::Effect> pushes;
  const double duration = problem.observations.datasets.front().window_end;
  for (const LikelyPush& push : likely) pushes.push_back(push_effect(problem, push, duration));
  return pushes;
}

/// Patterns as candidates, and of how many they are the likeliest.
struct CandidatePatterns {
  std::vector<PlacePattern> patterns;
  int tried = 0;
};

/// Of one kind at one place the best about another model joins too: beside the wrong effects a wave
/// of another period may be the best, from which a fit doesn't come to the right one.
void add_patterns(const PatternScan& scan, CandidatePatterns& candidates) {
  candidates.tried = std::max(candidates.tried, scan.tried);
  for (const LikelyPattern& likely : scan.likely) {
    const bool known =
        std::any_of(candidates.patterns.begin(), candidates.patterns.end(),
                    [&](const PlacePattern& own) { return own.name == likely.pattern.name; });
    if (!known) candidates.patterns.push_back(likely.pattern);
  }
}

/// Forces of stated forms that may be at work: about the leading model, which may lack one, and
/// about the model without effects, for one may be what the effects stand in for.
CandidatePatterns candidate_patterns(const Prepared& prepared, const Selection& found) {
  const Problem& problem = *prepared.built.problem;
  CandidatePatterns patterns;
  if (problem.settings.patterns_tried == 0) return patterns;
  const std::vector<Alignment>& alignments = found.comparison.noise.alignments;
  const ModelFit& leader = leading(found.search);
  const ModelFit& none = found.search.models.front();
  add_patterns(likely_patterns({&problem, leader.candidates, leader.fit.p}, alignments), patterns);
  if (!leader.candidates.empty())
    add_patterns(likely_patterns({&problem, {}, none.fit.p}, alignments), patterns);
  return patterns;
}

/// The same data with these effects as candidates.
Prepared with_effects(const Prepared& prepared, std::vector<effects::Effect> effects) {
  const Problem& problem = *prepared.built.problem;
  Prepared out = prepared;
  out.built = builder_of(std::move(effects), problem.settings)(problem.observations);
  Problem among = *out.built.problem;
  among.forward = beside(among.forward, among.hypotheses, problem);
  out.built.problem = std::make_shared<const Problem>(std::move(among));
  out.noise = estimate_noise(*out.built.problem, out.built.problem->hypotheses.nominal(),
                             prepared.noise.alignments);
  return out;
}

/// The patterns of a search's leading model.
std::vector<PlacePattern> leading_patterns(const Problem& problem, const SearchResult& search,
                                           std::vector<PlacePattern> patterns) {
  const std::vector<int>& members = leading(search).candidates;
  std::erase_if(patterns, [&](const PlacePattern& pattern) {
    return std::none_of(members.begin(), members.end(), [&](int c) {
      return problem.hypotheses.candidates[c].name == pattern.name;
    });
  });
  return patterns;
}

/// Every effect that was asked for.
std::vector<effects::Effect> all_effects(const Problem& problem) {
  std::vector<int> all(problem.hypotheses.candidates.size());
  std::iota(all.begin(), all.end(), 0);
  return problem.hypotheses.effects_of(all);
}

/// The models that none leads clearly, the most probable first, in the parameters of a problem with
/// more candidates: what forces have to lead is the best that is known without them.
std::vector<ModelFit> known_models(const Problem& problem, const SearchResult& search,
                                   const Problem& more) {
  const double least = leading(search).log_weight() - problem.settings.clear_lead;
  std::vector<ModelFit> models;
  for (const ModelFit* own : most_probable_first(search.models)) {
    const ModelFit& model = *own;
    if (!model.fit.valid || model.candidates.empty() || model.log_weight() < least) continue;
    ModelFit carried;
    for (const int c : model.candidates)
      carried.candidates.push_back(
          more.hypotheses.candidate(problem.hypotheses.candidates[c].name));
    std::sort(carried.candidates.begin(), carried.candidates.end());
    carried.fit.p = carried_over({&problem, model.candidates, model.fit.p}, more.hypotheses);
    carried.fit.valid = carried.candidates.front() >= 0;
    models.push_back(std::move(carried));
  }
  return models;
}

}  // namespace

Searched search_with_forces(Prepared prepared, const ProblemBuilder& rebuild,
                            const DiagnoseOptions& options) {
  if (!prepared.reasons.empty()) return {std::move(prepared), {}, {}};
  Searched effects = search_among_effects(std::move(prepared), rebuild, options);
  if (!forces_sought(effects.prepared, effects.selection)) return effects;
  prepared = std::move(effects.prepared);
  Selection alone = std::move(effects.selection);

  if (options.progress) options.progress("pushes and forces of other forms");
  const Problem& problem = *prepared.built.problem;
  const std::vector<effects::Effect> pushes = likely_push_effects(prepared, alone, options);
  const CandidatePatterns likely = candidate_patterns(prepared, alone);
  if (pushes.empty() && likely.patterns.empty()) return {std::move(prepared), std::move(alone), {}};

  // Beside the whole catalogue: a pattern may do what an effect does that was not worth a fit.
  std::vector<effects::Effect> all = all_effects(problem);
  all.insert(all.end(), pushes.begin(), pushes.end());
  for (const PlacePattern& pattern : likely.patterns) all.push_back(pattern_effect(pattern));
  Prepared with = with_effects(prepared, std::move(all));
  const Problem& among = *with.built.problem;
  Selection found = selected(with, options, known_models(problem, alone.search, among));
  if (found.search.models.empty()) return {std::move(prepared), std::move(alone), {}};

  leave_out_unfounded(among, likely.tried, found);
  if (!among.hypotheses.beyond_effects(leading(found.search).candidates) ||
      !predicts_as_well({among, found}, {problem, alone}))
    return {std::move(prepared), std::move(alone), {}};
  std::vector<PlacePattern> patterns = leading_patterns(among, found.search, likely.patterns);
  return {std::move(with), std::move(found), std::move(patterns)};
}

}  // namespace jaculus::diagnosis
