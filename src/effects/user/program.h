#pragma once
// A user's effect at one place of a robot, compiled: its formulas over one row of numbers, which
// the run's readings and states are copied into.

#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "effects/user/expression.h"
#include "effects/user/spec.h"
#include "jaculus/simulation/law.h"

namespace jaculus::effects {

/// A name that stands for a reading: "qd", "elbow.q".
struct ReadingName {
  std::string name;
  simulation::ReadingKind kind = simulation::ReadingKind::time;
  std::string of{};  ///< the joint or body of a dotted name; empty: of the effect's own place
  Dimension dimension{};
};

/// The reading that a name stands for at a place of this kind; nothing where it is none.
std::optional<ReadingName> reading_named(const std::string& name, const EffectPlace& place);
/// Names of readings at such a place, for messages.
std::vector<std::string> reading_names(const EffectPlace& place);
/// Whether a reading is of motors or the battery, and so unknown before the motors.
bool of_motors(simulation::ReadingKind kind);
/// Every reading that the formulas use, each once; of a program's effect those that it names.
std::vector<ReadingName> readings_of(const EffectSpec& spec);

/// All numbers of a program, and what is computed of them.
class Program {
 public:
  explicit Program(const EffectSpec& spec);
  Program(const Program&) = delete;  // expressions point into it
  Program& operator=(const Program&) = delete;

  void set_parameters(const Vector& theta);
  /// The states' initial values, of parameters and constants alone.
  [[nodiscard]] Vector initial() const;

  /// The delay of the commands, of parameters and constants alone [s].
  [[nodiscard]] double delay() const { return compiled_[*delay_].expression.value(); }
  /// What a sensor's log has at t [s] for a value.
  double reading(double t, double value);

  void before(const double* readings, const double* states, double* actions);
  void act(const double* readings, const double* states, double* actions, double* rates);

  /// Whether an action before the motors needs a value by its index.
  [[nodiscard]] bool value_comes_before(std::size_t value) const { return early_values_[value]; }

  // For the check of units: every number that formulas read, with its dimension, and the formulas.
  struct Slot {
    std::string name;
    Dimension dimension;
  };
  [[nodiscard]] const std::vector<Slot>& slots() const { return slots_; }
  [[nodiscard]] double* numbers() { return numbers_.data(); }
  struct Compiled {
    const Formula* formula;
    Expression expression;
  };
  [[nodiscard]] const std::vector<Compiled>& formulas() const { return compiled_; }

 private:
  std::size_t add_slot(const std::string& name, const Dimension& dimension);
  std::size_t compile(const Formula& formula, std::size_t slots, bool of_motion = true);
  void find_early();

  const EffectSpec spec_;
  std::vector<ReadingName> readings_;
  std::vector<Slot> slots_;
  std::vector<double> numbers_;
  std::size_t first_reading_ = 0, first_state_ = 0, first_value_ = 0;
  std::vector<Compiled> compiled_;
  std::vector<std::size_t> initials_, derivatives_, values_;  ///< in compiled_
  std::optional<std::size_t> delay_, reading_;                ///< in compiled_
  struct Act {
    std::size_t formula;  ///< in compiled_
    bool before;
  };
  std::vector<Act> acts_;  ///< one an action's value
  std::vector<bool> early_values_;
};

}  // namespace jaculus::effects
