// Hypotheses and forward model of observations: parameters onto plant, controller and start;
// simulation; channels.

#include "diagnosis/forward/plant_forward.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>

#include "diagnosis/forward/grid_simulation.h"
#include "diagnosis/forward/measured_input.h"
#include "diagnosis/forward/missing_forces.h"
#include "diagnosis/forward/sized_effects.h"
#include "diagnosis/forward/start_directions.h"
#include "diagnosis/forward/tolerance_part.h"
#include "diagnosis/forward/unknown_gains.h"
#include "jaculus/core/interrupt.h"
#include "jaculus/simulation/experiment.h"
#include "simulation/integrate/start.h"

namespace jaculus::diagnosis {
namespace {

using effects::Effect;
using effects::EffectParameter;
using model::PlanarModel;
using simulation::Controller;
using simulation::Plant;
using simulation::Reference;
using simulation::Simulation;
using simulation::StartState;

/// What of a dataset doesn't depend on the parameters.
struct Base {
  Plant plant;
  simulation::Sampled sampled = simulation::Sampled::motors;  ///< what channels need
  std::vector<Controller> controllers;  ///< a segment each for measured input, else one
  StartState start;
  std::vector<StartDirection> directions;
  std::vector<GainFactor> factors;
  std::vector<ToleranceDirection> tolerances;
  std::vector<int> tolerance_of;  ///< their parameters in the hypotheses
  RestRates rest;
};

struct Model {
  Observations observations;
  Settings settings;
  Hypotheses hypotheses;
  std::vector<Base> bases;
};

Base base_of(const ObservedDataset& observed, const Settings& settings) {
  Base base;
  base.plant = simulation::dataset_plant(observed.dataset, observed.model);
  if (motion_alone(observed)) base.sampled = simulation::Sampled::motion;
  if (observed.measured_input) {
    for (const Segment& segment : observed.segments)
      base.controllers.push_back(measured_controller(observed, segment, settings.input_step));
    base.start = {observed.segments.front().start_q, observed.segments.front().start_v};
  } else {
    base.controllers.push_back(simulation::stated_controller(observed.dataset, observed.model,
                                                             first_gains(observed, settings)));
    base.start = reference_start(base.plant, base.controllers.front().reference);
  }

  base.rest = rest_rates(observed);
  base.directions = start_directions(observed, base.start, settings);
  if (settings.tolerances_granted != 0) base.tolerances = tolerances_of(observed, settings);
  return base;
}

void add_effects(Model& model, std::vector<Effect> effects) {
  Hypotheses& h = model.hypotheses;
  h.effects = std::make_shared<const std::vector<Effect>>(std::move(effects));
  for (const Effect& effect : *h.effects) {
    Candidate candidate{effect.name, effect.where.front(), {}, &effect};
    for (const EffectParameter& p : effect.parameters) {
      candidate.parameters.push_back(count_of(h.parameters));
      FreeParameter free{effect.name, p.name, p.unit, p.nominal, p.scale, p.bounds};
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
      const auto same = std::find_if(h.starts.begin(), h.starts.end(),
                                     [&](int i) { return h.parameters[i].name == d.name; });
      if (same != h.starts.end()) continue;
      h.starts.push_back(count_of(h.parameters));
      h.parameters.push_back({"start", d.name, d.unit, 0.0, d.scale, {}});
    }
  }
}

void add_tolerances(Model& model) {
  Hypotheses& h = model.hypotheses;
  for (Base& base : model.bases) {
    for (const ToleranceDirection& direction : base.tolerances) {
      const auto same = std::find_if(h.tolerances.begin(), h.tolerances.end(),
                                     [&](int i) { return h.parameters[i].name == direction.name; });
      const int parameter = same != h.tolerances.end() ? *same : count_of(h.parameters);
      base.tolerance_of.push_back(parameter);
      if (same != h.tolerances.end()) continue;
      h.tolerances.push_back(parameter);
      h.parameters.push_back(
          {"tolerance", direction.name, "deviations", 0.0, 1.0, direction.range, 1.0});
    }
  }
}

/// How long forces that are missing are sought [s]: over the longest window of a logged input, for
/// beside such windows no plan is granted any; where all is under plans, over the longest of these.
double longest(const std::vector<ObservedDataset>& datasets) {
  double window = 0.0, plan = 0.0;
  for (const ObservedDataset& observed : datasets) {
    for (const Segment& segment : observed.segments)
      if (observed.measured_input) window = std::max(window, segment.end() - segment.start);
    if (!observed.measured_input) plan = std::max(plan, observed.window_end);
  }
  return window > 0.0 ? window : plan;
}

void add_forces(Model& model) {
  Hypotheses& h = model.hypotheses;
  const double count = longest(model.observations.datasets) / model.settings.force_box;
  const int boxes = std::max(1, static_cast<int>(std::ceil(count)));
  std::map<std::string, std::pair<double, std::string>> sizes;  // with units, of all robots
  for (const ObservedDataset& observed : model.observations.datasets)
    for (const auto& [name, scale] : force_scales(observed.model, model.settings.lever))
      sizes.emplace(name, std::pair(scale, force_unit(observed.model, name)));
  for (const auto& [name, size] : sizes) {
    const auto& [scale, unit] = size;
    ForceGroup group{name, {}};
    for (int k = 0; k < boxes; ++k) {
      group.boxes.push_back(count_of(h.parameters));
      FreeParameter box{"force", name, unit, 0.0, scale, {}};
      box.probe = model.settings.force_slope * scale;
      h.parameters.push_back(box);
    }
    h.forces.push_back(group);
  }
}

void apply_forces(const Model& model, const Vector& p, Plant& plant) {
  const double box = model.settings.force_box;
  for (const ForceGroup& group : model.hypotheses.forces)
    for (int k = 0; k < count_of(group.boxes); ++k)
      if (const double value = p[group.boxes[k]];
          value != 0.0 && has_place(plant.model, group.name))
        plant.pushes.push_back(box_push(group.name, value, k * box, box));
}

/// Moves what is off by tolerances; whether the robot then stands otherwise.
bool apply_tolerances(const Base& base, const Vector& p, Plant& plant, Controller& controller) {
  bool stands_otherwise = false;
  for (std::size_t i = 0; i < base.tolerances.size(); ++i) {
    const double e = p[base.tolerance_of[i]];
    if (e == 0.0) continue;
    base.tolerances[i].move(e, plant, controller);
    stands_otherwise = stands_otherwise || base.tolerances[i].geometry;
  }
  return stands_otherwise;
}

void apply_candidates(const Model& model, const PlanarModel& robot, const Vector& p, Plant& plant) {
  for (const Candidate& candidate : model.hypotheses.candidates) {
    const Vector theta = candidate.theta(p);
    if (theta != candidate.effect->nominal() && candidate.effect->applies(robot))
      candidate.effect->apply(theta, plant);
  }
}

void apply_starts(const Model& model, const Base& base, const Vector& p, const Plant& plant,
                  StartState& start) {
  bool stands = false;
  for (const StartDirection& d : base.directions) {
    for (const int i : model.hypotheses.starts) {
      if (model.hypotheses.parameters[i].name != d.name || p[i] == 0.0) continue;
      start.q += p[i] * d.q;
      start.v += p[i] * d.v;
      stands = stands || d.stands;
    }
  }
  if (stands) level_feet(plant, start.q);
}

/// Sample times of a segment: its duration and a little more. The grid goes with the loop's steps,
/// so that a late command is the same motion later and not another rounding of it.
Vector sample_times(const ObservedDataset& observed, const Segment& segment, const Plant& plant,
                    const Settings& settings) {
  const bool logged = observed.measured_input;
  const double end = logged ? segment.end() - segment.start : observed.window_end;
  const double late = logged ? 0.0 : plant.actuation.late_start + plant.actuation.delay;
  const double first = std::fmod(late, settings.grid);
  const double steps = std::ceil((end + settings.simulated_beyond + late) / settings.grid);
  return Vector::LinSpaced(static_cast<Eigen::Index>(steps) + 1, first,
                           first + settings.grid * steps);
}

/// A log that acts later than it is stamped, or sooner, moves itself: what acts first is known too.
void delay_log(const ObservedDataset& observed, const Segment& segment, double step,
               SimulationSetup& setup) {
  simulation::Actuation& actuation = setup.plant.actuation;
  if (actuation.delay == 0.0) return;
  setup.controller = measured_controller(observed, segment, step, actuation.delay);
  actuation.delay = 0.0;
}

SimulationSetup setup_of(const Model& model, int dataset, int index, const Vector& p) {
  const ObservedDataset& observed = model.observations.datasets[dataset];
  const Segment& segment = observed.segments[index];
  const Base& base = model.bases[dataset];
  SimulationSetup setup{
      base.plant, base.controllers[observed.measured_input ? index : 0], base.start, {}};

  apply_candidates(model, observed.model, p, setup.plant);
  apply_factors(base.factors, p, setup.plant, setup.controller);
  const bool moved = apply_tolerances(base, p, setup.plant, setup.controller);
  base.rest.apply(setup.plant);
  apply_forces(model, p, setup.plant);
  if (observed.measured_input) {
    setup.start = state_as_read(setup.plant, {segment.start_q, segment.start_v});
    delay_log(observed, segment, model.settings.input_step, setup);
  } else if (moved || moves_start(setup.plant)) {
    setup.start = reference_start(setup.plant, setup.controller.reference);
  }
  apply_starts(model, base, p, setup.plant, setup.start);

  setup.options.sample_times = sample_times(observed, segment, setup.plant, model.settings);
  setup.options.duration = setup.options.sample_times[setup.options.sample_times.size() - 1];
  const double accuracy =
      observed.measured_input ? model.settings.window_accuracy : model.settings.plan_accuracy;
  setup.options.absolute_tolerance = accuracy;
  setup.options.relative_tolerance = 100.0 * accuracy;
  return setup;
}

/// A first parameter that adds a stiff hinge or floor (a little play or compliance), below the
/// least value worth simulating.
struct Stiff {
  int parameter = -1;
  double share = 0.0;  ///< of the way from nominal to that least value
  double least = 0.0;
};

/// Those that p has. Influence is proportional to play and compliance near zero while the
/// stiffness, and the cost, grow.
std::vector<Stiff> stiff_parameters(const Model& model, const PlanarModel& robot, const Vector& p) {
  std::vector<Stiff> found;
  for (const Candidate& candidate : model.hypotheses.candidates) {
    const int i = candidate.parameters.front();
    const FreeParameter& own = model.hypotheses.parameters[i];
    const double least = own.nominal + model.settings.least_hinge * own.scale;
    if (p[i] <= own.nominal || p[i] >= least || !own.one_sided() ||
        !candidate.effect->applies(robot))
      continue;
    Plant plant = simulation::nominal_plant(robot);
    candidate.effect->apply(candidate.effect->probed(), plant);
    if (plant.transmissions.empty() && plant.ground.compliance <= 0.0) continue;
    found.push_back({i, (p[i] - own.nominal) / (least - own.nominal), least});
  }
  return found;
}

/// When a script's steps, and the end of any command, arrive at the motors.
std::vector<double> command_steps(const SimulationSetup& setup) {
  std::vector<double> steps;
  const Reference& reference = setup.controller.reference;
  const double late = setup.plant.actuation.late_start + setup.plant.actuation.delay;
  steps.push_back(reference.duration + late);
  if (reference.linear || reference.position.size() > 0) return steps;
  for (Eigen::Index k = 1; k < reference.time.size(); ++k)
    if (reference.feedforward.col(k) != reference.feedforward.col(k - 1))
      steps.push_back(reference.time[k] + late);
  return steps;
}

Prediction simulate_segment(const Model& model, int dataset, int segment, const Vector& p) {
  stop_if_interrupted();  // a diagnosis is made of these
  SimulationSetup setup = setup_of(model, dataset, segment, p);
  setup.options.sampled = model.bases[dataset].sampled;
  // What steps with the loop is averaged over its holds, which doubles the samples: only where a
  // channel needs it.
  const std::vector<Channel>& channels = model.observations.datasets[dataset].channels;
  const bool stepped = std::any_of(channels.begin(), channels.end(),
                                   [](const Channel& c) { return c.zero_order_hold; });
  const auto run = stepped ? simulate_on_grid : simulation::simulate;
  const Simulation simulation = run(setup.plant, setup.controller, setup.start, setup.options);
  Prediction prediction;
  prediction.message = simulation.message;
  prediction.reached = simulation.end_time;
  if (simulation.status != simulation::SimulationStatus::done ||
      simulation.time.size() != setup.options.sample_times.size())
    return prediction;

  prediction = prediction_of(model.observations.datasets[dataset], setup.plant, simulation);
  for (const simulation::Event& event : simulation.events) {
    using enum simulation::EventKind;
    const bool impact = event.kind == stop || event.kind == land;
    if (event.time > 0.0 && impact) prediction.impacts.push_back(event.time);
  }
  prediction.steps = command_steps(setup);
  prediction.valid = prediction.values.allFinite();
  if (!prediction.valid) prediction.message = "the simulation gave values that are not finite";
  return prediction;
}

/// Simulated without what is stiff, and the share of each one's influence added.
Prediction predict_segment(const Model& model, int dataset, int segment, const Vector& p) {
  const std::vector<Stiff> stiff =
      stiff_parameters(model, model.observations.datasets[dataset].model, p);
  Vector base = p;
  for (const Stiff& own : stiff)
    base[own.parameter] = model.hypotheses.parameters[own.parameter].nominal;
  const Prediction without = simulate_segment(model, dataset, segment, base);
  if (!without.valid) return without;

  Prediction sum = without;
  for (const Stiff& own : stiff) {
    Vector there = base;
    there[own.parameter] = own.least;
    const Prediction with = simulate_segment(model, dataset, segment, there);
    if (!with.valid) return with;
    sum.values += own.share * (with.values - without.values);
  }
  return sum;
}

/// Of the first dataset whose robot can have the candidate.
Matrix tolerance_part_of(const Model& model, int candidate, const Vector& p) {
  const Candidate& own = model.hypotheses.candidates[candidate];
  const std::vector<int>& tolerances = model.hypotheses.tolerances;
  Matrix all = Matrix::Zero(count_of(own.parameters), count_of(tolerances));
  for (int d = 0; d < count_of(model.bases); ++d) {
    const Base& base = model.bases[d];
    if (!own.effect->applies(model.observations.datasets[d].model)) continue;
    const Matrix part = tolerance_part(base.plant, *own.effect, own.theta(p), base.tolerances);
    for (Eigen::Index j = 0; j < part.cols(); ++j)
      all.col(index_of(tolerances, base.tolerance_of[j])) = part.col(j);
    return all;
  }
  return all;
}

/// Of names of a dataset's unknowns: which controller it is, where the datasets have several.
std::string controller_suffix(const std::vector<ObservedDataset>& datasets, int dataset) {
  const auto like = [&](int own) {
    int first = 0;
    while (!same_controller(datasets[first].dataset.controller, datasets[own].dataset.controller))
      ++first;
    return first;
  };
  bool several = false;
  for (int d = 0; d < count_of(datasets); ++d) several = several || like(d) != 0;
  return several ? "_" + std::to_string(like(dataset) + 1) : "";
}

}  // namespace

PlantForward plant_forward(const Observations& observations,
                           const std::vector<const Effect*>& effects, const Settings& settings) {
  auto model = std::make_shared<Model>();
  model->observations = observations;
  model->settings = settings;

  const std::vector<ObservedDataset>& datasets = observations.datasets;
  add_effects(*model, sized_effects(datasets, effects));
  for (int d = 0; d < count_of(datasets); ++d) {
    Base base = base_of(datasets[d], settings);
    const std::string suffix = controller_suffix(datasets, d);
    base.factors = add_gain_factors(datasets[d], base.controllers.front(), suffix, settings,
                                    model->hypotheses);
    const std::vector<GainFactor> clock =
        add_foreign_clock(datasets[d], datasets.size() > 1, settings, model->hypotheses);
    base.factors.insert(base.factors.end(), clock.begin(), clock.end());
    model->bases.push_back(std::move(base));
  }
  add_starts(*model);
  add_tolerances(*model);
  add_forces(*model);

  return {
      model->hypotheses,
      [model](int dataset, int segment, const Vector& p) {
        return predict_segment(*model, dataset, segment, p);
      },
      [model](int candidate, const Vector& p) { return tolerance_part_of(*model, candidate, p); },
      [model](int dataset, int segment, const Vector& p) {
        return setup_of(*model, dataset, segment, p);
      }};
}

}  // namespace jaculus::diagnosis
