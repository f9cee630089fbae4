#include "jaculus/diagnosis/diagnosis_json.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "diagnosis/agreement_text.h"
#include "diagnosis/noise/noise_model.h"
#include "diagnosis/remainder/hypothesis.h"
#include "diagnosis/remainder_json.h"
#include "jaculus/core/json.h"
#include "jaculus/diagnosis/summary.h"
#include "jaculus/effects/select.h"
#include "jaculus/trajectory/csv.h"

namespace jaculus::diagnosis {
namespace {

using effects::component_name;
using effects::ModelOverride;
using model::PlanarModel;
using simulation::Plant;
using Json = nlohmann::ordered_json;

Json pair(const Bounds& b) { return Json::array({json_number(b.lower), json_number(b.upper)}); }

Json share_json(const std::optional<EffectShare>& share) {
  if (!share) return nullptr;
  return {{"alone", json_number(share->alone)},
          {"last", json_number(share->last)},
          {"shapley", json_number(share->shapley)},
          {"tolerances", json_number(share->tolerances)},
          {"ci95", pair(share->ci95)}};
}

/// Joints that an effect acts at, or whose links it acts on; none where it acts elsewhere.
std::vector<std::string> joints_of(const Diagnosis& d, const std::string& effect) {
  if (!d.problem || d.problem->observations.datasets.empty()) return {};
  const int c = d.problem->hypotheses.candidate(effect);
  if (c < 0) return {};
  const effects::Effect* own = d.problem->hypotheses.candidates[c].effect;
  if (own == nullptr || !own->joints) return {};
  return own->joints(d.problem->observations.datasets.front().model);
}

/// What stands in for an effect, each a set of effects.
Json stand_ins(const FoundEffect& effect) {
  Json sets = Json::array();
  for (const std::string& other : effect.indistinguishable) sets.push_back(Json::array({other}));
  return sets;
}

Json effects_json(const Diagnosis& d) {
  Json list = Json::array();
  for (const FoundEffect& e : d.effects) {
    Json parameters = Json::object();
    for (const FoundParameter& p : e.parameters)
      parameters[p.name] = {{"value", json_number(p.value)},
                            {"ci95", pair(p.ci95)},
                            {"unit", p.unit},
                            {"at_bound", p.at_bound},
                            {"cut_by_range", p.cut_by_range}};
    list.push_back({{"name", e.name},
                    {"at", joints_of(d, e.name)},
                    {"caption", e.caption},
                    {"probability", e.probability},
                    {"parameters", parameters},
                    {"share", share_json(e.share)},
                    {"indistinguishable", stand_ins(e)},
                    {"like", e.indistinguishable}});
  }
  return list;
}

Json tolerated_json(const Diagnosis& d) {
  Json list = Json::array();
  for (const Tolerated& t : d.tolerated)
    list.push_back(
        {{"name", t.name}, {"deviations", json_number(t.value)}, {"ci95", pair(t.ci95)}});
  return list;
}

Json channel_json(const Channel& channel, double gap, double noise_floor) {
  return {{"gap", json_number(gap)},
          {"noise_floor", json_number(noise_floor)},
          {"unit", channel.unit},
          {"stream", channel.stream}};
}

Json channels_json(const Diagnosis& d) {
  Json channels = Json::object();
  if (d.where) {
    for (const ChannelGap& c : d.where->channels)
      channels[c.name] = channel_json({c.stream, c.name, c.unit}, c.gap, c.noise_floor);
    return channels;
  }
  if (!d.problem) return channels;

  for (int i = 0; i < count_of(d.problem->observations.datasets); ++i) {
    const ObservedDataset& observed = d.problem->observations.datasets[i];
    for (int k = 0; k < count_of(observed.channels); ++k) {
      const Channel& channel = observed.channels[k];
      const double floor = d.noise ? d.noise->datasets[i].channels[k].noise_floor : kNaN;
      const auto found = d.gap.channels.find(channel.stream + "." + channel.name);
      const double gap = found == d.gap.channels.end() ? kNaN : found->second.before * floor;
      channels[channel.name] = channel_json(channel, gap, floor);
    }
  }
  return channels;
}

Json shares(const std::vector<ComponentShare>& list, bool detail) {
  Json out = Json::object();
  for (const ComponentShare& s : list) {
    Json& entry = out[component_name(s.component)];
    if (detail) {
      entry = {{"share", json_number(s.share)}, {"ci95", pair(s.ci95)}, {"visible", s.visible}};
    } else {
      entry = json_number(s.share);
    }
  }
  return out;
}

/// What the judged model lacks along each coordinate.
Json lacking_json(const Diagnosis& d) {
  Json joints = Json::object();
  for (const LackingForce& force : d.lacking)
    joints[force.name] = {{"residual_rms", json_number(force.rms)}, {"unit", force.unit}};
  return joints;
}

/// Of each of several datasets the gap, predicted by what was fitted to the others, and whether the
/// account holds there.
Json datasets_json(const Diagnosis& d) {
  Json list = Json::array();
  for (std::size_t i = 0; i < d.agreement.sets.size(); ++i) {
    const SetAgreement& set = d.agreement.sets[i];
    const bool judged = d.gap.over == "conditions" && i < d.gap.by_fold.size();
    const FoldGap gap = judged ? d.gap.by_fold[i] : FoldGap{};
    list.push_back(
        {{"name", set.dataset},
         {"gap", {{"before", json_number(gap.before)}, {"after", json_number(gap.after)}}},
         {"agrees", set.agrees}});
  }
  return list;
}

Json where_json(const Diagnosis& d) {
  Json where = {{"components", Json::object()},
                {"joints", lacking_json(d)},
                {"phases", Json::object()},
                {"first_departure_s", nullptr},
                {"channels", channels_json(d)}};
  if (!d.where) return where;
  where["components"] = shares(d.where->components, false);
  where["component_intervals"] = shares(d.where->components, true);
  for (const PhaseShare& phase : d.where->phases)
    where["phases"][phase.name] = json_number(phase.share);
  if (d.where->departure.found) where["first_departure_s"] = json_number(d.where->departure.time);
  where["first_departure_ci95"] = pair(d.where->departure.ci95);
  where["unexplained"] = json_number(d.where->unexplained);
  where["notes"] = d.where->notes;
  return where;
}

Json flag(const std::optional<bool>& value) { return value ? Json(*value) : Json(nullptr); }

Json horizon_json(const HorizonGap& gap) {
  return {{"horizon_s", json_number(gap.reach)},
          {"whole", gap.horizon == kInfinity},
          {"before", json_number(gap.before)},
          {"after", json_number(gap.after)},
          {"floor", json_number(gap.floor)}};
}

/// Errors in units that people read, at the horizon that is judged and at all of them.
Json physical_json(const Diagnosis& d) {
  Json channels = Json::object();
  for (const PhysicalGap& row : physical_gaps(d.gap, d.tolerances, d.horizon)) {
    Json& entry = channels[row.name] = {{"unit", row.unit}};
    entry.update(horizon_json(row.judged));
    entry["tolerance"] = row.tolerance ? json_number(*row.tolerance) : Json(nullptr);
    entry["met"] = flag(row.met);
    entry["met_before"] = flag(row.met_before);
    entry["horizons"] = Json::array();
    for (const HorizonGap& gap : row.horizons) entry["horizons"].push_back(horizon_json(gap));
  }
  return channels;
}

Json gap_json(const Diagnosis& d) {
  Json channels = Json::object();
  for (const auto& [name, c] : d.gap.channels)
    channels[name] = {{"before", json_number(c.before)}, {"after", json_number(c.after)}};
  return {{"before", json_number(d.gap.before)},
          {"after", json_number(d.gap.after)},
          {"noise_floor", 1.0},
          {"within_tolerances", json_number(d.gap.adjusted)},
          {"energy_explained",
           d.gap.valid ? json_number(1.0 - energy_left(d.gap.before, d.gap.after)) : Json(nullptr)},
          {"shrink", d.gap.shrink ? json_number(*d.gap.shrink) : Json(nullptr)},
          {"ci95", pair(d.gap.ci95)},
          {"held_out", d.gap.over},
          {"folds", d.gap.folds},
          {"physical", physical_json(d)},
          {"per_channel", channels}};
}

/// `name:parameter=value,...` of one chosen effect.
std::string effect_text(const Diagnosis& d, int candidate, const Vector& theta) {
  const Candidate& c = d.problem->hypotheses.candidates[candidate];
  std::vector<std::string> parts;
  for (std::size_t k = 0; k < c.parameters.size(); ++k)
    parts.push_back(fmt::format("{}={}", c.effect->parameters[k].name, theta[count_of(parts)]));
  return fmt::format("{}:{}", c.name, fmt::join(parts, ","));
}

/// hypothesis.yaml, hypothesis_2.yaml, ...; those of an earlier diagnosis go.
void write_hypotheses(const Diagnosis& d, const std::filesystem::path& folder) {
  const auto file = [&](std::size_t i) {
    return folder / (i == 0 ? "hypothesis.yaml" : fmt::format("hypothesis_{}.yaml", i + 1));
  };
  std::vector<std::string> texts;
  if (d.problem && !d.problem->observations.datasets.empty())
    texts = hypotheses_of(d.remainder, d.problem->observations.datasets.front().model);
  for (std::size_t i = 0; i < texts.size(); ++i) trajectory::write_file(file(i), texts[i]);
  for (std::size_t i = texts.size(); std::filesystem::exists(file(i)); ++i)
    std::filesystem::remove(file(i));
}

}  // namespace

std::string diagnosis_json(const Diagnosis& d) {
  Json ranking = Json::array(), disturbances = Json::array();
  for (const Ranked& r : d.ranking) {
    Json parameters = Json::object();
    for (const FoundParameter& p : r.parameters)
      parameters[p.name] = {{"value", json_number(p.value)}, {"unit", p.unit}};
    ranking.push_back({{"effect", r.effect},
                       {"log_evidence", json_number(r.log_evidence)},
                       {"held_out_error", json_number(r.held_out_error)},
                       {"probability", r.probability},
                       {"parameters", parameters}});
  }

  for (const OneOff& one : d.disturbances)
    disturbances.push_back({{"trial", one.trial},
                            {"from_s", one.onset},
                            {"channel", one.channel},
                            {"excess", one.excess}});
  const Summary summary = summary_of(d);
  Json json = {{"format", "jaculus-diagnosis/2"},
               {"verdict", to_text(d.verdict)},
               {"summary",
                {{"where", summary.where}, {"which", summary.which}, {"how_far", summary.how_far}}},
               {"reasons", d.reasons},
               {"effects", effects_json(d)},
               {"within_tolerances", tolerated_json(d)},
               {"ranking", ranking},
               {"where", where_json(d)},
               {"gap", gap_json(d)},
               {"remainder", remainder_json(d)},
               {"datasets", datasets_json(d)},
               {"agreement", agreement_json(d.agreement)},
               {"disturbances", disturbances},
               {"notes", d.notes}};
  json["settings"] = Json::object();

  for (const SettingRow& row : setting_rows(d.settings)) json["settings"][row.name] = row.value;
  json["discriminating_experiment"] = nullptr;
  if (d.next) {
    json["discriminating_experiment"] = {
        {"experiment", d.next->experiment},
        {"expected_log_bayes_factor", json_number(d.next->log_bayes_factor)}};
  }

  return json.dump(2) + "\n";
}

std::string augmented_yaml(const Diagnosis& d) {
  std::string text = "format: jaculus-augmented/1\n";
  if (!d.problem || d.problem->observations.datasets.empty()) return text + "effects: []\n";

  const ObservedDataset& observed = d.problem->observations.datasets.front();
  text += fmt::format("robot: {}\n", observed.dataset.robot);
  std::vector<ModelOverride> overrides;
  for (const auto& [path, value] : observed.dataset.overrides) overrides.emplace_back(path, value);
  std::string effects, files;  // those that users wrote
  PlanarModel model = observed.model;
  for (int i = 0; i < count_of(d.model.candidates); ++i) {
    const int c = d.model.candidates[i];
    const Candidate& candidate = d.problem->hypotheses.candidates[c];
    if (candidate.effect == nullptr || !candidate.effect->applies(model)) continue;
    if (candidate.is_event()) continue;    // it is over
    if (candidate.is_pattern()) continue;  // a hypothesis
    const Vector& theta = d.theta[i];
    for (const ModelOverride& value : candidate.effect->overrides(theta, model)) {
      std::erase_if(overrides, [&](const ModelOverride& o) { return o.first == value.first; });
      overrides.push_back(value);
    }
    Plant plant = simulation::nominal_plant(
        model);  // a second effect's overrides count on top of the first one's
    candidate.effect->apply(theta, plant);
    model = plant.model;
    effects += fmt::format("  - \"{}\"\n", effect_text(d, c, theta));
    const std::string& file = candidate.effect->file;
    const std::string line = fmt::format("  - \"{}\"\n", file);
    if (!file.empty() && files.find(line) == std::string::npos) files += line;
  }

  text +=
      "# Model values by which planning knows of the effect; where it can't, nothing stands "
      "here.\noverride:";
  text += overrides.empty() ? " {}\n" : "\n";

  for (const auto& [path, value] : overrides) text += fmt::format("  {}: {}\n", path, value);
  return text +
         "# All of it for simulation, in place of the overrides: jaculus simulate "
         "--augmented, or one by one --effect\neffects:" +
         (effects.empty() ? " []\n" : "\n" + effects) +
         (files.empty() ? "" : "effect_files:\n" + files);
}

void write_diagnosis(const Diagnosis& diagnosis, const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  trajectory::write_file(folder / "diagnosis.json", diagnosis_json(diagnosis));
  trajectory::write_file(folder / "augmented.yaml", augmented_yaml(diagnosis));
  write_hypotheses(diagnosis, folder);
}

}  // namespace jaculus::diagnosis
