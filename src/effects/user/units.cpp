#include "effects/user/units.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <random>

#include "effects/user/programs.h"
#include "jaculus/core/error.h"

namespace jaculus::effects {

namespace {

using simulation::ActionKind;

constexpr int kTrials = 40;         ///< random points a formula is tried at
constexpr double kFactor = 1.7;     ///< by which a base unit changes
constexpr double kRounding = 1e-7;  ///< relative; of what may cancel

int Dimension::*const kBaseUnits[] = {&Dimension::metre, &Dimension::kilogram, &Dimension::second,
                                      &Dimension::ampere};
const char* const kBaseNames[] = {"length", "mass", "time", "current"};

/// About 1, of either sign.
double random_number(std::mt19937& random) {
  std::uniform_real_distribution<double> exponent(-1.0, 1.0);
  std::bernoulli_distribution negative(0.5);
  const double size = std::exp2(exponent(random));
  return negative(random) ? -size : size;
}

/// The power with which a formula goes with a base unit; NaN where it goes with none, nothing where
/// it can't be told.
std::optional<double> power_of(const Program::Compiled& compiled, Program& program,
                               int Dimension::*unit, std::mt19937& random) {
  const std::vector<Program::Slot>& slots = program.slots();
  double* numbers = program.numbers();
  std::optional<double> power;
  bool any = false;
  for (int trial = 0; trial < kTrials; ++trial) {
    std::vector<double> x(slots.size());
    for (std::size_t i = 0; i < x.size(); ++i) numbers[i] = x[i] = random_number(random);
    const double before = compiled.expression.value();
    for (std::size_t i = 0; i < x.size(); ++i)
      numbers[i] = x[i] * std::pow(kFactor, slots[i].dimension.*unit);
    const double after = compiled.expression.value();

    const bool finite = std::isfinite(before) && std::isfinite(after);
    any = any || finite;
    if (!finite || (before == 0.0 && after == 0.0)) continue;
    const double own = std::log(after / before) / std::log(kFactor);
    if (std::isnan(own) || std::isinf(own)) return kNaN;
    if (!power) power = own;
    if (std::abs(own - *power) > kRounding * 10.0) return kNaN;
  }
  if (!any)
    throw compiled.formula->node.error(
        fmt::format("\"{}\" has no value anywhere; allowed: one that has", compiled.formula->text));
  return power;
}

void check_formula(const Program::Compiled& compiled, Program& program) {
  const Formula& formula = *compiled.formula;
  std::mt19937 random(1);
  Dimension found = formula.dimension;
  bool wrong = false, whole = true;
  for (std::size_t u = 0; u < std::size(kBaseUnits); ++u) {
    const auto power = power_of(compiled, program, kBaseUnits[u], random);
    if (!power) continue;
    if (std::isnan(*power))
      throw formula.node.error(fmt::format(
          "\"{}\" adds, compares or takes functions of values of different units (their "
          "{} parts); allowed: one that is in {} throughout, with `constants` for "
          "numbers that have a unit",
          formula.text, kBaseNames[u], unit_name(formula.dimension)));
    const int rounded = static_cast<int>(std::lround(*power));
    whole = whole && std::abs(*power - rounded) < 1e-5;
    wrong = wrong || !whole || rounded != formula.dimension.*kBaseUnits[u];
    found.*kBaseUnits[u] = rounded;
  }
  if (!wrong) return;
  found.radian = 0;  // not looked at
  throw formula.node.error(fmt::format("\"{}\" is in {}; allowed: {}", formula.text,
                                       whole ? unit_name(found) : "a broken power of a unit",
                                       unit_name(formula.dimension)));
}

/// " (q = 0.7, qd = -1.2)": where a law was tried.
std::string point_text(const EffectSpec& spec, const std::vector<double>& read,
                       const std::vector<double>& states) {
  const std::vector<ReadingName> readings = readings_of(spec);
  std::string at;
  const auto add = [&](const std::string& name, double value) {
    at += fmt::format("{}{} = {:.3g}", at.empty() ? "" : ", ", name, value);
  };
  for (std::size_t i = 0; i < read.size(); ++i) add(readings[i].name, read[i]);
  for (std::size_t i = 0; i < states.size(); ++i) add(spec.states[i].name, states[i]);
  return at.empty() ? "" : " (" + at + ")";
}

/// That an action's value is another than that which does nothing.
InputError does_something(const EffectSpec& spec, std::size_t action, std::size_t part,
                          double value, double none, const std::string& at) {
  const SpecAction& own = spec.actions[action];
  const yaml::Node& node = spec.code ? spec.node : own.formulas[part].node;
  return node.error(fmt::format(
      "{} is {:.4g} at nominal parameters{}; allowed: {}, for at nominal an effect does nothing",
      spec.code ? spec.code->actions[action] : '"' + own.formulas[part].text + '"', value, at,
      none));
}

/// InputError where a law at nominal parameters does something at a random point.
void check_law(const EffectSpec& spec, const simulation::LawFunctions& functions) {
  std::mt19937 random(2);
  int count = 0;
  for (const SpecAction& action : spec.actions) count += simulation::Action{action.kind}.values();
  std::vector<double> read(readings_of(spec).size()), states(spec.states.size()),
      rates(states.size()), actions(count);

  for (int trial = 0; trial < kTrials; ++trial) {
    for (double& value : read) value = random_number(random);
    for (double& value : states) value = random_number(random);
    if (functions.before) functions.before(read.data(), states.data(), actions.data());
    functions.act(read.data(), states.data(), actions.data(), rates.data());

    const double* value = actions.data();
    for (std::size_t a = 0; a < spec.actions.size(); ++a) {
      const ActionKind kind = spec.actions[a].kind;
      const bool factor = kind == ActionKind::torque_scale || kind == ActionKind::friction_scale;
      const double none = factor ? 1.0 : 0.0;
      for (int part = 0; part < simulation::Action{kind}.values(); ++part, ++value)
        if (*value != none)
          throw does_something(spec, a, part, *value, none, point_text(spec, read, states));
    }
  }
}

}  // namespace

void check_units(Program& program) {
  const std::vector<double> kept(program.numbers(), program.numbers() + program.slots().size());
  for (const Program::Compiled& compiled : program.formulas()) check_formula(compiled, program);
  std::copy(kept.begin(), kept.end(), program.numbers());
}

void check_nominal(const EffectSpec& spec, Program& program) {
  std::mt19937 random(2);
  if (spec.delay && program.delay() != 0.0)
    throw spec.delay->node.error(fmt::format(
        "\"{}\" is {:.4g} s at nominal parameters; allowed: 0, for at nominal an effect does "
        "nothing",
        spec.delay->text, program.delay()));
  for (int trial = 0; spec.reading && trial < kTrials; ++trial) {
    const double value = random_number(random), shown = program.reading(std::abs(value), value);
    if (shown != value)
      throw spec.reading->node.error(
          fmt::format("\"{}\" is {:.4g} at nominal parameters where value is {:.4g}; allowed: "
                      "value, "
                      "for at nominal an effect does nothing",
                      spec.reading->text, shown, value));
  }
  if (spec.reading) return;

  Vector nominal(count_of(spec.parameters));
  for (int i = 0; i < count_of(spec.parameters); ++i) nominal[i] = spec.parameters[i].own.nominal;
  check_law(spec, law_functions(std::make_shared<Programs>(spec), nominal));
}

}  // namespace jaculus::effects
