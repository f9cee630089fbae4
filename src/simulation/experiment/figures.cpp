// What a leap's trial amounts to.

#include "simulation/experiment/figures.h"

#include <cmath>
#include <set>

namespace jaculus::simulation {
namespace {

/// Linear between samples; NaN outside of them.
double value_at(const Simulation& s, const Eigen::Ref<const Eigen::RowVectorXd>& values,
                double time) {
  for (Eigen::Index k = 0; k + 1 < s.time.size(); ++k) {
    if (time < s.time[k] || time > s.time[k + 1]) continue;
    const double share = (time - s.time[k]) / (s.time[k + 1] - s.time[k]);
    return (1.0 - share) * values[k] + share * values[k + 1];
  }
  return kNaN;
}

/// When the last of the feet left the floor; contacts at the start are those of all feet.
std::optional<double> lift_off_time(const model::PlanarModel& model, const Simulation& s) {
  std::set<std::string> standing;
  for (const model::PlanarPoint& foot : model.feet) standing.insert(foot.name);
  for (const Event& event : s.events) {
    if (event.kind == EventKind::lift) standing.erase(event.what);
    if (event.kind == EventKind::land) standing.insert(event.what);
    if (event.kind == EventKind::lift && standing.empty()) return event.time;
  }
  return std::nullopt;
}

}  // namespace

LeapState state_at(const model::PlanarModel& model, const Simulation& s, double time,
                   const std::optional<double>& height) {
  const int x = model.coordinate_index("x"), z = model.coordinate_index("z"),
            pitch = model.coordinate_index("pitch");
  LeapState state;
  state.time = time;
  if (x >= 0) state.speed = value_at(s, s.v.row(x), time);
  if (pitch < 0) return state;
  state.pitch = value_at(s, s.q.row(pitch), time);
  if (z < 0 || !height) return state;
  // Free flight of the base with the legs and the pitch rate as they are: z + w t - g t^2/2 =
  // height, on the way down.
  const double w = value_at(s, s.v.row(z), time), above = value_at(s, s.q.row(z), time) - *height;
  const double root = w * w + 2.0 * model.gravity * above;
  if (root >= 0.0)
    state.landing_pitch =
        state.pitch + value_at(s, s.v.row(pitch), time) * (w + std::sqrt(root)) / model.gravity;
  return state;
}

LeapFigures leap_figures(const Experiment& experiment, const model::PlanarModel& model,
                         const TrialRun& run) {
  LeapFigures figures;
  figures.duration = command_duration(experiment.setup);

  if (const trajectory::Stream* mocap = run.trial.stream(trajectory::kMocapStream);
      mocap != nullptr && mocap->channel("x") >= 0) {
    figures.recipe =
        trajectory::leap_speed(mocap->time, mocap->values.row(mocap->channel("x")).transpose(),
                               Vector(), figures.duration);
    const int x = model.coordinate_index("x");
    Vector exact(mocap->time.size());
    for (Eigen::Index k = 0; k < exact.size(); ++k)
      exact[k] = value_at(run.truth, run.truth.q.row(x), std::max(0.0, mocap->time[k]));
    figures.recipe_exact = trajectory::leap_speed(mocap->time, exact, Vector(), figures.duration);
  }

  figures.plan_end = state_at(model, run.truth, figures.duration, experiment.touchdown_height);
  if (const auto time = lift_off_time(model, run.truth))
    figures.lift_off = state_at(model, run.truth, *time, experiment.touchdown_height);
  return figures;
}

}  // namespace jaculus::simulation
