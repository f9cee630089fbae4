#include "transcription/terms/common.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

namespace jaculus::transcription {

namespace {

/// The names among which a key's names are looked up, by their index.
std::vector<std::string> names_of(key::Of of, const TermContext& context) {
  std::vector<std::string> names;
  if (of == key::Of::phase)
    for (const PhaseBlock& phase : context.layout.phases) names.push_back(phase.name);
  if (of == key::Of::foot)
    for (const model::PlanarPoint& foot : context.model().feet) names.push_back(foot.name);
  if (of == key::Of::motor)
    for (const model::PlanarMotor& motor : context.model().motors) names.push_back(motor.joint);
  return names;
}

}  // namespace

int named(const TermSpec& spec, std::string_view key, const TermContext& context) {
  const auto [of, name] = spec.values.name(key);
  return index_of_name(name, of, names_of(of, context));
}

std::vector<int> all_named(const TermSpec& spec, std::string_view key, const TermContext& context) {
  const auto [of, list] = spec.values.names(key);
  const std::vector<std::string> names = names_of(of, context);

  std::vector<int> indices;
  for (const yaml::Node& name : list) indices.push_back(index_of_name(name, of, names));
  if (spec.values.has(key)) return indices;

  indices.resize(names.size());
  std::iota(indices.begin(), indices.end(), 0);
  return indices;
}

namespace terms {

Key phases_key() {
  return {"phases", key::Names{key::Of::phase}, "list of phases", {.words = "all"}};
}

Key feet_key() { return {"feet", key::Names{key::Of::foot}, "list of feet", {.words = "all"}}; }

Key of_key() {
  return {"of", key::Choice{{"base", "com"}}, "base or com: whose velocity", {.value = "base"}};
}

Key direction_key() { return {"direction", key::Choice{{"x", "z"}}, "x or z", {.value = "x"}}; }

int needed_coordinate(const char* name, const TermSpec& spec, const TermContext& context) {
  const int index = context.model().coordinate_index(name);
  if (index < 0)
    throw spec.node.error(fmt::format("{} needs the coordinate {}, which this robot's base has not",
                                      spec.type, name));
  return index;
}

bool leave_out(int first, int last, const PhaseSpec& phase, Scheme scheme, PathTerm& term) {
  std::vector<double> mesh = phase.stated_mesh.empty() ? phase.mesh : phase.stated_mesh;
  if (mesh.empty()) mesh.assign(phase.intervals, 1.0);
  const double whole = std::accumulate(mesh.begin(), mesh.end(), 0.0);
  std::vector<double> points = {0.0};  // fractions of the duration
  double end = 0.0;
  for (double length : mesh) {
    if (scheme == Scheme::hermite_simpson) points.push_back((end + 0.5 * length) / whole);
    end += length;
    points.push_back(end / whole);
  }
  const int count = count_of(points);
  if (first + last >= count) return false;
  if (first > 0) term.after = std::max(term.after, points[first - 1]);
  if (last > 0) term.before = std::min(term.before, points[count - last]);
  return true;
}

std::vector<int> node_columns(const TermContext& context, int node) {
  std::vector<int> columns(2 * context.layout.n);
  std::iota(columns.begin(), columns.end(), context.layout.nodes[node].q);
  return columns;
}

double weight_scale(const TermContext& context) {
  const double weight = context.model().total_mass() * context.model().gravity;
  return weight > 0.0 ? weight : 1.0;
}

}  // namespace terms

}  // namespace jaculus::transcription
