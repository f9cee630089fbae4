// diagnosis.json, and a prediction as a line of text for the journal.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "jaculus/core/error.h"
#include "jaculus/evaluation/predictions.h"

namespace jaculus::evaluation {
namespace {

using nlohmann::json;

/// A member of an object, or an error that names it.
const json& member(const json& object, const std::string& key, const std::string& path) {
  if (!object.is_object() || !object.contains(key))
    throw InputError(path + "." + key + ": missing; allowed: as in the format's description");
  return object.at(key);
}

std::string text_in(const json& object, const std::string& key, const std::string& path) {
  const json& value = member(object, key, path);
  if (!value.is_string())
    throw InputError(fmt::format("{}.{}: {} given; allowed: a text", path, key, value.dump()));
  return value.get<std::string>();
}

/// A number; null stands for what is not known.
double number_of(const json& value, const std::string& path) {
  if (value.is_null()) return kNaN;
  if (!value.is_number())
    throw InputError(fmt::format("{}: {} given; allowed: a number", path, value.dump()));
  return value.get<double>();
}

double probability_of(const json& value, const std::string& path) {
  const double p = number_of(value, path);
  if (!(p >= 0.0 && p <= 1.0 + 1e-9))
    throw InputError(fmt::format("{}: {} given; allowed: 0 to 1", path, p));
  return std::min(p, 1.0);
}

NamedEffect effect_of(const json& entry, const std::string& path) {
  NamedEffect effect;
  effect.name = text_in(entry, "name", path);
  effect.probability = probability_of(member(entry, "probability", path), path + ".probability");
  if (entry.contains("at") && entry.at("at").is_array()) {
    for (const json& joint : entry.at("at")) effect.joints.push_back(joint.get<std::string>());
  }
  if (!entry.contains("parameters")) return effect;
  for (const auto& [name, p] : entry.at("parameters").items()) {
    const std::string place = path + ".parameters." + name;
    effect.parameters[name] = number_of(member(p, "value", place), place + ".value");
    if (!p.contains("ci95") || !p.at("ci95").is_array() || p.at("ci95").size() != 2) continue;
    effect.ci95[name] = {number_of(p.at("ci95")[0], place), number_of(p.at("ci95")[1], place)};
  }
  return effect;
}

/// Per channel, in its unit: as given, else (format 1) what is given in noise floors, times the
/// floor.
std::map<std::string, ChannelGap> channels_of(const json& root) {
  std::map<std::string, ChannelGap> channels;
  const json physical = root.value("/gap/physical"_json_pointer, json::object());
  for (const auto& [name, gap] : physical.items())
    channels[name] = {gap.value("unit", ""), number_of(gap.value("before", json()), name),
                      number_of(gap.value("after", json()), name)};
  if (!channels.empty()) return channels;

  const json per = root.value("/gap/per_channel"_json_pointer, json::object());
  const json floors = root.value("/where/channels"_json_pointer, json::object());

  for (const auto& [key, gap] : per.items()) {
    const std::string name = key.substr(key.find('.') + 1);
    const auto floor = floors.find(name);
    if (floor == floors.end()) continue;
    const double unit = number_of(floor->value("noise_floor", json()), key);
    channels[name] = {floor->value("unit", ""), unit * number_of(gap.value("before", json()), key),
                      unit * number_of(gap.value("after", json()), key)};
  }

  return channels;
}

std::vector<SaidEvent> events_of(const json& root) {
  std::vector<SaidEvent> events;
  for (const json& e : root.value("/remainder/events"_json_pointer, json::array())) {
    const auto number = [&](const char* key) { return number_of(e.value(key, json()), key); };
    events.push_back({e.value("trial", ""), e.value("joint", ""), number("from_s"), number("to_s"),
                      number("peak")});
  }
  return events;
}

/// Parts without a weight of their own are ordered by the size of what they explain.
std::vector<SaidPart> parts_of(const json& root) {
  std::vector<SaidPart> parts;
  for (const json& place : root.value("/remainder/places"_json_pointer, json::array())) {
    const std::string at = place.value("joint", "");
    const bool of_body = at == "x" || at == "z" || at == "pitch";
    const std::string where = place.value("place", of_body ? "body" : "joint");
    const double rms = number_of(place.value("rms", json()), "rms");
    if (!place.contains("follows") || !place.at("follows").is_array()) continue;
    for (const json& follows : place.at("follows")) {
      const double share = number_of(follows.value("share", json()), "share");
      const double weight = follows.contains("weight") ? number_of(follows.at("weight"), "weight")
                                                       : rms * std::sqrt(std::max(0.0, share));
      parts.push_back({where, at, follows.value("regressor", ""), weight});
    }
  }
  return parts;
}

Prediction prediction_of(const json& root, const std::string& path) {
  Prediction prediction;
  prediction.verdict = diagnosis::verdict_from(text_in(root, "verdict", path), path + ".verdict");
  if (root.contains("effects")) {
    int i = 0;
    for (const json& entry : root.at("effects"))
      prediction.effects.push_back(effect_of(entry, fmt::format("{}.effects[{}]", path, i++)));
  }

  if (root.contains("ranking")) {
    int i = 0;
    for (const json& entry : root.at("ranking")) {
      const std::string place = fmt::format("{}.ranking[{}]", path, i++);
      prediction.ranking[text_in(entry, "effect", place)] =
          probability_of(member(entry, "probability", place), place + ".probability");
    }
  }

  if (root.contains("where") && root.at("where").contains("components")) {
    for (const auto& [name, share] : root.at("where").at("components").items())
      prediction.components[name] =
          number_of(share.is_object() ? share.value("share", json()) : share, path + ".where");
  }
  if (root.contains("gap") && root.at("gap").is_object()) {
    prediction.gap_before = number_of(root.at("gap").value("before", json()), path + ".gap.before");
    prediction.gap_after = number_of(root.at("gap").value("after", json()), path + ".gap.after");
  }
  prediction.channels = channels_of(root);
  prediction.events = events_of(root);
  prediction.described = parts_of(root);
  prediction.remainder = prediction.verdict == diagnosis::Verdict::unexplained ||
                         root.value("/remainder/established"_json_pointer, false);
  prediction.parted = !root.value("/remainder/partings"_json_pointer, json::array()).empty();
  return prediction;
}

json number_or_null(double value) { return std::isfinite(value) ? json(value) : json(); }

json events_json(const std::vector<SaidEvent>& said) {
  json events = json::array();
  for (const SaidEvent& e : said) {
    events.push_back({{"trial", e.trial},
                      {"joint", e.joint},
                      {"from_s", number_or_null(e.from)},
                      {"to_s", number_or_null(e.to)},
                      {"peak", number_or_null(e.peak)}});
  }
  return events;
}

/// As a diagnosis.json has places, one a part.
json parts_json(const std::vector<SaidPart>& parts) {
  json places = json::array();
  for (const SaidPart& part : parts)
    places.push_back({{"place", part.place},
                      {"joint", part.at},
                      {"follows", json::array({{{"regressor", part.family},
                                                {"weight", number_or_null(part.weight)}}})}});
  return places;
}

}  // namespace

Prediction read_prediction(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream)
    throw InputError(fmt::format("{}: can't be read; allowed: a diagnosis.json", file.string()));
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  const json root = json::parse(text, nullptr, false);
  if (root.is_discarded())
    throw InputError(fmt::format("{}: is no JSON; allowed: a diagnosis.json", file.string()));
  const std::string format = text_in(root, "format", file.string());
  if (format != "jaculus-diagnosis/1" && format != "jaculus-diagnosis/2") {
    throw InputError(
        fmt::format("{}: format: {} given; allowed: jaculus-diagnosis/1, jaculus-diagnosis/2",
                    file.string(), root.at("format").dump()));
  }
  return prediction_of(root, file.string());
}

