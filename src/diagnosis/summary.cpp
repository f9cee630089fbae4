#include "jaculus/diagnosis/summary.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/data/partings.h"
#include "diagnosis/forward/problem.h"
#include "diagnosis/verdict/rules.h"
#include "jaculus/core/units.h"

namespace jaculus::diagnosis {
namespace {

constexpr std::size_t kMostNamed = 3;  // places, effects or channels in a sentence
constexpr double kWorthAWord = 0.05;   // share of the gap's energy
constexpr double kWithinNoise = 1.5;   // of a channel's floor, below which its error is noise

/// "a", "a and b", "a, b and c".
std::string listed(const std::vector<std::string>& parts, const std::string& last = "and") {
  std::string text;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (i > 0) text += i + 1 == parts.size() ? " " + last + " " : ", ";
    text += parts[i];
  }
  return text;
}

std::string per_cent(double share) { return fmt::format("{:.0f} %", 100.0 * share); }

/// As a sentence begins; what begins with a name of the user's ("two_days: ...") stays.
std::string capital(std::string text) {
  const std::string first = text.substr(0, text.find(' '));
  const bool name = first.find_first_of("_:") != std::string::npos;
  if (!text.empty() && !name)
    text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  return text;
}

/// Coordinates along which the judged model lacks most, with the force.
std::vector<std::string> lacking_places(const Diagnosis& d) {
  std::vector<LackingForce> forces = d.lacking;
  std::erase_if(forces, [](const LackingForce& f) { return f.unit == "noise floors"; });
  std::stable_sort(forces.begin(), forces.end(),
                   [](const LackingForce& a, const LackingForce& b) { return a.boxes > b.boxes; });
  std::vector<std::string> places;
  for (const LackingForce& f : forces)
    if (places.size() < kMostNamed)
      places.push_back(fmt::format("{:.2g} {} along {}", f.rms, f.unit, in_words(f.name)));
  return places;
}

/// Pushes that every trial had: "a push of -131 N (-140 to -120) on the body along x from 0.213 to
/// 0.282 s". Empty without any.
std::vector<std::string> push_phrases(const Diagnosis& d) {
  std::vector<std::string> phrases;
  for (const ForceEvent& e : d.events) {
    if (!e.trial.empty()) continue;
    phrases.push_back(
        fmt::format("a push of {:.3g} {} ({:.3g} to {:.3g}) {} from {:.3g} to {:.3g} s", e.peak,
                    e.unit, e.peak_ci95.lower, e.peak_ci95.upper,
                    e.along.empty() ? "at " + in_words(e.joint) : "on the body along " + e.along,
                    e.from, e.to));
  }
  return phrases;
}

/// How many trials a diagnosis has.
int trials_of(const Diagnosis& d) {
  int trials = 0;
  if (d.problem)
    for (const ObservedDataset& observed : d.problem->observations.datasets)
      trials += count_of(observed.dataset.trials);
  return trials;
}

/// " Left and right part in 2 of 4 trials, first at rear b 0.118 s after the start ..." Empty where
/// they don't.
std::string parting_sentence(const Diagnosis& d) {
  const Parting* first = earliest(d.partings);
  if (first == nullptr) return {};
  const ShownUnit shown = shown_unit(first->unit);
  return fmt::format(
      " Left and right part in {} of {} trials, first at {} {:.3g} s after the start (by {:.2g} "
      "{}), "
      "which no model of the plane holds: what follows is not judged.",
      d.partings.size(), trials_of(d), in_words(first->joint), first->from,
      first->most / shown.size, shown.unit);
}

/// Whether anything is left beside pushes that every trial had.
bool more_left(const Diagnosis& d) {
  if (!leading_remainder(d).empty()) return true;
  const std::vector<VerdictRule>& rules = verdict_rules();
  return std::none_of(rules.begin(), rules.end(), [&](const VerdictRule& rule) {
    return rule.name == d.rule && names_effects(rule.verdict) && rule.verdict != Verdict::partial;
  });
}

std::string gap_place(const Diagnosis& d) {
  if (d.verdict == Verdict::insufficient) return "These data can't say where a gap lies.";
  const bool nothing_more = d.effects.empty() && d.verdict == Verdict::unexplained && d.gap.valid &&
                            d.gap.after < d.settings.plain_gap && !more_left(d);
  if (nothing_more && !push_phrases(d).empty())
    return "Something pushed the robot in every trial; beside that no gap is beyond what sensors "
           "and a builder's tolerances allow.";
  if (d.verdict == Verdict::none)
    return "Nowhere: no gap is beyond what sensors and a builder's tolerances allow.";

  std::vector<ComponentShare> shares;
  if (d.where)
    for (const ComponentShare& s : d.where->components)
      if (s.share >= kWorthAWord) shares.push_back(s);
  std::stable_sort(
      shares.begin(), shares.end(),
      [](const ComponentShare& a, const ComponentShare& b) { return a.share > b.share; });
  std::vector<std::string> places;
  for (const ComponentShare& s : shares)
    if (places.size() < kMostNamed)
      places.push_back(fmt::format("{} ({} of its energy)",
                                   in_words(effects::component_name(s.component)),
                                   per_cent(s.share)));

  const std::vector<std::string> lacking = lacking_places(d);
  std::string text = places.empty() ? "The gap has no place that the catalogue could tell"
                                    : "The gap lies in " + listed(places);
  if (d.where && d.where->departure.found) {
    const double time = d.where->departure.time;
    text += time <= 0.0
                ? "; the robot is off the model already when it starts"
                : fmt::format("; the robot leaves the model {:.3g} s after the start", time);
  }
  const bool remains = d.verdict == Verdict::partial || d.verdict == Verdict::unexplained;
  if (remains && !lacking.empty())
    text += fmt::format("; what {} is {} (rms)",
                        d.verdict == Verdict::partial ? "remains" : "it lacks", listed(lacking));
  return text + ".";
}

std::string where_sentence(const Diagnosis& d) { return gap_place(d) + parting_sentence(d); }

/// "tail compliance (stiffness 100 N m/rad, 96 to 104)".
std::string effect_phrase(const FoundEffect& effect) {
  std::string text = in_words(effect.name);
  if (effect.parameters.empty()) return text;
  const FoundParameter& p = effect.parameters.front();
  text += fmt::format(" ({} {:.3g}{}", in_words(p.name), p.value, after_number(p.unit));
  if (std::isfinite(p.ci95.lower) && std::isfinite(p.ci95.upper))
    text += fmt::format(", {:.3g} to {:.3g}", p.ci95.lower, p.ci95.upper);
  for (const FoundParameter& own : effect.parameters)
    if (own.at_bound)
      text += fmt::format("; {} is at its bound, so this is not all of it", in_words(own.name));
  return text + ")";
}

/// Shares as sentences give them: what is beyond nothing and all is noise.
std::string clipped(double share) { return per_cent(std::clamp(share, 0.0, 1.0)); }

/// "A and B explain 69 % of what the builder's tolerances leave of the held-out gap, 1.3 noise
/// floors": where these take nearly all, shares of the whole say nothing of the effects.
std::string explaining_the_rest(const Diagnosis& d, const std::vector<FoundEffect>& effects) {
  std::vector<std::string> phrases;
  for (const FoundEffect& e : effects) phrases.push_back(effect_phrase(e));
  return fmt::format(
      "{} {} {} of what the builder's tolerances leave of the held-out gap, {:.2g} noise floors",
      capital(listed(phrases)), effects.size() > 1 ? "explain" : "explains",
      clipped(1.0 - energy_left(d.gap.adjusted, d.gap.after)), d.gap.adjusted);
}

/// "A explains 73 % of the gap's energy, with B 96 %", the largest share first; empty where there
/// are none.
std::string explaining(const Diagnosis& d) {
  std::vector<FoundEffect> effects = d.effects;
  for (const FoundEffect& e : effects)
    if (!e.share) return {};
  std::stable_sort(effects.begin(), effects.end(), [](const FoundEffect& a, const FoundEffect& b) {
    return a.share->alone > b.share->alone;
  });

  const double all = 1.0 - energy_left(d.gap.before, d.gap.after);
  const double tolerances = effects[0].share->tolerances;
  const bool by_tolerances = tolerances >= kWorthAWord && all - tolerances < kWorthAWord;
  if (by_tolerances && d.gap.adjusted > std::max(1.0, d.gap.after))
    return explaining_the_rest(d, effects);

  std::string text =
      fmt::format("{} explains {} of the held-out gap's energy", capital(effect_phrase(effects[0])),
                  clipped(effects[0].share->alone));
  std::vector<std::string> others;
  for (std::size_t i = 1; i < effects.size(); ++i) others.push_back(effect_phrase(effects[i]));
  if (!others.empty())
    text += fmt::format(", together with {} {}", listed(others), clipped(all - tolerances));
  if (tolerances >= kWorthAWord)
    text += fmt::format(", beside the builder's tolerances ({})", clipped(tolerances));
  return text;
}

/// "kp 0.93 of its stated range, 0.8 to 1".
std::string unknown_phrase(const FittedUnknown& u) {
  return fmt::format("{} {:.2g} {}, {:.2g} to {:.2g}{}", in_words(u.name), u.value,
                     u.kind == "factor" ? "times the first guess" : "of its stated range",
                     u.ci95.lower, u.ci95.upper, u.at_bound ? ", at its bound" : "");
}

/// Whether it is a set's own and not the robot's.
bool is_clock(const FittedUnknown& u) { return u.name.starts_with("clock"); }

/// What values that the files leave open, common to all sets, do to the gap as stated; empty where
/// they do nothing, or no sets tell.
std::string unknowns_sentence(const Agreement& agreement) {
  std::vector<std::string> values, explained, worse;
  for (const FittedUnknown& u : agreement.unknowns)
    if (!is_clock(u)) values.push_back(unknown_phrase(u));
  for (const std::string& channel : agreement.channels()) {
    const double share = agreement.explained(channel, &ChannelAgreement::unknowns);
    if (share >= kWorthAWord)
      explained.push_back(fmt::format("{} in {}", per_cent(share), in_words(channel)));
    else if (share <= -kWorthAWord)
      worse.push_back(in_words(channel));
  }
  if (values.empty() || explained.empty()) return {};

  std::string text = fmt::format(
      "What the files leave open ({}), common to all sets, explains of the gap's energy {}",
      fmt::join(values, "; "), listed(explained));
  if (!worse.empty()) text += fmt::format(", but makes it larger in {}", listed(worse));
  return text + ". ";
}

/// Where a name more likely doesn't hold than does.
std::string doubt_sentence(const Diagnosis& d) {
  double least = 1.0;
  for (const FoundEffect& e : d.effects) least = std::min(least, e.probability);
  if (least >= d.settings.likely) return {};
  return fmt::format(" {} with a probability of {} only: {}, not a finding.",
                     d.effects.size() > 1 ? "Each of these names holds" : "That name holds",
                     per_cent(least), d.effects.size() > 1 ? "candidates" : "a candidate");
}

std::string effects_sentence(const Diagnosis& d) {
  if (d.verdict == Verdict::none) return "No effect is needed.";
  if (d.verdict == Verdict::insufficient)
    return d.reasons.empty() ? "No effect can be named." : capital(d.reasons.front()) + ".";
  const std::string unknowns = unknowns_sentence(d.agreement);
  const std::string left = leading_remainder(d), more = left.empty() ? "" : " " + left;
  if (d.effects.empty())
    return (unknowns.empty()
                ? "No effect of the catalogue is established."
                : unknowns + "Beside that no effect of the catalogue is established.") +
           more;

  std::vector<std::string> named, rivals;
  for (const FoundEffect& e : d.effects)
    if (named.size() < kMostNamed) named.push_back(effect_phrase(e));
  if (d.verdict == Verdict::ambiguous)
    return unknowns + fmt::format(
                          "Probably one of these causes it, and these data can't tell which "
                          "(probabilities beside the names below): {}.",
                          listed(named, "or"));

  for (const FoundEffect& e : d.effects) {
    std::vector<std::string> others;
    for (const std::string& other : e.indistinguishable)
      if (others.size() < kMostNamed) others.push_back(in_words(other));
    if (!others.empty()) rivals.push_back(in_words(e.name) + " from " + listed(others, "or"));
  }
  const char* verb = named.size() > 1 ? "cause" : "causes";
  std::string text = explaining(d);
  if (text.empty()) text = fmt::format("{} {} it", capital(listed(named)), verb);
  if (!rivals.empty()) text += "; these data can't tell " + listed(rivals);
  if (d.verdict == Verdict::partial && more.empty())
    text += "; something else, not named, is there too";
  return unknowns + text + "." + more + doubt_sentence(d);
}

std::string which_sentence(const Diagnosis& d) {
  const std::vector<std::string> pushes = push_phrases(d);
  if (pushes.empty()) return effects_sentence(d);
  return fmt::format(
      "{} acted in every trial: something hits or catches the robot each time, or the model lacks "
      "what acts then. {}",
      capital(listed(pushes)), effects_sentence(d));
}

/// Channels whose error before is farthest above noise.
std::vector<PhysicalGap> telling_channels(const Diagnosis& d) {
  std::vector<PhysicalGap> rows = physical_gaps(d.gap, d.tolerances, d.horizon);
  std::erase_if(rows, [](const PhysicalGap& row) { return !std::isfinite(row.judged.before); });
  std::stable_sort(rows.begin(), rows.end(), [](const PhysicalGap& a, const PhysicalGap& b) {
    return a.judged.before * b.judged.floor > b.judged.before * a.judged.floor;
  });
  if (rows.size() > kMostNamed) rows.resize(kMostNamed);
  return rows;
}

std::string tolerance_phrase(const Diagnosis& d) {
  std::vector<std::string> met, missed;
  for (const PhysicalGap& row : physical_gaps(d.gap, d.tolerances, d.horizon)) {
    if (!row.met) continue;
    std::vector<std::string>& list = *row.met ? met : missed;
    list.push_back(fmt::format("{} ({:.3g} against {:.3g} {})", in_words(row.name),
                               row.judged.after, *row.tolerance, row.unit));
  }
  std::string text;
  if (!met.empty()) text += " Good enough: " + listed(met) + ".";
  if (!missed.empty()) text += " Not good enough: " + listed(missed) + ".";
  return text;
}

std::string how_far_sentence(const Diagnosis& d) {
  const std::vector<PhysicalGap> rows = telling_channels(d);
  if (!d.gap.valid || rows.empty())
    return "How far the gap shrinks can't be told: nothing could be held out.";

  std::vector<std::string> changes;
  const bool falls = std::all_of(rows.begin(), rows.end(), [](const PhysicalGap& row) {
    return row.judged.after < row.judged.before;
  });
  const bool models_differ = !d.model.candidates.empty();
  for (const PhysicalGap& row : rows) {
    const std::string unit = " " + row.unit;
    changes.push_back(models_differ ? fmt::format("{} from {:.3g} to {:.3g}{}", in_words(row.name),
                                                  row.judged.before, row.judged.after, unit)
                                    : fmt::format("{} {:.3g}{} (noise {:.2g})", in_words(row.name),
                                                  row.judged.before, unit, row.judged.floor));
  }
  std::string text = fmt::format("{} {} (rms up to {:.2g} s after the start, {} that no fit saw)",
                                 models_differ ? falls ? "Error falls in" : "Error changes in"
                                               : "The nominal model's error is, in",
                                 listed(changes), rows.front().judged.reach,
                                 d.gap.over == "time" ? "windows" : in_words(d.gap.over));
  if (models_differ && d.gap.before >= kWithinNoise)
    text += fmt::format(": {} of the gap's energy",
                        clipped(1.0 - energy_left(d.gap.before, d.gap.after)));
  return text + "." + tolerance_phrase(d);
}

}  // namespace

std::string in_words(std::string name) {
  std::replace(name.begin(), name.end(), '_', ' ');
  return name;
}

Summary summary_of(const Diagnosis& diagnosis) {
  return {where_sentence(diagnosis), which_sentence(diagnosis), how_far_sentence(diagnosis)};
}

}  // namespace jaculus::diagnosis
