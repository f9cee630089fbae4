#include "jaculus/report/preflight_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "report/document/document.h"

namespace jaculus::report {
namespace {

using diagnosis::PlannedEffect;
using diagnosis::PlannedPair;
using diagnosis::Preflight;

std::string number_cell(double value, const char* format = "{:.3g}") {
  return std::isfinite(value) ? fmt::format(fmt::runtime(format), value) : "-";
}

/// "ambiguous (0.4)".
std::string way_cell(double factor, const char* telling) {
  return std::isfinite(factor) ? fmt::format("{} ({:.1f})", plain(telling), factor)
                               : plain(telling);
}

Section seen_section(const Preflight& p) {
  ReportTable table{"Named from which size on",
                    {"effect", "parameter", "stated", "least", "unit", "of the prior scale",
                     "of the bound", "log odds as stated", "gap as stated"},
                    {},
                    "Log odds are expected, against no effect, with prior odds; the gap is in "
                    "noise floors. No least size: not named within the bounds."};
  for (const PlannedEffect& e : p.effects)
    table.rows.push_back({plain(e.name), plain(e.parameter), number_cell(e.stated),
                          e.structural ? number_cell(e.least) : "nothing is recorded of it", e.unit,
                          number_cell(e.least_scales), number_cell(e.least_of_bounds),
                          number_cell(e.log_odds, "{:.1f}"), number_cell(e.gap, "{:.2f}")});
  return {"Which effects would be seen", {}, {}, {table}};
}

/// Expected log Bayes factors, rows at work, columns as rivals, of effects in sets.
HeatMap factor_map(const Preflight& p) {
  HeatMap map{
      "told_apart",
      "Expected log Bayes factors",
      "at work",
      "rival",
      {},
      {},
      {},
      fmt::format("Below {:g} two effects can't be told apart; above 20 all are shown alike.",
                  p.settings.indistinguishable_below)};
  std::vector<std::string> names;
  for (const auto& set : p.sets) names.insert(names.end(), set.begin(), set.end());
  for (const std::string& name : names) map.rows.push_back(plain(name));
  map.columns = map.rows;
  map.values.assign(names.size(), std::vector<double>(names.size(), kNaN));
  for (const PlannedPair& pair : p.pairs) {
    const int a = index_of(names, pair.a), b = index_of(names, pair.b);
    if (a < 0 || b < 0) continue;
    map.values[a][b] = std::min(20.0, pair.told_a);
    map.values[b][a] = std::min(20.0, pair.told_b);
  }
  return map;
}

Section pair_section(const Preflight& p) {
  ReportTable table{"Pairs that could not be told apart",
                    {"effect", "other", "first at work", "second at work", "in exact data",
                     "what would tell them"},
                    {},
                    "With expected log Bayes factors. Taken: for the other."};
  for (const PlannedPair& pair : p.pairs) {
    if (pair.tellable) continue;
    std::string by;
    for (const diagnosis::TellingChange& change : pair.by)
      by += fmt::format("{}{} {} ({:.1f})", by.empty() ? "" : "; ", change.kind, change.name,
                        change.log_bayes_factor);
    table.rows.push_back({plain(pair.a), plain(pair.b), way_cell(pair.told_a, name_of(pair.with_a)),
                          way_cell(pair.told_b, name_of(pair.with_b)),
                          pair.structural ? "the same" : "different", by.empty() ? "-" : by});
  }
  Section section{"Which could not be told apart"};
  if (table.rows.empty()) {
    section.text.emplace_back("All pairs of which one would be named could be told apart.");
    return section;
  }
  section.tables.push_back(std::move(table));
  section.heat_maps.push_back(factor_map(p));
  return section;
}

Section next_section(const Preflight& p) {
  ReportTable table{
      "Experiments that could follow",
      {"experiment", "information of both [bit]", "pairs told more"},
      {},
      fmt::format("The planned one alone: {:.2f} bit of {:.2f}.", p.information, p.uncertainty)};
  for (const diagnosis::FollowingExperiment& f : p.following)
    table.rows.push_back({f.name, number_cell(f.information, "{:.2f}"), fmt::format("{}", f.told)});
  return {"What to record next", {}, {}, {table}};
}

}  // namespace

Report preflight_report(const Preflight& p) {
  Document document;
  document.kind = "preflight";
  document.title = p.experiment;
  document.caption = "What the planned experiment could tell";
  document.facts = {{"robot", p.robot}, {"effects", fmt::format("{}", p.effects.size())}};
  document.notices = p.notes;
  const std::vector<std::string> questions = {"What would be seen", "What could not be told apart",
                                              "What next"};
  const std::vector<std::string> sentences = preflight_sentences(p);
  for (std::size_t i = 0; i < sentences.size(); ++i)
    document.summary.emplace_back(questions[i], sentences[i]);
  if (p.reasons.empty()) document.sections = {seen_section(p), pair_section(p)};
  if (!p.following.empty()) document.sections.push_back(next_section(p));
  return finished(std::move(document));
}

}  // namespace jaculus::report
