#pragma once
// Rows of the testbed's list of effects, made for one robot: the ranges of strengths are shares of
// what its motors, masses and lengths are, in round figures. A robot has no row for a part that it
// lacks.

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "jaculus/testbed/effects.h"
#include "testbed/sizes.h"

namespace jaculus::testbed {

using Values = std::vector<double>;
using Experiments = std::vector<trajectory::ExperimentKind>;

// Where an effect shows: with a tail that moves, with feet on the floor, with a base that moves,
// a base that is held, anything that stands or is mounted, a robot held that has no tail, wherever
// there is a joint.
inline const Experiments kTail = {trajectory::ExperimentKind::leap,
                                  trajectory::ExperimentKind::self_righting,
                                  trajectory::ExperimentKind::tail_bench};
inline const Experiments kLeap = {trajectory::ExperimentKind::leap};
inline const Experiments kMoving = {trajectory::ExperimentKind::leap,
                                    trajectory::ExperimentKind::self_righting};
inline const Experiments kHeld = {trajectory::ExperimentKind::tail_bench,
                                  trajectory::ExperimentKind::pendulum};
inline const Experiments kSupported = {trajectory::ExperimentKind::leap,
                                       trajectory::ExperimentKind::tail_bench,
                                       trajectory::ExperimentKind::pendulum};
inline const Experiments kPendulum = {trajectory::ExperimentKind::pendulum};
inline const Experiments kAll = {
    trajectory::ExperimentKind::leap, trajectory::ExperimentKind::self_righting,
    trajectory::ExperimentKind::tail_bench, trajectory::ExperimentKind::pendulum};

class EffectRows {
 public:
  explicit EffectRows(const RobotFiles& files) : files(files), sizes(sizes_of(files)) {}

  /// An effect that the diagnosis' catalogue has too; `component`: as in BenchEffect.
  BenchEffect& add(const std::string& name, const std::string& caption,
                   const std::string& component, std::vector<BenchParameter> parameters,
                   Experiments experiments, std::function<void(const Values&, Changes&)> apply) {
    all.push_back({name,
                   caption,
                   false,
                   component,
                   std::move(parameters),
                   std::move(experiments),
                   std::move(apply),
                   false,
                   {},
                   false});
    return all.back();
  }

  /// One that it has not.
  BenchEffect& add_outside(const std::string& name, const std::string& caption,
                           std::vector<BenchParameter> parameters, Experiments experiments,
                           std::function<void(const Values&, Changes&)> apply) {
    all.push_back({name,
                   caption,
                   true,
                   "",
                   std::move(parameters),
                   std::move(experiments),
                   std::move(apply),
                   false,
                   {},
                   false});
    return all.back();
  }

  const RobotFiles& files;
  const Sizes sizes;
  std::vector<BenchEffect> all;
};

/// A strength: nothing where it is 0, to be drawn from round figures of `lower` to `upper`.
inline BenchParameter strength(const std::string& name, const std::string& unit, double lower,
                               double upper) {
  return {name, unit, 0.0, round_figure(lower), round_figure(upper)};
}

/// A number beside the strength that a blinded case draws.
inline BenchParameter drawn(const std::string& name, const std::string& unit, double usual,
                            double lower, double upper) {
  return {name, unit, usual, lower, upper, true};
}

// In the order of the list.
void add_transmission(EffectRows& rows);
void add_friction(EffectRows& rows);
void add_actuation(EffectRows& rows);
void add_air(EffectRows& rows);
void add_masses(EffectRows& rows);
void add_contact(EffectRows& rows);
void add_sensing(EffectRows& rows);
void add_bias(EffectRows& rows);
void add_one_joint(EffectRows& rows);
void add_outside(EffectRows& rows);
void add_outside_anywhere(EffectRows& rows);
void add_pushes(EffectRows& rows);

}  // namespace jaculus::testbed
