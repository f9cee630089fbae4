#include "diagnosis/localise/windows.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <random>

#include "diagnosis/forward/grid_simulation.h"
#include "jaculus/dynamics/rigid_body.h"

namespace jaculus::diagnosis {
namespace {

using dynamics::AbsoluteTree;
using dynamics::Motion;
using model::PlanarModel;
using simulation::Controller;
using simulation::Simulation;
using simulation::SimulationStatus;
using trajectory::Table;

constexpr std::uint64_t kSeed = 1;

/// Value and slope of a mean residual at t with their variances.
struct LocalFit {
  bool ok = false;
  double value = 0.0, slope = 0.0, value_variance = 0.0, slope_variance = 0.0;
};

LocalFit local_fit(const DepartureChannel& mean, double t, const Settings& settings) {
  const double half_width = settings.state_half_width;
  const auto counted = [](int rows) { return static_cast<std::size_t>(rows); };
  std::vector<Eigen::Index> near;
  double width = half_width;
  for (int widen = 0; widen < 2 && near.size() < counted(settings.state_rows_wanted);
       ++widen, width *= 2.0) {
    near.clear();
    for (Eigen::Index k = 0; k < mean.time.size(); ++k)
      if (std::abs(mean.time[k] - t) <= width) near.push_back(k);
  }

  LocalFit fit;
  if (near.size() < counted(settings.state_rows)) return fit;
  const int powers = near.size() < counted(settings.state_rows_parabola) ? 2 : 3;
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const Eigen::Index k : near) {
    const double s = (mean.time[k] - t) / half_width, w = 1.0 / (mean.error[k] * mean.error[k]);
    const Eigen::Vector3d row(1.0, s, powers == 3 ? s * s : 0.0);
    normal += w * row * row.transpose();
    right += w * mean.mean[k] * row;
  }

