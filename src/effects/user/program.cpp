#include "effects/user/program.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cassert>

#include "jaculus/core/error.h"

namespace jaculus::effects {

namespace {

using simulation::ReadingKind;

struct Known {
  const char* name;
  ReadingKind kind;
  Dimension turning, sliding;
};

const Known kOfJoint[] = {
    {"q", ReadingKind::joint_position, dimension::angle, dimension::length},
    {"qd", ReadingKind::joint_rate, dimension::angular_velocity, dimension::velocity},
    {"load", ReadingKind::joint_load, dimension::torque, dimension::force},
    {"tau", ReadingKind::motor_torque, dimension::torque, dimension::force},
    {"tau_limit", ReadingKind::motor_limit, dimension::torque, dimension::force},
    {"current", ReadingKind::motor_current, dimension::current, dimension::current},
    {"voltage", ReadingKind::motor_voltage, dimension::voltage, dimension::voltage},
};
const Known kOfBody[] = {
    {"x", ReadingKind::point_x, dimension::length, dimension::length},
    {"z", ReadingKind::point_z, dimension::length, dimension::length},
    {"vx", ReadingKind::point_rate_x, dimension::velocity, dimension::velocity},
    {"vz", ReadingKind::point_rate_z, dimension::velocity, dimension::velocity},
    {"angle", ReadingKind::body_angle, dimension::angle, dimension::angle},
    {"omega", ReadingKind::body_rate, dimension::angular_velocity, dimension::angular_velocity},
};
const Known kOfAll[] = {
    {"t", ReadingKind::time, dimension::time, dimension::time},
    {"bus", ReadingKind::bus_voltage, dimension::voltage, dimension::voltage},
};

template <std::size_t n>
const Known* find(const Known (&list)[n], const std::string& name) {
  const auto found = std::find_if(std::begin(list), std::end(list),
                                  [&](const Known& k) { return name == k.name; });
  return found == std::end(list) ? nullptr : found;
}

InputError at_column(const Formula& formula, int column, const std::string& what) {
  return formula.node.error(fmt::format("column {} of \"{}\": {}", column, formula.text, what));
}

std::vector<const Formula*> formulas_of(const EffectSpec& spec) {
  std::vector<const Formula*> all;
  for (const SpecState& state : spec.states) {
    all.push_back(&state.initial);
    if (!spec.code) all.push_back(&state.derivative);
  }
  for (const SpecValue& value : spec.values) all.push_back(&value.formula);
  for (const SpecAction& action : spec.actions)
    for (const Formula& formula : action.formulas) all.push_back(&formula);
  for (const auto* formula : {&spec.delay, &spec.reading})
    if (*formula) all.push_back(&**formula);
  return all;
}

}  // namespace

bool of_motors(ReadingKind kind) {
  return simulation::is_of_motor(kind) || kind == ReadingKind::bus_voltage;
}

std::optional<ReadingName> reading_named(const std::string& name, const EffectPlace& place) {
  if (place.kind == PlaceKind::sensor && name != "t" && name != "value") return std::nullopt;
  if (const Known* known = find(kOfAll, name))
    return ReadingName{name, known->kind, {}, known->turning};
  const std::size_t dot = name.rfind('.');
  if (dot != std::string::npos) {
    const std::string of = name.substr(0, dot), what = name.substr(dot + 1);
    if (of.empty()) return std::nullopt;
    const bool slides = index_of(place.sliding, of) >= 0;
    if (const Known* known = find(kOfJoint, what))
      return ReadingName{name, known->kind, of, slides ? known->sliding : known->turning};
    if (const Known* known = find(kOfBody, what))
      return ReadingName{name, known->kind, of, known->turning};
    return std::nullopt;
  }
  if (place.kind == PlaceKind::sensor)
    return ReadingName{name, ReadingKind::sensor_value, {}, place.channel_dimension()};
  if (!place.at_joints() && !place.on_body()) return std::nullopt;
  const Known* known = place.at_joints() ? find(kOfJoint, name) : find(kOfBody, name);
  if (known == nullptr) return std::nullopt;
  return ReadingName{name, known->kind, {}, place.slides ? known->sliding : known->turning};
}

std::vector<std::string> reading_names(const EffectPlace& place) {
  if (place.kind == PlaceKind::sensor) return {"value", "t"};
  std::vector<std::string> names;
  if (place.at_joints()) {
    for (const Known& known : kOfJoint) names.emplace_back(known.name);
  } else if (place.on_body()) {
    for (const Known& known : kOfBody) names.emplace_back(known.name);
  }
  for (const Known& known : kOfAll) names.emplace_back(known.name);
  return names;
}

std::vector<ReadingName> readings_of(const EffectSpec& spec) {
  std::vector<ReadingName> all;
  if (spec.code) {
    for (const std::string& name : spec.code->reads)
      all.push_back(*reading_named(name, spec.place));
    return all;
  }
  const auto own = [&](const std::string& name) {
    const auto is = [&](const auto& item) { return item.name == name; };
    return std::any_of(spec.constants.begin(), spec.constants.end(), is) ||
           std::any_of(spec.states.begin(), spec.states.end(), is) ||
           std::any_of(spec.values.begin(), spec.values.end(), is) ||
           std::any_of(spec.parameters.begin(), spec.parameters.end(),
                       [&](const SpecParameter& p) { return p.own.name == name; });
  };
  for (const Formula* formula : formulas_of(spec)) {
    for (const UsedName& used : names_in(formula->text)) {
      const auto seen = [&](const ReadingName& r) { return r.name == used.name; };
      if (own(used.name) || std::any_of(all.begin(), all.end(), seen)) continue;
      if (const auto reading = reading_named(used.name, spec.place)) all.push_back(*reading);
    }
  }
  return all;
}

Program::Program(const EffectSpec& spec) : spec_(spec), readings_(readings_of(spec_)) {
  for (const SpecParameter& p : spec_.parameters) add_slot(p.own.name, p.dimension);
  for (const SpecConstant& c : spec_.constants) add_slot(c.name, c.dimension);
  const std::size_t constant = slots_.size();
  first_reading_ = slots_.size();
  for (const ReadingName& r : readings_) add_slot(r.name, r.dimension);
  first_state_ = slots_.size();
  for (const SpecState& s : spec_.states) add_slot(s.name, s.dimension);
  first_value_ = slots_.size();
  for (const SpecValue& v : spec_.values) add_slot(v.name, v.formula.dimension);

  numbers_.assign(slots_.size(), 1.0);
  for (std::size_t i = 0; i < spec_.parameters.size(); ++i)
    numbers_[i] = spec_.parameters[i].own.nominal;
  for (std::size_t i = 0; i < spec_.constants.size(); ++i)
    numbers_[spec_.parameters.size() + i] = spec_.constants[i].value;

  for (const SpecState& s : spec_.states) initials_.push_back(compile(s.initial, constant, false));
  for (std::size_t i = 0; i < spec_.values.size(); ++i)
    values_.push_back(compile(spec_.values[i].formula, first_value_ + i));
  if (spec_.code) return;  // it computes all that follows
  for (const SpecState& s : spec_.states)
    derivatives_.push_back(compile(s.derivative, slots_.size()));
  for (const SpecAction& action : spec_.actions) {
    const bool before = simulation::Action{action.kind}.before_motors();
    for (const Formula& formula : action.formulas)
      acts_.push_back({compile(formula, slots_.size()), before});
  }
  if (spec_.delay) delay_ = compile(*spec_.delay, constant, false);
  if (spec_.reading) reading_ = compile(*spec_.reading, slots_.size());
  find_early();
}

std::size_t Program::add_slot(const std::string& name, const Dimension& dimension) {
  slots_.push_back({name, dimension});
  return slots_.size() - 1;
}

/// Compiles a formula over the first `slots` numbers, readings among them where it is `of_motion`;
/// names of later ones are told as such.
std::size_t Program::compile(const Formula& formula, std::size_t slots, bool of_motion) {
  Expression::Symbols symbols;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < slots; ++i) {
    symbols.emplace_back(slots_[i].name, &numbers_[i]);
    names.push_back(slots_[i].name);
  }
  for (const UsedName& used : names_in(formula.text)) {
    if (std::find(names.begin(), names.end(), used.name) != names.end()) continue;
    std::vector<std::string> allowed = names;
    if (of_motion)
      for (const std::string& name : reading_names(spec_.place))
        if (std::find(allowed.begin(), allowed.end(), name) == allowed.end())
          allowed.push_back(name);
    const bool later = std::any_of(slots_.begin(), slots_.end(),
                                   [&](const Slot& slot) { return slot.name == used.name; });
    allowed.insert(allowed.end(), function_names().begin(), function_names().end());
    const auto near = yaml::nearest_name(used.name, allowed);
    throw at_column(
        formula, used.column,
        fmt::format("{} '{}'{}; allowed: {}{}", later ? "not known yet:" : "unknown name",
                    used.name, near && !later ? fmt::format(", did you mean '{}'?", *near) : "",
                    fmt::join(allowed, ", "),
                    of_motion && spec_.place.kind != PlaceKind::sensor
                        ? ", and JOINT.q or BODY.x of others"
                        : ""));
  }

