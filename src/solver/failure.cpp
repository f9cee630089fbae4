#include "solver/failure.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "jaculus/components/motor.h"
#include "jaculus/core/units.h"
#include "solver/row_words.h"

namespace jaculus::solver {
namespace {

// A sentence that names more kinds of limits than these is a list.
constexpr std::size_t kMostKinds = 3;
// Of the strongest kind's weight: a weaker one would not be felt beside it.
constexpr double kFelt = 0.2;

/// All limits of one kind and side.
struct Binding {
  std::string kind;
  Side side = Side::fixed;
  std::string unit;
  std::vector<std::string> of, phases;
  double weight = 0.0;  ///< what the sum of scaled slacks falls by, for a scale more of all of them
  Bounds limit{kInfinity, -kInfinity};
  double passed = 0.0;  ///< by how much at most [unit]
};

void add_once(std::vector<std::string>& list, const std::string& text) {
  if (!text.empty() && std::find(list.begin(), list.end(), text) == list.end())
    list.push_back(text);
}

/// Which limit of a motor its torque stands at: an input's bound is the tighter of two.
std::string torque_kind(const model::PlanarModel& model, const std::string& joint) {
  const int m = model.motor_index(joint);
  if (m < 0) return "motor torque";
  const model::PlanarMotor& motor = model.motors[m];
  if (model.slides(motor)) return "motor force";
  const bool current =
      components::largest_joint_torque(motor).limit == components::MotorLimit::current;
  return current ? "motor torque (set by the current limit)" : "motor torque";
}

/// That of a limit's kind, new where there is none yet.
Binding& binding_of(std::vector<Binding>& list, std::string kind, const LimitSensitivity& limit,
                    bool of_something) {
  const auto same = [&](const Binding& b) {
    return b.kind == kind && b.unit == limit.unit &&
           (b.side == limit.side || of_something);  // either way a motor's limit is one
  };
  const auto found = std::find_if(list.begin(), list.end(), same);
  if (found != list.end()) return *found;
  return list.emplace_back(Binding{std::move(kind), limit.side, limit.unit, {}, {}});
}

std::vector<Binding> all_bindings(const Conflict& conflict, const model::PlanarModel& model) {
  std::vector<Binding> list;
  for (const LimitSensitivity& limit : conflict.limits) {
    if (limit.side == Side::fixed) continue;  // what is imposed is asked for, no limit
    const RowWords words = row_words(limit.name);
    std::string kind = words.kind == "motor torque" ? torque_kind(model, words.of) : words.kind;
    Binding& own = binding_of(list, std::move(kind), limit, !words.of.empty());
    add_once(own.of, words.of);
    add_once(own.phases, words.phase);
    own.weight += std::abs(limit.scaled);

    const double value = words.of.empty() ? limit.limit : std::abs(limit.limit);
    own.limit = {std::min(own.limit.lower, value), std::max(own.limit.upper, value)};
    for (const Relaxation& row : conflict.relaxed)
      if (limit.is_row && row.row == limit.index)
        own.passed = std::max(own.passed, std::abs(row.amount));
  }
  return list;
}

/// Those that are felt, strongest first.
std::vector<Binding> bindings(const Conflict& conflict, const model::PlanarModel& model) {
  std::vector<Binding> list = all_bindings(conflict, model);
  std::stable_sort(list.begin(), list.end(),
                   [](const Binding& a, const Binding& b) { return a.weight > b.weight; });
  const double felt = list.empty() ? 0.0 : kFelt * list.front().weight;
  std::erase_if(list, [felt](const Binding& b) { return b.weight < felt; });

  // Limits of motors and floor before bounds of single coordinates: they are what a robot has.
  std::stable_partition(list.begin(), list.end(), [](const Binding& b) { return !b.of.empty(); });
  return list;
}

std::string text_of(const Binding& b) {
  const char* side = !b.of.empty() ? "at" : b.side == Side::lower ? "at least" : "at most";
  const std::string value = b.limit.upper - b.limit.lower < 1e-9 * std::abs(b.limit.upper)
                                ? fmt::format("{:.4g}", b.limit.upper)
                                : fmt::format("{:.4g} to {:.4g}", b.limit.lower, b.limit.upper);
  std::string text = b.kind;
  if (!b.of.empty()) text += fmt::format(" of {}", fmt::join(b.of, ", "));
  if (!b.phases.empty()) text += fmt::format(" in {}", fmt::join(b.phases, ", "));
  text += fmt::format(" ({} {}{}", side, value, after_number(b.unit));
  if (b.passed > 0.0)
    text += fmt::format(", short by up to {:.2g}{}", b.passed, after_number(b.unit));
  return text + ")";
}

}  // namespace

std::string binding_sentence(const Conflict& conflict, const model::PlanarModel& model) {
  if (conflict.feasible) return {};
  std::vector<Binding> list = bindings(conflict, model);
  if (list.empty()) return {};
  std::vector<std::string> texts;
  for (const Binding& b : list)
    if (texts.size() < kMostKinds) texts.push_back(text_of(b));
  const std::string first = texts.front();
  texts.erase(texts.begin());
  return fmt::format("what binds is the limit on {}{}{}", first, texts.empty() ? "" : ", then on ",
                     fmt::join(texts, ", then on "));
}

}  // namespace jaculus::solver