  if (powers == 2) normal(2, 2) = 1.0;
  const Eigen::LLT<Eigen::Matrix3d> factor(normal);
  if (factor.info() != Eigen::Success) return fit;
  const Eigen::Vector3d solution = factor.solve(right);
  const Eigen::Matrix3d covariance = factor.solve(Eigen::Matrix3d::Identity());
  return {true, solution[0], solution[1] / half_width, mean.inflation * covariance(0, 0),
          mean.inflation * covariance(1, 1) / (half_width * half_width)};
}

/// Row of dq (or dv, where `rate`) that a channel measures; empty where it measures neither.
Vector channel_row(const PlanarModel& model, const std::string& name, bool& rate) {
  const trajectory::ChannelName parts = trajectory::parse_channel(name);
  rate = parts.quantity == trajectory::Quantity::velocity;
  std::string base = rate ? parts.of : name;
  if (base == "imu_pitch") base = "pitch";
  Vector row = Vector::Zero(model.size());
  if (const int coordinate = model.coordinate_index(base); coordinate >= 0) {
    row[coordinate] = 1.0;
    return row;
  }
  const int body = model.body_of_joint(base);
  if (body < 0) return {};
  row = model.joint_map.row(body).transpose();
  return row.isZero() ? Vector() : row;
}

void add_row(const Vector& row, double value, double deviation, Matrix& normal, Vector& right) {
  normal += row * row.transpose() / (deviation * deviation);
  right += row * value / (deviation * deviation);
}

/// Correction of the model's state at t.
void correct(const PlanarModel& model, const std::vector<DepartureChannel>& means, double t,
             const Matrix& foot_rows, const Settings& settings, MeasuredState& state) {
  const double wide = settings.unmeasured, wide_rate = settings.unmeasured_rate;
  const auto n = state.q.size();
  Matrix normal_q = Matrix::Identity(n, n) / (wide * wide),
         normal_v = Matrix::Identity(n, n) / (wide_rate * wide_rate);
  Vector right_q = Vector::Zero(n), right_v = Vector::Zero(n);
  for (const DepartureChannel& mean : means) {
    bool rate = false;
    const Vector row = channel_row(model, mean.name, rate);
    const LocalFit fit = row.size() > 0 ? local_fit(mean, t, settings) : LocalFit{};
    if (!fit.ok) continue;
    if (rate) {
      add_row(row, fit.value, std::sqrt(fit.value_variance), normal_v, right_v);
    } else {
      add_row(row, fit.value, std::sqrt(fit.value_variance), normal_q, right_q);
      add_row(row, fit.slope, std::sqrt(fit.slope_variance), normal_v, right_v);
    }
  }

  for (Eigen::Index f = 0; f < foot_rows.rows(); ++f) {
    add_row(foot_rows.row(f).transpose(), 0.0, settings.foot_rests, normal_q, right_q);
    add_row(foot_rows.row(f).transpose(), 0.0, settings.foot_rests_rate, normal_v, right_v);
  }

  const Eigen::LDLT<Matrix> factor(normal_v);
  state.q += normal_q.ldlt().solve(right_q);
  state.v += factor.solve(right_v);
  state.rate_covariance = factor.solve(Matrix::Identity(n, n));
}

/// Phase of the plan at a time; empty where it states none.
std::string phase_at(const ObservedDataset& observed, double t) {
  if (!observed.dataset.plan) return "";
  const Table& plan = *observed.dataset.plan;
  const int time = plan.column("time");
  if (time < 0 || plan.phase.empty()) return "";
  std::string phase;
  for (Eigen::Index k = 0; k < plan.values.rows(); ++k)
    if (plan.values(k, time) <= t + 1e-9) phase = plan.phase[k];
  return phase;
}

/// Energies of one sample of one channel, in noise floors.
struct SampleError {
  double time = 0.0, error = 0.0, noise = 0.0, free_run = 0.0, weight = 1.0;
};

/// Errors of a restarted simulation in every channel within [t0, t1).
std::vector<SampleError> errors_of(const ResidualRows& rows,
                                   const std::vector<DepartureChannel>& means,
                                   const Prediction& restarted, double t0, double t1,
                                   const Settings& settings) {
  std::vector<SampleError> errors;
  for (int c = 0; c < count_of(means); ++c) {
    const Channel& channel = rows.observed.channels[c];
    const ChannelNoise& noise_of = rows.channels[c];
    if (!(noise_of.noise_floor > 0.0) || channel.zero_order_hold) continue;
    const LocalFit start = local_fit(means[c], t0, settings);
    if (!start.ok) continue;
    for (Eigen::Index k = 0; k < means[c].time.size(); ++k) {
      const double t = means[c].time[k];
      if (t < t0 || t >= t1) continue;
      const double moved = restarted.at(c, t - t0) - rows.predictions.front()->at(c, t);
      const double noise = std::pow(means[c].error[k], 2) + start.value_variance +
                           (means[c].rate ? 0.0 : start.slope_variance * (t - t0) * (t - t0));
      const double floor = noise_of.noise_floor;
      errors.push_back({t, std::pow((means[c].mean[k] - moved) / floor, 2), noise / (floor * floor),
                        std::pow(means[c].mean[k] / floor, 2), 1.0 / noise_of.inflation()});
    }
  }

  return errors;
}

void add_phases(const ResidualRows& rows, const std::vector<SampleError>& errors, double begin,
                double end, std::uint64_t seed, std::vector<PhaseShare>& phases) {
  struct Sum {
    double error = 0.0, noise = 0.0, effective = 0.0;
    int count = 0;
  };

  std::vector<Sum> sums;
  for (const SampleError& e : errors) {
    std::string name = phase_at(rows.observed, e.time);
    double from = begin, to = end;
    if (name.empty()) {
      const double length = (end - begin) / 4.0;
      const double part = std::clamp(std::floor((e.time - begin) / length), 0.0, 3.0);
      from = begin + part * length;
      to = from + length;
      name = fmt::format("{:.3f} s to {:.3f} s", from, to);
    }
    auto same = std::find_if(phases.begin(), phases.end(),
                             [&](const PhaseShare& p) { return p.name == name; });
    if (same == phases.end()) {
      phases.push_back({name, from, to, 0.0, {0.0, 1.0}});
      if (!phase_at(rows.observed, e.time).empty())
        phases.back().start = phases.back().end = e.time;
      sums.emplace_back();
      same = phases.end() - 1;
    }
    Sum& sum = sums[same - phases.begin()];
    same->start = std::min(same->start, e.time);
    same->end = std::max(same->end, e.time);
    sum.error += e.error;
    sum.noise += e.noise;
    sum.effective += e.weight;
    ++sum.count;
  }

  // chi2-like sums: a phase's excess has the deviation of a squared normal sum with its effective
  // number of samples.
  std::mt19937_64 generator(seed);
  std::normal_distribution<double> normal;
  constexpr int kDraws = 2000;
  Matrix shares = Matrix::Zero(kDraws + 1, count_of(phases));
  for (int d = 0; d <= kDraws; ++d) {
    for (int i = 0; i < count_of(sums); ++i) {
      const double inflation = sums[i].count / std::max(1e-9, sums[i].effective);
      const double excess = std::max(0.0, sums[i].error - sums[i].noise);
      const double noise = sums[i].noise / std::max(1, sums[i].count);
      const double deviation = std::sqrt((2.0 * sums[i].noise + 4.0 * excess) * noise * inflation);
      shares(d, i) = std::max(
          0.0, sums[i].error - sums[i].noise + (d == 0 ? 0.0 : deviation * normal(generator)));
    }
    if (const double total = shares.row(d).sum(); total > 0.0) shares.row(d) /= total;
  }

  for (int i = 0; i < count_of(phases); ++i) {
    const auto col = i;
    phases[i].share = shares(0, col);
    std::vector<double> draws(shares.col(col).begin() + 1, shares.col(col).end());
    std::sort(draws.begin(), draws.end());
    phases[i].ci95 = {draws[kDraws / 40], draws[kDraws - kDraws / 40]};
  }
}

double rms(const std::vector<SampleError>& errors, double SampleError::*field) {
  double sum = 0.0;
  for (const SampleError& e : errors) sum += e.*field;
  return errors.empty() ? kNaN : std::sqrt(sum / static_cast<double>(errors.size()));
}

/// Errors of one window, of the model restarted at its start; empty where that fails.
std::vector<SampleError> run_window(const ResidualRows& rows,
                                    const std::vector<DepartureChannel>& means,
                                    const SimulationSetup& setup, const Simulation& model_run,
                                    const Settings& settings, double t1, double& t0) {
  const double step = model_run.time[1] - model_run.time[0];
  const auto k = std::clamp<Eigen::Index>(std::lround((t0 - model_run.time[0]) / step), 0,
                                          model_run.time.size() - 1);
  t0 = model_run.time[k];
  SimulationSetup window = setup;
  window.start = {model_run.q.col(k), model_run.v.col(k)};
  if (k > 0) {  // at the command's start the trial's own start is known better than any fit
    const MeasuredState state = measured_state(setup.plant.model, means, model_run, k, settings);
    if (!state.ok) return {};
    window.start = {state.q, state.v};
  }

  window.controller = controller_from(setup.controller, t0);
  const auto points = static_cast<Eigen::Index>(std::ceil((t1 - t0) * 1e3)) + 2;
  window.options.sample_times =
      Vector::LinSpaced(points, 0.0, 1e-3 * static_cast<double>(points - 1));
  window.options.duration = window.options.sample_times[points - 1];
  const Simulation restarted =
      simulate_on_grid(window.plant, window.controller, window.start, window.options);
  if (restarted.status != SimulationStatus::done || restarted.time.size() != points) return {};

  return errors_of(rows, means, prediction_of(rows.observed, window.plant, restarted), t0, t1,
                   settings);
}

}  // namespace