  try {
    compiled_.push_back({&formula, Expression(formula.text, symbols)});
  } catch (const ExpressionError& e) {
    throw at_column(formula, e.column, std::string(e.what()) + "; allowed: an expression");
  }
  return compiled_.size() - 1;
}

/// Values that actions before the motors need; none of these may read motors or battery.
void Program::find_early() {
  early_values_.assign(spec_.values.size(), false);
  const auto need = [&](const Formula& formula, auto&& self) -> void {
    for (const UsedName& used : names_in(formula.text)) {
      for (const ReadingName& reading : readings_) {
        if (reading.name == used.name && of_motors(reading.kind))
          throw at_column(formula, used.column,
                          fmt::format("'{}' follows from what this changes; allowed: what doesn't, "
                                      "or a state that follows it",
                                      used.name));
      }
      for (std::size_t i = 0; i < spec_.values.size(); ++i) {
        if (spec_.values[i].name != used.name || early_values_[i]) continue;
        early_values_[i] = true;
        self(spec_.values[i].formula, self);
      }
    }
  };
  for (const SpecAction& action : spec_.actions)
    if (simulation::Action{action.kind}.before_motors())
      for (const Formula& formula : action.formulas) need(formula, need);
}

void Program::set_parameters(const Vector& theta) {
  assert(theta.size() == std::ssize(spec_.parameters));
  std::copy(theta.begin(), theta.end(), numbers_.begin());
}

