// A diagnosis for terminals.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "diagnosis/agreement_text.h"
#include "jaculus/core/units.h"
#include "jaculus/diagnosis/diagnosis_json.h"
#include "jaculus/diagnosis/summary.h"

namespace jaculus::diagnosis {
namespace {

constexpr std::size_t kMostTolerated = 4;  // tolerances in a line

std::string shown_number(double value) {
  return std::isfinite(value) ? fmt::format("{:.4g}", value) : "-";
}

std::string share_per_cent(double share) {
  return std::isfinite(share) ? fmt::format("{:.0f} %", 100.0 * share) : "-";
}

std::string share_text(const EffectShare& share) {
  const std::string interval = std::isfinite(share.ci95.lower)
                                   ? fmt::format(" [{}, {}]", share_per_cent(share.ci95.lower),
                                                 share_per_cent(share.ci95.upper))
                                   : "";
  const std::string own = "    of the held-out gap's energy: " + share_per_cent(share.alone);
  if (!std::isfinite(share.last)) return own + " alone, in place of the first\n";
  if (share.alone == share.last) return own + interval + "\n";
  std::string text = own + " alone, " + share_per_cent(share.last) + " lost without it";
  if (std::isfinite(share.shapley))
    text += ", " + share_per_cent(share.shapley) + interval + " on the mean over orders";
  return text + "\n";
}

/// What the parameter's range has to do with what is stated.
const char* range_text(const FoundParameter& p) {
  if (p.at_bound) return ", at its bound";
  return p.cut_by_range ? ", cut where its range ends" : "";
}

std::string effects_text(const Diagnosis& d) {
  std::string text;
  for (const FoundEffect& e : d.effects) {
    text += fmt::format("  {:<26} p {:.2f}", e.name, e.probability);
    for (const FoundParameter& p : e.parameters)
      text += fmt::format("  {} {} [{}, {}]{}{}", p.name, shown_number(p.value),
                          shown_number(p.ci95.lower), shown_number(p.ci95.upper),
                          after_number(p.unit), range_text(p));
    text += "\n";
    if (e.share) text += share_text(*e.share);
    if (!e.indistinguishable.empty())
      text +=
          fmt::format("    not told apart here from: {}\n", fmt::join(e.indistinguishable, ", "));
  }
  return text;
}

/// Where the robot is off its files within its builder's tolerances.
std::string tolerated_text(const Diagnosis& d) {
  if (d.tolerated.empty()) return {};
  std::vector<std::string> rows;
  for (const Tolerated& t : d.tolerated)
    if (rows.size() < kMostTolerated)
      rows.push_back(
          fmt::format("{} {:+.1f} [{:.1f}, {:.1f}]", t.name, t.value, t.ci95.lower, t.ci95.upper));
  return fmt::format("within the builder's tolerances, in deviations: {}{}\n",
                     fmt::join(rows, ", "), d.tolerated.size() > rows.size() ? ", ..." : "");
}

/// "0.71 mm to 0.5 s".
std::string judged_text(double error, const PhysicalGap& row) {
  if (!std::isfinite(error)) return "not judged";
  return fmt::format("{:.3g} {} up to {:.3g} s", error, row.unit, row.judged.reach);
}

std::string tolerance_text(const PhysicalGap& row) {
  const auto verdict = [](const std::optional<bool>& met) {
    return !met ? "can't be judged" : *met ? "met" : "not met";
  };
  const std::string asked =
      fmt::format("tolerance {} {:.4g} {}: ", row.name, *row.tolerance, row.unit);
  if (!row.met) return asked + "can't be judged, for nothing could be held out of this channel\n";
  std::string text =
      asked + fmt::format("{} by the augmented model ({}), {} by the nominal one ({})\n",
                          verdict(row.met), judged_text(row.judged.after, row),
                          verdict(row.met_before), judged_text(row.judged.before, row));
  if (*row.tolerance < row.judged.floor)
    text += fmt::format("  noise and starts alone make {:.3g} {} here: no model could meet it\n",
                        row.judged.floor, row.unit);
  return text;
}

/// Behind the point; "-" where it can't be told.
std::string two_digits(double value) {
  return std::isfinite(value) ? fmt::format("{:.2f}", value) : "-";
}

/// Errors in units first, noise floors after them.
std::string gap_text(const Diagnosis& d) {
  const std::vector<PhysicalGap> rows = physical_gaps(d.gap, d.tolerances, d.horizon);
  std::string text;
  if (d.gap.valid) {
    text += fmt::format("error on held-out {} (rms): before -> after, and what noise alone makes\n",
                        d.gap.over);
    for (const PhysicalGap& row : rows) {
      text += fmt::format("  {:<22}", row.name);
      for (const HorizonGap& gap : row.horizons)
        text += fmt::format("  {:>7.3g} -> {:<7.3g} ({:.2g}) {} to {:.3g} s", gap.before, gap.after,
                            gap.floor, row.unit, gap.reach);
      text += "\n";
    }
    text += fmt::format("gap on held-out {}: {:.2f} noise floors before, {:.2f} after", d.gap.over,
                        d.gap.before, d.gap.after);
    if (d.gap.shrink)
      text += fmt::format(", shrink {} [{}, {}]", two_digits(*d.gap.shrink),
                          two_digits(d.gap.ci95.lower), two_digits(d.gap.ci95.upper));
    if (std::isfinite(d.gap.adjusted))
      text += fmt::format("; the builder's tolerances alone leave {:.2f}", d.gap.adjusted);
    text += "\n";
  }

  for (const PhysicalGap& row : rows)
    if (row.tolerance) text += tolerance_text(row);
  return text;
}

std::string events_text(const Diagnosis& d) {
  std::string text;
  if (!d.events.empty()) text += "forces that acted briefly (peak):\n";
  for (const ForceEvent& e : d.events) {
    const std::string place = e.along.empty() ? e.joint : e.joint + " " + e.along;
    text += fmt::format("  {:<10} {:<12} {:6.2f} to {:.2f} s  {:.3g}",
                        e.trial.empty() ? "each trial" : e.trial, place, e.from, e.to, e.peak);
    if (std::isfinite(e.peak_ci95.lower))
      text += fmt::format(" [{}, {}]", shown_number(e.peak_ci95.lower),
                          shown_number(e.peak_ci95.upper));
    text += fmt::format(
        " {}{}\n", e.unit,
        e.every_trial && !e.trial.empty() ? " (at that time in most other trials too)" : "");
  }
  return text;
}

}  // namespace

std::string diagnosis_text(const Diagnosis& d) {
  const Summary summary = summary_of(d);
  std::string text = fmt::format("verdict: {}\n  where: {}\n  which: {}\n  how far: {}\n",
                                 to_text(d.verdict), summary.where, summary.which, summary.how_far);
  for (const std::string& reason : d.reasons) text += "  " + reason + "\n";
  text += effects_text(d);
  text += tolerated_text(d);
  text += gap_text(d);
  for (const std::string& sentence : remainder_sentences(d)) text += sentence + "\n";
  text += events_text(d);
  text += agreement_text(d.agreement);

  if (!d.ranking.empty())
    text += fmt::format("\n{:<44} {:>6} {:>12} {:>9}\n", "ranking, most probable first", "p",
                        "log evidence", "held out");
  std::size_t rows = 0;
  for (const Ranked& r : d.ranking) {
    if (++rows > 10) break;
    text += fmt::format("{:<44} {:>6.2f} {:>12} {:>9}\n", r.effect, r.probability,
                        shown_number(r.log_evidence), shown_number(r.held_out_error));
  }

  if (d.next)
    text += fmt::format("\nto tell them apart: {} (expected log Bayes factor {:.1f})\n",
                        d.next->experiment, d.next->log_bayes_factor);
  for (const std::string& note : d.notes) text += "note: " + note + "\n";
  return text;
}

}  // namespace jaculus::diagnosis