std::string prediction_to_text(const Prediction& prediction) {
  json effects = json::array();
  for (const NamedEffect& e : prediction.effects) {
    json parameters = json::object();
    for (const auto& [name, value] : e.parameters) {
      parameters[name] = {{"value", number_or_null(value)}};
      const auto ci = e.ci95.find(name);
      if (ci != e.ci95.end())
        parameters[name]["ci95"] = {number_or_null(ci->second.lower),
                                    number_or_null(ci->second.upper)};
    }
    effects.push_back({{"name", e.name},
                       {"probability", e.probability},
                       {"at", e.joints},
                       {"parameters", parameters}});
  }

  json ranking = json::array();
  for (const auto& [name, p] : prediction.ranking)
    ranking.push_back({{"effect", name}, {"probability", p}});
  const diagnosis::Verdict verdict = prediction.verdict.value_or(diagnosis::Verdict::insufficient);
  const json root = {{"verdict", to_text(verdict)},
                     {"failed", !prediction.verdict},
                     {"message", prediction.message},
                     {"effects", effects},
                     {"ranking", ranking},
                     {"where", {{"components", prediction.components}}},
                     {"gap",
                      {{"before", number_or_null(prediction.gap_before)},
                       {"after", number_or_null(prediction.gap_after)}}},
                     {"remainder",
                      {{"established", prediction.remainder},
                       {"places", parts_json(prediction.described)},
                       {"events", events_json(prediction.events)},
                       {"partings", json::array_t(prediction.parted ? 1 : 0)}}},
                     {"seconds", number_or_null(prediction.seconds)}};

  return root.dump();
}

Prediction prediction_from_text(const std::string& text) {
  const json root = json::parse(text, nullptr, false);
  if (root.is_discarded()) throw InputError("answer: is no JSON");
  Prediction prediction = prediction_of(root, "answer");
  if (root.value("failed", false)) prediction.verdict.reset();
  prediction.message = root.value("message", "");
  prediction.seconds = number_of(root.value("seconds", json()), "answer.seconds");
  return prediction;
}

}  // namespace jaculus::evaluation
