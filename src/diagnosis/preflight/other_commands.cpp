#include "diagnosis/preflight/other_commands.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <numbers>

#include "jaculus/core/error.h"

namespace jaculus::diagnosis {
namespace {

using model::PlanarModel;
using simulation::Experiment;
using trajectory::InputScript;

constexpr double kChirpStep = 0.05;  // of the highest frequency's period
constexpr std::array<double, 9> kHolds = {0.5, 1.0, 0.5, 0.0, -0.5, -1.0, -0.5, 0.0, 0.0};

NamedExperiment with_script(const Experiment& present, const std::string& what,
                            InputScript script) {
  NamedExperiment named{fmt::format("{}: {}", name_of(present.setup.experiment), what), present};
  named.experiment.setup.script = std::move(script);
  return named;
}

/// The script's largest values, a joint each.
Vector amplitudes(const InputScript& script) {
  return script.values.cwiseAbs().rowwise().maxCoeff();
}

NamedExperiment chirp(const Experiment& present, const Settings& settings) {
  InputScript script = *present.setup.script;
  const Vector amplitude = amplitudes(script);
  const double duration = simulation::command_duration(present.setup);
  const double step = kChirpStep / settings.chirp_highest;
  const Eigen::Index steps = std::max(2L, std::lround(duration / step));
  script.time = Vector::LinSpaced(steps + 1, 0.0, duration);
  const Vector frequency =
      settings.chirp_lowest +
      (settings.chirp_highest - settings.chirp_lowest) * script.time.array() / (2.0 * duration);
  const Vector wave = (2.0 * std::numbers::pi * frequency.array() * script.time.array()).sin();
  script.values = amplitude * wave.transpose();
  script.values.col(steps).setZero();
  return with_script(
      present, fmt::format("chirp from {} to {} Hz", settings.chirp_lowest, settings.chirp_highest),
      std::move(script));
}

NamedExperiment holds(const Experiment& present) {
  InputScript script = *present.setup.script;
  const Vector amplitude = amplitudes(script);
  const Eigen::Index n = std::ssize(kHolds);
  script.time = Vector::LinSpaced(n, 0.0, simulation::command_duration(present.setup));
  script.values = amplitude * Eigen::Map<const Eigen::RowVectorXd>(kHolds.data(), n);
  return with_script(present, "slow holds", std::move(script));
}

NamedExperiment stronger(const Experiment& present, const Settings& settings) {
  InputScript script = *present.setup.script;
  script.values *= settings.stronger_command;
  return with_script(present, fmt::format("{} times the command", settings.stronger_command),
                     std::move(script));
}

/// The same plan on a lower battery.
NamedExperiment lower_voltage(const Experiment& present, const PlanarModel& model,
                              const Settings& settings) {
  if (model.motors.empty() || model.motors.front().ideal())
    throw InputError("this robot's motors have no voltage");
  NamedExperiment named{"", present};
  std::optional<double>& bus = named.experiment.setup.controller.bus_voltage;
  bus = settings.lower_voltage * bus.value_or(model.motors.front().voltage);
  named.name = fmt::format("{} on {:.3g} V", name_of(present.setup.experiment), *bus);
  return named;
}

NamedExperiment with_payload(const Experiment& present, const PlanarModel& model,
                             const Settings& settings) {
  const bool moves = model.base_free[0] || model.base_free[1] || model.base_free[2];
  const model::PlanarBody& body = moves ? model.bodies.front() : model.bodies.back();
  const double payload = settings.payload * body.mass;
  NamedExperiment named{fmt::format("{} with {:.3g} kg more on {}",
                                    name_of(present.setup.experiment), payload, body.name),
                        present};
  named.experiment.setup.overrides["bodies." + body.name + ".mass"] =
      fmt::format("{:.17g}", body.mass + payload);
  return named;
}

}  // namespace

std::vector<ExperimentMaker> other_commands(const Experiment& present, const PlanarModel& model,
                                            const Settings& settings) {
  std::vector<ExperimentMaker> makers;
  if (present.setup.script) {
    makers.emplace_back([present, settings] { return chirp(present, settings); });
    makers.emplace_back([present] { return holds(present); });
    makers.emplace_back([present, settings] { return stronger(present, settings); });
  } else {
    makers.emplace_back(
        [present, model, settings] { return lower_voltage(present, model, settings); });
  }
  makers.emplace_back(
      [present, model, settings] { return with_payload(present, model, settings); });
  return makers;
}

}  // namespace jaculus::diagnosis
