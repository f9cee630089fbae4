#include "jaculus/evaluation/replan.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "jaculus/core/json.h"
#include "jaculus/model/robot.h"
#include "jaculus/simulation/simulate.h"
#include "jaculus/trajectory/trajectory.h"

namespace jaculus::evaluation {
namespace {

// The robot's gains of February 2019 [duty/rad, duty s/rad] at 8.2 N m a duty (16 V over 0.186 ohm,
// not saturated).
constexpr double kProportional = 0.4 * 8.2, kDerivative = 0.01 * 8.2;

/// The problem with values of the model in place of what it overrides by the same path.
transcription::Problem with_values(transcription::Problem problem,
                                   const std::vector<effects::ModelOverride>& values) {
  for (const auto& [path, text] : values) {
    std::erase_if(problem.overrides,
                  [&, name = path](const model::Override& o) { return o.path == name; });
    problem.overrides.push_back(
        {path, yaml::Node::parse("value: " + text, "effect: " + path).at("value")});
  }
  return problem;
}

ReplanFigures plan_and_replay(const transcription::Problem& problem, const PlanReplay& replay,
                              const solver::PlanOptions& options) {
  ReplanFigures figures;
  const model::PlanarModel model =
      model::read_robot(problem.robot_folder, problem.overrides).planar;
  const solver::Plan plan = solver::make_plan(problem, model, options);
  figures.status = to_string(plan.result.status);
  figures.converged = plan.converged();
  if (!plan.converged() || !plan.trajectory) return figures;

  const trajectory::Trajectory& t = *plan.trajectory;
  const Eigen::Index end = t.time.size() - 1;
  const int x = model.coordinate_index("x");
  if (x < 0)
    throw InputError(
        fmt::format("{}: its base can't move forward; allowed: a leap", problem.file.string()));
  figures.duration = t.time[end] - t.time[0];
  figures.planned_speed = t.velocity(x, end);
  figures.planned_acceleration = figures.planned_speed / figures.duration;
  figures.realised_speed = replay(trajectory::to_table(t));
  figures.realised_acceleration = figures.realised_speed / figures.duration;

  return figures;
}

nlohmann::json figures_json(const ReplanFigures& f) {
  return {{"status", f.status},
          {"duration_s", json_number(f.duration)},
          {"planned_speed_m_s", json_number(f.planned_speed)},
          {"realised_speed_m_s", json_number(f.realised_speed)},
          {"planned_acceleration_m_s2", json_number(f.planned_acceleration)},
          {"realised_acceleration_m_s2", json_number(f.realised_acceleration)},
          {"shortfall_m_s2", json_number(f.shortfall())}};
}

std::string figures_text(const std::string& which, const ReplanFigures& f) {
  if (!f.converged) return fmt::format("  {:<24} {}\n", which, f.status);
  return fmt::format(
      "  {:<24} planned {:6.3f}, realised {:6.3f}, short by {:6.3f} m/s^2 in {:.4f} s\n", which,
      f.planned_acceleration, f.realised_acceleration, f.shortfall(), f.duration);
}

}  // namespace

PlanReplay replay_on_plant(const std::filesystem::path& folder,
                           const std::vector<effects::EffectValue>& effects) {
  const model::PlanarModel model = model::read_robot(folder).planar;
  return [model, effects](const trajectory::Table& plan) {
    simulation::Plant plant = simulation::nominal_plant(model);
    simulation::Controller controller;
    controller.reference =
        simulation::plan_reference(plan, model, trajectory::Quantity::torque, kNaN, "plan.csv");
    const auto motors = std::ssize(controller.reference.motors);
    controller.kp = Vector::Constant(motors, kProportional);
    controller.kd = Vector::Constant(motors, kDerivative);

    effects::apply_effects(effects, plant);
    simulation::SimulationOptions options;
    options.duration = controller.reference.duration;
    options.sample_times = Vector::LinSpaced(2, 0.0, options.duration);
    const simulation::Simulation run = simulation::simulate(
        plant, controller, simulation::reference_start(plant, controller.reference), options);
    return run.status == simulation::SimulationStatus::done
               ? run.v(plant.model.coordinate_index("x"), 1)
               : kNaN;
  };
}

Replan replan(const transcription::Problem& problem,
              const std::vector<effects::EffectValue>& effects, const PlanReplay& replay,
              const solver::PlanOptions& options) {
  Replan result;
  model::PlanarModel model = model::read_robot(problem.robot_folder, problem.overrides).planar;
  for (const effects::EffectValue& value : effects) {
    for (const effects::ModelOverride& edit : value.effect->overrides(value.theta, model)) {
      std::erase_if(result.overrides,
                    [&](const effects::ModelOverride& o) { return o.first == edit.first; });
      result.overrides.push_back(edit);
    }
    simulation::Plant plant =
        simulation::nominal_plant(model);  // the next effect's values count on top of this one's
    value.effect->apply(value.theta, plant);
    model = plant.model;
  }

  result.planner_knows = !result.overrides.empty();
  result.before = plan_and_replay(problem, replay, options);
  result.after = result.planner_knows
                     ? plan_and_replay(with_values(problem, result.overrides), replay, options)
                     : result.before;

  return result;
}

std::string replan_json(const Replan& replan) {
  nlohmann::json overrides = nlohmann::json::object();
  for (const auto& [path, value] : replan.overrides) overrides[path] = value;
  const nlohmann::json json = {{"planner_knows", replan.planner_knows},
                               {"overrides", overrides},
                               {"before", figures_json(replan.before)},
                               {"after", figures_json(replan.after)}};
  return json.dump(2) + "\n";
}

std::string replan_text(const Replan& replan) {
  return figures_text("effect not known", replan.before) +
         (replan.planner_knows
              ? figures_text("effect known", replan.after)
              : "  planning can't have this effect: it has no values of the model\n");
}

}  // namespace jaculus::evaluation
