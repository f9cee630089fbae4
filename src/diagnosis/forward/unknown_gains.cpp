#include "diagnosis/forward/unknown_gains.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "diagnosis/forward/tolerance_directions.h"

namespace jaculus::diagnosis {
namespace {

using model::PlanarDrag;
using model::PlanarModel;
using model::PlanarMotor;
using trajectory::StatedController;
using trajectory::StatedGain;

bool is_tail(const PlanarModel& model, const std::string& joint) {
  const int motor = model.motor_index(joint);
  return motor >= 0 &&
         std::any_of(model.drags.begin(), model.drags.end(),
                     [&](const PlanarDrag& drag) { return drag.body == model.motors[motor].body; });
}

/// What the file states of a joint's gain; null where it says nothing.
const StatedGain* stated_gain(const std::map<std::string, StatedGain>& stated,
                              const std::string& joint) {
  auto found = stated.find(joint);
  if (found == stated.end()) found = stated.find("*");
  return found == stated.end() ? nullptr : &found->second;
}

bool gain_unknown(const std::map<std::string, StatedGain>& stated, bool any_stated,
                  const std::string& joint) {
  const StatedGain* gain = stated_gain(stated, joint);
  return gain == nullptr ? !any_stated : !gain->known();
}

/// A motor's torque as the quantity that the controller commands.
double unit_of_gain(const StatedController& controller, const PlanarMotor& motor,
                    const Settings& settings) {
  if (controller.quantity == trajectory::Quantity::torque) return 1.0;
  const double duty = 1.0 / settings.torque_of_duty;
  return controller.quantity == trajectory::Quantity::voltage
             ? duty * controller.bus_voltage.value_or(motor.voltage)
             : duty;
}

/// The factor of that name, which is added where there is none.
int add_factor(Hypotheses& hypotheses, const std::string& name, double spread, double widest) {
  const Bounds bounds{-widest * spread, widest * spread};
  for (const int i : hypotheses.gains)
    if (hypotheses.parameters[i].name == name) return i;
  hypotheses.gains.push_back(count_of(hypotheses.parameters));
  hypotheses.parameters.push_back({"nuisance", name, "-", 0.0, spread, bounds});
  return hypotheses.gains.back();
}

bool feedforward_unknown(const StatedController& stated, bool any_gain_unknown) {
  const bool duty = stated.quantity == trajectory::Quantity::duty;
  return !stated.gains_stated || (duty && any_gain_unknown);
}

/// What is open of some motors' gains.
struct OpenGains {
  bool derivative, tail, ranged;
  [[nodiscard]] std::string name() const {
    return std::string(ranged ? "range_" : "log_") + (derivative ? "kd" : "kp") +
           (tail ? "_tail" : "");
  }
};

bool has_range(const StatedGain* gain) {
  return gain != nullptr && std::isfinite(gain->range.upper) && gain->range.lower >= 0.0;
}

/// The motors of a controller's reference whose gain is open so, those of the tail or the others.
GainFactor open_motors(const ObservedDataset& observed, const simulation::Controller& controller,
                       const OpenGains& open) {
  const StatedController& stated = observed.dataset.controller;
  GainFactor factor{-1, {}, {}, open.derivative, {}};
  for (int m = 0; m < count_of(controller.reference.motors); ++m) {
    const std::string& joint = controller.reference.motors[m];
    const auto& gains = open.derivative ? stated.kd : stated.kp;
    const StatedGain* gain = stated_gain(gains, joint);
    if (is_tail(observed.model, joint) != open.tail || has_range(gain) != open.ranged ||
        !gain_unknown(gains, stated.gains_stated, joint))
      continue;
    factor.motors.push_back(m);
    if (open.ranged) factor.ranges.push_back(gain->range);
  }
  return factor;
}

bool same_gains(const std::map<std::string, StatedGain>& a,
                const std::map<std::string, StatedGain>& b) {
  const auto same = [](const auto& own, const auto& other) {
    return own.first == other.first && own.second.range.lower == other.second.range.lower &&
           own.second.range.upper == other.second.range.upper;
  };
  return a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin(), same);
}

}  // namespace

double share_of_range(double p) { return 0.5 * std::erfc(-p / std::numbers::sqrt2); }

