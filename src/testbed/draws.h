#pragma once
// Draws for sealed cases: experiments with their signatures, sensors, strengths.

#include <optional>
#include <random>
#include <string>
#include <vector>

#include "jaculus/testbed/effects.h"
#include "jaculus/testbed/trials.h"

namespace jaculus::testbed {

/// An experiment with what every case on it needs.
struct Stage {
  std::string name;  ///< "leap aerotail_V7.csv duty"
  Dataset asked;
  bool tail = false;  ///< whether the robot has one
};

/// All experiments of a batch: every plan with torque and with duty, the drop, the bench.
std::vector<Stage> all_stages(const std::vector<std::filesystem::path>& plans);

/// Whether an effect can act on a stage at all.
bool can_act(const BenchEffect& effect, const Stage& stage);

using Random = std::mt19937_64;

/// Streams, rates, noise, losses and number of trials.
TrialSpec draw_trials(Random& random, const Stage& stage);

/// An effect with its numbers.
struct Dose {
  const BenchEffect* effect = nullptr;
  std::vector<double> values;
};

/// The noise-free run of a stage under changes, in the spec's streams; nothing where the robot is lost.
std::optional<Dataset> exact_run(const Stage& stage, const Changes& changes, const TrialSpec& spec);

/// Searches the strength at which the gap is `target` noise floors, to 10 %; nothing where no strength within the effect's range
/// comes within a factor of 1.5. The gap reached is put into `reached`.
std::optional<Dose> find_dose(const BenchEffect& effect, const Stage& stage, const TrialSpec& spec,
                              const Dataset& nominal, double target, Random& random, double& reached);

/// Noise-free runs of one stage with each effect at a small strength, in streams fine enough for every draw of draw_trials.
struct Signatures {
  Dataset nominal;  ///< without any
  std::vector<std::string> effects;
  std::vector<Dataset> runs;    ///< an effect each
  Dataset level;                ///< without any, from where the robot stands on both feet
  std::vector<Dataset> starts;  ///< a joint each, which starts kStartStep from there
};

/// By which a joint's start is moved for its signature [rad].
inline constexpr double kStartStep = 2e-3;
/// By which people and motors set a joint's start, standard deviation: what a diagnosis grants [rad].
inline constexpr double kStartSpread = 0.01;

/// The streams that signatures are kept in.
TrialSpec signature_spec();
/// Of an effect's first parameter, at which its signature is taken.
double signature_strength(const std::string& effect);
/// How many effects have a signature on a stage, and one of them as bytes, for a process of its own; empty where the robot is lost.
std::vector<std::string> signature_effects(const Stage& stage);
std::string signature_bytes(const Stage& stage, const std::string& effect);
Signatures signatures_of(const Stage& stage, const std::vector<std::string>& bytes);

/// Share of `changed` - `nominal` that neither shifts of the streams' clocks nor other starts of the joints explain [0, 1].
double share_beyond_nuisances(const Signatures& signatures, const TrialSpec& spec, const Dataset& nominal,
                              const Dataset& changed);

/// Effects of the catalogue that, at some strength, show what the true one shows.
std::vector<std::string> equivalents(const Stage& stage, const Signatures& signatures, const TrialSpec& spec,
                                     const Dataset& like, const Dose& truth);

}  // namespace jaculus::testbed
