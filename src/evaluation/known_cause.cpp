// NAME.truth.yaml.

#include <fmt/format.h>

#include "jaculus/core/error.h"
#include "jaculus/core/yaml.h"
#include "jaculus/evaluation/real.h"

namespace jaculus::evaluation {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> texts_of(const yaml::Node& parent, const std::string& key) {
  const auto node = parent.find(key);
  return node ? node->texts() : std::vector<std::string>{};
}

KnownEffect read_effect(const yaml::Node& node) {
  node.only({"any_of", "joint", "parameter", "unit", "value", "within"});
  KnownEffect effect;
  effect.any_of = node.at("any_of").texts();
  if (const auto joint = node.find("joint")) effect.joint = joint->text();
  if (const auto parameter = node.find("parameter")) effect.parameter = parameter->text();
  if (const auto unit = node.find("unit")) effect.unit = unit->text();

  const auto value = node.find("value");
  if (!value) return effect;
  if (!node.has("within")) {
    effect.remark = value->text();
    return effect;
  }
  // The unit stands beside the value, in the words of whoever measured it.
  effect.value = value->number(dimension::none);
  effect.within = node.at("within").number(dimension::none, {0.0, 1.0});
  return effect;
}

KnownEvent read_event(const yaml::Node& node) {
  node.only({"trial", "joint", "from", "to", "peak"});
  KnownEvent event;
  event.trial = node.at("trial").text();
  event.joint = node.at("joint").text();
  event.from = node.at("from").number(dimension::time);
  event.to = node.at("to").number(dimension::time);
  event.peak = node.at("peak").number(dimension::none);
  if (!(event.to > event.from))
    throw node.error(fmt::format("to {} after from {}; allowed: later", event.to, event.from));
  return event;
}

}  // namespace

KnownCause read_known_cause(const fs::path& file) {
  const yaml::Node node = yaml::Node::load(file);
  node.only({"effects", "listed", "absent", "events", "effects_as_in", "source"});
  KnownCause known;

  if (const auto other = node.find("effects_as_in")) {
    if (node.has("effects"))
      throw other->error("effects given as well; allowed: effects or effects_as_in");
    known = read_known_cause(file.parent_path() / other->text());
    known.events.clear();
  }

  if (const auto effects = node.find("effects")) {
    for (const yaml::Node& effect : effects->items()) known.effects.push_back(read_effect(effect));
  }
  for (const std::string& name : texts_of(node, "listed")) known.listed.push_back(name);
  for (const std::string& name : texts_of(node, "absent")) known.absent.push_back(name);
  if (const auto events = node.find("events")) {
    for (const yaml::Node& event : events->items()) known.events.push_back(read_event(event));
  }
  if (const auto source = node.find("source")) known.source = source->text();

  return known;
}

std::optional<KnownCause> known_cause_of(const fs::path& dataset) {
  const fs::path folder = fs::weakly_canonical(dataset);
  const fs::path file = folder.parent_path() / (folder.filename().string() + ".truth.yaml");
  std::error_code code;
  if (!fs::exists(file, code)) return std::nullopt;
  return read_known_cause(file);
}

}  // namespace jaculus::evaluation
