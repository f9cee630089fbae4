#pragma once
// Effects as users write and read them: "tail_compliance:stiffness=98,damping_ratio=0.1".

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "jaculus/effects/effect.h"

namespace jaculus::effects {

/// An effect as a robot has it, with values of its parameters, in its own terms (compliance, not
/// stiffness).
struct EffectValue {
  std::shared_ptr<const Effect> effect;
  Vector theta;
};

/// A parameter as users read it.
struct ShownParameter {
  std::string name;  ///< "stiffness"
  double value = 0.0;
  std::string unit;  ///< "N m/rad"
};

/// Reads "name:parameter=value,parameter=value", or "name@joint:..." of one of several joints that
/// share an effect; a parameter by its own name or the shown one, the
/// others nominal. Values are SI. InputError, opening with `place` ("--effect", "file:line: key"),
/// where a name is unknown, a value is no number or lies outside the bounds, or this robot can't
/// have the effect.
EffectValue read_effect(const std::string& text, const model::PlanarModel& model,
                        const std::string& place, const Catalogue& catalogue = effect_catalogue());

/// What augmented.yaml of a diagnosis says of effects.
struct AugmentedEffects {
  std::vector<std::string> effects;  ///< each as read_effect() takes it
  std::vector<std::string> files;    ///< of users' effects among them
};
/// InputError where the file is none.
AugmentedEffects read_augmented(const std::filesystem::path& file);

/// Sets several effects on a plant, in the order given.
void apply_effects(const std::vector<EffectValue>& effects, simulation::Plant& plant);

/// One parameter's value as users read it, and back. A reciprocal of 0 is infinite, and of infinity
/// 0.
double shown_value(const EffectParameter& parameter, double value);
double own_value(const EffectParameter& parameter, double shown);
/// Every parameter of an effect at `theta`.
std::vector<ShownParameter> shown_parameters(const Effect& effect, const Vector& theta);

/// Every effect of a catalogue with where it acts, the experiments that show it, and its parameters
/// in its own terms, as `simulate --explain` prints it.
std::string catalogue_text(const Catalogue& catalogue = effect_catalogue());

}  // namespace jaculus::effects
