#include "jaculus/studies/compare.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "jaculus/model/robot.h"

namespace jaculus::studies {
namespace {

const ComparedPlan* partner(const std::vector<ComparedPlan>& plans, TailKind kind,
                            const ComparedPlan& of) {
  const ComparedPlan* first = nullptr;
  for (const ComparedPlan& plan : plans) {
    if (plan.kind != kind) continue;
    if (plan.conditions == of.conditions) return &plan;
    if (first == nullptr) first = &plan;
  }
  return first;
}

using Field = double ComparedPlan::*;

double change(const ComparedPlan& a, const ComparedPlan& b, Field field) {
  return a.converged && b.converged ? a.*field - b.*field : kNaN;
}

/// Of an acceleration to another; NaN where that is next to nothing.
double ratio(const ComparedPlan& a, const ComparedPlan& b, Field field) {
  return std::abs(b.*field) < kLeastAcceleration ? kNaN : change(a, b, field) / (b.*field);
}

Gain gain(const ComparedPlan& plan, const ComparedPlan* over) {
  if (over == nullptr || over == &plan) return {};
  constexpr Field kBase = &ComparedPlan::base_acceleration, kCom = &ComparedPlan::com_acceleration;
  return {over->name,
          over->conditions != plan.conditions,
          ratio(plan, *over, kBase),
          ratio(plan, *over, kCom),
          -change(plan, *over, &ComparedPlan::duration) / over->duration,
          change(plan, *over, kBase),
          change(plan, *over, kCom)};
}

double worth(const ComparedPlan& drag, const ComparedPlan& inertial, const ComparedPlan& over,
             Field field) {
  const double alone = change(inertial, over, field);
  return alone > kLeastGain * std::abs(over.*field) ? change(drag, over, field) / alone - 1.0
                                                    : kNaN;
}

void append(std::string& text, const std::string& name,
            const std::map<std::string, Bounds>& values) {
  for (const auto& [key, b] : values)
    text += fmt::format("{}.{} {} {}\n", name, key, b.lower, b.upper);
}

/// Without the joints of bodies that feel the air: they are what is compared.
std::map<std::string, Bounds> without_tail(const model::PlanarModel& model,
                                           std::map<std::string, Bounds> values) {
  for (const model::PlanarDrag& drag : model.drags) values.erase(model.bodies[drag.body].joint);
  return values;
}

}  // namespace

std::string to_string(TailKind kind) {
  switch (kind) {
    case TailKind::none:
      return "none";
    case TailKind::held:
      return "held";
    case TailKind::inertial:
      return "inertial";
    case TailKind::drag:
      return "drag";
  }
  return "";
}

TailKind tail_kind(const transcription::Problem& problem, const model::PlanarModel& model) {
  if (model.drags.empty()) return TailKind::none;
  for (const model::PlanarDrag& drag : model.drags) {
    const std::string& joint = model.bodies[drag.body].joint;
    const auto locked = [&joint](const auto& lock) { return lock.first == joint; };
    if (std::any_of(problem.locks.begin(), problem.locks.end(), locked)) return TailKind::held;
  }
  const auto blows = [](const model::PlanarDrag& drag) {
    return drag.kind != model::DragKind::none && drag.coefficient > 0.0;
  };
  return std::any_of(model.drags.begin(), model.drags.end(), blows) ? TailKind::drag
                                                                    : TailKind::inertial;
}

std::string conditions(const transcription::Problem& problem) {
  const model::PlanarModel model =
      model::read_robot(problem.robot_folder, problem.overrides).planar;
  std::string text = fmt::format("{} {} {} {} {}\n", problem.voltage.value_or(kNaN),
                                 problem.torque.value_or(kNaN), problem.force.value_or(kNaN),
                                 problem.current.value_or(kNaN), problem.friction.value_or(kNaN));

  for (const transcription::PhaseSpec& phase : problem.phases) {
    for (const std::string& foot : phase.contacts) text += foot + " ";
    text += fmt::format("{} {} {} {}\n", phase.intervals, phase.duration.lower,
                        phase.duration.upper, fmt::join(phase.mesh, " "));
  }

  const transcription::TranscriptionSpec& grid = problem.transcription;
  text +=
      fmt::format("{} {} {} {} {} {}\n", fmt::underlying(grid.scheme), fmt::underlying(grid.inputs),
                  grid.check_interval_end, problem.refinement.max_rounds,
                  problem.refinement.max_rounds > 0 ? problem.refinement.tolerance : 0.0,
                  problem.refinement.limits);

  append(text, "bounds", without_tail(model, problem.position_bounds));
  append(text, "bounds velocity", without_tail(model, problem.velocity_bounds));
  text += fmt::format("at rest {} {}\n", problem.initial.at_rest, problem.final.at_rest);
  append(text, "initial", without_tail(model, problem.initial.position));
  append(text, "initial velocity", without_tail(model, problem.initial.velocity));
  append(text, "final", without_tail(model, problem.final.position));
  append(text, "final velocity", without_tail(model, problem.final.velocity));

  for (const transcription::TermSpec& term : problem.constraints) text += term.node.dump() + "\n";
  text += problem.maximise ? "maximise\n" : "minimise\n";
  for (const transcription::TermSpec& term : problem.objective)
    text += fmt::format("{} {}\n", term.weight, term.node.dump());

  for (const model::Override& o : problem.overrides) {
    // The winding counts, what makes the tail another one does not: that is what is compared.
    if (o.path.ends_with(".resistance")) text += o.path + " " + o.value.dump() + "\n";
  }

  return text;
}

std::vector<PlanGains> gains(const std::vector<ComparedPlan>& plans) {
  std::vector<PlanGains> result;
  for (const ComparedPlan& plan : plans) {
    const ComparedPlan* tailless = partner(plans, TailKind::none, plan);
    if (tailless == nullptr) tailless = &plans.front();
    result.push_back({gain(plan, tailless), gain(plan, partner(plans, TailKind::held, plan))});
  }
  return result;
}

std::vector<DragWorth> drag_worth(const std::vector<ComparedPlan>& plans) {
  std::vector<DragWorth> result;
  for (const ComparedPlan& plan : plans) {
    if (plan.kind != TailKind::drag) continue;
    const ComparedPlan* inertial = partner(plans, TailKind::inertial, plan);
    if (inertial == nullptr) continue;
    for (const TailKind kind : {TailKind::none, TailKind::held}) {
      const ComparedPlan* over = partner(plans, kind, plan);
      if (over == nullptr) continue;
      result.push_back(
          {plan.name, inertial->name, over->name,
           inertial->conditions != plan.conditions || over->conditions != plan.conditions,
           worth(plan, *inertial, *over, &ComparedPlan::base_acceleration),
           worth(plan, *inertial, *over, &ComparedPlan::com_acceleration),
           change(plan, *inertial, &ComparedPlan::base_acceleration),
           change(plan, *inertial, &ComparedPlan::com_acceleration)});
    }
  }
  return result;
}

}  // namespace jaculus::studies
