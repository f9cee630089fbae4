#pragma once
// Multiple shooting: the model restarted from the measured state at the start of every window.
//
// The measured state at t0 is the model's own plus a correction from the mean residual over the
// trials. A parabola through each channel's residual within `state_half_width` of t0 gives its
// value and slope with their errors; dq, dv follow by weighted least squares from
//     channel rows:  value = C dq, slope = C dv (a velocity channel: value = C dv)
//     feet in stance by the model: J dq = 0, J dv = 0 (`foot_rests`, `foot_rests_rate`): with
//       motion capture alone they carry the legs
//     prior of what nothing measures: `unmeasured`, `unmeasured_rate`
// and is then put on the floor: feet in stance at height zero and without velocity. Error of a
// window: measured less what the restarted model gives. Its noise: that of the mean, plus the
// channel's restart value and slope carried on.
// Limits of validity: stance as the model has it; what no channel and no foot ties down keeps the
// model's state.

#include <vector>

#include "diagnosis/forward/plant_forward.h"
#include "diagnosis/localise/departure.h"
#include "diagnosis/localise/rows.h"

namespace jaculus::diagnosis {

/// Windows and phases of one dataset; `means` are its channels' mean residuals (one a channel of
/// the dataset, in order).
struct WindowAnswer {
  std::vector<RestartedWindow> windows;
  std::vector<PhaseShare> phases;
};
WindowAnswer restarted_windows(const ResidualRows& rows, const std::vector<DepartureChannel>& means,
                               const PlantForward& forward, const Vector& p,
                               const Settings& settings);

/// The robot's state by its sensors, the model's own where they say nothing.
struct MeasuredState {
  bool ok = false;
  Vector q, v;
  Matrix rate_covariance;   ///< of v
  std::vector<int> stance;  ///< feet on the floor, by the model
};
/// State at sample k of the model's run.
MeasuredState measured_state(const model::PlanarModel& model,
                             const std::vector<DepartureChannel>& means,
                             const simulation::Simulation& model_run, Eigen::Index k,
                             const Settings& settings);
/// d(position channels)/dq, a row a channel; zero rows of those which are none.
Matrix position_rows(const model::PlanarModel& model, const std::vector<DepartureChannel>& means);
/// Whether the position channels tie every coordinate down by themselves.
bool all_measured(const model::PlanarModel& model, const std::vector<DepartureChannel>& means);
/// The controller with its clock set on by t0 [s].
simulation::Controller controller_from(const simulation::Controller& controller, double t0);

/// State of the robot next to `q`, `v` with the feet `stance` on the floor and at rest; false where
/// that can't be had.
bool put_on_floor(const model::PlanarModel& model, const std::vector<int>& stance, Vector& q,
                  Vector& v);

}  // namespace jaculus::diagnosis
