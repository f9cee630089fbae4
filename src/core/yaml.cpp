#include "jaculus/core/yaml.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>

#include "core/text_file.h"
#include "core/yaml_tree.h"

namespace jaculus::yaml {

/// A place in a document: the value, and the path by which it was reached (aliases have several).
struct Node::Impl {
  std::shared_ptr<const Tree> tree;
  std::filesystem::path file;
  std::string path;
  std::shared_ptr<const OwnUnits> units{};
};

namespace {

using Kind = Tree::Kind;

std::string shorten(const std::string& text) {
  constexpr std::size_t kMax = 60;
  return text.size() <= kMax ? text : text.substr(0, kMax) + "...";
}

/// What stands at a node, for messages.
std::string given(const Tree& tree) {
  if (tree.kind == Kind::scalar) return fmt::format("'{}'", shorten(tree.scalar));
  return tree.kind == Kind::list ? "a list" : tree.kind == Kind::map ? "a map" : "nothing";
}

bool is_plain_number(const Tree& tree) {
  if (tree.kind != Kind::scalar || tree.quoted) return false;
  const std::string& s = tree.scalar;
  const char* begin = s.data() + (s.starts_with('+') ? 1 : 0);
  double value = 0.0;
  return std::from_chars(begin, s.data() + s.size(), value).ptr == s.data() + s.size() &&
         !s.empty();
}

bool is_infinite(const Tree& tree, bool negative) {
  if (tree.kind != Kind::scalar || tree.quoted) return false;
  std::string s = tree.scalar;
  if (negative) return s == "-.inf" || s == "-.Inf" || s == "-.INF";
  if (s.starts_with('+')) s.erase(0, 1);
  return s == ".inf" || s == ".Inf" || s == ".INF";
}

std::string describe(const Dimension& dimension, const Bounds& allowed) {
  const std::string unit = dimension == dimension::none ? "" : " " + unit_name(dimension);
  const bool lower = std::isfinite(allowed.lower);
  const bool upper = std::isfinite(allowed.upper);
  if (lower && upper)
    return fmt::format("{:.10g} to {:.10g}{}", allowed.lower, allowed.upper, unit);
  if (lower) return fmt::format("at least {:.10g}{}", allowed.lower, unit);
  if (upper) return fmt::format("at most {:.10g}{}", allowed.upper, unit);
  return dimension == dimension::none ? "a plain number" : "a number in" + unit;
}

std::string list_of(const std::vector<std::string>& names) {
  return names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "));
}

}  // namespace

Node::Node() {
  auto tree = std::make_shared<Tree>();
  tree->kind = Kind::map;
  tree->complete = true;
  impl_ = std::make_shared<const Impl>(Impl{tree, {}, {}});
}

Node::Node(std::shared_ptr<const Impl> impl) : impl_(std::move(impl)) {}

Node Node::load(const std::filesystem::path& file) {
  return Node(std::make_shared<const Impl>(
      Impl{parse_tree(read_text_file(file, "a YAML file"), file.string()), file, {}}));
}

Node Node::parse(const std::string& text, const std::string& name) {
  if (text.size() > kMaxTextBytes) {
    throw InputError({.file = name}, fmt::format("holds {} bytes; allowed: at most {}", text.size(),
                                                 kMaxTextBytes));
  }
  return Node(std::make_shared<const Impl>(Impl{parse_tree(text, name), name, {}}));
}

Node Node::with_units(std::shared_ptr<const OwnUnits> units) const {
  Impl impl = *impl_;
  impl.units = std::move(units);
  return Node(std::make_shared<const Impl>(std::move(impl)));
}

bool Node::is_map() const { return impl_->tree->kind == Kind::map; }
bool Node::is_list() const { return impl_->tree->kind == Kind::list; }
bool Node::is_scalar() const { return impl_->tree->kind == Kind::scalar; }

void Node::only(std::initializer_list<std::string_view> keys) const {
  only(std::vector<std::string>(keys.begin(), keys.end()));
}

void Node::only(const std::vector<std::string>& keys) const {
  if (!is_map())
    throw error(fmt::format("{} given; allowed: a map with the keys {}", given(*impl_->tree),
                            list_of(keys)));
  for (const Tree::Entry& entry : impl_->tree->entries) {
    if (std::find(keys.begin(), keys.end(), entry.key) != keys.end()) continue;
    Tree place = *entry.value;
    place.line = entry.line;
    const Node key(std::make_shared<const Impl>(
        Impl{std::make_shared<const Tree>(place), impl_->file, impl_->path}));
    throw key.error(fmt::format("unknown key '{}'{}; allowed: {}", shorten(entry.key),
                                did_you_mean(entry.key, keys), list_of(keys)));
  }
}

bool Node::has(std::string_view key) const { return find(key).has_value(); }

Node Node::at(std::string_view key) const {
  if (std::optional<Node> node = find(key)) return *node;
  throw error(fmt::format("key '{}' is missing; it must be given", key));
}

std::optional<Node> Node::find(std::string_view key) const {
  if (!is_map()) throw error(fmt::format("{} given; allowed: a map", given(*impl_->tree)));
  for (const Tree::Entry& entry : impl_->tree->entries) {
    if (entry.key != key) continue;
    const std::string path = impl_->path.empty() ? entry.key : impl_->path + "." + entry.key;
    return Node(std::make_shared<const Impl>(Impl{entry.value, impl_->file, path, impl_->units}));
  }
  return std::nullopt;
}

std::vector<Node> Node::items() const {
  if (!is_list())
    throw error(fmt::format("{} given; allowed: a list, [a, b, ...]", given(*impl_->tree)));
  std::vector<Node> nodes;
  nodes.reserve(impl_->tree->items.size());
  for (const auto& item : impl_->tree->items) {
    nodes.push_back(Node(std::make_shared<const Impl>(
        Impl{item, impl_->file, fmt::format("{}[{}]", impl_->path, nodes.size()), impl_->units})));
  }
  return nodes;
}

std::vector<std::pair<std::string, Node>> Node::entries() const {
  if (!is_map()) throw error(fmt::format("{} given; allowed: a map", given(*impl_->tree)));
  std::vector<std::pair<std::string, Node>> result;
  for (const Tree::Entry& entry : impl_->tree->entries)
    result.emplace_back(entry.key, at(entry.key));
  return result;
}

double Node::number(const Dimension& dimension, const Bounds& allowed) const {
  const Tree& tree = *impl_->tree;
  if (tree.kind != Kind::scalar)
    throw error(fmt::format("{} given; allowed: {}", given(tree), describe(dimension, allowed)));
  const std::string& s = tree.scalar;
  double value = 0.0;
  try {
    // Plain numbers are SI whatever the dimension; everything else states its unit.
    value =
        parse_quantity(s, is_plain_number(tree) ? dimension::none : dimension, impl_->units.get());
  } catch (const InputError& e) {
    throw error(e.what());
  }
  if (!allowed.contains(value)) {
    throw error(
        fmt::format("{} is out of range; allowed: {}", shorten(s), describe(dimension, allowed)));
  }
  return value;
}

int Node::integer(int lower, int upper) const {
  const Tree& tree = *impl_->tree;
  const std::string allowed = fmt::format("allowed: a whole number from {} to {}", lower, upper);
  int value = 0;
  const std::string& s = tree.scalar;
  const char* begin = s.data() + (s.starts_with('+') ? 1 : 0);
  const auto [end, code] = std::from_chars(begin, s.data() + s.size(), value);
  const bool whole = tree.kind == Kind::scalar && !tree.quoted && !s.empty() &&
                     end == s.data() + s.size() && end != begin;
  if (!whole || (code != std::errc() && code != std::errc::result_out_of_range)) {
    throw error(fmt::format("{} given; {}", given(tree), allowed));
  }
  if (code != std::errc() || value < lower || value > upper) {
    throw error(fmt::format("{} is out of range; {}", shorten(s), allowed));
  }
  return value;
}

bool Node::boolean() const {
  const Tree& tree = *impl_->tree;
  if (tree.kind == Kind::scalar && !tree.quoted &&
      (tree.scalar == "true" || tree.scalar == "false")) {
    return tree.scalar == "true";
  }
  throw error(fmt::format("{} given; allowed: true or false", given(tree)));
}

std::string Node::text() const {
  const Tree& tree = *impl_->tree;
  if (tree.kind != Kind::scalar || tree.scalar.empty()) {
    throw error(fmt::format("{} given; allowed: a text that is not empty", given(tree)));
  }
  const bool boolean = !tree.quoted && (tree.scalar == "true" || tree.scalar == "false");
  if (boolean || is_plain_number(tree)) {
    throw error(fmt::format("{} given; allowed: a text (in quotes where it looks like a number)",
                            given(tree)));
  }
  return tree.scalar;
}

std::string Node::choice(const std::vector<std::string>& choices) const {
  const Tree& tree = *impl_->tree;
  if (tree.kind == Kind::scalar &&
      std::find(choices.begin(), choices.end(), tree.scalar) != choices.end()) {
    return tree.scalar;
  }
  throw error(fmt::format("{} given{}; allowed: {}", given(tree),
                          tree.kind == Kind::scalar ? did_you_mean(tree.scalar, choices) : "",
                          list_of(choices)));
}

Bounds Node::bounds(const Dimension& dimension) const {
  if (is_scalar()) {
    const double value = number(dimension);
    return {value, value};
  }

  const std::string unit = unit_name(dimension);
  const std::vector<Node> ends = is_list() ? items() : std::vector<Node>();
  if (ends.size() != 2) {
    throw error(fmt::format(
        "{} given; allowed: [lower, upper] in {} (-.inf and .inf: no bound), or one number",
        is_list() ? fmt::format("{} values", ends.size()) : given(*impl_->tree), unit));
  }

  Bounds result;
  if (!is_infinite(*ends[0].impl_->tree, true)) result.lower = ends[0].number(dimension);
  if (!is_infinite(*ends[1].impl_->tree, false)) result.upper = ends[1].number(dimension);
  if (result.lower > result.upper) {
    throw error(fmt::format(
        "lower bound {:.10g} is above upper bound {:.10g}; allowed: lower <= upper, in {}",
        result.lower, result.upper, unit));
  }

  return result;
}

Vec2 Node::vec2(const Dimension& dimension) const {
  const std::vector<double> values = numbers(dimension);
  if (values.size() != 2) {
    throw error(fmt::format("{} values given; allowed: two, [x, z] in {}", values.size(),
                            unit_name(dimension)));
  }
  return {values[0], values[1]};
}

std::vector<double> Node::numbers(const Dimension& dimension) const {
  std::vector<double> values;
  for (const Node& item : items()) values.push_back(item.number(dimension));
  return values;
}

std::vector<std::string> Node::texts() const {
  std::vector<std::string> values;
  for (const Node& item : items()) values.push_back(item.text());
  return values;
}

InputError Node::error(const std::string& what) const {
  return InputError({impl_->file.string(), line(), impl_->path}, what);
}

std::string Node::path() const { return impl_->path; }
int Node::line() const { return impl_->tree->line; }
std::filesystem::path Node::file() const { return impl_->file; }
std::string Node::dump() const { return dump_tree(*impl_->tree); }

void refuse_other_kind(const Node& file, std::string_view wanted) {
  struct Kind {
    const char *format, *name, *use;
  };
  static constexpr std::array<Kind, 8> kKinds = {
      Kind{"jaculus-problem/1", "a problem", "`jaculus solve` solves it"},
      Kind{"jaculus-experiment/1", "an experiment", "`jaculus simulate` plays it"},
      Kind{"jaculus-study/1", "a study", "`jaculus study` runs it"},
      Kind{"jaculus-dataset/1", "a dataset", "`jaculus diagnose` takes its folder"},
      Kind{"jaculus-robot/1", "a robot", "`jaculus check` takes its folder"},
      Kind{"jaculus-effect/1", "an effect", "`jaculus check` tries it, --effects takes it"},
      Kind{"jaculus-columns/1", "a map of columns", "`jaculus import csv --map` takes it"},
      Kind{"jaculus-openlog/1", "a description of a binary log",
           "`jaculus import openlog` takes it"}};

  if (!file.is_map()) return;
  const std::optional<Node> format = file.find("format");
  if (!format || !format->is_scalar()) return;
  const auto named = [&](std::string_view text) {
    return std::find_if(kKinds.begin(), kKinds.end(),
                        [&](const Kind& kind) { return text == kind.format; });
  };
  const auto given = named(format->text()), asked = named(wanted);
  if (given == kKinds.end() || asked == kKinds.end() || given == asked) return;
  throw format->error(fmt::format("{} given ({}; {}); allowed here: {} ({})", given->name,
                                  given->format, given->use, asked->name, asked->format));
}

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const unsigned char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    if (c == '\n') {
      out += "\\n";
    } else if (c < 0x20) {
      out += fmt::format("\\x{:02x}", c);
    } else {
      out += c;
    }
  }
  return out + '"';
}

