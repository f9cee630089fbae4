#include "report/diagnosis_tables.h"

#include <fmt/format.h>

#include <cmath>

namespace jaculus::report {
namespace {

std::string energy_share(double share) {
  return std::isfinite(share) ? fmt::format("{:.0f} %", 100.0 * share) : "–";
}

std::string yes_or_no(const std::optional<bool>& met) { return !met ? "–" : *met ? "yes" : "no"; }

}  // namespace

std::string shown(double value, int digits) {
  return std::isfinite(value) ? fmt::format("{:.{}g}", value, digits) : "–";
}

ReportTable parameter_table(const diagnosis::Diagnosis& d) {
  ReportTable table{"Parameters of what was found",
                    {"effect", "probability", "parameter", "value", "95 % from", "to", "unit"},
                    {},
                    ""};
  for (const diagnosis::FoundEffect& e : d.effects) {
    for (const diagnosis::FoundParameter& p : e.parameters) {
      std::string unit = p.unit;
      if (p.at_bound) unit += ", at its bound";
      if (p.cut_by_range) unit += ", cut by its range";
      table.rows.push_back({plain(e.name), shown(e.probability, 3), plain(p.name), shown(p.value),
                            shown(p.ci95.lower), shown(p.ci95.upper), unit});
    }
    if (e.parameters.empty())
      table.rows.push_back({plain(e.name), shown(e.probability, 3), "–", "–", "–", "–", "–"});
  }
  return table;
}

ReportTable share_table(const diagnosis::Diagnosis& d) {
  ReportTable table{
      "What each explains of the held-out gap's energy",
      {"effect", "alone", "lost without it", "mean over orders", "95 % from", "to"},
      {},
      "The mean is over the orders in which the effects may join (Shapley); these sum "
      "to what the set explains."};
  for (const diagnosis::FoundEffect& e : d.effects) {
    if (!e.share) continue;
    table.rows.push_back({plain(e.name), energy_share(e.share->alone), energy_share(e.share->last),
                          energy_share(e.share->shapley), energy_share(e.share->ci95.lower),
                          energy_share(e.share->ci95.upper)});
  }
  return table;
}

ReportTable event_table(const diagnosis::Diagnosis& d) {
  ReportTable table{"Forces that acted once",
                    {"trial", "joint", "from [s]", "to [s]", "peak", "95 % from", "to", "unit"},
                    {},
                    "Of half a sine that is most like each."};
  for (const diagnosis::ForceEvent& e : d.events)
    table.rows.push_back({e.trial.empty() ? "each" : plain(e.trial),
                          plain(e.along.empty() ? e.joint : e.joint + " " + e.along),
                          shown(e.from, 3), shown(e.to, 3), shown(e.peak, 3),
                          shown(e.peak_ci95.lower, 3), shown(e.peak_ci95.upper, 3), e.unit});
  return table;
}

ReportTable physical_table(const diagnosis::Diagnosis& d) {
  ReportTable table{
      "By channel, root mean square up to a horizon",
      {"channel", "unit", "up to", "before", "after", "noise alone"},
      {},
      "Before: the model as believed. After: with what was found. Noise alone: what a "
      "perfect model is expected to leave."};
  const bool asked = !d.tolerances.empty();
  if (asked) table.columns.insert(table.columns.end(), {"tolerance", "met", "met before"});
  for (const auto& row : diagnosis::physical_gaps(d.gap, d.tolerances, d.horizon)) {
    for (const diagnosis::HorizonGap& gap : row.horizons) {
      table.rows.push_back({plain(row.name), row.unit, fmt::format("{:.3g} s", gap.reach),
                            shown(gap.before, 3), shown(gap.after, 3), shown(gap.floor, 2)});
      if (!asked) continue;
      const bool judged = row.tolerance && gap.horizon == row.judged.horizon;
      for (const std::string& cell :
           {judged ? shown(*row.tolerance, 3) : "–", judged ? yes_or_no(row.met) : "–",
            judged ? yes_or_no(row.met_before) : "–"})
        table.rows.back().push_back(cell);
    }
  }
  return table;
}

}  // namespace jaculus::report
