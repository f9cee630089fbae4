#pragma once
// What a diagnosis says, as values.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "jaculus/core/types.h"
#include "jaculus/diagnosis/agreement.h"
#include "jaculus/diagnosis/held_out.h"
#include "jaculus/diagnosis/localisation.h"
#include "jaculus/diagnosis/physical.h"
#include "jaculus/diagnosis/remainder.h"
#include "jaculus/diagnosis/settings.h"
#include "jaculus/diagnosis/verdict.h"
#include "jaculus/effects/effect.h"

namespace jaculus::diagnosis {

struct Problem;     // data, hypotheses and forward model (src/diagnosis/forward/problem.h)
struct NoiseModel;  // src/diagnosis/noise/noise_model.h

/// A parameter as users read it.
struct FoundParameter {
  std::string name, unit;
  double value = 0.0;
  Bounds ci95;
  bool at_bound = false;  ///< the value is where its range ends, and says no more than that
  /// The interval, not the value, ends where the range does: data may allow more.
  bool cut_by_range = false;
};

struct FoundEffect {
  std::string name, caption;
  double probability = 0.0;
  std::vector<FoundParameter> parameters;
  std::vector<std::string> indistinguishable;  ///< effects that these data can't tell from it
  /// Of the held-out gap's energy. A rival beside the named set has its share alone; nothing where
  /// no share can be told.
  std::optional<EffectShare> share{};
};

/// One row of the ranking: an effect or a set of them, "none" or "unexplained".
struct Ranked {
  std::string effect;            ///< "a", "a + b"
  double log_evidence = kNaN;    ///< relative to none
  double held_out_error = kNaN;  ///< [noise floors]
  double probability = 0.0;
  std::vector<std::string> members{};  ///< names of its effects; empty for none and unexplained
  /// as fitted in this set, "effect.parameter" with its unit; without intervals
  std::vector<FoundParameter> parameters{};
};

/// What the model that is judged lacks along one coordinate.
struct LackingForce {
  std::string name;    ///< a coordinate, "elbow", "x"; or "misfit of x"
  double rms = 0.0;    ///< of the force or the misfit [unit]
  std::string unit;    ///< "N m", "N"; of a misfit "noise floors"
  double boxes = 0.0;  ///< boxes of time, or values, of which the data tell it
};

/// A force that acted briefly: under a logged input beyond what the model usually lacks, in one
/// trial or more; under a plan or script in every trial.
struct ForceEvent {
  int dataset = 0;
  std::string trial;             ///< empty: in every one
  std::string joint;             ///< "base" for the body
  std::string along{};           ///< of the body "x", "z" or "pitch"
  double from = 0.0, to = 0.0;   ///< [s]
  double peak = 0.0;             ///< of the half-sine that is most like it [unit]
  Bounds peak_ci95{kNaN, kNaN};  ///< [unit]; NaN where it was not fitted
  std::string unit;              ///< "N m", "N"
  double probability = 0.0;      ///< under a logged input that nothing usual makes it anywhere
  /// Most other trials have it at the same time as well: it comes with the clock or the motion.
  bool every_trial = false;
};

/// A disturbance of one segment alone.
struct OneOff {
  int dataset = 0, segment = 0;
  std::string trial;
  double onset = 0.0;  ///< [s]
  double excess =
      0.0;  ///< rms about the other segments' mean over the usual scatter from there on [-]
  std::string channel;  ///< where it shows most
};

/// Left and right of one joint that part, which no model of the plane holds.
struct Parting {
  std::string dataset;  ///< of its folder
  std::string trial;
  std::string joint;  ///< that parts first
  double from = 0.0;  ///< data of the trial are left out from here on [s]
  double most = 0.0;  ///< by which they part then [unit]
  std::string unit;   ///< "rad", "m"
};

/// An experiment that would separate the rivals of an ambiguous verdict.
struct NextExperiment {
  std::string experiment;
  double log_bayes_factor = kNaN;  ///< expected
};

/// A set of effects as it was fitted.
struct FittedModel {
  std::vector<int> candidates;  ///< indices in the problem's hypotheses
  Vector p;                     ///< all parameters
};

/// How far a robot is off its files within its builder's tolerances, as data tell.
struct Tolerated {
  std::string name;    ///< "friction of elbow"
  double value = 0.0;  ///< [deviations that the builder vouches for]
  Bounds ci95;         ///< [deviations]
};

struct Diagnosis {
  Verdict verdict = Verdict::insufficient;
  std::string rule;  ///< of verdict/rules.h that decided; empty where the data stopped it
  std::vector<std::string> reasons;  ///< why this verdict, or what to record next time
  std::vector<std::string> notes;    ///< what was left out or assumed
  std::vector<FoundEffect> effects;  ///< most probable first; empty where the verdict names none
  std::vector<Ranked> ranking;
  std::vector<OneOff> disturbances;
  std::vector<Parting> partings;  ///< by dataset and trial, in time
  HeldOut gap;                    ///< of `model` against `stated` and `none`
  Tolerances tolerances;          ///< that the user named
  std::optional<double> horizon;  ///< by which they are judged [s]; nothing: the whole motion
  Agreement agreement;            ///< of `model` with every dataset
  /// probability that `model` lacks forces, given that it is at work
  double lacking_probability = 0.0;
  std::vector<LackingForce> lacking;  ///< of `model`, by coordinate
  std::vector<ForceEvent> events;     ///< about `model`, by dataset, trial and time
  Remainder remainder;                ///< what `model` leaves, described
  std::optional<Localisation> where;
  std::optional<NextExperiment> next;
  std::vector<FittedModel> rivals;  ///< of an ambiguous verdict: its two most probable models
  FittedModel stated;               ///< as files have it, unknown gains fitted
  /// The same with the builder's tolerances fitted, and pushes where these are all that is told.
  FittedModel none;
  FittedModel model;  ///< whose gap is stated: what the verdict names, else the most evident one
  /// Parameters of each effect of `model`, with what tolerances of the same quantity add.
  std::vector<Vector> theta;
  std::vector<Tolerated> tolerated;  ///< of `model`, the farthest first, one deviation off or more
  long predictions = 0;
  Settings settings;
  /// To whose effects `problem` points; null: the library's.
  std::shared_ptr<const effects::Catalogue> catalogue;
  /// As diagnosed; null where nothing could be.
  std::shared_ptr<const Problem> problem;
  /// By which the gap was judged; null where nothing was fitted.
  std::shared_ptr<const NoiseModel> noise;
};

}  // namespace jaculus::diagnosis