Controller controller_from(const Controller& controller, double t0) {
  Controller shifted = controller;
  shifted.reference.time.array() -= t0;
  shifted.reference.duration -= t0;
  return shifted;
}

Matrix position_rows(const PlanarModel& model, const std::vector<DepartureChannel>& means) {
  Matrix rows(count_of(means), model.size());
  rows.setZero();
  for (int c = 0; c < count_of(means); ++c) {
    bool rate = false;
    const Vector row = channel_row(model, means[c].name, rate);
    if (row.size() > 0 && !rate) rows.row(c) = row.transpose();
  }
  return rows;
}

bool all_measured(const PlanarModel& model, const std::vector<DepartureChannel>& means) {
  return position_rows(model, means).colPivHouseholderQr().rank() == model.size();
}

MeasuredState measured_state(const PlanarModel& model, const std::vector<DepartureChannel>& means,
                             const Simulation& model_run, Eigen::Index k,
                             const Settings& settings) {
  MeasuredState state;
  state.q = model_run.q.col(k);
  state.v = model_run.v.col(k);
  for (int f = 0; f < count_of(model.feet); ++f)
    if (model_run.force(2 * f + 1, k) > settings.stance_load) state.stance.push_back(f);
  const AbsoluteTree tree(model);
  Motion motion(tree);
  if (!set_configuration(tree, state.q, motion)) return state;
  correct(model, means, model_run.time[k], foot_jacobian(tree, motion, state.stance), settings,
          state);
  state.ok = put_on_floor(model, state.stance, state.q, state.v);
  return state;
}

