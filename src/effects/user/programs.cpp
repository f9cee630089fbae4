#include "effects/user/programs.h"

namespace jaculus::effects {

Programs::Programs(EffectSpec spec) : spec_(std::move(spec)), readings_(readings_of(spec_)) {}

std::shared_ptr<Program> Programs::lend(const std::shared_ptr<Programs>& programs,
                                        const Vector& theta) {
  std::unique_ptr<Program> own;
  {
    const std::lock_guard lock(programs->mutex_);
    if (!programs->idle_.empty()) {
      own = std::move(programs->idle_.back());
      programs->idle_.pop_back();
    }
  }
  if (!own) own = std::make_unique<Program>(programs->spec());
  own->set_parameters(theta);

  return {own.release(), [programs](Program* program) {
            std::unique_ptr<Program> back(program);
            const std::lock_guard lock(programs->mutex_);
            programs->idle_.push_back(std::move(back));
          }};
}

simulation::LawFunctions law_functions(const std::shared_ptr<Programs>& programs,
                                       const Vector& theta) {
  if (programs->spec().code) return programs->spec().code->functions(theta);

  const std::shared_ptr<Program> program = Programs::lend(programs, theta);
  simulation::LawFunctions functions;
  functions.before = [program](const double* readings, const double* states, double* actions) {
    program->before(readings, states, actions);
  };
  functions.act = [program](const double* readings, const double* states, double* actions,
                            double* rates) { program->act(readings, states, actions, rates); };
  return functions;
}

}  // namespace jaculus::effects
