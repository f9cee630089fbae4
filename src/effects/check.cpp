#include "jaculus/effects/check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "jaculus/core/units.h"
#include "jaculus/trajectory/quantity.h"

namespace jaculus::effects {

namespace {

constexpr int kMostIterations = 15;
constexpr double kDifference = 0.02;  ///< of the probing step, for slopes
constexpr double kEnough = 1e-3;      ///< of it, where the fit ends
constexpr double kTruth = 0.75;       ///< share of the probing step that is to come back
constexpr double kFades = 0.1;        ///< a 64th of the step may have this share of its influence
constexpr double kExact = 0.01;       ///< error without noise, of the departure from nominal
constexpr double kShown = 0.2;        ///< standard error from which data show too little, of it
constexpr double kErrors = 4.0;       ///< standard errors off, with noise

double rms(const Vector& v) { return std::sqrt(v.squaredNorm() / static_cast<double>(v.size())); }

/// Without all that is random.
simulation::Experiment exact(simulation::Experiment experiment) {
  experiment.scatter.clear();
  for (simulation::SensorStream& stream : experiment.streams) {
    stream.dropout = 0.0;
    stream.time_shift = {};
    for (auto& [channel, noise] : stream.noise) noise = 0.0;
  }
  return experiment;
}

/// What jumps where a command does: a sample at the jump falls on either side of it.
bool steps_with_commands(const std::string& channel) {
  using trajectory::Quantity;
  const Quantity quantity = trajectory::parse_channel(channel).quantity;
  return quantity != Quantity::position && quantity != Quantity::velocity;
}

Check check_nominal_data(const Vector& without, const Vector& with) {
  const bool same =
      without.size() == with.size() && std::equal(without.begin(), without.end(), with.begin());
  return {"nominal changes nothing",
          same ? fmt::format("bit for bit, {} samples", with.size()) : "samples differ", same};
}

Check check_fading(const std::vector<Influence>& list) {
  Check check{"fades to nothing", "rms in noises", true};
  double before = kInfinity;
  for (const Influence& influence : list) {
    check.found += fmt::format("{} {:.3g} at {:.3g}", &influence == &list.front() ? ":" : ",",
                               influence.size, influence.share);
    check.passed = check.passed && influence.size < std::max(before, 1e-9);
    before = influence.size;
  }
  check.passed =
      check.passed && list.front().size > 0.0 && list.back().size < kFades * list.front().size;
  if (!check.passed)
    check.found +=
        fmt::format("; each must be less than the one before, the last {:g} of the first", kFades);
  return check;
}

Check check_return(const std::string& what, const EffectParameter& p, const FirstParameter& fit,
                   double truth, double tolerance) {
  if (std::isnan(fit.value))
    return {what, "its simulations did not end, so that nothing was fitted", false};
  Check check{what,
              fmt::format("{} {:.4g} +- {:.2g}{}, true {:.4g}", p.name, fit.value, fit.deviation,
                          after_number(p.unit), truth),
              std::abs(fit.value - truth) <= tolerance};
  if (!check.passed)
    check.found += fmt::format(
        "; off by {:.2g}, allowed {:.2g}: perhaps the motion jumps with it, or several values look "
        "alike",
        std::abs(fit.value - truth), tolerance);
  return check;
}

}  // namespace

DataOf data_of(const simulation::Experiment& experiment, const Effect& effect) {
  const model::PlanarModel model = simulation::dataset_robot(experiment.setup).planar;
  const simulation::Plant plant = simulation::dataset_plant(experiment.setup, model);
  const simulation::Controller controller = simulation::experiment_controller(experiment, model);

  return [=, noiseless = exact(experiment)](const Vector& theta,
                                            std::string& why) -> std::optional<Vector> {
    simulation::Plant changed = plant;
    effect.apply(theta, changed);
    const simulation::TrialRun run =
        simulation::run_trial(noiseless, changed, controller, 0, noiseless.seed);
    if (run.truth.status != simulation::SimulationStatus::done) {
      why = fmt::format("{}: {}", simulation::status_name(run.truth.status), run.truth.message);
      return std::nullopt;
    }

    const auto counts = [&changed](const std::string& channel) {
      return !steps_with_commands(channel) || changed.sensing.laws.contains(channel);
    };
    std::vector<double> all;
    for (std::size_t s = 0; s < run.trial.streams.size(); ++s) {
      const trajectory::Stream& stream = run.trial.streams[s];
      for (int c = 0; c < count_of(stream.channels); ++c) {
        const auto noise = experiment.streams[s].noise.find(stream.channels[c]);
        if (noise == experiment.streams[s].noise.end() || !(noise->second > 0.0)) continue;
        if (!counts(stream.channels[c])) continue;
        for (const double value : stream.values.row(c)) all.push_back(value / noise->second);
      }
    }
    return Eigen::Map<const Vector>(all.data(), count_of(all));
  };
}

Vector part_of_step(const Effect& effect, double share, int parameter) {
  Vector theta = effect.nominal();
  theta[parameter] += share * (effect.probed()[parameter] - theta[parameter]);
  return theta;
}

std::vector<Influence> influences(const Effect& effect, const DataOf& data) {
  std::string why;
  const auto none = data(effect.nominal(), why);
  std::vector<Influence> list;
  for (const double share : {1.0, 1.0 / 4.0, 1.0 / 16.0, 1.0 / 64.0}) {
    const auto with = data(part_of_step(effect, share), why);
    list.push_back({share, none && with ? rms(*with - *none) : kNaN});
  }
  return list;
}

FirstParameter fit_first(const Effect& effect, const DataOf& data, const Vector& measured) {
  const Bounds bounds = effect.parameters[0].bounds;
  const double step = kDifference * (effect.probed()[0] - effect.nominal()[0]);
  // A simulation that ends early (events that cluster at one value) is a step too far, as in any
  // fit through simulation.
  const auto predicted = [&](double value) {
    Vector theta = effect.nominal();
    theta[0] = value;
    std::string why;
    return data(theta, why);
  };

  double value = effect.probed()[0];
  std::optional<Vector> at = predicted(value);
  Vector slope;
  for (int iteration = 0; at && iteration < kMostIterations; ++iteration) {
    const std::optional<Vector> beside = predicted(value - step);
    if (!beside) break;
    slope = (*beside - *at) / -step;
    const double wanted = slope.dot(measured - *at) / slope.squaredNorm();
    double move = std::clamp(value + wanted, bounds.lower, bounds.upper) - value;
    const auto better = [&](const std::optional<Vector>& y) {
      return y && (measured - *y).norm() <= (measured - *at).norm();
    };
    std::optional<Vector> next = predicted(value + move);
    while (std::abs(move) > 1e-5 * std::abs(step) && !better(next))
      next = predicted(value + (move *= 0.5));
    value += move;
    at = next;
    if (std::abs(move) < kEnough * std::abs(step)) break;
  }
  if (slope.size() == 0) return {};
  return {value, 1.0 / slope.norm()};
}

std::vector<Check> check_effect(const Effect& effect, const simulation::Experiment& experiment) {
  const DataOf data = data_of(experiment, effect);
  Effect nothing = effect;
  nothing.apply = [](const Vector&, simulation::Plant&) {};
  std::string why;
  const auto without = data_of(experiment, nothing)(effect.nominal(), why);
  const auto with = data(effect.nominal(), why);
  if (!without || !with) return {{"the experiment ends", why, false}};

  std::vector<Check> checks{check_nominal_data(*without, *with),
                            check_fading(influences(effect, data))};
  const Vector truth = part_of_step(effect, kTruth);
  std::optional<Vector> measured = data(truth, why);
  if (!measured) {
    checks.push_back({"simulated data give it back", why, false});
    return checks;
  }

  const EffectParameter& first = effect.parameters[0];
  const double departure = std::abs(truth[0] - first.nominal);
  checks.push_back(check_return("comes back without noise", first,
                                fit_first(effect, data, *measured), truth[0], kExact * departure));
  std::mt19937 random(7);
  std::normal_distribution<double> noise;
  for (double& value : *measured) value += noise(random);
  const FirstParameter noisy = fit_first(effect, data, *measured);
  checks.push_back(
      check_return("comes back with noise", first, noisy, truth[0], kErrors * noisy.deviation));
  checks.push_back({"the experiment shows enough of it",
                    fmt::format("standard error {:.2g} of the departure {:.3g} {}",
                                noisy.deviation / departure, departure, first.unit),
                    noisy.deviation < kShown * departure});

  for (int i = 1; i < count_of(effect.parameters); ++i) {
    const auto alone = data(part_of_step(effect, 1.0, i), why);
    const Vector others = effect.probed();
    Vector both = others;
    both[i] = effect.parameters[i].nominal;
    const auto with_all = data(others, why), without_it = data(both, why);
    const EffectParameter& p = effect.parameters[i];
    const bool ended = alone && with_all && without_it;
    checks.push_back({fmt::format("{} matters", p.name),
                      ended ? fmt::format("rms in noises: {:.3g} beside the others, {:.3g} alone",
                                          rms(*with_all - *without_it), rms(*alone - *with))
                            : why,
                      ended && rms(*with_all - *without_it) > 0.0});
  }
  return checks;
}

}  // namespace jaculus::effects
