#pragma once
// The compiled programs of one effect. A run has one to itself and gives it back: a diagnosis makes
// tens of thousands of runs, and to compile the formulas takes a tenth of one. There come to be as
// many as runs were at once.

#include <memory>
#include <mutex>
#include <vector>

#include "effects/user/program.h"

namespace jaculus::effects {

class Programs {
 public:
  explicit Programs(EffectSpec spec);

  [[nodiscard]] const EffectSpec& spec() const { return spec_; }
  /// As readings_of(spec) has them.
  [[nodiscard]] const std::vector<ReadingName>& readings() const { return readings_; }

  /// A program at these parameters, for one thread, back in `programs` once nobody holds it. May be
  /// called from several threads.
  static std::shared_ptr<Program> lend(const std::shared_ptr<Programs>& programs,
                                       const Vector& theta);

 private:
  const EffectSpec spec_;
  const std::vector<ReadingName> readings_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<Program>> idle_;
};

/// Functions of the effect's law at `theta`: its formulas', or those of its code.
simulation::LawFunctions law_functions(const std::shared_ptr<Programs>& programs,
                                       const Vector& theta);

}  // namespace jaculus::effects
