#include "diagnosis/verdict/rules.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "jaculus/core/error.h"

namespace jaculus::diagnosis {
namespace {

constexpr std::array<const char*, 7> kTexts = {"insufficient", "none",    "unexplained", "effect",
                                               "several",      "partial", "ambiguous"};

bool named(const VerdictEvidence& e) { return e.naming != Naming::nothing; }

bool one_trial(const VerdictEvidence& e, const Settings&) { return e.one_trial; }

bool none_probable(const VerdictEvidence& e, const Settings& s) {
  return !named(e) && e.none > s.likely;
}

/// Whether effects are so much more probable than none that held-out data need not be predicted
/// better than by a robot whose tolerances were fitted, but no worse: tolerances that are all at
/// their ends predict as well, and are as improbable as they are far out.
bool strong(const VerdictEvidence& e, const Settings& s) {
  return e.log_odds >= s.strong_odds && no_worse(e.gap.after, e.gap.adjusted, s);
}

bool small_gap(const VerdictEvidence& e, const Settings& s) {
  if (!e.gap.valid || !(e.gap.adjusted < s.plain_gap)) return false;
  if (!named(e)) return true;
  if (strong(e, s)) return false;
  const double most = (1.0 - s.least_improvement_small_gap) * e.gap.adjusted;
  return e.gap.log_gain <= s.worth_small_gap || e.gap.after >= most;
}

bool unknown_structure(const VerdictEvidence& e, const Settings&) { return !named(e); }

bool no_better_prediction(const VerdictEvidence& e, const Settings& s) {
  if (!e.gap.valid || e.gap.adjusted < s.plain_gap || strong(e, s)) return false;
  const double most = (1.0 - s.least_improvement) * e.gap.adjusted;
  return e.gap.log_gain <= s.worth || e.gap.after >= most;
}

/// Of a gap's energy, what another gap has [-].
double share_left(double before, double after) {
  return before > 1.0 ? std::clamp(energy_left(before, after), 0.0, 1.0) : 0.0;
}

bool less_than_is_left(const VerdictEvidence& e, const Settings& s) {
  if (!e.gap.valid || e.gap.adjusted < s.plain_gap) return false;
  const double before = strong(e, s) ? e.gap.before : e.gap.adjusted;
  return share_left(before, e.gap.after) * s.named_beside > 1.0;
}

/// Whether forces remain that are worth stating: by their share of the gap, or, where what is left
/// is a gap by itself (settings.plain_gap), by a lesser share of what tolerances leave, for the
/// rest may be no effect's.
bool more_is_there(const VerdictEvidence& e, const Settings& s) {
  if (e.naming != Naming::sure || e.lacking <= s.likely || !e.gap.valid) return false;
  if (e.gap.after < s.plain_gap) return share_left(e.gap.before, e.gap.after) > s.remainder_share;
  const double base = std::min(e.gap.before, e.gap.adjusted);
  return share_left(base, e.gap.after) > s.plain_remainder_share;
}

bool one_effect(const VerdictEvidence& e, const Settings&) {
  return e.naming == Naming::sure && e.effects == 1;
}

bool several_effects(const VerdictEvidence& e, const Settings&) { return e.naming == Naming::sure; }

bool rivals(const VerdictEvidence&, const Settings&) { return true; }

}  // namespace

const char* to_text(Verdict verdict) { return kTexts[static_cast<int>(verdict)]; }

Verdict verdict_from(const std::string& text, const std::string& place) {
  const auto found = std::find(kTexts.begin(), kTexts.end(), text);
  if (found == kTexts.end())
    throw InputError(
        place + ": '" + text +
        "' given; allowed: insufficient, none, unexplained, effect, several, partial, ambiguous");
  return static_cast<Verdict>(found - kTexts.begin());
}

const std::vector<VerdictRule>& verdict_rules() {
  static const std::vector<VerdictRule> rules = {
      {"one trial", Verdict::insufficient,
       "one trial: its noise can only be guessed from its own roughness, so no cause is stated; "
       "record three or more",
       one_trial},
      {"none probable", Verdict::none, "", none_probable},
      {"small gap", Verdict::none,
       "the nominal model predicts held-out data as well as a robot within its builder's "
       "tolerances "
       "lets it, and no effect does so much better: no gap is claimed (settings plain_gap, "
       "worth_small_gap, least_improvement_small_gap)",
       small_gap},
      {"unknown structure", Verdict::unexplained, "", unknown_structure},
      {"no better prediction", Verdict::unexplained,
       "the fitted effects predict held-out data no better than the nominal model does within its "
       "builder's tolerances (settings worth, least_improvement)",
       no_better_prediction},
      {"less than is left", Verdict::unexplained,
       "of the held-out gap that builder's tolerances leave, the fitted effects explain less than "
       "they "
       "leave, so that what is named could be the shadow of something else (setting named_beside)",
       less_than_is_left},
      {"more is there", Verdict::partial,
       "what is named stands by evidence and on data that no fit saw, but it is not all: forces "
       "remain that it doesn't explain, and what is missing may bend names and values (settings "
       "remainder_share, plain_remainder_share, plain_gap, prior_lacking)",
       more_is_there},
      {"one effect", Verdict::effect, "", one_effect},
      {"several effects", Verdict::several, "", several_effects},
      {"rivals", Verdict::ambiguous, "", rivals}};

  return rules;
}

const VerdictRule& decide(const VerdictEvidence& evidence, const Settings& settings) {
  const std::vector<VerdictRule>& rules = verdict_rules();
  return *std::find_if(rules.begin(), rules.end(),
                       [&](const VerdictRule& rule) { return rule.applies(evidence, settings); });
}

std::string nearest_text(const std::string& names, const HeldOut& gap, const Settings& settings) {
  if (!gap.valid || gap.after >= settings.plain_gap)
    return "the nearest that was found, which leaves structure beyond noise: " + names;
  return fmt::format(
      "the nearest that was found, which leaves {:.2f} noise floors on trials that no fit saw: {}",
      gap.after, names);
}

}  // namespace jaculus::diagnosis
