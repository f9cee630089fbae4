#include "jaculus/effects/trials.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "jaculus/core/error.h"
#include "jaculus/core/installation.h"
#include "jaculus/core/interrupt.h"
#include "jaculus/core/json.h"

namespace jaculus::effects {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

Json state_json(const simulation::LeapState& state, double duration) {
  return {{"time_s", json_number(state.time)},
          {"speed_m_s", json_number(state.speed)},
          {"acceleration_m_s2", json_number(state.speed / duration)},
          {"pitch_rad", json_number(state.pitch)},
          {"landing_pitch_rad", json_number(state.landing_pitch)}};
}

Json figures_json(const simulation::LeapFigures& figures) {
  Json json = {{"duration_s", json_number(figures.duration)}};
  const double true_acceleration = figures.plan_end.speed / figures.duration;
  for (const auto& [key, recipe] : {std::pair("recipe", &figures.recipe),
                                    std::pair("recipe_without_noise", &figures.recipe_exact)}) {
    json[key] = nullptr;
    if (!*recipe) continue;
    json[key] = {{"start_s", (*recipe)->start},
                 {"speed_m_s", (*recipe)->speed},
                 {"acceleration_m_s2", (*recipe)->acceleration},
                 {"bias_m_s2", json_number((*recipe)->acceleration - true_acceleration)}};
  }
  json["plan_end"] = state_json(figures.plan_end, figures.duration);
  json["lift_off"] =
      figures.lift_off ? state_json(*figures.lift_off, figures.duration) : Json(nullptr);
  return json;
}

/// Where a joint of the truth is first outside its range, and how far it goes; null where it stays.
Json range_left(const simulation::Simulation& truth, const std::string& joint, bool turns,
                const Bounds& range, const Eigen::RowVectorXd& values) {
  constexpr double kTouches = 1e-6;  // [rad or m] a stop holds a joint at its range's end
  const auto outside = [&](double value) {
    return std::max({range.lower - value, value - range.upper, 0.0});
  };
  double furthest = 0.0, first = kNaN;
  for (Eigen::Index k = 0; k < values.size(); ++k) {
    if (!(outside(values[k]) > kTouches)) continue;
    if (std::isnan(first)) first = truth.time[k];
    furthest = std::max(furthest, outside(values[k]));
  }
  if (std::isnan(first)) return nullptr;
  return {{"joint", joint},
          {"time_s", first},
          {"beyond", furthest},
          {"unit", turns ? "rad" : "m"},
          {"range", {json_number(range.lower), json_number(range.upper)}}};
}

/// Joints that leave the range of the robot's files: the plant stops them only where it has a stop.
/// Those that follow from a loop are no function of the coordinates alone and are not looked at.
Json ranges_left(const model::PlanarModel& model, const simulation::Simulation& truth) {
  Json left = Json::array();
  const auto add = [&](const std::string& joint, bool turns, const Bounds& range,
                       const Eigen::RowVectorXd& values) {
    const Json found = range_left(truth, joint, turns, range, values);
    if (!found.is_null()) left.push_back(found);
  };
  for (int i = 0; i < model.size(); ++i)
    add(model.coordinates[i].name, model.coordinates[i].angular, model.coordinates[i].range,
        truth.q.row(i));
  for (const model::JointRange& own : model.joint_ranges) {
    const auto row = model.joint_map.row(own.body);
    if (row.isZero()) continue;
    const bool turns = model.bodies[own.body].kind == model::JointKind::revolute;
    add(own.joint, turns, own.range,
        ((row * truth.q).array() + model.joint_offset[own.body]).matrix());
  }
  return left;
}

Json trial_json(const simulation::Experiment& experiment, const model::PlanarModel& model,
                const simulation::TrialRun& run) {
  Json json = {{"name", run.trial.name},
               {"status", simulation::status_name(run.truth.status)},
               {"end_time_s", json_number(run.truth.end_time)}};
  if (!run.truth.message.empty()) json["message"] = run.truth.message;
  json["streams"] = Json::array();
  for (const trajectory::Stream& stream : run.trial.streams)
    json["streams"].push_back({{"name", stream.name},
                               {"samples", stream.time.size()},
                               {"gaps", stream.values.array().isNaN().count()}});
  json["final"] = Json::object();

  for (int i = 0; i < model.size() && run.truth.time.size() > 0; ++i)
    json["final"][model.coordinates[i].name] = json_number(run.truth.q(i, run.truth.q.cols() - 1));
  json["events"] = Json::array();
  const char* const kinds[] = {"lift", "land", "slip", "stick", "stop", "release", "limit"};
  for (const simulation::Event& event : run.truth.events)
    json["events"].push_back({{"time_s", event.time},
                              {"kind", kinds[static_cast<int>(event.kind)]},
                              {"what", event.what}});
  json["ranges_left"] = ranges_left(model, run.truth);
  if (experiment.setup.experiment == trajectory::ExperimentKind::leap)
    json["leap"] = figures_json(simulation::leap_figures(experiment, model, run));

  return json;
}

std::string effects_text(const std::vector<EffectValue>& effects) {
  std::string text;
  for (const EffectValue& value : effects) {
    text += (text.empty() ? "" : "; ") + value.effect->name;
    for (const ShownParameter& p : shown_parameters(*value.effect, value.theta))
      text += fmt::format(" {}={} {}", p.name, p.value, p.unit);
  }
  return text.empty() ? "none" : text;
}

/// A robot that is named by its place stands in the dataset in full, for the dataset lies
/// elsewhere.
std::string robot_of(const simulation::Experiment& experiment) {
  const fs::path folder = model::find_robot(experiment.setup.robot, experiment.setup.folder);
  const fs::path beside = (experiment.setup.folder / experiment.setup.robot).lexically_normal();
  return folder == beside ? fs::absolute(folder).lexically_normal().string()
                          : experiment.setup.robot;
}

}  // namespace

