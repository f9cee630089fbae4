#pragma once
// The truth of a blinded case, and what was predicted of it.

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "jaculus/core/types.h"
#include "jaculus/diagnosis/verdict.h"
#include "jaculus/testbed/blinded_cases.h"

namespace jaculus::evaluation {

/// What held-out trials show of a case's true effects; NaN where no fit could be had.
struct PossibleGap {
  double after = kNaN;       ///< that the true effects with fitted parameters leave [noise floors]
  double tolerances = kNaN;  ///< that the builder's tolerances leave without effects [noise floors]
  double log_gain = kNaN;    ///< log density of the held-out rows by the former, less by the latter
};

/// What is true of one blinded case.
struct CaseTruth {
  std::string case_id;  ///< opaque; the dataset's folder
  /// "single", "several" (of older batches "pair"), "none", "outside", "mixed", "event"
  std::string kind;
  /// names in the catalogue, "NAME@JOINT" where one joint alone has it; of outside the generator's
  /// own names
  std::vector<std::string> effects;
  /// an effect each, in the catalogue's order and terms; NaN: not known
  std::vector<std::vector<double>> parameters;
  /// of a mixed case: what acts beside `effects` and is in no catalogue
  std::vector<std::string> beside = {};
  /// of each of `effects`, then of `beside`, alone [noise floors]
  std::vector<double> strengths = {};
  double legs_apart = 0.0;  ///< by how much left and right motors part at most [rad]
  /// rms of the gap over all channels, beyond clocks and starts [noise floors]
  double strength_in_noise_floors = 0.0;
  /// draws before it that were left out because left and right legs diverge
  std::vector<std::string> diverged;
  /// effects that the generator can't tell from the true ones in this experiment
  std::vector<std::string> equivalent;
  std::string component;  ///< where it acts, by component_name; empty: not scored
  /// none where it was not asked, or an effect is not the catalogue's
  std::optional<PossibleGap> possible = {};
  /// pushes, each in every trial
  std::vector<testbed::TrueEvent> events = {};
  int trials = 0;  ///< 0: not known
};

/// An effect as a prediction names it.
struct NamedEffect {
  std::string name;
  double probability = 0.0;
  std::map<std::string, double> parameters;  ///< by the name shown, "stiffness"
  std::map<std::string, Bounds> ci95;
  std::vector<std::string> joints = {};  ///< where it acts, if the prediction says so
};

/// A disturbance that a prediction says was there.
struct SaidEvent {
  std::string trial, joint;
  double from = 0.0, to = 0.0;  ///< [s]
  double peak = 0.0;            ///< signed [N m or N]
};

/// A part of the description of what is left.
struct SaidPart {
  std::string place;    ///< "joint", "body", "feet", "sensor", "commands"
  std::string at;       ///< the joint, foot or coordinate
  std::string family;   ///< what it follows, as a regressor's name
  double weight = 0.0;  ///< by which parts are ordered
};

/// The gap of one channel on held-out time, root mean square.
struct ChannelGap {
  std::string unit;                    ///< SI
  double before = kNaN, after = kNaN;  ///< [unit]
};

/// What a diagnosis.json says, or that there is none.
struct Prediction {
  std::optional<diagnosis::Verdict> verdict;  ///< nothing: no prediction came
  std::string message;                        ///< why none came
  std::vector<NamedEffect> effects;
  /// probability by effect; may hold "none" and "unexplained"
  std::map<std::string, double> ranking;
  std::map<std::string, double> components;    ///< share by component
  double gap_before = kNaN, gap_after = kNaN;  ///< [noise floors]
  std::map<std::string, ChannelGap> channels;  ///< by channel
  std::vector<SaidEvent> events;
  std::vector<SaidPart> described;  ///< what is left, as it is described
  /// whether it says that more is there than it names: verdict unexplained, or a remainder that it
  /// calls established
  bool remainder = false;
  bool parted = false;    ///< whether it says that left and right part, which no plane holds
  double seconds = kNaN;  ///< that it took; NaN where not known
};

/// Reads a diagnosis.json. InputError (file: key path: what) where it is none.
Prediction read_prediction(const std::filesystem::path& file);
std::string prediction_to_text(const Prediction& prediction);  ///< JSON, one line
Prediction prediction_from_text(const std::string& text);

}  // namespace jaculus::evaluation
