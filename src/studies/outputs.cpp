#include <cmath>

#include "jaculus/components/tail_drag.h"
#include "jaculus/core/angle.h"
#include "studies/reorientation_study.h"
#include "studies/study_kind.h"

namespace jaculus::studies {
namespace {

using Point = ReorientationPoint;

template <class F>
StudyJson at_stop(const Point& p, F&& f) {
  return p.result.stop ? json_number(f(*p.result.stop)) : StudyJson(nullptr);
}

StudyJson time_to_target(const Point& p) {
  return p.result.time_to_target ? StudyJson(*p.result.time_to_target) : StudyJson(nullptr);
}

// The moment of drag in still air over the one without a shaft.
StudyJson shaft_torque_ratio(const Point& p) {
  const model::PlanarDrag d = to_case(p.setup).drag;
  if (d.kind == model::DragKind::none) return nullptr;
  return components::rotation_drag_factor(1.0, 1.0, 1.0, d.start, d.end) /
         components::rotation_drag_factor(1.0, 1.0, 1.0, 0.0, d.end);
}

// Momentum about the pin at the end, all of it from the air.
StudyJson drag_impulse(const Point& p) {
  const ReorientationCase c = to_case(p.setup);
  const ReorientationResult& r = p.result;
  return c.body_inertia * r.body_rate + c.tail_inertia * (r.body_rate + r.tail_rate);
}

double normalised_inertia(const Point& p) {
  const ReorientationCase c = to_case(p.setup);
  return c.tail_inertia / (c.body_inertia + c.tail_inertia);
}

StudyJson drag_factor(const Point& p) {
  model::PlanarDrag d = to_case(p.setup).drag;
  return -components::drag_load(d, 0.0, 1.0, 0.0).moment;
}

// What a tail of this kind is good for.
std::vector<Output> effectiveness_outputs() {
  return {
      {"gear", false, false, false, [](const Point& p) { return json_number(p.setup.motor.gear); },
       "motor turns a joint turn"},
      {"search_bound", false, false, false,
       [](const Point& p) { return StudyJson(p.search_bound); },
       "lower or upper where the search ended on its bound"},
      {"effectiveness", false, false, false,
       [](const Point& p) { return json_number(p.result.effectiveness); },
       "body angle over tail angle"},

      {"effectiveness_without_drag", true, false, false,
       [](const Point& p) { return json_number(p.without_drag->effectiveness); },
       "the same tail without drag"},
      {"aerodynamic_effectiveness", true, false, false,
       [](const Point& p) {
         return json_number(p.result.effectiveness - p.without_drag->effectiveness);
       },
       "the difference of the two"},
      {"effectiveness_in_still_air", false, false, true,
       [](const Point& p) { return json_number(p.still->effectiveness); },
       "without wind and speed"},
  };
}

// How the task ends, and when.
std::vector<Output> end_outputs() {
  return {
      {"body_angle_at_end_deg", false, false, false,
       [](const Point& p) { return json_number(std::abs(p.result.body_angle) * kDegrees); },
       "magnitude"},
      {"tail_angle_at_end_deg", false, false, false,
       [](const Point& p) { return json_number(p.result.tail_angle * kDegrees); }, "to the body"},
      {"duration_s", false, false, false,
       [](const Point& p) { return json_number(to_case(p.setup).duration); }, "of the task"},

      {"time_to_target_s", false, false, false, time_to_target, "null where not reached"},
      {"time_to_90deg_s", false, false, false, time_to_target,
       "for a target of 90 deg; null where not reached"},
      {"delay_s", false, true, false,
       [](const Point& p) {
         if (!p.result.time_to_target || !p.rigid->time_to_target) return StudyJson(nullptr);
         return json_number(*p.result.time_to_target - *p.rigid->time_to_target);
       },
       "of the target behind a rigid tail's"},
  };
}

// What happens at the tail's stop.
std::vector<Output> stop_outputs() {
  return {
      {"stop_time_s", false, false, false,
       [](const Point& p) { return at_stop(p, [](auto& s) { return s.time; }); },
       "null where the stop is not reached"},
      {"body_angle_at_stop_deg", false, false, false,
       [](const Point& p) {
         return at_stop(p, [](auto& s) { return std::abs(s.body_angle) * kDegrees; });
       },
       "magnitude"},
      {"tail_rate_at_stop_rad_s", false, false, false,
       [](const Point& p) { return at_stop(p, [](auto& s) { return s.tail_rate; }); },
       "to the body, just before"},

      {"body_rate_before_stop_rad_s", false, false, false,
       [](const Point& p) { return at_stop(p, [](auto& s) { return s.body_rate_before; }); },
       "signed"},
      {"body_rate_after_stop_rad_s", false, false, false,
       [](const Point& p) { return at_stop(p, [](auto& s) { return s.body_rate_after; }); },
       "signed"},
      {"stop_impulse_N_m_s", false, false, false,
       [](const Point& p) { return at_stop(p, [](auto& s) { return std::abs(s.impulse); }); },
       "angular impulse that arrests the tail"},
      {"rotation_after_stop_deg", false, false, false,
       [](const Point& p) {
         return at_stop(p, [&](auto&) { return p.result.rotation_after_stop * kDegrees; });
       },
       "that goes on after the stop"},
  };
}

// Beside a tail that has inertia alone; weight, and the air's share.
std::vector<Output> inertia_outputs() {
  return {
      {"hold_torque_N_m", false, false, false,
       [](const Point& p) { return json_number(hold_torque(p.setup)); },
       "that holds the tail level; null without tail.mass and tail.com"},
      {"equal_inertial_tail", false, false, false,
       [](const Point& p) { return json_number(p.result.effectiveness); },
       "normalised inertia of the tail without drag that turns the body as far a degree of tail"},
      {"equal_inertial_tail_over_body", false, false, false,
       [](const Point& p) {
         return json_number(p.result.effectiveness / (1.0 - p.result.effectiveness));
       },
       "its inertia in units of the body's"},

      {"tail_share_of_inertia", false, false, false,
       [](const Point& p) { return json_number(normalised_inertia(p)); },
       "normalised inertia of this tail"},
      {"inertia_saved", false, false, false,
       [](const Point& p) {
         return json_number(1.0 - normalised_inertia(p) / p.result.effectiveness);
       },
       "share by which its normalised inertia is below that of the equal inertial tail"},
      {"added_mass", false, false, false,
       [](const Point& p) {
         return json_number((p.setup.tail_mass + p.setup.framing_mass) / p.setup.body_mass);
       },
       "tail and framing over the body's mass; null without the three masses"},
      {"shaft_torque_ratio", false, false, false, shaft_torque_ratio,
       "drag moment over the one without shaft"},
      {"drag_factor_N_m_s2", false, false, false, drag_factor,
       "b of the drag moment b omega^2 in still air"},
      {"drag_impulse_N_m_s", false, false, false, drag_impulse,
       "angular impulse of the air on body and tail"},
  };
}

}  // namespace

const std::vector<Output>& output_catalogue() {
  static const std::vector<Output> table = [] {
    std::vector<Output> all;
    for (const auto& group :
         {effectiveness_outputs(), end_outputs(), stop_outputs(), inertia_outputs()})
      all.insert(all.end(), group.begin(), group.end());
    return all;
  }();
  return table;
}

}  // namespace jaculus::studies
