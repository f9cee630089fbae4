#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "transcription/terms/factories.h"

namespace jaculus::terms {

namespace {

std::vector<std::string> phase_names(const TermContext& context) {
  std::vector<std::string> names;
  for (const PhaseBlock& phase : context.layout.phases) names.push_back(phase.name);
  return names;
}

std::vector<std::string> foot_names(const TermContext& context) {
  std::vector<std::string> names;
  for (const PlanarPoint& foot : context.model().feet) names.push_back(foot.name);
  return names;
}

int index_of(const yaml::Node& node, const std::vector<std::string>& names) {
  const std::string chosen = node.choice(names);
  return static_cast<int>(std::find(names.begin(), names.end(), chosen) - names.begin());
}

std::vector<int> chosen(const yaml::Node& node, const char* key, const std::vector<std::string>& names) {
  std::vector<int> result;
  if (const auto list = node.find(key)) {
    for (const yaml::Node& item : list->items()) result.push_back(index_of(item, names));
  } else {
    result.resize(names.size());
    std::iota(result.begin(), result.end(), 0);
  }
  return result;
}

}  // namespace

std::vector<int> chosen_phases(const yaml::Node& node, const TermContext& context) {
  return chosen(node, "phases", phase_names(context));
}

std::vector<int> chosen_feet(const yaml::Node& node, const TermContext& context) {
  return chosen(node, "feet", foot_names(context));
}

int phase_index(const yaml::Node& node, const TermContext& context) { return index_of(node, phase_names(context)); }

int foot_index(const yaml::Node& node, const TermContext& context) { return index_of(node, foot_names(context)); }

int needed_coordinate(const char* name, const TermSpec& spec, const TermContext& context) {
  const int index = context.model().coordinate_index(name);
  if (index < 0)
    throw spec.node.error(fmt::format("{} needs the coordinate {}, which this robot's base has not", spec.type, name));
  return index;
}

bool leave_out(int first, int last, const PhaseSpec& phase, Scheme scheme, PathTerm& term) {
  std::vector<double> mesh = phase.stated_mesh.empty() ? phase.mesh : phase.stated_mesh;
  if (mesh.empty()) mesh.assign(static_cast<size_t>(phase.intervals), 1.0);
  const double whole = std::accumulate(mesh.begin(), mesh.end(), 0.0);
  std::vector<double> points = {0.0};  // fractions of the duration
  double end = 0.0;
  for (double length : mesh) {
    if (scheme == Scheme::hermite_simpson) points.push_back((end + 0.5 * length) / whole);
    end += length;
    points.push_back(end / whole);
  }
  const int count = static_cast<int>(points.size());
  if (first + last >= count) return false;
  if (first > 0) term.after = std::max(term.after, points[static_cast<size_t>(first - 1)]);
  if (last > 0) term.before = std::min(term.before, points[static_cast<size_t>(count - last)]);
  return true;
}

std::vector<int> node_columns(const TermContext& context, int node) {
  std::vector<int> columns(static_cast<size_t>(2 * context.layout.n));
  std::iota(columns.begin(), columns.end(), context.layout.nodes[static_cast<size_t>(node)].q);
  return columns;
}

double weight_scale(const TermContext& context) {
  const double weight = context.model().total_mass() * context.model().gravity;
  return weight > 0.0 ? weight : 1.0;
}

}  // namespace jaculus::terms
