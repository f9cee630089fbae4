#pragma once
// The families of effects. Each has its functions, one an effect, and below them its rows of the
// catalogue; to add an effect is to write both there. catalogue.cpp strings the families together.

#include <algorithm>
#include <functional>
#include <string>
#include <vector>

#include "effects/scope.h"

namespace jaculus::effects {

using model::PlanarBody;
using model::PlanarDrag;
using model::PlanarModel;
using model::PlanarMotor;
using simulation::Plant;
using trajectory::ExperimentKind;

/// How large a floating base is, of which priors and bounds of its masses are made.
struct BaseSize {
  double mass = 0.0;         ///< [kg]
  Vec2 com = Vec2::Zero();   ///< in its frame [m]
  Vec2 half = Vec2::Zero();  ///< of a uniform bar of its spread, along x and z of its frame [m]
};

/// One physical effect: of the robot as a whole, of its base, or of joints, then an entry for each
/// scope.
struct Row {
  Row(Effect (*make)()) : whole(make) {}
  Row(Effect (*make)(const BaseSize&)) : on_base(make) {}
  Row(Effect (*make)(const JointScope&), std::vector<JointScope> its_scopes)
      : on_joints(make), scopes(std::move(its_scopes)) {}

  Effect (*whole)() = nullptr;
  Effect (*on_base)(const BaseSize&) = nullptr;
  Effect (*on_joints)(const JointScope&) = nullptr;
  std::vector<JointScope> scopes;
};

/// At nominal values an effect leaves the plant alone: not even an entry of zeros is added.
Effect guarded(Effect effect);

/// The effects of rows, in their order: an entry for each scope.
std::vector<Effect> effects_of(const std::vector<Row>& rows);

std::vector<Row> transmission();
std::vector<Row> actuation();
std::vector<Row> aerodynamics();
std::vector<Row> inertia();
std::vector<Row> contact();
std::vector<Row> sensing();

/// A scope's joints with a motor, by name.
std::function<std::vector<std::string>(const PlanarModel&)> joints_of(const JointScope& scope);

/// An effect on a scope's joints, without parameters and apply: "tail_" and `kind`, `caption` and
/// "the tail's joint". It applies where the robot has such a joint.
Effect effect_on_joints(const JointScope& scope, const std::string& kind,
                        const std::string& caption);

/// True where x or z or pitch of the base is free.
bool base_moves(const PlanarModel& model);

/// YAML text of a number that reads back to the same bits, and of a pair.
std::string text_of(double value);
std::string text_of(const Vec2& value);

}  // namespace jaculus::effects
