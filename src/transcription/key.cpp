#include "jaculus/transcription/key.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <stdexcept>
#include <tuple>

namespace jaculus::transcription {

namespace {

using yaml::Node;

/// Reads a value for its errors alone.
struct CheckValue {
  const Node& node;
  void operator()(const key::Number& k) const { std::ignore = node.number(k.dimension, k.allowed); }
  void operator()(const key::Interval& k) const { std::ignore = node.bounds(k.dimension); }
  void operator()(const key::Integer& k) const { std::ignore = node.integer(k.lower, k.upper); }
  void operator()(const key::Flag&) const { std::ignore = node.boolean(); }
  void operator()(const key::Choice& k) const { std::ignore = node.choice(k.words); }
  void operator()(const key::Name&) const { std::ignore = node.text(); }
  void operator()(const key::Names&) const { std::ignore = node.texts(); }
  void operator()(const key::Other&) const {}
};

struct UnitOf {
  std::string operator()(const key::Number& k) const { return unit_name(k.dimension); }
  std::string operator()(const key::Interval& k) const { return unit_name(k.dimension); }
  std::string operator()(const key::Integer&) const { return "-"; }
  std::string operator()(const key::Other& k) const { return k.unit; }
  template <class Words>
  std::string operator()(const Words&) const {
    return "";
  }
};

const char* word(key::Of of) {
  return of == key::Of::phase ? "phase" : of == key::Of::foot ? "foot" : "motor";
}

}  // namespace

std::string Key::unit() const { return std::visit(UnitOf{}, kind); }

KeyValues::KeyValues(const Node& map, const std::vector<Key>& keys,
                     const std::vector<std::string>& others)
    : keys_(keys) {
  std::vector<std::string> known = others;
  for (const Key& key : keys_) known.push_back(key.name);
  map.only(known);

  for (const Key& key : keys_) {
    if (key.required() || map.has(key.name)) {
      values_[key.name] = map.at(key.name);
    } else if (!key.absent.value.empty()) {
      values_[key.name] = Node::parse(key.absent.value, "the default of " + key.name);
    } else {
      continue;
    }
    std::visit(CheckValue{values_[key.name]}, key.kind);
  }
}

const Key& KeyValues::declaration(std::string_view key) const {
  const auto same = [&](const Key& k) { return k.name == key; };
  const auto found = std::find_if(keys_.begin(), keys_.end(), same);
  if (found == keys_.end())
    throw std::logic_error(fmt::format("key '{}' is read but not declared", key));
  return *found;
}

template <class Kind>
const Kind& KeyValues::declared(std::string_view key) const {
  const Kind* kind = std::get_if<Kind>(&declaration(key).kind);
  if (kind == nullptr)
    throw std::logic_error(fmt::format("key '{}' is read as what it is not declared to be", key));
  return *kind;
}

const Node& KeyValues::value(std::string_view key) const {
  const auto found = values_.find(key);
  if (found == values_.end())
    throw std::logic_error(fmt::format("key '{}' is read where the file does not give it", key));
  return found->second;
}

bool KeyValues::has(std::string_view key) const {
  static_cast<void>(declaration(key));
  return values_.find(key) != values_.end();
}

double KeyValues::number(std::string_view key) const {
  const auto& [dimension, allowed] = declared<key::Number>(key);
  return value(key).number(dimension, allowed);
}

double KeyValues::number_or(std::string_view key, double otherwise) const {
  return has(key) ? number(key) : otherwise;
}

Bounds KeyValues::interval(std::string_view key) const {
  return value(key).bounds(declared<key::Interval>(key).dimension);
}

int KeyValues::integer(std::string_view key) const {
  const auto& [lower, upper] = declared<key::Integer>(key);
  return value(key).integer(lower, upper);
}

bool KeyValues::flag(std::string_view key) const {
  static_cast<void>(declared<key::Flag>(key));
  return value(key).boolean();
}

std::string KeyValues::choice(std::string_view key) const {
  return value(key).choice(declared<key::Choice>(key).words);
}

std::pair<key::Of, Node> KeyValues::name(std::string_view key) const {
  return {declared<key::Name>(key).of, value(key)};
}

std::pair<key::Of, std::vector<Node>> KeyValues::names(std::string_view key) const {
  const key::Of of = declared<key::Names>(key).of;
  return {of, has(key) ? value(key).items() : std::vector<Node>{}};
}

void KeyValues::check_names(key::Of of, const std::vector<std::string>& known) const {
  for (const Key& key : keys_) {
    if (!has(key.name)) continue;
    const auto* one = std::get_if<key::Name>(&key.kind);
    const auto* list = std::get_if<key::Names>(&key.kind);
    if (one != nullptr && one->of == of) std::ignore = index_of_name(value(key.name), of, known);
    if (list == nullptr || list->of != of) continue;
    for (const Node& name : value(key.name).items()) std::ignore = index_of_name(name, of, known);
  }
}

int index_of_name(const Node& name, key::Of of, const std::vector<std::string>& known) {
  const std::string given = name.text();
  if (const int found = index_of(known, given); found >= 0) return found;

  throw name.error(fmt::format("unknown {} '{}'{}; allowed: {}", word(of), given,
                               yaml::did_you_mean(given, known),
                               known.empty() ? "none" : fmt::format("{}", fmt::join(known, ", "))));
}

}  // namespace jaculus::transcription
