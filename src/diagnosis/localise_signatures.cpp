#include "diagnosis/localise_signatures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/localise_rows.h"
#include "effects/groups.h"

namespace jaculus {
namespace {

constexpr int kHalvings = 4;           // of a step whose simulation fails
constexpr double kNuisanceStep = 0.2;  // prior widths, of central differences

bool holds(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// Whether a name is a joint of the list or a channel of one ("front_a_velocity").
bool belongs(const std::vector<std::string>& joints, const std::string& name) {
  return std::any_of(joints.begin(), joints.end(), [&](const std::string& joint) { return name.starts_with(joint); });
}

void restore(std::map<std::string, double>& values, const std::map<std::string, double>& before,
             const std::vector<std::string>& joints) {
  std::erase_if(values, [&](const auto& entry) { return belongs(joints, entry.first); });
  for (const auto& [name, value] : before)
    if (belongs(joints, name)) values[name] = value;
}

template <class Entry>
void restore(std::vector<Entry>& entries, const std::vector<Entry>& before, const std::vector<std::string>& joints) {
  std::erase_if(entries, [&](const Entry& entry) { return holds(joints, entry.joint); });
  for (const Entry& entry : before)
    if (holds(joints, entry.joint)) entries.push_back(entry);
}

/// Undoes on a plant what an effect did at these joints and bodies.
void undo(const std::vector<std::string>& joints, const std::vector<int>& bodies, const Plant& before, Plant& plant) {
  restore(plant.friction, before.friction, joints);
  restore(plant.transmissions, before.transmissions, joints);
  restore(plant.actuation.torque_scale, before.actuation.torque_scale, joints);
  restore(plant.sensing.scale, before.sensing.scale, joints);
  restore(plant.sensing.offset, before.sensing.offset, joints);
  for (const int b : bodies) plant.model.bodies[static_cast<size_t>(b)] = before.model.bodies[static_cast<size_t>(b)];
  for (size_t m = 0; m < plant.model.motors.size(); ++m)
    if (holds(joints, plant.model.motors[m].joint)) plant.model.motors[m] = before.model.motors[m];
}

bool on_all_legs(const Effect& effect) {
  return effect.acts_in(Component::front_legs) && effect.acts_in(Component::rear_legs);
}

/// What the columns of one problem are made from.
struct Setting {
  const DiagnosisProblem& problem;
  const PlantForward& forward;
  const EvidenceSpace& space;
  const Vector& p;
  std::vector<Vector> baseline;  ///< raw rows at p, a condition each

  [[nodiscard]] const Candidate& candidate(const SignatureColumn& column) const {
    return problem.hypotheses.candidates[static_cast<size_t>(column.candidate)];
  }
  [[nodiscard]] int index(const SignatureColumn& column) const {
    return candidate(column).parameters[static_cast<size_t>(column.parameter)];
  }
  [[nodiscard]] const FreeParameter& parameter(const SignatureColumn& column) const {
    return problem.hypotheses.parameters[static_cast<size_t>(index(column))];
  }
};

/// The column in the evidence space; empty where a simulation failed.
Vector column_at(const Setting& setting, const SignatureColumn& column) {
  const Candidate& candidate = setting.candidate(column);
  const int index = setting.index(column);
  std::vector<Vector> change;
  for (size_t c = 0; c < setting.baseline.size(); ++c) {
    if (!candidate.effect->applies(setting.problem.observations.conditions[c].model)) {
      change.push_back(Vector::Zero(setting.baseline[c].size()));
      continue;
    }
    Vector theta = setting.p(candidate.parameters);
    // An effect that is already at work is moved through the parameters: it can't be set twice on one plant.
    const bool by_part = column.split && theta == candidate.effect->nominal();
    theta[column.parameter] += column.step;
    Vector moved = setting.p, predicted;
    if (!by_part) moved[index] += column.step;
    const auto apply = [&](RunSetup& setup) {
      if (by_part) apply_in(*candidate.effect, theta, column.part, setup.plant);
    };
    if (!predict_changed(setting.problem, setting.forward, static_cast<int>(c), moved, apply, predicted)) return {};
    change.push_back((predicted - setting.baseline[c]) * (setting.parameter(column).scale / column.step));
  }
  return setting.space.apply(change);
}

/// The same with the step halved until it can be simulated.
Vector column_of(const Setting& setting, SignatureColumn& column) {
  for (int attempt = 0; attempt <= kHalvings; ++attempt) {
    const Vector values = column_at(setting, column);
    if (values.size() > 0) return values;
    column.step *= 0.5;
  }
  column.failed = true;
  return Vector::Zero(setting.space.rows);
}

int side_of(const FreeParameter& parameter) {
  if (parameter.nominal <= parameter.bounds.lower) return 1;
  return parameter.nominal >= parameter.bounds.upper ? -1 : 0;
}

/// Change of the rows per prior width of a condition-wide nuisance.
Vector nuisance_column(const Setting& setting, int index) {
  const double step = kNuisanceStep * setting.problem.hypotheses.parameters[static_cast<size_t>(index)].scale;
  std::vector<Vector> change;
  for (size_t c = 0; c < setting.baseline.size(); ++c) {
    Vector side[2];
    for (const int n : {0, 1}) {
      Vector moved = setting.p;
      moved[index] += n == 0 ? -step : step;
      if (!predict_changed(
              setting.problem, setting.forward, static_cast<int>(c), moved, [](RunSetup&) {}, side[n]))
        return Vector::Zero(setting.space.rows);
    }
    change.push_back((side[1] - side[0]) / (2.0 * kNuisanceStep));
  }
  return setting.space.apply(change);
}

void assemble(const Matrix& S, const Vector& residual, Signatures& s) {
  s.system = ShareSystem(s.total);
  s.system.add(S, residual, Matrix(S.rows(), 0), Vector(0), static_cast<double>(S.rows()));
  s.system.project_out(s.nuisances);
}

/// Strength that the residual asks of a column by itself, in its unit, within bounds; 0 where that is within its uncertainty.
double asked_step(const Signatures& s, const Setting& setting, int column) {
  const SignatureColumn& c = s.columns[static_cast<size_t>(column)];
  const FreeParameter& parameter = setting.parameter(c);
  const double information = s.system.G(column, column) + 1.0;
  const double widths = s.system.b[column] / information;
  if (widths * widths * information < 9.0) return 0.0;
  const double now = setting.p[setting.index(c)];
  return std::clamp(now + widths * parameter.scale, parameter.bounds.lower, parameter.bounds.upper) - now;
}

}  // namespace

Signatures plan_columns(const Hypotheses& h) {
  Signatures s;
  std::vector<std::pair<int, int>> sums;  // candidates that are a sum: index, parameters
  for (size_t i = 0; i < h.candidates.size(); ++i) {
    const Candidate& candidate = h.candidates[i];
    const bool split = on_all_legs(*candidate.effect);
    std::vector<Component> parts{candidate.where};
    if (split) parts = {Component::front_legs, Component::rear_legs};
    ShareCandidate all;
    for (const Component part : parts) {
      ShareCandidate one;
      for (size_t k = 0; k < candidate.parameters.size(); ++k) {
        const FreeParameter& parameter = h.parameters[static_cast<size_t>(candidate.parameters[k])];
        one.columns.push_back(static_cast<int>(s.columns.size()));
        one.sides.push_back(side_of(parameter));
        s.columns.push_back({static_cast<int>(i), static_cast<int>(k), part, split, parameter.usual_step()});
      }
      one.parts = {{part, one.columns}};
      all.parts.push_back(one.parts.front());
      all.sides = one.sides;
      s.candidates.push_back(one);
      s.hypothesis.push_back(static_cast<int>(i));
    }
    if (!split) continue;
    sums.emplace_back(static_cast<int>(s.candidates.size()), static_cast<int>(all.sides.size()));
    s.candidates.push_back(all);
    s.hypothesis.push_back(static_cast<int>(i));
  }
  s.total = static_cast<int>(s.columns.size());
  for (const auto& [index, parameters] : sums)
    for (int k = 0; k < parameters; ++k) s.candidates[static_cast<size_t>(index)].columns.push_back(s.total++);
  for (size_t i = 0; i < h.nuisances.size(); ++i) s.nuisances.push_back(s.total++);
  return s;
}

void sum_parts(const Signatures& s, Matrix& S) {
  for (const ShareCandidate& candidate : s.candidates) {
    if (candidate.parts.size() < 2) continue;
    for (size_t k = 0; k < candidate.columns.size(); ++k) {
      S.col(candidate.columns[k]).setZero();
      for (const SharePart& part : candidate.parts) S.col(candidate.columns[k]) += S.col(part.columns[k]);
    }
  }
}

void apply_in(const Effect& effect, const Vector& theta, Component part, Plant& plant) {
  const Plant before = plant;
  effect.apply(theta, plant);
  if (!on_all_legs(effect)) return;
  const effects::JointGroups groups = effects::joint_groups(before.model);
  if (part == Component::front_legs) undo(groups.rear, groups.rear_bodies, before, plant);
  if (part == Component::rear_legs) undo(groups.front, groups.front_bodies, before, plant);
}

Signatures signatures_of(const DiagnosisProblem& problem, const Linearisation& about, const PlantForward& forward,
                         std::vector<std::string>& notes) {
  Signatures s = plan_columns(problem.hypotheses);
  const EvidenceSpace space = evidence_space(problem, about);
  const Setting setting{problem, forward, space, about.p, rows_of(problem, about.at_p)};
  const Vector residual = space.residual(setting.baseline);
  Matrix S = Matrix::Zero(space.rows, s.total);
  for (size_t k = 0; k < s.columns.size(); ++k) {
    S.col(static_cast<Eigen::Index>(k)) = column_of(setting, s.columns[k]);
    if (s.columns[k].failed)
      notes.push_back(
          fmt::format("{} could not be simulated and takes no share", setting.candidate(s.columns[k]).name));
  }
  for (size_t i = 0; i < s.nuisances.size(); ++i)
    S.col(s.nuisances[i]) = nuisance_column(setting, problem.hypotheses.nuisances[i]);
  sum_parts(s, S);
  assemble(S, residual, s);
  for (size_t k = 0; k < s.columns.size(); ++k) {
    SignatureColumn there = s.columns[k];
    there.step = asked_step(s, setting, static_cast<int>(k));
    if (there.step == 0.0 || there.failed) continue;
    const Vector values = column_at(setting, there);
    if (values.size() == 0) continue;  // so strong, it can't be simulated: the probe's signature stays
    s.columns[k] = there;
    S.col(static_cast<Eigen::Index>(k)) = values;
  }
  sum_parts(s, S);
  assemble(S, residual, s);
  return s;
}

}  // namespace jaculus
