#pragma once
// Before an experiment: which effects it could show and from which size on, which of them could not
// be told apart, what would tell them, and what to record next.
//
// The experiment is simulated as stated and its data are made the problem that a diagnosis would
// have to solve; what it could then say of each effect is linear Gaussian evidence about signatures
// that are simulated (src/diagnosis/preflight/). M. Krysander, E. Frisk, 2008, for structural
// isolability; E. Eriksson, E. Frisk, M. Krysander, 2013, for the statistical one.

#include <filesystem>
#include <string>
#include <vector>

#include "jaculus/diagnosis/options.h"
#include "jaculus/simulation/experiment.h"

namespace jaculus::diagnosis {

struct PreflightOptions {
  DiagnoseOptions diagnosis;  ///< settings, effects or catalogue, progress
  /// Of each effect at work, in its probing steps: a prior scale unless the effect states another.
  double size = 1.0;
  bool alternatives = true;  ///< whether to look for sensors and motions that would tell more
};

/// What the planned experiment would show of one effect.
struct PlannedEffect {
  std::string name, caption;
  std::string parameter, unit;    ///< the first one, as users read it
  bool structural = false;        ///< whether it changes anything that is recorded, in exact data
  double stated = kNaN;           ///< value at which it is taken to be at work [unit]
  double least = kNaN;            ///< value from which it would be named [unit]; NaN: none in reach
  double least_scales = kNaN;     ///< its departure from nominal [prior scales]
  double least_of_bounds = kNaN;  ///< the same over the distance to the bound [-]; NaN: no bound
  double log_odds = kNaN;         ///< of the stated one against no effect, expected
  double gap = kNaN;              ///< of the stated one [noise floors]
  bool named = false;             ///< whether the stated one would be named
};

/// Something that would tell a pair apart.
struct TellingChange {
  std::string kind;  ///< "sensor", "motion"
  std::string name;
  double log_bayes_factor = kNaN;  ///< expected, the lesser of both ways
};

/// What a diagnosis would make of data with one of two effects at work.
enum class Telling {
  not_judged,  ///< it would not be named as stated
  told,        ///< it is named, the other is not
  ambiguous,   ///< either may be at work
  taken,       ///< for the other, which imitates it with fewer or likelier parameters
  open         ///< any of these: the noise of the data decides
};
const char* name_of(Telling telling);

/// Two effects, one of them at least named as stated.
struct PlannedPair {
  std::string a, b;
  double told_a = kNaN;  ///< expected log Bayes factor with a at work, b as rival; NaN: a not named
  double told_b = kNaN;  ///< the same the other way round
  Telling with_a = Telling::not_judged;  ///< a at work
  Telling with_b = Telling::not_judged;  ///< b at work
  double chance_a = kNaN;                ///< that data with a at work are told from b
  double chance_b = kNaN;                ///< the same the other way round
  bool structural = false;               ///< one is the same as the other in exact data
  bool tellable = false;                 ///< told in every way that is judged
  std::vector<TellingChange> by{};  ///< of a pair that is not tellable: what would tell, best first
};

/// An experiment that could follow, diagnosed together with the planned one.
struct FollowingExperiment {
  std::string name;
  double information = kNaN;  ///< on which effect is at work, of both together [bit]
  int told = 0;               ///< pairs not tellable by the planned one that both together tell
};

struct Preflight {
  std::string experiment;  ///< its name
  std::string robot;
  std::vector<std::string> reasons;  ///< why no diagnosis could be made; empty: what follows holds
  std::vector<std::string> notes;
  double size = 1.0;  ///< PreflightOptions::size
  std::vector<PlannedEffect> effects;
  std::vector<PlannedPair> pairs;
  /// Effects that pairs not tellable connect, by name.
  std::vector<std::vector<std::string>> sets;
  double information = kNaN;  ///< of the planned experiment on which effect is at work [bit]
  double uncertainty = kNaN;  ///< entropy of the prior: what could be known at most [bit]
  std::vector<FollowingExperiment> following;  ///< the most informative first
  Settings settings;
};

Preflight preflight(const simulation::Experiment& experiment, const PreflightOptions& options);

/// Three sentences: what would be seen, what could not be told apart, what to do about it.
std::vector<std::string> preflight_sentences(const Preflight& preflight);
/// For terminals.
std::string preflight_text(const Preflight& preflight);
/// preflight.json; a number that does not exist is null.
std::string preflight_json(const Preflight& preflight);
/// Writes it into a folder, made where it is absent.
void write_preflight(const Preflight& preflight, const std::filesystem::path& folder);

}  // namespace jaculus::diagnosis
