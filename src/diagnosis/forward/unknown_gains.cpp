#include "diagnosis/forward/unknown_gains.h"

#include <algorithm>
#include <cmath>
#include <map>

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

int add_factor(Hypotheses& hypotheses, const std::string& name, double spread, double bound) {
  const Bounds bounds{-bound * spread, bound * spread};
  hypotheses.nuisances.push_back(count_of(hypotheses.parameters));
  hypotheses.parameters.push_back({"nuisance", name, "-", 0.0, spread, bounds});
  return hypotheses.nuisances.back();
}

/// The motors of a controller's reference whose gain is unknown, those of the tail or the others.
std::vector<int> unknown_motors(const ObservedDataset& observed,
                                const simulation::Controller& controller, bool derivative,
                                bool tail) {
  const StatedController& stated = observed.dataset.controller;
  std::vector<int> motors;
  for (int m = 0; m < count_of(controller.reference.motors); ++m) {
    const std::string& joint = controller.reference.motors[m];
    const auto& gains = derivative ? stated.kd : stated.kp;
    if (is_tail(observed.model, joint) == tail && gain_unknown(gains, stated.gains_stated, joint))
      motors.push_back(m);
  }
  return motors;
}

}  // namespace

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
      if (gain == nullptr || !(gain->range.lower > 0.0) || !std::isfinite(gain->range.upper))
        continue;
      (*into)[motor.joint] = std::sqrt(gain->range.lower * gain->range.upper);
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
      const std::vector<int> motors = unknown_motors(observed, controller, derivative, tail);
      if (motors.empty()) continue;
      const std::string name =
          std::string("log_") + (derivative ? "kd" : "kp") + (tail ? "_tail" : "");
      const int parameter =
          add_factor(hypotheses, name + suffix, settings.gain_spread, settings.factor_bound);
      factors.push_back({parameter, motors, derivative});
    }
  }

  if (!stated.gains_stated) {
    const int parameter = add_factor(hypotheses, "log_feedforward" + suffix,
                                     settings.feedforward_spread, settings.factor_bound);
    factors.push_back({parameter, {}, false});
  }
  return factors;
}

void apply_factors(const std::vector<GainFactor>& factors, const Vector& p,
                   simulation::Plant& plant, simulation::Controller& controller) {
  for (const GainFactor& factor : factors) {
    const double scale = std::exp(p[factor.parameter]);
    if (factor.motors.empty()) plant.actuation.feedforward_scale *= scale;
    for (const int m : factor.motors)
      (factor.derivative ? controller.kd : controller.kp)[m] *= scale;
  }
}

}  // namespace jaculus::diagnosis
