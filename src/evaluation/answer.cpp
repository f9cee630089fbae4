// diagnosis.json, and an answer as a line of text for the journal.

#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "jaculus/core/error.h"
#include "jaculus/evaluation/score.h"

namespace jaculus {
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
  if (!value.is_string()) throw InputError(fmt::format("{}.{}: {} given; allowed: a text", path, key, value.dump()));
  return value.get<std::string>();
}

/// A number; null stands for what is not known.
double number_of(const json& value, const std::string& path) {
  if (value.is_null()) return kNaN;
  if (!value.is_number()) throw InputError(fmt::format("{}: {} given; allowed: a number", path, value.dump()));
  return value.get<double>();
}

double probability_of(const json& value, const std::string& path) {
  const double p = number_of(value, path);
  if (!(p >= 0.0 && p <= 1.0 + 1e-9)) throw InputError(fmt::format("{}: {} given; allowed: 0 to 1", path, p));
  return std::min(p, 1.0);
}

NamedEffect effect_of(const json& entry, const std::string& path) {
  NamedEffect effect;
  effect.name = text_in(entry, "name", path);
  effect.probability = probability_of(member(entry, "probability", path), path + ".probability");
  if (!entry.contains("parameters")) return effect;
  for (const auto& [name, p] : entry.at("parameters").items()) {
    const std::string place = path + ".parameters." + name;
    effect.parameters[name] = number_of(member(p, "value", place), place + ".value");
    if (!p.contains("ci95") || !p.at("ci95").is_array() || p.at("ci95").size() != 2) continue;
    effect.ci95[name] = {number_of(p.at("ci95")[0], place), number_of(p.at("ci95")[1], place)};
  }
  return effect;
}

void check_verdict(const std::string& verdict, const std::string& path) {
  for (const char* known : {"effect", "several", "ambiguous", "none", "unexplained", "insufficient"}) {
    if (verdict == known) return;
  }
  throw InputError(
      fmt::format("{}.verdict: '{}' given; allowed: effect, several, ambiguous, none, unexplained, "
                  "insufficient",
                  path, verdict));
}

CaseAnswer answer_of(const json& root, const std::string& path) {
  CaseAnswer answer;
  answer.verdict = text_in(root, "verdict", path);
  check_verdict(answer.verdict, path);
  if (root.contains("effects")) {
    int i = 0;
    for (const json& entry : root.at("effects"))
      answer.effects.push_back(effect_of(entry, fmt::format("{}.effects[{}]", path, i++)));
  }
  if (root.contains("ranking")) {
    int i = 0;
    for (const json& entry : root.at("ranking")) {
      const std::string place = fmt::format("{}.ranking[{}]", path, i++);
      answer.ranking[text_in(entry, "effect", place)] =
          probability_of(member(entry, "probability", place), place + ".probability");
    }
  }
  if (root.contains("where") && root.at("where").contains("components")) {
    for (const auto& [name, share] : root.at("where").at("components").items())
      answer.components[name] = number_of(share.is_object() ? share.value("share", json()) : share, path + ".where");
  }
  if (root.contains("gap") && root.at("gap").is_object()) {
    answer.gap_before = number_of(root.at("gap").value("before", json()), path + ".gap.before");
    answer.gap_after = number_of(root.at("gap").value("after", json()), path + ".gap.after");
  }
  return answer;
}

json number_or_null(double value) { return std::isfinite(value) ? json(value) : json(); }

}  // namespace

CaseAnswer read_answer(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw InputError(fmt::format("{}: can't be read; allowed: a diagnosis.json", file.string()));
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  const json root = json::parse(text, nullptr, false);
  if (root.is_discarded()) throw InputError(fmt::format("{}: is no JSON; allowed: a diagnosis.json", file.string()));
  if (text_in(root, "format", file.string()) != "jaculus-diagnosis/1") {
    throw InputError(
        fmt::format("{}: format: {} given; allowed: jaculus-diagnosis/1", file.string(), root.at("format").dump()));
  }
  return answer_of(root, file.string());
}

std::string answer_to_text(const CaseAnswer& answer) {
  json effects = json::array();
  for (const NamedEffect& e : answer.effects) {
    json parameters = json::object();
    for (const auto& [name, value] : e.parameters) {
      parameters[name] = {{"value", number_or_null(value)}};
      const auto ci = e.ci95.find(name);
      if (ci != e.ci95.end())
        parameters[name]["ci95"] = {number_or_null(ci->second.lower), number_or_null(ci->second.upper)};
    }
    effects.push_back({{"name", e.name}, {"probability", e.probability}, {"parameters", parameters}});
  }
  json ranking = json::array();
  for (const auto& [name, p] : answer.ranking) ranking.push_back({{"effect", name}, {"probability", p}});
  const json root = {
      {"verdict", answer.verdict == "failed" ? "insufficient" : answer.verdict},
      {"failed", answer.verdict == "failed"},
      {"message", answer.message},
      {"effects", effects},
      {"ranking", ranking},
      {"where", {{"components", answer.components}}},
      {"gap", {{"before", number_or_null(answer.gap_before)}, {"after", number_or_null(answer.gap_after)}}},
      {"seconds", number_or_null(answer.seconds)}};
  return root.dump();
}

CaseAnswer answer_from_text(const std::string& text) {
  const json root = json::parse(text, nullptr, false);
  if (root.is_discarded()) throw InputError("answer: is no JSON");
  CaseAnswer answer = answer_of(root, "answer");
  if (root.value("failed", false)) answer.verdict = "failed";
  answer.message = root.value("message", "");
  answer.seconds = number_of(root.value("seconds", json()), "answer.seconds");
  return answer;
}

}  // namespace jaculus
