// Sections of a problem file whose keys fill one member each.

#include <fmt/format.h>

#include "transcription/fields.h"
#include "transcription/problem_keys.h"
#include "transcription/problem_read.h"

namespace jaculus::transcription {

namespace {

using yaml::Node;

using Figure = std::optional<double> Problem::*;

/// A key of `limits` and the figure that it gives.
struct Limit {
  Key key;
  Figure figure;
  Figure sliding = nullptr;  ///< the same of joints that slide, where that has another unit [N]
};

const std::vector<Limit>& limit_table() {
  const auto limit = [](const char* name, const Dimension& dimension, Figure figure,
                        const char* meaning, Figure sliding = nullptr) {
    const key::Number positive = {dimension, {0.0, kInfinity}};
    return Limit{{name, positive, meaning, {.words = "the robot's"}}, figure, sliding};
  };
  static const std::vector<Limit> table = {
      limit("voltage", dimension::voltage, &Problem::voltage, "of the bus, for every motor"),
      limit("torque", dimension::torque, &Problem::torque,
            "of every motor, before its gear; in N of those whose joints slide", &Problem::force),
      limit("current", dimension::current, &Problem::current, "of every motor"),
      limit("friction", dimension::none, &Problem::friction,
            "Coulomb coefficient that a plan counts on"),
  };
  return table;
}

/// Whether a value reads as a number of this dimension. A plain one reads as any.
bool is_in(const Node& value, const Dimension& dimension) {
  try {
    static_cast<void>(value.number(dimension));
    return true;
  } catch (const InputError&) {
    return false;
  }
}

void drop_limit(const Limit& limit, Problem& problem) {
  (problem.*limit.figure).reset();
  if (limit.sliding != nullptr) (problem.*limit.sliding).reset();
}

void read_limit(const Node& value, const Limit& limit, Problem& problem) {
  const auto& [dimension, allowed] = std::get<key::Number>(limit.key.kind);
  const bool slides = limit.sliding != nullptr && is_in(value, dimension::force);
  const bool turns = !slides || is_in(value, dimension);
  double number = 0.0;
  try {
    number = value.number(turns ? dimension : dimension::force, allowed);
  } catch (const InputError& error) {
    const char* also = limit.sliding != nullptr ? ", or in N for joints that slide" : "";
    throw value.error(error.fault() + also);
  }

  if (number <= 0.0)
    throw value.error(fmt::format("{:g} given; allowed: a positive number", number));
  if (turns) problem.*limit.figure = number;
  if (slides) problem.*limit.sliding = number;
}

const std::vector<Field<TranscriptionSpec>>& transcription_fields() {
  using S = TranscriptionSpec;
  static const std::vector<Field<S>> fields = {
      field("scheme", &S::scheme, key::Choice{{"hermite_simpson", "trapezoidal"}},
            "hermite_simpson (third-order defects, midpoints) or trapezoidal"),
      field("inputs", &S::inputs, key::Choice{{"held", "linear"}},
            "held over an interval, or linear between its ends"),
      field("check_interval_end", &S::check_interval_end, key::Flag{},
            "limits also at the end of each interval with its own input, not only at its start and "
            "middle"),
  };
  return fields;
}

const std::vector<Field<SolverSpec>>& solver_fields() {
  using S = SolverSpec;
  static const std::vector<Field<S>> fields = {
      field("tolerance", &S::tolerance, key::Number{dimension::none, {1e-14, 1e-1}},
            "of the scaled optimality error"),
      field("max_iterations", &S::max_iterations, key::Integer{1, 1000000}, "a start"),
      field("linear_solver", &S::linear_solver,
            key::Choice{{"frontal", "mumps", "ma27", "ma57", "ma86", "ma97"}},
            "frontal, mumps, ma27, ma57, ma86 or ma97 (HSL's where the user has libhsl)"),
      field("seed", &S::seed, key::Integer{0, 2147483647},
            "of everything random; --seed replaces it"),
      field("starts", &S::starts, key::Integer{1, 10000},
            "the guess first, then smooth random ones"),
  };
  return fields;
}

const std::vector<Field<RefinementSpec>>& refinement_fields() {
  using S = RefinementSpec;
  static const std::vector<Field<S>> fields = {
      field("max_rounds", &S::max_rounds, key::Integer{0, 50}, "solves after the first"),
      field("tolerance", &S::tolerance, key::Number{dimension::none, {0.0, 1.0}},
            "of the local error, relative to each state's scale; 0 halves every interval in every "
            "round"),
      field(
          "limits", &S::limits, key::Number{dimension::none, {0.0, 1.0}},
          "by how much a limit may be passed between nodes, over its scale (its own size where it "
          "has one, the robot's weight for forces of feet): splits intervals where one is, and a "
          "plan that passes more fails its verification; 0: not asked for"),
  };
  return fields;
}

}  // namespace

namespace problem_keys {

std::vector<Key> limits() {
  std::vector<Key> keys;
  for (const Limit& limit : limit_table()) keys.push_back(limit.key);
  return keys;
}

std::vector<Key> transcription() { return keys_of(transcription_fields()); }

std::vector<Key> solver() { return keys_of(solver_fields()); }

std::vector<Key> refinement() { return keys_of(refinement_fields()); }

}  // namespace problem_keys

namespace problem_read {

void limits(Problem& problem, const Node& node) {
  if (is_null(node)) {
    for (const Limit& limit : limit_table()) drop_limit(limit, problem);
    return;
  }

  node.only(problem_keys::names(problem_keys::limits()));
  for (const Limit& limit : limit_table()) {
    const auto value = node.find(limit.key.name);
    if (!value) continue;
    problem.places["limits." + limit.key.name] = *value;
    drop_limit(limit, problem);
    if (!is_null(*value)) read_limit(*value, limit, problem);
  }
}

void transcription(Problem& problem, const Node& node) {
  read_fields(node, transcription_fields(), problem.transcription);
}

void solver(Problem& problem, const Node& node) {
  read_fields(node, solver_fields(), problem.solver);
}

void refinement(Problem& problem, const Node& node) {
  read_fields(node, refinement_fields(), problem.refinement);
}

void reference(Problem& problem, const Node& node) {
  if (is_null(node)) problem.reference.clear();
  if (is_null(node)) return;

  const std::vector<Key>& keys = problem_keys::of("reference");
  node.only(problem_keys::names(keys));
  for (const Key& key : keys) {
    const auto value = node.find(key.name);
    if (!value) continue;
    problem.reference.erase(key.name);
    if (is_null(*value)) continue;
    problem.reference[key.name] = value->number(std::get<key::Number>(key.kind).dimension);
  }
}

}  // namespace problem_read

}  // namespace jaculus::transcription
