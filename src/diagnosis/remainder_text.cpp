// What a diagnosis leaves, in sentences.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "jaculus/diagnosis/summary.h"

namespace jaculus::diagnosis {
namespace {

/// A period as people read it: "17 deg (0.3 rad)".
std::string period_text(const Dependence& d) {
  if (d.unit != "rad") return fmt::format("{:.3g} {}", d.period, d.unit);
  return fmt::format("{:.3g} deg ({:.3g} rad)", d.period * 180.0 / std::numbers::pi, d.period);
}

/// "repeats with the joint's position, period 17 deg (0.3 rad): cogging, a bent shaft or a tooth".
std::string dependence_text(const Dependence& d) {
  if (!d.form.empty()) return d.form;
  const std::string of = in_words(d.of);

  switch (d.regressor) {
    case Regressor::constant:
      return "is always there: a bias or an offset";
    case Regressor::sign_of_speed:
      return "has the sign of the speed: dry friction";
    case Regressor::speed:
      return "grows with the speed: viscous friction";
    case Regressor::speed_squared:
      return "grows with the square of the speed: drag";
    case Regressor::motor_torque:
      return "is a share of the motor's torque: its scale";
    case Regressor::torque_friction:
      return "is a share of the motor's torque, against the motion: friction of a loaded gear";
    case Regressor::weight_friction:
      return "is a share of the weight carried, against the motion: friction of a loaded bearing";
    case Regressor::position:
      return d.coefficients.front() < 0.0 ? "grows with the position: a spring or a cable"
                                          : "pushes away from a position: a spring past its middle";
    case Regressor::periodic:
      return fmt::format(
          "repeats with the joint's position, period {}: cogging, a bent shaft or a tooth",
          period_text(d));
    case Regressor::gravity_direction:
      return "turns with the direction of gravity: a weight";
    case Regressor::acceleration:
      return "is proportional to the acceleration: an inertia";
    case Regressor::time:
      return "grows with time since the start: a drift";
    case Regressor::other_speed:
      return "grows with the speed of " + of;
    case Regressor::other_acceleration:
      return "grows with the acceleration of " + of;
    case Regressor::channel:
      return "follows " + of;
    case Regressor::periodic_in_time:
      return fmt::format("repeats in time, {:.3g} times a second: what it stands on sways",
                         1.0 / d.period);
  }
  return "";
}

std::string per_cent_of(const Dependence& d) {
  if (!std::isfinite(d.share)) return dependence_text(d);
  const auto shown = [](double share) { return 100.0 * std::clamp(share, 0.0, 1.0); };
  return fmt::format("{:.0f} % of it ({:.0f} to {:.0f} %) {}", shown(d.share), shown(d.ci95.lower),
                     shown(d.ci95.upper), dependence_text(d));
}

/// What a place follows, joined; empty without a pattern.
std::string follows_text(const RemainderPlace& place) {
  std::vector<std::string> parts;
  for (const Dependence& d : place.follows) parts.push_back(per_cent_of(d));
  return fmt::format("{}", fmt::join(parts, "; "));
}

/// "Of the gap that is left, a force on the body along x explains 62 % (40 to 84 %): it ...".
std::string simulated_sentence(const RemainderPlace& place) {
  const std::string where = place.place == "body"   ? "the body, along " + in_words(place.joint)
                            : place.place == "feet" ? "the foot " + in_words(place.joint)
                                                    : in_words(place.joint);
  return fmt::format("A force at {} would explain what is left of the gap: {}.", where,
                     follows_text(place));
}

std::string box_sentence(const RemainderPlace& place) {
  return fmt::format("What is left at {} is {:.2g} {} rms; {}.", in_words(place.joint), place.rms,
                     place.unit, place.follows.empty() ? "no pattern in it" : follows_text(place));
}

std::string sentence_of(const RemainderPlace& place) {
  return place.by_simulation ? simulated_sentence(place) : box_sentence(place);
}

bool remains(const Diagnosis& diagnosis) {
  return diagnosis.verdict == Verdict::partial || diagnosis.verdict == Verdict::unexplained;
}

}  // namespace

std::string leading_remainder(const Diagnosis& diagnosis) {
  const std::vector<RemainderPlace>& places = diagnosis.remainder.places;
  const auto first = std::find_if(places.begin(), places.end(), [](const RemainderPlace& p) {
    return !p.follows.empty() && !p.is_push();
  });
  return remains(diagnosis) && first != places.end() ? sentence_of(*first) : "";
}

std::vector<std::string> remainder_sentences(const Diagnosis& diagnosis) {
  std::vector<std::string> sentences;
  for (const RemainderPlace& place : diagnosis.remainder.places) {
    const bool silent = place.follows.empty() && !remains(diagnosis);
    if (place.is_push()) continue;
    if (place.by_simulation || (std::isfinite(place.rms) && !silent))
      sentences.push_back(sentence_of(place));
  }
  return sentences;
}

}  // namespace jaculus::diagnosis