Vector Program::initial() const {
  Vector values(count_of(initials_));
  for (std::size_t i = 0; i < initials_.size(); ++i)
    values[static_cast<Eigen::Index>(i)] = compiled_[initials_[i]].expression.value();
  return values;
}

double Program::reading(double t, double value) {
  for (std::size_t i = 0; i < readings_.size(); ++i)
    numbers_[first_reading_ + i] = readings_[i].kind == ReadingKind::time ? t : value;
  for (std::size_t i = 0; i < values_.size(); ++i)
    numbers_[first_value_ + i] = compiled_[values_[i]].expression.value();
  return compiled_[*reading_].expression.value();
}

void Program::before(const double* readings, const double* states, double* actions) {
  std::copy_n(readings, readings_.size(), numbers_.begin() + static_cast<long>(first_reading_));
  std::copy_n(states, spec_.states.size(), numbers_.begin() + static_cast<long>(first_state_));
  for (std::size_t i = 0; i < values_.size(); ++i)
    if (early_values_[i]) numbers_[first_value_ + i] = compiled_[values_[i]].expression.value();
  for (std::size_t a = 0; a < acts_.size(); ++a)
    if (acts_[a].before) actions[a] = compiled_[acts_[a].formula].expression.value();
}

void Program::act(const double* readings, const double* states, double* actions, double* rates) {
  std::copy_n(readings, readings_.size(), numbers_.begin() + static_cast<long>(first_reading_));
  std::copy_n(states, spec_.states.size(), numbers_.begin() + static_cast<long>(first_state_));
  for (std::size_t i = 0; i < values_.size(); ++i)
    numbers_[first_value_ + i] = compiled_[values_[i]].expression.value();
  for (std::size_t a = 0; a < acts_.size(); ++a)
    if (!acts_[a].before) actions[a] = compiled_[acts_[a].formula].expression.value();
  for (std::size_t s = 0; s < derivatives_.size(); ++s)
    rates[s] = compiled_[derivatives_[s]].expression.value();
}

}  // namespace jaculus::effects
