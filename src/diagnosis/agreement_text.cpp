#include "diagnosis/agreement_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "jaculus/core/json.h"
#include "jaculus/diagnosis/physical.h"

namespace jaculus::diagnosis {
namespace {

using Json = nlohmann::ordered_json;

/// "x 13.9 -> 1.8 mm (held out 2.0)".
std::string channel_text(const ChannelAgreement& c) {
  const ShownUnit shown = shown_unit(c.unit);
  return fmt::format("{} {:.3g} -> {:.3g} {} (held out {:.3g}, unknowns alone {:.3g})", c.channel,
                     c.stated / shown.size, c.account / shown.size, shown.unit,
                     c.held_out / shown.size, c.unknowns / shown.size);
}

}  // namespace

Json agreement_json(const Agreement& agreement) {
  Json unknowns = Json::object(), sets = Json::array(), explained = Json::object();
  for (const FittedUnknown& u : agreement.unknowns)
    unknowns[u.name] = {
        {"kind", u.kind},
        {"value", json_number(u.value)},
        {"ci95", Json::array({json_number(u.ci95.lower), json_number(u.ci95.upper)})},
        {"at_bound", u.at_bound}};

  for (const SetAgreement& set : agreement.sets) {
    Json channels = Json::object();
    for (const ChannelAgreement& c : set.channels)
      channels[c.stream + "." + c.channel] = {{"unit", c.unit},
                                              {"stated", json_number(c.stated)},
                                              {"unknowns_fitted", json_number(c.unknowns)},
                                              {"account", json_number(c.account)},
                                              {"held_out", json_number(c.held_out)},
                                              {"noise_floor", json_number(c.noise_floor)}};
    sets.push_back({{"dataset", set.dataset},
                    {"agrees", set.agrees},
                    {"harmed_by", set.harmed_by},
                    {"gap_rms", channels}});
  }

  for (const std::string& channel : agreement.channels()) {
    const auto share = [&](double ChannelAgreement::*after) {
      return json_number(agreement.explained(channel, after));
    };
    explained[channel] = {{"unknowns_fitted", share(&ChannelAgreement::unknowns)},
                          {"account", share(&ChannelAgreement::account)},
                          {"held_out", share(&ChannelAgreement::held_out)}};
  }
  return {{"unknowns", unknowns},
          {"unknowns_pass_for", agreement.hidden},
          {"sets", sets},
          {"energy_explained", explained}};
}

std::string agreement_text(const Agreement& agreement) {
  std::string text;
  for (const FittedUnknown& u : agreement.unknowns)
    text +=
        fmt::format("left open by the files: {}, {} {:.3g} [{:.3g}, {:.3g}]{}\n", u.name, u.kind,
                    u.value, u.ci95.lower, u.ci95.upper, u.at_bound ? ", at its bound" : "");
  if (!agreement.hidden.empty())
    text += fmt::format("the unknowns can pass for: {}\n", fmt::join(agreement.hidden, ", "));

  for (const SetAgreement& set : agreement.sets) {
    std::vector<std::string> parts;
    for (const ChannelAgreement& c : set.channels) parts.push_back(channel_text(c));
    const std::string harm =
        set.harmed_by.empty() ? "" : fmt::format(", harmed by {}", fmt::join(set.harmed_by, ", "));
    text += fmt::format("{}: {}{}; rms of {}\n", set.dataset,
                        set.agrees ? "agrees" : "does not agree", harm, fmt::join(parts, ", "));
  }

  for (const std::string& channel : agreement.channels())
    text +=
        fmt::format("{} over all sets: {:.0f} % of the gap's energy explained, {:.0f} % held out\n",
                    channel, 100.0 * agreement.explained(channel, &ChannelAgreement::account),
                    100.0 * agreement.explained(channel, &ChannelAgreement::held_out));
  return text;
}

}  // namespace jaculus::diagnosis
