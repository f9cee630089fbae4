#pragma once
// Real datasets whose cause is known: what is known of them beside what a diagnosis says.
//
// What is known stands beside a dataset's folder, NAME.truth.yaml, where no diagnosis can see it (a
// diagnosis runs in a folder that holds a copy of the dataset alone). Judged are
//   effects   each known one: named (one of `any_of`, at its joint where the prediction says
//             joints), and its value within `within` of the known one
//   absent    named nevertheless: wrong
//   extra     named, and neither known nor listed as possible
//   events    a disturbance said for that trial and joint whose time is within 0.1 s of the known
//             span's middle and whose peak is within 30 %
// A gap is given in the channel's own unit, on held-out time, before and after.

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "jaculus/evaluation/score.h"

namespace jaculus::evaluation {

/// An effect that is known to act.
struct KnownEffect {
  std::vector<std::string> any_of;  ///< names in the catalogue, or words where it has none
  std::string joint;                ///< where it acts; empty: not said
  std::string parameter;            ///< by the name that predictions show; empty: no value known
  std::string unit;                 ///< of the value, SI
  double value = kNaN;              ///< [unit]
  double within = kNaN;             ///< relative, how near an estimate has to come [-]
  std::string remark;               ///< the value in words where it is no number
};

/// A disturbance that is known to the sample.
struct KnownEvent {
  std::string trial, joint;
  double from = 0.0, to = 0.0;  ///< [s]
  double peak = 0.0;            ///< signed [N m or N]
};

/// What NAME.truth.yaml says.
struct KnownCause {
  std::vector<KnownEffect> effects;
  std::vector<std::string> listed;  ///< may be named, need not be
  std::vector<std::string> absent;  ///< must not be named
  std::vector<KnownEvent> events;
  std::string source;
};

/// Reads a truth file. InputError with file:line for anything unknown in it. `effects_as_in` takes
/// effects, listed and absent of another file of the same folder.
KnownCause read_known_cause(const std::filesystem::path& file);

/// What is known of a dataset: its truth file, or nothing where there is none.
std::optional<KnownCause> known_cause_of(const std::filesystem::path& dataset);

/// One known effect against an prediction.
struct KnownEffectScore {
  KnownEffect known;
  std::string named_as;       ///< the name that the prediction has for it; empty: not named
  double probability = kNaN;  ///< as the prediction states it
  double estimate = kNaN;     ///< [unit of the known value]
  Bounds ci95{kNaN, kNaN};    ///< [unit of the known value]
  bool within = false;        ///< whether the estimate is as near as asked
};

/// One real dataset.
struct RealScore {
  std::string name;  ///< of its folder, with the one above it
  std::optional<KnownCause> known;
  Prediction prediction;
  std::vector<KnownEffectScore> effects;
  std::vector<std::string> absent_named;  ///< of `absent`, wrongly
  std::vector<std::string> extra;         ///< named beyond what is known or listed
  int events_found = 0;                   ///< of the known ones
  int events_false = 0;                   ///< said, and not known
};

/// Judges an prediction.
RealScore score_real(const std::string& name, const std::optional<KnownCause>& known,
                     const Prediction& prediction);

struct RealOptions {
  std::filesystem::path binary;  ///< the jaculus program that diagnoses
  std::filesystem::path out;     ///< predictions are kept here, a folder a dataset
  double time_limit_s = 1800.0;  ///< of one diagnosis
  std::function<void(const std::string&)> notice = {};
};

/// Diagnoses each dataset in a process of its own, in a folder that holds a copy of it and nothing
/// else, then judges. InputError for a folder that is no dataset or a truth file with a fault,
/// before anything runs. Writes real.json and real.txt into options.out.
std::vector<RealScore> score_real_datasets(const std::vector<std::filesystem::path>& datasets,
                                           const RealOptions& options);

std::string real_json(const std::vector<RealScore>& scores);
std::string real_text(const std::vector<RealScore>& scores);

}  // namespace jaculus::evaluation
