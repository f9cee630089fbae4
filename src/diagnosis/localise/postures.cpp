#include "diagnosis/localise/postures.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <map>

#include "diagnosis/localise/rows.h"
#include "diagnosis/localise/windows.h"
#include "jaculus/dynamics/rigid_body.h"

namespace jaculus::diagnosis {
namespace {

using simulation::Simulation;
using simulation::SimulationStatus;

constexpr double kApart = 0.05;       // of the longest time, that pictures are apart at least
constexpr double kDetermined = 1e-6;  // of a coordinate's unit vector outside the rows measured

bool simulated(const Simulation& run) {
  return run.status == SimulationStatus::done && run.time.size() >= 3 && run.q.allFinite();
}

/// Linear between rows, on a grid that the smoother of windows.h finds enough of; what a row tells
/// is spread over them. Sparse rows would otherwise leave the model's state as if it were measured.
DepartureChannel densified(const DepartureChannel& rows, const Settings& settings) {
  const Eigen::Index count = rows.time.size();
  if (count < 2) return rows;
  const double span = rows.time[count - 1] - rows.time[0];
  const double step = settings.state_half_width / settings.state_rows_wanted;
  const auto dense = static_cast<Eigen::Index>(std::ceil(span / step)) + 1;
  if (dense <= count) return rows;

  DepartureChannel out = rows;
  out.time = Vector::LinSpaced(dense, rows.time[0], rows.time[count - 1]);
  out.mean.resize(dense);
  out.error.resize(dense);
  out.inflation *= static_cast<double>(dense) / static_cast<double>(count);
  Eigen::Index i = 0;
  for (Eigen::Index k = 0; k < dense; ++k) {
    while (i + 2 < count && rows.time[i + 1] < out.time[k]) ++i;
    const double share = (out.time[k] - rows.time[i]) / (rows.time[i + 1] - rows.time[i]);
    out.mean[k] = rows.mean[i] + share * (rows.mean[i + 1] - rows.mean[i]);
    out.error[k] = rows.error[i] + share * (rows.error[i + 1] - rows.error[i]);
  }
  return out;
}

/// Residuals of one segment as the smoother takes them: channels without noise are left out.
std::vector<DepartureChannel> residuals_of(const ResidualRows& rows, int segment,
                                           const Settings& settings) {
  std::vector<DepartureChannel> channels;
  for (const RowSpan& span : rows.spans) {
    const ChannelNoise& noise = rows.channels[span.channel];
    const Channel& channel = rows.observed.channels[span.channel];
    if (span.segment != segment || !(noise.noise_floor > 0.0)) continue;
    const double origin = rows.alignment.origin(rows.observed, segment, span.channel);

    DepartureChannel one{channel.name, channel.zero_order_hold, {}, {}, {}, noise.inflation()};
    one.time = rows.observed.segments[segment].time[span.channel].array() - origin;
    one.mean = rows.judged.segment(span.first, span.count);
    one.error = Vector::Constant(span.count, noise.noise_floor);
    channels.push_back(densified(one, settings));
  }
  return channels;
}

/// Mean square of a segment's residuals in noise floors.
double energy_of(const ResidualRows& rows, int segment) {
  double sum = 0.0, count = 0.0;
  for (const RowSpan& span : rows.spans) {
    const double floor = rows.channels[span.channel].noise_floor;
    if (span.segment != segment || !(floor > 0.0)) continue;
    sum += rows.judged.segment(span.first, span.count).squaredNorm() / (floor * floor);
    count += span.count;
  }
  return count > 0.0 ? sum / count : 0.0;
}

int telling_segment(const ResidualRows& rows) {
  int best = 0;
  if (!rows.observed.measured_input) return best;
  for (int s = 1; s < count_of(rows.observed.segments); ++s)
    if (energy_of(rows, s) > energy_of(rows, best)) best = s;
  return best;
}

/// Error of one segment over the model's clock, rms over channels in noise floors, in cells of the
/// coarsest spacing.
std::map<double, double> error_over_time(const std::vector<DepartureChannel>& residuals,
                                         const ResidualRows& rows) {
  double cell = rows.observed.measured_input ? 0.01 : 0.005;
  for (const Channel& channel : rows.observed.channels)
    if (std::isfinite(channel.spacing)) cell = std::max(cell, channel.spacing);

  std::map<long, std::pair<double, double>> sums;
  for (const DepartureChannel& one : residuals) {
    for (Eigen::Index k = 0; k < one.time.size(); ++k) {
      if (one.time[k] < 0.0) continue;
      auto& [sum, count] = sums[std::lround(std::floor(one.time[k] / cell))];
      sum += std::pow(one.mean[k] / one.error[k], 2);
      count += 1.0;
    }
  }
  std::map<double, double> errors;
  for (const auto& [index, sum] : sums)
    errors[(static_cast<double>(index) + 0.5) * cell] = std::sqrt(sum.first / sum.second);
  return errors;
}

struct TellingTime {
  double time = 0.0;
  std::string why;
};

std::vector<TellingTime> telling_times(const std::map<double, double>& errors,
                                       const Departure& departure) {
  std::vector<TellingTime> times;
  if (errors.empty()) return times;
  const auto largest =
      std::max_element(errors.begin(), errors.end(),
                       [](const auto& a, const auto& b) { return a.second < b.second; });
  const auto half = std::find_if(errors.begin(), errors.end(),
                                 [&](const auto& e) { return e.second >= 0.5 * largest->second; });

  const double apart = kApart * errors.rbegin()->first;
  const auto add = [&](double time, const std::string& why) {
    for (const TellingTime& other : times)
      if (std::abs(other.time - time) < apart) return;
    times.push_back({time, why});
  };
  add(largest->first, "largest error");
  add(half->first, "half of the largest error");
  if (departure.found) add(departure.time, "leaves the model");
  std::sort(times.begin(), times.end(),
            [](const TellingTime& a, const TellingTime& b) { return a.time < b.time; });
  return times;
}

/// The coordinates that position channels tie down by themselves.
std::vector<bool> known_coordinates(const model::PlanarModel& model,
                                    const std::vector<DepartureChannel>& residuals) {
  const Matrix rows = position_rows(model, residuals);
  const Matrix onto = rows.completeOrthogonalDecomposition().pseudoInverse() * rows;
  std::vector<bool> known;
  for (int i = 0; i < model.size(); ++i) {
    Vector left = -onto.col(i);
    left[i] += 1.0;
    known.push_back(left.norm() < kDetermined);
  }
  return known;
}

/// Impulses that the model lacks between measured states, over time.
struct MeanForce {
  Vector sum, variance;
  double count = 0.0;
};

void add_force(const SimulationSetup& nominal, double begin, double length,
               const MeasuredState& last, const MeasuredState& now, MeanForce& force) {
  SimulationSetup setup = nominal;
  setup.start = {last.q, last.v};
  setup.controller = controller_from(setup.controller, begin);
  setup.options.sample_times = Vector::LinSpaced(3, 0.0, length);
  setup.options.duration = length;
  const Simulation run = simulate(setup.plant, setup.controller, setup.start, setup.options);
  if (!simulated(run)) return;

  const dynamics::AbsoluteTree tree(setup.plant.model);
  dynamics::Motion motion(tree);
  if (!set_configuration(tree, now.q, motion)) return;
  const Matrix mass = mass_matrix(tree, motion);
  const Matrix covariance = last.rate_covariance + now.rate_covariance;
  force.sum += mass * (now.v - run.v.col(2)) / length;
  force.variance += (mass * covariance * mass).diagonal().cwiseMax(0.0) / (length * length);
  force.count += 1.0;
}

/// Puts the mean force about a time into a posture.
void set_force(const SimulationSetup& nominal, const std::vector<DepartureChannel>& residuals,
               const Simulation& run, const Settings& settings, Posture& posture) {
  const double grid = run.time[1] - run.time[0];
  const auto stride = std::max<Eigen::Index>(1, std::lround(settings.force_step / grid));
  const auto first = static_cast<Eigen::Index>(
      std::max(0.0, (posture.time - 0.5 * settings.posture_force - run.time[0]) / grid));
  const double end = posture.time + 0.5 * settings.posture_force;

  MeanForce force{Vector::Zero(nominal.plant.model.size()),
                  Vector::Zero(nominal.plant.model.size())};
  MeasuredState last;
  for (Eigen::Index k = first; k < run.time.size() && run.time[k] <= end; k += stride) {
    const MeasuredState now = measured_state(nominal.plant.model, residuals, run, k, settings);
    if (last.ok && now.ok && last.stance == now.stance)
      add_force(nominal, run.time[k - stride], run.time[k] - run.time[k - stride], last, now,
                force);
    last = now;
  }
  if (force.count == 0.0) return;
  posture.force = force.sum / force.count;
  posture.force_deviation = force.variance.cwiseSqrt() / force.count;
}

/// Predictions and nuisances at p, in the noise that the gap is judged by.
NoiseModel noise_about(const Problem& problem, const NoiseModel& judged, const Vector& p) {
  NoiseModel noise = estimate_noise(problem, p, judged.alignments);
  for (std::size_t d = 0; noise.valid() && d < noise.datasets.size(); ++d)
    noise.datasets[d].channels = judged.datasets[d].channels;
  return noise;
}

Simulation run_of(const SimulationSetup& setup) {
  return simulate(setup.plant, setup.controller, setup.start, setup.options);
}

Eigen::Index sample_at(const Simulation& run, double time) {
  const double grid = run.time[1] - run.time[0];
  return std::clamp<Eigen::Index>(std::lround((time - run.time[0]) / grid), 0, run.time.size() - 1);
}

}  // namespace

std::vector<Posture> postures_of(const Problem& problem, const PlantForward& forward,
                                 const NoiseModel& judged, const Vector& none, const Vector& model,
                                 const Departure& departure) {
  const NoiseModel of_none = noise_about(problem, judged, none);
  if (!of_none.valid()) return {};
  const ResidualRows nominal_rows = residual_rows(problem, of_none, 0);
  const int segment = telling_segment(nominal_rows);
  const std::map<double, double> errors =
      error_over_time(residuals_of(nominal_rows, segment, problem.settings), nominal_rows);

  // Clocks and starts are those that the judged model finds: the nominal one bends them.
  const NoiseModel of_model = noise_about(problem, judged, model);
  const NoiseModel& noise = of_model.valid() ? of_model : of_none;
  const ResidualRows rows = residual_rows(problem, noise, 0);
  const std::vector<DepartureChannel> residuals = residuals_of(rows, segment, problem.settings);

  const SimulationSetup setup = forward.setup(0, segment, none);
  const Simulation nominal = run_of(setup);
  const Simulation judged_run = run_of(forward.setup(0, segment, noise.p));
  if (!simulated(nominal) || !simulated(judged_run)) return {};

  const model::PlanarModel& robot = rows.observed.model;
  const std::vector<bool> known = known_coordinates(robot, residuals);
  const bool whole = std::all_of(known.begin(), known.end(), [](bool k) { return k; });
  std::vector<Posture> postures;
  for (const TellingTime& at : telling_times(errors, departure)) {
    const Eigen::Index k = sample_at(judged_run, at.time);
    const MeasuredState state =
        measured_state(setup.plant.model, residuals, judged_run, k, problem.settings);
    if (!state.ok) continue;
    Posture posture{0,       segment, judged_run.time[k],  at.why,
                    state.q, {},      judged_run.q.col(k), known};
    posture.nominal = nominal.q.col(sample_at(nominal, at.time));
    if (whole) set_force(setup, residuals, judged_run, problem.settings, posture);
    postures.push_back(std::move(posture));
  }
  return postures;
}

}  // namespace jaculus::diagnosis
