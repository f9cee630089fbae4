#pragma once
// Draws for blinded cases: experiments with their signatures, sensors, strengths.

#include <optional>
#include <random>
#include <string>
#include <vector>

#include "jaculus/testbed/effects.h"
#include "jaculus/testbed/trials.h"
#include "testbed/robot_files.h"

namespace jaculus::testbed {

/// An experiment with what every case on it needs.
struct Stage {
  std::string name;  ///< "leap aerotail_V7.csv duty"
  trajectory::Dataset asked;
  RobotFiles robot;
  std::vector<BenchEffect> effects;  ///< of the robot
};

Stage make_stage(const std::string& name, const trajectory::Dataset& asked);

/// All experiments of a batch: every plan with torque and with duty, on the first robot all of
/// whose motors it has; then of every robot what it can do without a plan: drop and bench, with the
/// tail or, without one, with the legs; on a fixed base the pendulum's steps and swings by every
/// input. InputError where no robot fits a plan.
std::vector<Stage> all_stages(const std::vector<std::filesystem::path>& plans,
                              const std::vector<std::filesystem::path>& robots);

/// When a stage's commands end [s].
double commands_end(const Stage& stage);

/// The effect of a name on a stage; null where it can't act there at all, or where the log itself
/// says what drove the joints and the effect is one of what came before it.
const BenchEffect* acting_effect(const Stage& stage, const std::string& name);

using Random = std::mt19937_64;

/// Streams, rates, noise, losses and number of trials.
TrialSpec draw_trials(Random& random, const Stage& stage, bool clutter);

/// An effect with its numbers.
struct Dose {
  const BenchEffect* effect = nullptr;
  std::vector<double> values;
};

/// Numbers of an effect beside the strength, and the `end` of the strength's range, that of the
/// side that was drawn. A push falls within the stage's commands where its ranges allow that.
Dose draw_dose(const BenchEffect& effect, const Stage& stage, Random& random, double& end);

/// The noise-free run of a stage under changes, in the spec's streams; nothing where the robot is
/// lost.
std::optional<trajectory::Dataset> exact_run(const Stage& stage, const Changes& changes,
                                             const TrialSpec& spec);

/// Searches the strength at which the gap is `target` noise floors, to 10 %; nothing where no
/// strength within the effect's range comes within a factor of 1.5. The gap reached is put into
/// `reached`.
std::optional<Dose> find_dose(const BenchEffect& effect, const Stage& stage, const TrialSpec& spec,
                              const trajectory::Dataset& nominal, double target, Random& random,
                              double& reached);

/// Noise-free runs of one stage with each effect at a small strength, in streams fine enough for
/// every draw of draw_trials.
struct Signatures {
  trajectory::Dataset nominal;  ///< without any
  std::vector<std::string> effects;
  std::vector<trajectory::Dataset> runs;  ///< an effect each
  trajectory::Dataset level;              ///< without any, from where the robot stands on both feet
  std::vector<trajectory::Dataset> starts;  ///< a joint each, which starts kStartStep from there
};

/// By which a joint's start is moved for its signature [rad].
inline constexpr double kStartStep = 2e-3;
/// By which people and motors set a joint's start, standard deviation: what a diagnosis grants
/// [rad].
inline constexpr double kStartSpread = 0.01;

/// The streams that signatures are kept in.
TrialSpec signature_spec();
/// Of an effect's first parameter, at which its signature is taken.
double signature_strength(const BenchEffect& effect);
/// How many effects have a signature on a stage, and one of them as bytes, for a process of its
/// own; empty where the robot is lost.
std::vector<std::string> signature_effects(const Stage& stage);
std::string signature_bytes(const Stage& stage, const std::string& name);
Signatures signatures_of(const Stage& stage, const std::vector<std::string>& bytes);

/// Share of `changed` - `nominal` that neither shifts of the streams' clocks nor other starts of
/// the joints explain [0, 1].
double share_beyond_nuisances(const Stage& stage, const Signatures& signatures,
                              const TrialSpec& spec, const trajectory::Dataset& nominal,
                              const trajectory::Dataset& changed);

/// Effects of the catalogue that, at some strength, show what the true one shows.
std::vector<std::string> equivalents(const Stage& stage, const Signatures& signatures,
                                     const TrialSpec& spec, const trajectory::Dataset& like,
                                     const Dose& truth);

}  // namespace jaculus::testbed
