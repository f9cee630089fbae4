// Hypotheses and forward model of observations: parameters onto plant, controller and start; simulation; channels.

#include "jaculus/diagnosis/forward.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>

#include "diagnosis/grid_simulation.h"
#include "diagnosis/starts.h"
#include "jaculus/simulation/experiment.h"

namespace jaculus {
namespace {

// Gains to begin with where a file states none: those of this class of robot, as torque at the motor.
constexpr double kLegP = 3.3, kLegD = 0.1, kTailP = 8.0, kTailD = 0.1;  // N m/rad, N m s/rad
constexpr double kTorqueOfDuty = 8.2;                                   // N m for a duty of 1
constexpr double kGainSpread = 0.7, kScaleSpread = 0.3;                 // of the logarithms
constexpr double kGrid = 1e-3;                                          // s, of predictions
constexpr double kLeastHinge = 0.1;  // of the prior's scale, below which a hinge's influence is interpolated
constexpr double kBeyond = 0.02;     // s, simulated after the window for shifts

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// A nuisance that scales gains or the feed-forward of one condition: factor exp(p).
struct Factor {
  int parameter = -1;
  std::vector<int> motors;  ///< of the reference; empty: the feed-forward
  bool derivative = false;
};

/// What of a condition doesn't depend on the parameters.
struct Base {
  Plant plant;
  std::vector<Controller> controllers;  ///< a run each for measured input, else one
  StartState start;
  std::vector<StartDirection> directions;
  std::vector<Factor> factors;
};

struct Model {
  const Observations* observations = nullptr;
  Hypotheses hypotheses;
  std::vector<Base> bases;
  std::vector<const Effect*> effects;
};

bool is_tail(const PlanarModel& model, const std::string& joint) {
  const int motor = model.motor_index(joint);
  return motor >= 0 && std::any_of(model.drags.begin(), model.drags.end(),
                                   [&](const PlanarDrag& drag) { return drag.body == model.motors[at(motor)].body; });
}

AssumedGains first_gains(const Condition& condition) {
  AssumedGains gains;
  const std::string& quantity = condition.dataset.controller.quantity;
  for (const PlanarMotor& motor : condition.model.motors) {
    const bool tail = is_tail(condition.model, motor.joint);
    double unit = 1.0;
    if (quantity != "torque") unit = 1.0 / kTorqueOfDuty;
    if (quantity == "voltage") unit *= condition.dataset.controller.bus_voltage.value_or(motor.voltage);
    gains.kp[motor.joint] = (tail ? kTailP : kLegP) * unit;
    gains.kd[motor.joint] = (tail ? kTailD : kLegD) * unit;
    for (const auto& [stated, into] : {std::pair(&condition.dataset.controller.kp, &gains.kp),
                                       std::pair(&condition.dataset.controller.kd, &gains.kd)}) {
      auto found = stated->find(motor.joint);
      if (found == stated->end()) found = stated->find("*");
      if (found == stated->end() || !(found->second.range.lower > 0.0) || !std::isfinite(found->second.range.upper))
        continue;
      (*into)[motor.joint] = std::sqrt(found->second.range.lower * found->second.range.upper);
    }
  }
  return gains;
}

bool gain_unknown(const std::map<std::string, StatedGain>& stated, bool any_stated, const std::string& joint) {
  auto found = stated.find(joint);
  if (found == stated.end()) found = stated.find("*");
  return found == stated.end() ? !any_stated : !found->second.known();
}

int add_factor(Hypotheses& hypotheses, const std::string& name, double spread) {
  hypotheses.nuisances.push_back(static_cast<int>(hypotheses.parameters.size()));
  hypotheses.parameters.push_back({"nuisance", name, "-", 0.0, spread, {-4.0 * spread, 4.0 * spread}});
  return hypotheses.nuisances.back();
}

void add_gain_factors(const Condition& condition, const std::string& suffix, Base& base, Hypotheses& hypotheses) {
  const StatedController& stated = condition.dataset.controller;
  if (stated.kind != "feedforward_pd") return;
  for (const bool derivative : {false, true}) {
    for (const bool tail : {false, true}) {
      Factor factor;
      factor.derivative = derivative;
      const auto& motors = base.controllers.front().reference.motors;
      for (std::size_t m = 0; m < motors.size(); ++m) {
        if (is_tail(condition.model, motors[m]) == tail &&
            gain_unknown(derivative ? stated.kd : stated.kp, stated.gains_stated, motors[m])) {
          factor.motors.push_back(static_cast<int>(m));
        }
      }
      if (factor.motors.empty()) continue;
      factor.parameter = add_factor(
          hypotheses, std::string("log_") + (derivative ? "kd" : "kp") + (tail ? "_tail" : "") + suffix, kGainSpread);
      base.factors.push_back(factor);
    }
  }
  if (stated.gains_stated) return;
  Factor feedforward;
  feedforward.parameter = add_factor(hypotheses, "log_feedforward" + suffix, kScaleSpread);
  base.factors.push_back(feedforward);
}

/// The logged input of a trial as a script from the start of a run on.
Controller measured_controller(const Condition& condition, const Run& run) {
  const Trial& trial = condition.dataset.trials[at(run.trial)];
  Dataset scripted = condition.dataset;
  scripted.plan.reset();
  scripted.trials.clear();
  for (const PlanarMotor& motor : condition.model.motors) {
    for (const Stream& stream : trial.streams) {
      const int channel = stream.channel(motor.joint + "_" + condition.dataset.controller.input);
      if (channel < 0) continue;
      std::vector<double> time, value;
      for (Eigen::Index i = 0; i < stream.time.size(); ++i) {
        if (!std::isfinite(stream.values(channel, i))) continue;
        if (!time.empty() && stream.time[i] <= run.start) time.clear(), value.clear();
        time.push_back(std::max(0.0, stream.time[i] - run.start));
        value.push_back(stream.values(channel, i));
      }
      InputScript script;
      script.quantity = condition.dataset.controller.input;
      script.time = Eigen::Map<Vector>(time.data(), static_cast<Eigen::Index>(time.size()));
      script.joints = {motor.joint};
      script.values = Eigen::Map<Eigen::RowVectorXd>(value.data(), static_cast<Eigen::Index>(value.size()));
      scripted.script = script;  // a robot of one joint, as trees with a logged input are here
    }
  }
  Controller controller = stated_controller(scripted, condition.model, {});
  controller.rate_hz = kInfinity;
  controller.reference.linear = true;
  return controller;
}

Base base_of(const Condition& condition) {
  Base base;
  base.plant = dataset_plant(condition.dataset, condition.model);
  if (condition.measured_input) {
    for (const Run& run : condition.runs) base.controllers.push_back(measured_controller(condition, run));
    base.start = {condition.runs.front().start_q, condition.runs.front().start_v};
  } else {
    base.controllers.push_back(stated_controller(condition.dataset, condition.model, first_gains(condition)));
    base.start = reference_start(base.plant, base.controllers.front().reference);
  }
  base.directions = start_directions(condition, base.start);
  return base;
}

void add_effects(Model& model) {
  Hypotheses& h = model.hypotheses;
  for (const Effect* effect : model.effects) {
    Candidate candidate{effect->name, effect->where, {}, effect};
    for (const EffectParameter& p : effect->parameters) {
      candidate.parameters.push_back(static_cast<int>(h.parameters.size()));
      FreeParameter free{effect->name, p.name, p.unit, p.nominal, p.scale, p.bounds};
      free.probe = p.probed() - p.nominal;
      h.parameters.push_back(free);
    }
    h.candidates.push_back(candidate);
  }
}

void add_starts(Model& model) {
  Hypotheses& h = model.hypotheses;
  for (Base& base : model.bases) {
    for (const StartDirection& d : base.directions) {
      const auto same =
          std::find_if(h.starts.begin(), h.starts.end(), [&](int i) { return h.parameters[at(i)].name == d.name; });
      if (same != h.starts.end()) continue;
      h.starts.push_back(static_cast<int>(h.parameters.size()));
      h.parameters.push_back({"start", d.name, d.unit, 0.0, d.scale, {}});
    }
  }
}

void apply_candidates(const Model& model, const PlanarModel& robot, const Vector& p, Plant& plant) {
  for (const Candidate& candidate : model.hypotheses.candidates) {
    const Vector theta = candidate.theta(p);
    if (theta != candidate.effect->nominal() && candidate.effect->applies(robot)) candidate.effect->apply(theta, plant);
  }
}

void apply_factors(const Base& base, const Vector& p, Plant& plant, Controller& controller) {
  for (const Factor& factor : base.factors) {
    const double scale = std::exp(p[factor.parameter]);
    if (factor.motors.empty()) plant.actuation.feedforward_scale *= scale;
    for (const int m : factor.motors) (factor.derivative ? controller.kd : controller.kp)[m] *= scale;
  }
}

void apply_starts(const Model& model, const Base& base, const Vector& p, const Plant& plant, StartState& start) {
  bool stands = false;
  for (const StartDirection& d : base.directions) {
    for (const int i : model.hypotheses.starts) {
      if (model.hypotheses.parameters[at(i)].name != d.name || p[i] == 0.0) continue;
      start.q += p[i] * d.q;
      start.v += p[i] * d.v;
      stands = stands || d.stands;
    }
  }
  if (stands) level_feet(plant, start.q);
}

/// Whether a robot stands otherwise than the nominal one does.
bool moves_start(const Plant& plant) {
  return plant.ground.foot_radius != 0.0 || plant.ground.compliance != 0.0 || !plant.sensing.offset.empty() ||
         !plant.sensing.scale.empty();
}

RunSetup setup_of(const Model& model, int c, int r, const Vector& p) {
  const Condition& condition = model.observations->conditions[at(c)];
  const Base& base = model.bases[at(c)];
  const Run& run = condition.runs[at(r)];
  RunSetup setup{base.plant, base.controllers[condition.measured_input ? at(r) : 0], base.start, {}};
  apply_candidates(model, condition.model, p, setup.plant);
  apply_factors(base, p, setup.plant, setup.controller);
  if (condition.measured_input) {
    setup.start = {run.start_q, run.start_v};
  } else if (moves_start(setup.plant)) {
    setup.start = reference_start(setup.plant, setup.controller.reference);
  }
  apply_starts(model, base, p, setup.plant, setup.start);
  double end = condition.window_end;
  if (condition.measured_input) {
    end = 0.0;
    for (const Vector& time : run.time)
      if (time.size() > 0) end = std::max(end, time[time.size() - 1] - run.start);
  }
  // The grid goes with the loop's steps, so that a late command is the same motion later and not another rounding of it.
  const double late = condition.measured_input ? 0.0 : setup.plant.actuation.late_start + setup.plant.actuation.delay;
  const double first = std::fmod(late, kGrid);
  const auto points = static_cast<Eigen::Index>(std::ceil((end + kBeyond + late) / kGrid)) + 1;
  setup.options.sample_times = Vector::LinSpaced(points, first, first + kGrid * static_cast<double>(points - 1));
  setup.options.duration = setup.options.sample_times[points - 1];
  return setup;
}

/// A first parameter that adds a stiff hinge or floor (a little play or compliance), below the least value worth simulating.
struct Stiff {
  int parameter = -1;
  double share = 0.0;  ///< of the way from nominal to that least value
  double least = 0.0;
};

/// Those that p has. Influence is proportional to play and compliance near zero while the stiffness, and the cost, grow.
std::vector<Stiff> stiff_parameters(const Model& model, const PlanarModel& robot, const Vector& p) {
  std::vector<Stiff> found;
  for (const Candidate& candidate : model.hypotheses.candidates) {
    const int i = candidate.parameters.front();
    const FreeParameter& own = model.hypotheses.parameters[at(i)];
    const double least = own.nominal + kLeastHinge * own.scale;
    if (p[i] <= own.nominal || p[i] >= least || !own.one_sided() || !candidate.effect->applies(robot)) continue;
    Plant plant = nominal_plant(robot);
    candidate.effect->apply(candidate.effect->probed(), plant);
    if (plant.transmissions.empty() && plant.ground.compliance <= 0.0) continue;
    found.push_back({i, (p[i] - own.nominal) / (least - own.nominal), least});
  }
  return found;
}

/// When a script's steps, and the end of any command, arrive at the motors.
std::vector<double> command_steps(const RunSetup& setup) {
  std::vector<double> steps;
  const Reference& reference = setup.controller.reference;
  const double late = setup.plant.actuation.late_start + setup.plant.actuation.delay;
  steps.push_back(reference.duration + late);
  if (reference.linear || reference.position.size() > 0) return steps;
  for (Eigen::Index k = 1; k < reference.time.size(); ++k)
    if (reference.feedforward.col(k) != reference.feedforward.col(k - 1)) steps.push_back(reference.time[k] + late);
  return steps;
}

Prediction simulate_run(const Model& model, int c, int r, const Vector& p) {
  const RunSetup setup = setup_of(model, c, r, p);
  const Simulation simulation = simulate_on_grid(setup.plant, setup.controller, setup.start, setup.options);
  Prediction prediction;
  prediction.message = simulation.message;
  if (simulation.status != SimulationStatus::done || simulation.time.size() != setup.options.sample_times.size())
    return prediction;
  prediction = prediction_of(model.observations->conditions[at(c)], setup.plant, simulation);
  for (const Event& event : simulation.events)
    if (event.time > 0.0 && (event.kind == EventKind::stop || event.kind == EventKind::land))
      prediction.impacts.push_back(event.time);
  prediction.steps = command_steps(setup);
  prediction.valid = prediction.values.allFinite();
  if (!prediction.valid) prediction.message = "the simulation gave values that are not finite";
  return prediction;
}

/// Simulated without what is stiff, and the share of each one's influence added.
Prediction predict_run(const Model& model, int c, int r, const Vector& p) {
  const std::vector<Stiff> stiff = stiff_parameters(model, model.observations->conditions[at(c)].model, p);
  Vector base = p;
  for (const Stiff& own : stiff) base[own.parameter] = model.hypotheses.parameters[at(own.parameter)].nominal;
  const Prediction without = simulate_run(model, c, r, base);
  Prediction sum = without;
  for (const Stiff& own : stiff) {
    if (!without.valid) break;
    Vector there = base;
    there[own.parameter] = own.least;
    const Prediction with = simulate_run(model, c, r, there);
    if (!with.valid) return with;
    sum.values += own.share * (with.values - without.values);
  }
  return sum;
}

}  // namespace

PlantForward plant_forward(const Observations& observations, const std::vector<const Effect*>& effects) {
  auto model = std::make_shared<Model>();
  model->observations = &observations;
  for (const Effect* effect : effects) {
    if (std::any_of(observations.conditions.begin(), observations.conditions.end(),
                    [&](const Condition& condition) { return effect->applies(condition.model); })) {
      model->effects.push_back(effect);
    }
  }
  add_effects(*model);
  for (std::size_t c = 0; c < observations.conditions.size(); ++c) {
    model->bases.push_back(base_of(observations.conditions[c]));
    const std::string suffix = observations.conditions.size() > 1 ? "_" + std::to_string(c + 1) : "";
    add_gain_factors(observations.conditions[c], suffix, model->bases.back(), model->hypotheses);
  }
  add_starts(*model);
  return {model->hypotheses,
          [model](int condition, int run, const Vector& p) { return predict_run(*model, condition, run, p); },
          [model](int condition, int run, const Vector& p) { return setup_of(*model, condition, run, p); }};
}

}  // namespace jaculus
