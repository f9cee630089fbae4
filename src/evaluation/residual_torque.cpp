#include "evaluation/residual_torque.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>

#include "diagnosis/localise/windows.h"
#include "effects/scope.h"
#include "jaculus/dynamics/rigid_body.h"

namespace jaculus::evaluation {
namespace {

using diagnosis::DepartureChannel;
using diagnosis::MeasuredState;
using diagnosis::SimulationSetup;
using model::PlanarModel;
using simulation::Simulation;

constexpr double kSignSmoothing = 0.1;  ///< of the sign of speed, as the plant's [rad/s]
constexpr int kMostSteps = 5000;        ///< of all segments; more tell a regression nothing new

/// One restart from a measured state to the next.
struct Restart {
  Vector force, deviation;  ///< a coordinate each, mean over the step
  Vector q, v, a;           ///< in the middle
  Vector command;           ///< a motor each, the model's torque there
};

/// A dataset's measured less predicted rows by the stamps as they are: aligned clocks would hide a
/// part of the torque, as a later command.
struct StampedRows {
  int dataset = 0;
  const diagnosis::ObservedDataset& observed;
  diagnosis::Alignment alignment;
  std::vector<diagnosis::RowSpan> spans;
  Vector residual;
};

StampedRows stamped_rows(const BaselineProblem& ready, int dataset) {
  const diagnosis::ObservedDataset& observed = ready.problem->observations.datasets[dataset];
  StampedRows rows{dataset, observed, unaligned(observed), row_spans(observed), {}};
  rows.residual =
      measured_rows(observed, rows.alignment) -
      predicted_rows(observed, rows.alignment, ready.noise.at_p.segments(observed, dataset));
  return rows;
}

/// Residuals of one segment as the smoother takes them: channels without noise are left out.
std::vector<DepartureChannel> residuals_of(const BaselineProblem& ready, const StampedRows& rows,
                                           int segment) {
  std::vector<DepartureChannel> channels;
  for (const diagnosis::RowSpan& span : rows.spans) {
    const diagnosis::ChannelNoise& noise =
        ready.noise.datasets[rows.dataset].channels[span.channel];
    if (span.segment != segment || !(noise.noise_floor > 0.0)) continue;
    const diagnosis::Channel& channel = rows.observed.channels[span.channel];
    const double origin = rows.alignment.origin(rows.observed, segment, span.channel);
    const Vector& stamps = rows.observed.segments[segment].time[span.channel];

    DepartureChannel one{channel.name, channel.zero_order_hold, {}, {}, {}, noise.inflation()};
    one.time = stamps.head(span.count).array() - origin;
    one.mean = rows.residual.segment(span.first, span.count);
    one.error = Vector::Constant(span.count, noise.noise_floor);
    channels.push_back(std::move(one));
  }
  return channels;
}

/// Whether the data say how fast every coordinate moves, rather than the smoother's prior.
bool rates_measured(const MeasuredState& state, const diagnosis::Settings& settings) {
  const double half = 0.5 * settings.unmeasured_rate;
  return state.ok && state.rate_covariance.diagonal().maxCoeff() < half * half;
}

/// The model from one measured state to the next; false where it can't run.
bool restart(SimulationSetup setup, double begin, double length, const MeasuredState& last,
             const MeasuredState& now, Restart& step) {
  setup.start = {last.q, last.v};
  setup.controller = diagnosis::controller_from(setup.controller, begin);
  setup.options.sample_times = Vector::LinSpaced(3, 0.0, length);
  setup.options.duration = length;
  const Simulation run = simulate(setup.plant, setup.controller, setup.start, setup.options);
  if (run.status != simulation::SimulationStatus::done || run.time.size() != 3 ||
      !run.v.allFinite())
    return false;

  const dynamics::AbsoluteTree tree(setup.plant.model);
  dynamics::Motion motion(tree);
  if (!set_configuration(tree, now.q, motion)) return false;
  const Matrix mass = mass_matrix(tree, motion);
  step.force = mass * (now.v - run.v.col(2)) / length;
  const Matrix covariance = last.rate_covariance + now.rate_covariance;
  step.deviation = (mass * covariance * mass).diagonal().cwiseMax(0.0).cwiseSqrt() / length;
  step.q = 0.5 * (last.q + now.q);
  step.v = 0.5 * (last.v + now.v);
  // The model's own acceleration: with the measured one, the equation of motion itself would be
  // a fit without remainder, measured acceleration less gravity and command.
  step.a = (run.v.col(2) - last.v) / length;
  step.command = run.torque.col(1);
  return true;
}

/// Steps of one segment, appended; false where not every coordinate is measured in it.
bool add_steps(const BaselineProblem& ready, const StampedRows& rows, int segment,
               std::vector<Restart>& steps) {
  const diagnosis::Settings& settings = ready.problem->settings;
  const SimulationSetup setup = ready.forward.setup(rows.dataset, segment, ready.noise.p);
  const std::vector<DepartureChannel> residuals = residuals_of(ready, rows, segment);
  if (!all_measured(setup.plant.model, residuals)) return false;
  const Simulation run = simulate(setup.plant, setup.controller, setup.start, setup.options);
  if (run.status != simulation::SimulationStatus::done || run.time.size() < 3) return true;

  const diagnosis::Segment& own = rows.observed.segments[segment];
  const double end =
      rows.observed.measured_input ? own.end() - own.start : rows.observed.window_end;
  const auto stride =
      std::max<Eigen::Index>(1, std::lround(settings.force_step / (run.time[1] - run.time[0])));
  MeasuredState last;
  for (Eigen::Index k = stride / 2; k < run.time.size() && run.time[k] <= end; k += stride) {
    const MeasuredState now = measured_state(setup.plant.model, residuals, run, k, settings);
    Restart step;
    if (rates_measured(last, settings) && rates_measured(now, settings) &&
        now.stance == last.stance &&
        restart(setup, run.time[k - stride], run.time[k] - run.time[k - stride], last, now, step))
      steps.push_back(std::move(step));
    last = now;
  }
  return true;
}

/// Absolute angle of a body in the middle of a step [rad].
double absolute_angle(const PlanarModel& model, int body, const Vector& q) {
  const Vector joints = model.joint_map * q + model.joint_offset;
  const int pitch = model.coordinate_index("pitch");
  double angle = pitch >= 0 ? q[pitch] : model.base_pose[2];
  for (int b = body; b > 0; b = model.bodies[b].parent) {
    const model::PlanarBody& own = model.bodies[b];
    angle += own.angle_offset;
    if (own.kind == model::JointKind::revolute) angle += own.sign * joints[b];
  }
  return angle;
}

/// Appends a step's row to a motor's joint.
void add_row(const PlanarModel& model, int motor, const Restart& step, Eigen::Index row,
             JointTorque& joint) {
  const int c = model.coordinate_index(model.motors[motor].joint);
  const double speed = step.v[c];
  const double angle = absolute_angle(model, model.motors[motor].body, step.q);
  joint.torque[row] = step.force[c];
  joint.deviation[row] = step.deviation[c];
  joint.library.row(row) << 1.0, std::tanh(speed / kSignSmoothing), speed, speed * speed * speed,
      step.a[c], std::sin(angle), std::cos(angle), step.command[motor];
}

/// Steps of all segments of a dataset; empty where a coordinate isn't measured.
std::vector<Restart> steps_of(const BaselineProblem& ready, int dataset) {
  const StampedRows rows = stamped_rows(ready, dataset);
  std::vector<Restart> steps;
  for (int s = 0; s < count_of(rows.observed.segments) && count_of(steps) < kMostSteps; ++s)
    if (!add_steps(ready, rows, s, steps)) return {};
  return steps;
}

void append(const PlanarModel& model, const std::vector<Restart>& steps,
            std::vector<JointTorque>& joints) {
  for (int m = 0; m < count_of(model.motors); ++m) {
    const std::string& name = model.motors[m].joint;
    if (model.coordinate_index(name) < 0) continue;
    auto own = std::find_if(joints.begin(), joints.end(),
                            [&](const JointTorque& j) { return j.joint == name; });
    if (own == joints.end()) {
      joints.push_back({name, {}, {}, Matrix(0, kTorqueTerms)});
      own = joints.end() - 1;
    }

    const Eigen::Index first = own->torque.size(), count = first + count_of(steps);
    own->torque.conservativeResize(count);
    own->deviation.conservativeResize(count);
    own->library.conservativeResize(count, kTorqueTerms);
    for (int i = 0; i < count_of(steps); ++i) add_row(model, m, steps[i], first + i, *own);
  }
}

}  // namespace

std::vector<JointTorque> residual_torques(const BaselineProblem& ready) {
  std::vector<JointTorque> joints;
  const auto& datasets = ready.problem->observations.datasets;
  for (int d = 0; d < count_of(datasets); ++d)
    if (const std::vector<Restart> steps = steps_of(ready, d); !steps.empty())
      append(datasets[d].model, steps, joints);
  return joints;
}

std::string effect_of_term(const diagnosis::Hypotheses& hypotheses, const PlanarModel& model,
                           const std::string& joint, TorqueTerm term) {
  const effects::JointScope* scope = nullptr;
  for (const effects::JointScope* one :
       {&effects::tail_scope(), &effects::leg_scope(), &effects::other_scope()}) {
    const std::vector<std::string> joints = one->select(model).joints;
    if (std::find(joints.begin(), joints.end(), joint) != joints.end()) scope = one;
  }
  if (scope == nullptr) return "";

  // The nearest first; a torque of its own that is constant or, off a tail, cubic has no entry.
  const std::map<TorqueTerm, std::vector<std::string>> table = {
      {TorqueTerm::constant, {}},
      {TorqueTerm::sign, {scope->prefix + "_coulomb_friction"}},
      {TorqueTerm::speed, {scope->prefix + "_viscous_friction"}},
      {TorqueTerm::speed_cubed, {scope->prefix == "tail" ? "drag_coefficient" : ""}},
      {TorqueTerm::acceleration, {scope->prefix + "_rotor_inertia"}},
      {TorqueTerm::sine, {scope->link_prefix + "_mass", "com_shift"}},
      {TorqueTerm::cosine, {scope->link_prefix + "_mass", "com_shift"}},
      {TorqueTerm::command, {"torque_constant"}}};
  for (const std::string& name : table.at(term))
    if (hypotheses.candidate(name) >= 0) return name;
  return "";
}

}  // namespace jaculus::evaluation