bool put_on_floor(const PlanarModel& model, const std::vector<int>& stance, Vector& q, Vector& v) {
  const AbsoluteTree tree(model);
  Motion motion(tree);

  for (int round = 0; round < 10; ++round) {
    if (!set_configuration(tree, q, motion)) return false;
    if (stance.empty()) return true;
    const Matrix J = foot_jacobian(tree, motion, stance);
    Vector height(count_of(stance));
    Matrix rows(height.size(), q.size());
    for (Eigen::Index f = 0; f < height.size(); ++f) {
      height[f] = foot_position(tree, motion, stance[f]).y();
      rows.row(f) = J.row(2 * f + 1);
    }
    if (height.cwiseAbs().maxCoeff() < 1e-9) {
      v -= J.completeOrthogonalDecomposition().solve(J * v);
      return q.allFinite() && v.allFinite();
    }
    q -= rows.completeOrthogonalDecomposition().solve(height);
  }

  return false;
}

WindowAnswer restarted_windows(const ResidualRows& rows, const std::vector<DepartureChannel>& means,
                               const PlantForward& forward, const Vector& p,
                               const Settings& settings) {
  const int windows = settings.restarts;
  WindowAnswer answer;
  const SimulationSetup setup = forward.setup(rows.dataset, 0, p);
  const Simulation model_run = simulate(setup.plant, setup.controller, setup.start, setup.options);
  if (model_run.status != SimulationStatus::done || model_run.time.size() < 3) return answer;

  const double end = std::min(rows.observed.window_end, model_run.time[model_run.time.size() - 1]);
  std::vector<SampleError> all;
  for (int w = 0; w < windows; ++w) {
    RestartedWindow window;
    window.start = end * w / windows;
    window.end = end * (w + 1) / windows;
    const std::vector<SampleError> errors =
        run_window(rows, means, setup, model_run, settings, window.end, window.start);
    window.phase = phase_at(rows.observed, window.start);
    window.done = !errors.empty();
    window.error = rms(errors, &SampleError::error);
    window.noise = rms(errors, &SampleError::noise);
    window.free_run = rms(errors, &SampleError::free_run);
    all.insert(all.end(), errors.begin(), errors.end());
    answer.windows.push_back(window);
  }

  add_phases(rows, all, 0.0, end, kSeed, answer.phases);
  return answer;
}

}  // namespace jaculus::diagnosis
