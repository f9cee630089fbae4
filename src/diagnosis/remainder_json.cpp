#include "diagnosis/remainder_json.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "jaculus/core/json.h"

namespace jaculus::diagnosis {
namespace {

using Json = nlohmann::ordered_json;

Json interval(const Bounds& b) { return Json::array({json_number(b.lower), json_number(b.upper)}); }

/// `weight`: by which parts are ordered where no force is known.
Json dependence_json(const Dependence& d, const std::optional<double>& weight) {
  Json json = {{"regressor", to_text(d.regressor)}};
  if (!d.of.empty()) json["of"] = d.of;
  if (std::isfinite(d.period)) {
    json["period"] = d.period;
    json["unit"] = d.unit;
  }
  if (!d.form.empty()) json["form"] = d.form;
  json["share"] = json_number(d.share);
  json["ci95"] = interval(d.ci95);
  json["selected"] = json_number(d.selected);
  if (weight) json["weight"] = json_number(*weight);
  json["coefficients"] = d.coefficients;
  return json;
}

/// A place that was described: of how many boxes the diagnosis' own windows tell its force is
/// stated where they do.
Json place_json(const RemainderPlace& place, const std::vector<LackingForce>& lacking) {
  Json follows = Json::array();
  for (const Dependence& d : place.follows)
    follows.push_back(
        dependence_json(d, place.by_simulation ? std::optional<double>(d.share) : std::nullopt));
  const auto own = std::find_if(lacking.begin(), lacking.end(),
                                [&](const LackingForce& f) { return f.name == place.joint; });
  return {{"joint", place.joint},
          {"place", place.place},
          {"share_of", place.by_simulation ? "gap" : "force"},
          {"rms", json_number(place.rms)},
          {"unit", place.unit},
          {"boxes", place.boxes},
          {"boxes_told", json_number(own == lacking.end() ? kNaN : own->boxes)},
          {"follows", follows}};
}

Json event_json(const ForceEvent& e) {
  return {{"trial", e.trial},
          {"joint", e.joint},
          {"along", e.along},
          {"from_s", json_number(e.from)},
          {"to_s", json_number(e.to)},
          {"peak", json_number(e.peak)},
          {"peak_ci95", interval(e.peak_ci95)},
          {"unit", e.unit},
          {"probability", json_number(e.probability)},
          {"every_trial", e.every_trial}};
}

Json parting_json(const Parting& p) {
  return {{"dataset", p.dataset},
          {"trial", p.trial},
          {"joint", p.joint},
          {"from_s", json_number(p.from)},
          {"most", json_number(p.most)},
          {"unit", p.unit}};
}

}  // namespace

Json remainder_json(const Diagnosis& d) {
  const std::vector<RemainderPlace>& described = d.remainder.places;
  Json places = Json::array(), events = Json::array(), partings = Json::array();
  for (const RemainderPlace& place : described) places.push_back(place_json(place, d.lacking));
  for (const LackingForce& f : d.lacking) {
    const bool known = std::any_of(described.begin(), described.end(),
                                   [&](const RemainderPlace& p) { return p.joint == f.name; });
    if (known) continue;
    places.push_back({{"joint", f.name},
                      {"rms", json_number(f.rms)},
                      {"unit", f.unit},
                      {"boxes_told", f.boxes},
                      {"follows", nullptr}});
  }

  for (const ForceEvent& e : d.events) events.push_back(event_json(e));
  for (const Parting& p : d.partings) partings.push_back(parting_json(p));
  return {{"share", json_number(d.remainder.share)},
          {"ci95", interval(d.remainder.ci95)},
          {"established", d.verdict == Verdict::partial || d.verdict == Verdict::unexplained},
          {"probability", d.lacking_probability},
          {"places", places},
          {"events", events},
          {"partings", partings}};
}

}  // namespace jaculus::diagnosis
