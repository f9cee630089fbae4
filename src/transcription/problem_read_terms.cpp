// Constraints and costs of a problem file.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>

#include "jaculus/transcription/term.h"
#include "transcription/problem_keys.h"
#include "transcription/problem_read.h"

namespace jaculus::transcription::problem_read {

namespace {

using yaml::Node;

TermSpec term(const Node& node) {
  if (!node.is_map()) throw node.error("not a map; allowed: {type: ..., ...}");
  TermSpec spec;
  spec.type = node.at("type").text();
  const auto name = node.find("name");
  spec.name = name ? name->text() : spec.type;
  spec.node = node;
  return spec;
}

/// Adds terms to what a base file has; one of the same name takes its place, two of one name in one
/// file are an error.
void merge_terms(std::vector<TermSpec>& terms, const std::vector<TermSpec>& added) {
  std::set<std::string> seen;
  for (const TermSpec& spec : added) {
    if (!seen.insert(spec.name).second) {
      throw spec.node.error(fmt::format(
          "'{}' given twice; allowed: once, or a `name` of its own for each", spec.name));
    }
    const auto same = std::find_if(terms.begin(), terms.end(),
                                   [&](const TermSpec& t) { return t.name == spec.name; });
    if (same != terms.end()) {
      *same = spec;
    } else {
      terms.push_back(spec);
    }
  }
}

const TermType& type_of(const TermSpec& spec, bool cost, const TermCatalogue& catalogue) {
  std::vector<std::string> names;
  for (const TermType& type : catalogue) {
    if (type.cost != cost) continue;
    if (type.name == spec.type) return type;
    names.push_back(type.name);
  }

  throw spec.node.error(fmt::format("unknown {} type '{}'{}; allowed: {}",
                                    cost ? "cost" : "constraint", spec.type,
                                    yaml::did_you_mean(spec.type, names), fmt::join(names, ", ")));
}

void declare(std::vector<TermSpec>& specs, bool cost, const TermCatalogue& catalogue) {
  const std::string section = cost ? "objective.*[]" : "constraints[]";
  const std::vector<std::string> common = problem_keys::names(problem_keys::of(section));
  for (TermSpec& spec : specs) {
    const TermType& type = type_of(spec, cost, catalogue);
    spec.values = KeyValues(spec.node, type.keys, common);
    spec.declared = std::make_shared<const TermType>(type);
  }
}

}  // namespace

void constraints(Problem& problem, const Node& node) {
  if (is_null(node)) problem.constraints.clear();
  if (is_null(node)) return;
  std::vector<TermSpec> added;
  for (const Node& item : node.items()) added.push_back(term(item));
  merge_terms(problem.constraints, added);
}

void objective(Problem& problem, const Node& node) {
  node.only(problem_keys::names(problem_keys::of("objective")));
  const bool maximise = node.has("maximise");
  if (!maximise && !node.has("minimise"))
    throw node.error("empty; allowed: maximise: [...], minimise: [...] or both");

  std::vector<TermSpec> added;
  for (const char* key : {"maximise", "minimise"}) {
    const auto list = node.find(key);
    if (!list) continue;
    for (const Node& item : list->items()) {
      TermSpec spec = term(item);
      if (const auto weight = item.find("weight")) {
        spec.weight = weight->number(dimension::none);
        if (spec.weight <= 0.0) {
          throw weight->error(
              fmt::format("{:g} given; allowed: a positive weight (move the cost between maximise "
                          "and minimise)",
                          spec.weight));
        }
      }
      if (maximise && std::string_view(key) == "minimise") spec.weight = -spec.weight;
      added.push_back(spec);
    }
  }

  if (added.empty()) throw node.error("no costs given; allowed: one or more");
  // Replaced as a whole: a weighted sum half inherited would have signs that nobody sees.
  problem.objective.clear();
  merge_terms(problem.objective, added);
  problem.maximise = maximise;
}

void declare_terms(Problem& problem, const TermCatalogue& catalogue) {
  declare(problem.constraints, false, catalogue);
  declare(problem.objective, true, catalogue);
}

}  // namespace jaculus::transcription::problem_read
