// The table of all terms: one row makes a term known to problem files, to `check --explain` and to the test of derivatives.

#include <fmt/format.h>

#include <stdexcept>

#include "transcription/terms/factories.h"

namespace jaculus {

const std::vector<TermEntry>& term_catalogue() {
  static const std::vector<TermEntry> entries = {
      {"friction", "feet within the friction pyramid |f_x| <= mu f_z: coefficient, feet, phases", false,
       terms::friction},
      {"normal_force", "normal force of one foot: min, max, feet, phases, skip_first, skip_last (collocation points)",
       false, terms::normal_force},
      {"force_at_end", "normal force of a foot at the end of a phase: phase, foot, normal", false, terms::force_at_end},
      {"swing_clearance", "least height of feet in the air: min, feet, phases", false, terms::swing_clearance},
      {"voltage", "motor voltage within the bus voltage: motors, phases", false, terms::voltage},
      {"joint_range", "ranges of joints that are no coordinates: phases", false, terms::joint_range},
      {"touchdown_pitch", "pitch where the ballistic flight after the end has the base at a height: height, pitch",
       false, terms::touchdown_pitch},
      {"mean_acceleration", "velocity at the end over the duration: of (base, com), direction (x, z)", true,
       terms::mean_acceleration},
      {"final_velocity", "velocity at the end: of (base, com), direction (x, z)", true, terms::final_velocity},
      {"distance", "distance travelled by the base along x", true, terms::distance},
      {"height", "height of the base at the end", true, terms::height},
      {"time", "duration", true, terms::time},
      {"torque_squared", "integral of the squared motor torques", true, terms::torque_squared},
      {"electrical_energy", "integral of the electrical power of all motors", true, terms::electrical_energy},
  };
  return entries;
}

namespace {

void make(const TermSpec& spec, bool cost, TermContext& context) {
  std::vector<std::string> names;
  for (const TermEntry& entry : term_catalogue()) {
    if (entry.cost != cost) continue;
    if (entry.type == spec.type) return entry.make(spec, context);
    names.push_back(entry.type);
  }
  const auto nearest = yaml::nearest_name(spec.type, names);
  throw spec.node.error(fmt::format("unknown {} type '{}'{}; allowed: {}", cost ? "cost" : "constraint", spec.type,
                                    nearest ? fmt::format(", did you mean '{}'?", *nearest) : "",
                                    fmt::join(names, ", ")));
}

/// The scratch of intervals is sized for so many rows; who writes a term with more learns it here.
void check_sizes(const TermContext& context) {
  const auto check = [](const PathTerm& term) {
    if (term.rows.size() > static_cast<size_t>(kMaxTermRows))
      throw std::logic_error(
          fmt::format("term '{}' has {} rows; at most {} fit, so split it", term.name, term.rows.size(), kMaxTermRows));
  };
  for (const std::vector<PathTerm>& phase : context.path)
    for (const PathTerm& term : phase) check(term);
  for (const auto& [term, weight] : context.integral_costs) check(term);
}

/// Where a foot is stated to carry nothing, its friction pyramid has no interior: the point is left out.
void open_pyramids(TermContext& context) {
  for (const auto& [phase, foot] : context.unloaded) {
    for (PathTerm& term : context.path[static_cast<size_t>(phase)])
      if (term.kind == LimitKind::friction && term.foot == foot) term.before = std::min(term.before, 1.0);
  }
}

}  // namespace

TermContext make_terms(const Problem& problem, const Equations& equations, Layout& layout) {
  TermContext context{problem, equations, layout, {}, {}, {}, {}, {}, {}};
  context.path.resize(layout.phases.size());
  terms::add_stance(context);
  terms::add_impacts(context);
  for (const TermSpec& spec : problem.constraints) make(spec, false, context);
  for (const TermSpec& spec : problem.objective) make(spec, true, context);
  open_pyramids(context);
  check_sizes(context);
  return context;
}

}  // namespace jaculus
