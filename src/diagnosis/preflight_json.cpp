#include <array>
#include <nlohmann/json.hpp>

#include "jaculus/core/json.h"
#include "jaculus/diagnosis/preflight.h"
#include "jaculus/trajectory/csv.h"

namespace jaculus::diagnosis {
namespace {

using Json = nlohmann::ordered_json;

Json planned_effect_json(const PlannedEffect& e) {
  return {{"name", e.name},
          {"caption", e.caption},
          {"parameter", e.parameter},
          {"unit", e.unit},
          {"visible", e.structural},
          {"stated", json_number(e.stated)},
          {"named", e.named},
          {"log_odds", json_number(e.log_odds)},
          {"gap", json_number(e.gap)},
          {"least", json_number(e.least)},
          {"least_of_prior_scale", json_number(e.least_scales)},
          {"least_of_bounds", json_number(e.least_of_bounds)}};
}

Json planned_pair_json(const PlannedPair& p) {
  Json by = Json::array();
  for (const TellingChange& change : p.by)
    by.push_back({{"kind", change.kind},
                  {"name", change.name},
                  {"expected_log_bayes_factor", json_number(change.log_bayes_factor)}});
  return {{"effects", {p.a, p.b}},
          {"tellable", p.tellable},
          {"at_work", {name_of(p.with_a), name_of(p.with_b)}},
          {"chance_told", {json_number(p.chance_a), json_number(p.chance_b)}},
          {"structural", p.structural},
          {"expected_log_bayes_factor", {json_number(p.told_a), json_number(p.told_b)}},
          {"told_by", by}};
}

}  // namespace

const char* name_of(Telling telling) {
  constexpr std::array<const char*, 5> names = {"not_judged", "told", "ambiguous", "taken", "open"};
  return names[static_cast<std::size_t>(telling)];
}

std::string preflight_json(const Preflight& p) {
  Json effects = Json::array(), pairs = Json::array(), following = Json::array();
  for (const PlannedEffect& e : p.effects) effects.push_back(planned_effect_json(e));
  for (const PlannedPair& pair : p.pairs) pairs.push_back(planned_pair_json(pair));
  for (const FollowingExperiment& f : p.following)
    following.push_back({{"experiment", f.name},
                         {"information_bit", json_number(f.information)},
                         {"pairs_told", f.told}});
  Json settings = Json::object();
  for (const SettingRow& row : setting_rows(p.settings)) settings[row.name] = row.value;

  const Json root = {{"format", "jaculus-preflight/1"},
                     {"experiment", p.experiment},
                     {"robot", p.robot},
                     {"possible", p.reasons.empty()},
                     {"summary", preflight_sentences(p)},
                     {"reasons", p.reasons},
                     {"notes", p.notes},
                     {"size", p.size},
                     {"effects", effects},
                     {"pairs", pairs},
                     {"sets", p.sets},
                     {"information_bit", json_number(p.information)},
                     {"uncertainty_bit", json_number(p.uncertainty)},
                     {"next", following},
                     {"settings", settings}};
  return root.dump(1) + "\n";
}

void write_preflight(const Preflight& preflight, const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  trajectory::write_file(folder / "preflight.json", preflight_json(preflight));
}

}  // namespace jaculus::diagnosis
