// The table of all terms: one row makes a term known to problem files, to `check --explain` and to
// the test of derivatives.

#include <fmt/format.h>

#include <stdexcept>

#include "transcription/terms/common.h"

namespace jaculus::transcription {

// Each is defined in terms/ and returns the declaration of one term.
namespace terms {
// contact.cpp
TermType friction();
TermType normal_force();
TermType force_at_end();
TermType swing_clearance();
// actuation.cpp
TermType voltage();
TermType motor_limits();
TermType joint_range();
TermType torque_squared();
TermType electrical_energy();
// ends.cpp
TermType touchdown_pitch();
TermType mean_acceleration();
TermType final_velocity();
TermType distance();
TermType height();
TermType time();
}  // namespace terms

const TermCatalogue& term_catalogue() {
  static const TermCatalogue catalogue = {
      // Constraints.
      terms::friction(),
      terms::normal_force(),
      terms::force_at_end(),
      terms::swing_clearance(),
      terms::voltage(),
      terms::motor_limits(),
      terms::joint_range(),
      terms::touchdown_pitch(),

      // Costs.
      terms::mean_acceleration(),
      terms::final_velocity(),
      terms::distance(),
      terms::height(),
      terms::time(),
      terms::torque_squared(),
      terms::electrical_energy(),
  };
  return catalogue;
}

std::string TermType::in_file(const std::string& own_name) const {
  std::string keys = "type: " + name;
  if (!own_name.empty()) keys += ", name: " + own_name;
  if (!example.empty()) keys += ", " + example;
  return "{" + keys + "}";
}

namespace {

void make(const TermSpec& spec, TermContext& context) {
  if (spec.declared == nullptr)
    throw std::logic_error(fmt::format("term '{}' has no declared type", spec.name));
  spec.declared->make(spec, context);
}

/// The scratch of intervals is sized for so many rows; who writes a term with more learns it here.
void check_sizes(const TermContext& context) {
  const auto check = [](const PathTerm& term) {
    if (count_of(term.rows) > kMaxTermRows)
      throw std::logic_error(fmt::format("term '{}' has {} rows; at most {} fit, so split it",
                                         term.name, term.rows.size(), kMaxTermRows));
  };
  for (const std::vector<PathTerm>& phase : context.path)
    for (const PathTerm& term : phase) check(term);
  for (const auto& [term, weight] : context.integral_costs) check(term);
}

/// Where a foot is stated to carry nothing, its friction pyramid has no interior: the point is left
/// out.
void open_pyramids(TermContext& context) {
  for (const auto& [phase, foot] : context.unloaded) {
    for (PathTerm& term : context.path[phase])
      if (term.loaded_foot == foot) term.before = std::min(term.before, 1.0);
  }
}

}  // namespace

TermContext make_terms(const Problem& problem, const components::Equations& equations,
                       Layout& layout) {
  TermContext context{problem, equations, layout, {}, {}, {}, {}, {}, {}};
  context.path.resize(layout.phases.size());

  terms::add_stance(context);
  terms::add_impacts(context);
  for (const TermSpec& spec : problem.constraints) make(spec, context);
  for (const TermSpec& spec : problem.objective) make(spec, context);

  open_pyramids(context);
  check_sizes(context);
  return context;
}

}  // namespace jaculus::transcription