bool same_controller(const StatedController& a, const StatedController& b) {
  return a.kind == b.kind && a.quantity == b.quantity && a.rate_hz == b.rate_hz &&
         a.gains_stated == b.gains_stated && a.bus_voltage == b.bus_voltage &&
         same_gains(a.kp, b.kp) && same_gains(a.kd, b.kd);
}

simulation::AssumedGains first_gains(const ObservedDataset& observed, const Settings& settings) {
  const StatedController& controller = observed.dataset.controller;
  simulation::AssumedGains gains;

  for (const PlanarMotor& motor : observed.model.motors) {
    const bool tail = is_tail(observed.model, motor.joint);
    const double unit = unit_of_gain(controller, motor, settings);
    gains.kp[motor.joint] = (tail ? settings.tail_kp : settings.leg_kp) * unit;
    gains.kd[motor.joint] = (tail ? settings.tail_kd : settings.leg_kd) * unit;

    for (const auto& [stated, into] :
         {std::pair(&controller.kp, &gains.kp), std::pair(&controller.kd, &gains.kd)}) {
      const StatedGain* gain = stated_gain(*stated, motor.joint);
      if (gain == nullptr) continue;
      double& first = (*into)[motor.joint];
      if (has_range(gain)) first = 0.5 * (gain->range.lower + gain->range.upper);
    }
  }

  return gains;
}

std::vector<GainFactor> add_gain_factors(const ObservedDataset& observed,
                                         const simulation::Controller& controller,
                                         const std::string& suffix, const Settings& settings,
                                         Hypotheses& hypotheses) {
  const StatedController& stated = observed.dataset.controller;
  if (stated.kind != trajectory::ControllerKind::feedforward_pd) return {};

  std::vector<GainFactor> factors;
  for (const bool derivative : {false, true}) {
    for (const bool tail : {false, true}) {
      for (const bool ranged : {false, true}) {
        const OpenGains open{derivative, tail, ranged};
        GainFactor factor = open_motors(observed, controller, open);
        if (factor.motors.empty()) continue;
        const double spread = ranged ? 1.0 : settings.gain_spread;
        const double widest = ranged ? kInfinity : settings.factor_bound;
        factor.parameter = add_factor(hypotheses, open.name() + suffix, spread, widest);
        factors.push_back(std::move(factor));
      }
    }
  }

  if (feedforward_unknown(stated, !factors.empty())) {
    const int parameter = add_factor(hypotheses, "log_feedforward" + suffix,
                                     settings.feedforward_spread, settings.factor_bound);
    factors.push_back({parameter, {}, {}, false, {}});
  }
  return factors;
}

std::vector<GainFactor> add_foreign_clock(const ObservedDataset& observed, bool several,
                                          const Settings& settings, Hypotheses& hypotheses) {
  if (observed.measured_input || !tracked_alone(observed)) return {};
  const double spread = settings.foreign_clock;
  const int parameter = count_of(hypotheses.parameters);
  hypotheses.gains.push_back(parameter);
  hypotheses.parameters.push_back({"nuisance",
                                   several ? "clock of " + observed.name() : "clock",
                                   "s",
                                   0.0,
                                   spread,
                                   {kWithin.lower * spread, kWithin.upper * spread}});
  return {{parameter, observed.streams, {}, false, {}}};
}

void apply_factors(const std::vector<GainFactor>& factors, const Vector& p,
                   simulation::Plant& plant, simulation::Controller& controller) {
  for (const GainFactor& factor : factors) {
    const double p_own = p[factor.parameter], scale = std::exp(p_own);
    for (const std::string& stream : factor.streams)
      plant.sensing.latency.try_emplace(stream, 0.0).first->second += p_own;
    if (!factor.streams.empty()) continue;
    if (factor.motors.empty()) plant.actuation.feedforward_scale *= scale;
    Vector& gains = factor.derivative ? controller.kd : controller.kp;
    for (std::size_t k = 0; k < factor.motors.size(); ++k) {
      double& gain = gains[factor.motors[k]];
      if (factor.ranges.empty()) {
        gain *= scale;
        continue;
      }
      const auto& [lower, upper] = factor.ranges[k];
      gain = lower + (upper - lower) * share_of_range(p_own);
    }
  }
}

}  // namespace jaculus::diagnosis
