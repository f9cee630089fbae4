#pragma once
// From datasets to a verdict: where the gap lies, which effect causes it, how far it shrinks.
//
//   observe -> predict, align, noise -> contradictions, one-off disturbances -> select models -> held-out gap -> verdict
//
// Verdict, from the posterior of selection.h:
//   insufficient  the data can't answer (reasons are in `reasons`), or there is one trial and nothing to tell its noise by
//   none          p(none) is the largest and above 0.5
//   unexplained   p(unknown structure) above 0.5
//   effect        one effect takes part in models of 0.8 or more, and no other in models of 0.5; or no other is listed
//   several       the same of several effects
//   ambiguous     else; the effects that take part in models of 5 % and more of what effects explain are listed
// Held-out data have a say (held_out_rules.h in src): where a further effect takes the gap from above 1.2 noise floors to below 0.6 of
// that, it counts in full; of an ambiguous set what is sure stands alone unless they ask for the rest; a member of `several` must raise
// their log density by 3. Where the effects as a whole do not raise it by 3 and lower the held-out error by 10 % (by 20 and by 5 % where
// the gap is below 1.5 noise floors), the verdict is none (gap below 1.5 noise floors) or unexplained; and unexplained where they leave
// more than 3 floors, or more than 1.5 and a quarter of the gap.
// Probabilities as stated are shares of right verdicts on the testbed (calibration.h in src); `reasons` says what makes one doubtful.

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "jaculus/diagnosis/checks.h"
#include "jaculus/diagnosis/held_out.h"
#include "jaculus/diagnosis/localise.h"
#include "jaculus/diagnosis/selection.h"

namespace jaculus {

/// A parameter as users read it.
struct FoundParameter {
  std::string name, unit;
  double value = 0.0;
  Bounds ci95;
};

struct FoundEffect {
  std::string name, caption;
  double probability = 0.0;
  std::vector<FoundParameter> parameters;
  std::vector<std::string> like;  ///< effects that these data can't tell from it, by sensitivities
};

/// One row of the ranking: an effect or a set of them, "none" or "unexplained".
struct Ranked {
  std::string effect;            ///< "a", "a + b"
  double log_evidence = kNaN;    ///< relative to none
  double held_out_error = kNaN;  ///< [noise floors]
  double probability = 0.0;
  std::vector<std::string> members{};  ///< names of its effects; empty for none and unexplained
};

/// An experiment that would separate the rivals of an ambiguous verdict.
struct NextExperiment {
  std::string experiment;
  double log_bayes_factor = kNaN;  ///< expected
};

/// A model as it was fitted.
struct FittedModel {
  std::vector<int> candidates;
  Vector p;  ///< of all parameters
};

struct Diagnosis {
  std::string verdict;
  std::vector<std::string> reasons;  ///< why this verdict, or what to record next time
  std::vector<std::string> notes;    ///< what was left out or assumed
  std::vector<FoundEffect> effects;  ///< most probable first; empty for none, unexplained and insufficient
  std::vector<Ranked> ranking;
  std::vector<OneOff> disturbances;
  HeldOut gap;
  std::optional<Localisation> where;
  std::optional<NextExperiment> next;
  std::vector<FittedModel> rivals;  ///< of an ambiguous verdict: its two most probable models with effects
  std::shared_ptr<DiagnosisProblem>
      problem;  ///< as diagnosed, noise floors and shifts in it; null where nothing could be
  Vector p;     ///< all parameters of the model whose gap is stated: what the verdict names, else the most evident one
  Vector p_none;            ///< nominal, condition-wide nuisances fitted
  std::vector<int> chosen;  ///< its candidates
  long predictions = 0;
};

struct DiagnoseOptions {
  ObservationOptions observation;
  SelectionOptions selection;
  double discrepancy_share = 0.08;     ///< of a channel's gap that the plant may misshape; see declare_discrepancy
  double discrepancy_floor = 1.0;      ///< smooth faults of the plant itself, in noise floors
  std::vector<const Effect*> effects;  ///< empty: the catalogue
  std::function<void(const std::string&)> progress;  ///< a line on what is going on
};

/// Diagnoses one or several datasets of one robot. Bad files are InputErrors of those who read them; a robot that lacks what a plan
/// commands, an InputError here; everything numerical is in the verdict.
Diagnosis diagnose(const std::vector<Dataset>& datasets, const DiagnoseOptions& options = {});

/// The held-out gap with all of options.effects fitted, whether the data speak for them or not: what a diagnosis could have reached
/// that knew them. Invalid where they can't be fitted.
HeldOut held_out_with(const std::vector<Dataset>& datasets, const DiagnoseOptions& options);

/// The same as diagnose for any problem, for models that are no plant. Robot-specific parts (where, next, shown parameters) stay empty.
Diagnosis diagnose_problem(std::shared_ptr<DiagnosisProblem> problem, const DiagnoseOptions& options = {});

}  // namespace jaculus
