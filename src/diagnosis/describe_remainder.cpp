#include "diagnosis/describe_remainder.h"

#include "diagnosis/build_problem.h"
#include "diagnosis/remainder/events.h"
#include "diagnosis/remainder/remainder.h"

namespace jaculus::diagnosis {
namespace {

constexpr int kAllWindows = 1'000'000;  // of a trial

/// The parameters of the model that is stated, in a problem about other windows of the same data.
Vector parameters_of(const Diagnosis& found, const Hypotheses& hypotheses) {
  const Vector& stated = names_effects(found.verdict) ? found.model.p : found.none.p;
  const std::vector<FreeParameter>& known = found.problem->hypotheses.parameters;
  Vector p = hypotheses.nominal();
  for (int i = 0; i < count_of(hypotheses.parameters); ++i) {
    const FreeParameter& own = hypotheses.parameters[i];
    for (int k = 0; k < count_of(known); ++k)
      if (own.owner != "force" && known[k].owner == own.owner && known[k].name == own.name)
        p[i] = stated[k];
  }
  return p;
}

/// The same options with windows of a box that follow one another over all of every trial.
DiagnoseOptions in_boxes(DiagnoseOptions options) {
  options.settings.windows = kAllWindows;
  options.settings.window_length = options.settings.force_box;
  options.settings.window_start_half_width = 0.5 * options.settings.force_box;
  return options;
}

}  // namespace

void describe_remainder(const std::vector<trajectory::Dataset>& datasets,
                        const DiagnoseOptions& options, Diagnosis& found) {
  if (found.problem == nullptr || found.none.p.size() == 0) return;
  set_share(found.gap, found.settings, found.remainder);
  if (!in_windows(*found.problem)) return;

  if (options.progress) options.progress("events");
  const BuiltProblem all = build_problem(datasets, in_boxes(options));
  if (!all.forward) return;
  const Vector p = parameters_of(found, all.problem->hypotheses);
  const std::vector<std::vector<MotionBox>> boxes = motion_boxes(*all.problem, *all.forward, p);
  for (ForceEvent& event : force_events(*all.problem, boxes)) found.events.push_back(event);

  if (options.progress) options.progress("what is left");
  found.remainder.places = described_places(*all.problem, boxes);
}

}  // namespace jaculus::diagnosis
