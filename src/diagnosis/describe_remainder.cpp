#include "diagnosis/describe_remainder.h"

#include "diagnosis/build_problem.h"
#include "diagnosis/remainder/box_states.h"
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

/// The problem over boxes that follow one another over all of every trial; without a forward model
/// where it can't be had.
BuiltProblem in_boxes(const std::vector<trajectory::Dataset>& datasets, DiagnoseOptions options,
                      double box) {
  options.settings.windows = kAllWindows;
  options.settings.window_length = box;
  options.settings.window_start_half_width = 0.5 * box;
  return build_problem(datasets, options);
}

std::vector<std::vector<MotionBox>> boxes_about(const Diagnosis& found, const BuiltProblem& all) {
  return motion_boxes(*all.problem, *all.forward, parameters_of(found, all.problem->hypotheses));
}

}  // namespace

void describe_remainder(const std::vector<trajectory::Dataset>& datasets,
                        const DiagnoseOptions& options, Diagnosis& found) {
  if (found.problem == nullptr || found.none.p.size() == 0) return;
  set_share(found.gap, found.settings, found.remainder);
  if (!in_windows(*found.problem)) return;

  if (options.progress) options.progress("events");
  const BuiltProblem all = in_boxes(datasets, options, options.settings.force_box);
  if (!all.forward) return;
  for (ForceEvent& event : force_events(*all.problem, boxes_about(found, all)))
    found.events.push_back(event);

  if (options.progress) options.progress("what is left");
  const double box = pattern_box(found.problem->observations.datasets, options.settings);
  const BuiltProblem fine = in_boxes(datasets, options, box);
  if (fine.forward)
    found.remainder.places = described_places(*fine.problem, boxes_about(found, fine));
}

}  // namespace jaculus::diagnosis