std::optional<std::string> nearest_name(std::string_view given,
                                        const std::vector<std::string>& candidates) {
  // Edit distance with transpositions, blind to case; one row of the table for each letter of
  // `given`.
  constexpr std::size_t kMaxLength = 100;
  if (given.empty() || given.size() > kMaxLength) return std::nullopt;
  const auto lower = [](char c) { return std::tolower(static_cast<unsigned char>(c)); };

  std::optional<std::string> best;
  std::size_t best_distance = std::max<std::size_t>(2, given.size() / 3) + 1;

  for (const std::string& candidate : candidates) {
    const std::size_t n = candidate.size();
    std::vector<std::vector<std::size_t>> table(given.size() + 1, std::vector<std::size_t>(n + 1));
    for (std::size_t i = 0; i <= given.size(); ++i) table[i][0] = i;
    for (std::size_t j = 0; j <= n; ++j) table[0][j] = j;

    for (std::size_t i = 1; i <= given.size(); ++i) {
      for (std::size_t j = 1; j <= n; ++j) {
        const bool same = lower(given[i - 1]) == lower(candidate[j - 1]);
        table[i][j] = std::min(
            {table[i - 1][j] + 1, table[i][j - 1] + 1, table[i - 1][j - 1] + (same ? 0 : 1)});
        const bool swapped = i > 1 && j > 1 && lower(given[i - 1]) == lower(candidate[j - 2]) &&
                             lower(given[i - 2]) == lower(candidate[j - 1]);
        if (swapped) table[i][j] = std::min(table[i][j], table[i - 2][j - 2] + 1);
      }
    }

    const std::size_t distance = table[given.size()][n];
    // A name that shares no letter position at all is no suggestion, however short.
    if (distance < best_distance && distance < std::max(given.size(), n)) {
      best_distance = distance;
      best = candidate;
    }
  }

  return best;
}

std::string did_you_mean(std::string_view given, const std::vector<std::string>& candidates) {
  const std::optional<std::string> near = nearest_name(given, candidates);
  return near ? fmt::format(", did you mean '{}'?", *near) : "";
}

}  // namespace jaculus::yaml