std::vector<EffectValue> choose_effects(const EffectChoice& choice,
                                        const model::PlanarModel& model) {
  std::vector<std::string> files = choice.files;
  std::vector<std::pair<std::string, std::string>> texts;  // with their places
  if (!choice.augmented.empty()) {
    const AugmentedEffects augmented = read_augmented(choice.augmented);
    files.insert(files.end(), augmented.files.begin(), augmented.files.end());
    for (const std::string& text : augmented.effects)
      texts.emplace_back(text, choice.augmented.string());
  }
  for (const std::string& text : choice.effects) texts.emplace_back(text, choice.effects_place);

  const Catalogue catalogue = catalogue_with(files, {model}, choice.coded);
  std::vector<EffectValue> values;
  for (const auto& [text, place] : texts)
    values.push_back(read_effect(text, model, place, catalogue));

  for (const Effect& own : catalogue) {
    const auto is_own = [&](const EffectValue& v) { return v.effect->file == own.file; };
    if (own.file.empty() || std::any_of(values.begin(), values.end(), is_own)) continue;
    throw InputError(fmt::format("{}: no {} names '{}' of {}; allowed: {}:{}=...",
                                 choice.files_place, choice.effects_place, own.name, own.file,
                                 own.name, own.parameters.front().name));
  }
  for (const UserEffect& own : choice.coded) {
    const std::string& name = own.effect.name;
    const auto is_own = [&](const EffectValue& v) {
      return v.effect->name == name || v.effect->name.starts_with(name + "@");
    };
    if (std::any_of(values.begin(), values.end(), is_own)) continue;
    throw InputError(fmt::format("{}: none names '{}'; allowed: {}:{}=...", choice.effects_place,
                                 name, name, own.effect.parameters.front().name));
  }
  return values;
}

Catalogue catalogue_for(const std::vector<std::string>& files,
                        const std::vector<trajectory::Dataset>& datasets,
                        const std::vector<UserEffect>& coded) {
  std::vector<model::PlanarModel> robots;
  for (const trajectory::Dataset& dataset : datasets)
    robots.push_back(simulation::dataset_robot(dataset).planar);
  return catalogue_with(files, robots, coded);
}

SimulatedTrials simulate_trials(const simulation::Experiment& experiment,
                                const std::vector<EffectValue>& effects,
                                const model::PlanarModel& model) {
  simulation::Plant plant = simulation::dataset_plant(experiment.setup, model);
  apply_effects(effects, plant);
  const simulation::Controller controller = simulation::experiment_controller(experiment, model);
  SimulatedTrials result;
  result.dataset = experiment.setup;
  result.dataset.robot = robot_of(experiment);
  result.dataset.provenance =
      fmt::format("Simulated by jaculus {} from {}, seed {}; effects: {}.", version(),
                  experiment.name, experiment.seed, effects_text(effects));
  result.summary = {{"experiment", experiment.name},    {"robot", experiment.setup.robot},
                    {"seed", experiment.seed},          {"version", version()},
                    {"effects", effects_text(effects)}, {"trials", Json::array()}};

  for (int i = 0; i < experiment.trials && !interrupt_requested(); ++i) {
    simulation::TrialRun run =
        simulation::run_trial(experiment, plant, controller, i, experiment.seed);
    result.summary["trials"].push_back(trial_json(experiment, model, run));
    result.done = result.done && run.truth.status == simulation::SimulationStatus::done;
    if (!run.trial.streams.empty()) result.dataset.trials.push_back(std::move(run.trial));
  }

  return result;
}

}  // namespace jaculus::effects
