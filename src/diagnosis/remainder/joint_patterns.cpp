#include "diagnosis/remainder/joint_patterns.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "diagnosis/remainder/pattern_file.h"

namespace jaculus::diagnosis {
namespace {

constexpr double kShare =
    0.1;  ///< of a motor's torque, prior of a scale: k_t as data sheets have it
constexpr double kRamp =
    0.05;  ///< of the duration, in which a loss sets in: a quarter of its grid's
constexpr double kAllOfIt = 1.5;    ///< of a share that is 1 where the cause is there: half as much
constexpr double kSettle = 1e-3;    ///< of a driver that follows at once: a sample at 1 kHz [s]
constexpr double kSpotWidth = 0.2;  ///< of a joint's range: the grid's places are 0.3 apart
constexpr double kLeastRange = 0.1;  ///< of a joint, below which nothing is told [rad or m]
const std::vector<int> kWaves = {1, 2, 3, 4, 6, 8, 10, 12, 14, 16, 18, 20, 24, 28, 36};  ///< a turn

// Grids of what a linear scan can't fit: factors of 2 to 3 apart, over what a motion can tell.
const std::vector<double> kSlacks = {0.0, 0.2, 0.4, 0.7};              ///< of a joint's range
const std::vector<double> kBristles = {0.03, 0.1, 0.3};                ///< the same
const std::vector<double> kSpots = {-0.8, -0.5, -0.2, 0.2, 0.5, 0.8};  ///< from the start, the same
const std::vector<double> kTravels = {0.5, 2.0};                       ///< the same
const std::vector<double> kDeadBands = {0.003, 0.01, 0.03};  ///< of a motor's limit, half of one
const std::vector<double> kSetsIn = {0.2, 0.4, 0.6, 0.8};    ///< of the motion's duration
const std::vector<double> kSlewTimes = {0.01, 0.03, 0.1};    ///< from nothing to the limit [s]

double range_of(const PatternPlace& place) { return std::max(kLeastRange, place.range); }

void add_frictions(PatternMaker& maker) {
  const PatternPlace& place = maker.at();
  const std::string rate = place.metre + "/s";
  maker.add(Regressor::constant, "offset", "is always there", {maker.parameter("offset")},
            {maker.line("offset")});
  maker
      .add(Regressor::sign_of_speed, "dry_friction", "acts against the motion",
           {maker.parameter("level")}, {maker.line("-level*tanh(qd/rest)")})
      .constants = {maker.rest_line()};
  maker.add(Regressor::speed, "damping", "grows with the speed",
            {maker.parameter("damping", rate, place.speed)}, {maker.line("-damping*qd")});
  maker.add(
      Regressor::speed_squared, "drag", "grows with the square of the speed",
      {maker.parameter("drag", fmt::format("{}^2/s^2", place.metre), place.speed * place.speed)},
      {maker.line("-drag*abs(qd)*qd")});
}

/// Friction with a memory: bristles that bend before they slip (Dahl 1968, "A solid friction
/// model", here with sigma = level/width and exponent 1), grease that motion works loose.
void add_worn_frictions(PatternMaker& maker) {
  const PatternPlace& place = maker.at();
  for (const double share : kBristles) {
    PlacePattern& bristles =
        maker.add_caused(Regressor::sign_of_speed, fmt::format("bristles_{:.0f}", 100.0 * share),
                         "is elastic for a small motion and acts against a larger one",
                         "hysteresis", {maker.one_sided("level")}, maker.line("-level*bend"));
    bristles.shape = width_shape(place.metre, share * range_of(place));
    bristles.states = {
        "  bend: {unit: \"-\", initial: 0, derivative: \"(qd - abs(qd)*bend)/width\"}\n"};
  }

  for (const double share : kTravels) {
    PlacePattern& grease = maker.add_caused(
        Regressor::sign_of_speed, fmt::format("grease_{:.0f}", 100.0 * share),
        "acts against the motion and fades with the way", "grease that is not worked loose",
        {maker.one_sided("level")}, maker.line("-level*tanh(qd/rest)*exp(-way/width)"));
    grease.shape = width_shape(place.metre, share * range_of(place));
    grease.states = {
        fmt::format("  way: {{unit: {}, initial: 0, derivative: \"abs(qd)\", scale: {:.4g}}}\n",
                    place.metre, range_of(place))};
    grease.constants = {maker.rest_line()};
  }
}

/// What may become of a motor's torque on its way, that is no share of it.
void add_losses(PatternMaker& maker) {
  const PatternPlace& place = maker.at();
  const std::string tau_limit = place.by_limit() ? "tau_limit" : "limit";
  std::vector<std::string> limit;
  if (!place.by_limit()) limit = {constant_line("limit", place.force, place.limit)};
  const auto add = [&](const std::string& kind, const std::string& caption,
                       const std::string& cause, const PatternParameter& parameter,
                       const std::string& line) -> PlacePattern& {
    return maker.add_caused(Regressor::motor_torque, kind, caption, cause, {parameter}, line);
  };

  add("saturation", "is a share of the motor's that grows with it", "magnets saturate",
      maker.lost(), maker.share_line(fmt::format("-share*abs(tau)*tau/{}", tau_limit)))
      .constants = limit;
  for (const double share : kDeadBands) {
    PlacePattern& dead = add(
        fmt::format("dead_band_{:.0f}", 1e3 * share), "is the motor's up to some size",
        "a dead band", {"share", "\"-\"", 1.0, 0.0, kAllOfIt},
        maker.share_line(fmt::format("-share*max(-width*{0}, min(width*{0}, tau))", tau_limit)));
    dead.shape = width_shape("\"-\"", share);
    dead.constants = limit;
  }
  PatternParameter rate = maker.lost();
  rate.name = "rate";
  rate.unit = "1/s";
  rate.scale /= place.duration;
  rate.upper /= place.duration;
  add("fading", "is a share of the motor's that grows with time", "it fades", rate,
      maker.share_line("-rate*t*tau"));

  for (const double share : kSetsIn) {
    PlacePattern& loss =
        add(fmt::format("loss_{:.0f}", 100.0 * share),
            "is a share of the motor's from some time on", "it derates", maker.lost(),
            maker.share_line("-share*tau*max(0, min(1, (t - after)/ramp))"));
    const double after = share * place.duration, ramp = kRamp * place.duration;
    loss.shape = {"after", "s", after, 2.0 * ramp, after - 4.0 * ramp, after + 4.0 * ramp};
    loss.constants = {constant_line("ramp", "s", ramp)};
  }

  for (const double time : kSlewTimes) {
    PlacePattern& slew =
        add(fmt::format("slew_{:.0f}_ms", 1e3 * time), "is what a change of the motor's lacks",
            "it can change only so fast", {"share", "\"-\"", 1.0, 0.0, kAllOfIt},
            maker.line(place.by_limit() ? "share*behind" : "share*limit*behind"));
    slew.shape = width_shape("s", time);
    // y' = (tau/limit - y)/settle within +-1/width; at the start y comes up at once.
    slew.values = {
        fmt::format("  behind: {{unit: \"-\", value: \"arrived - tau/{}\"}}\n", tau_limit)};
    slew.states = {
        "  arrived: {unit: \"-\", initial: 0, derivative: \"t < begin ? -behind/settle : "
        "max(-1/width, min(1/width, -behind/settle))\"}\n"};
    slew.constants = limit;
    slew.constants.push_back(constant_line("settle", "s", kSettle));
    slew.constants.push_back(constant_line("begin", "s", 5.0 * kSettle));
  }
}

void add_waves(PatternMaker& maker) {
  const PatternPlace& place = maker.at();
  const double turn = place.metre == "rad" ? 2.0 * std::numbers::pi : 1.0;
  for (const int waves : kWaves) {
    const double period = turn / waves;
    if (period > 2.0 * place.range) continue;
    maker
        .add(Regressor::periodic, fmt::format("wave_{}", waves),
             "repeats with the joint's position",
             {maker.parameter("sine"), maker.parameter("cosine")},
             {maker.line("sine*sin(2*pi*q/period) + cosine*cos(2*pi*q/period)")})
        .shape = period_shape(place.metre, period);
  }
}

/// A gear's ratio that varies once or twice a turn of its motor.
void add_runouts(PatternMaker& maker) {
  const PatternPlace& place = maker.at();
  if (!std::isfinite(place.turn)) return;
  PatternParameter sine = maker.share(), cosine = maker.share();
  sine.name = "sine";
  cosine.name = "cosine";
  for (const int waves : {1, 2}) {
    if (place.turn / waves > 2.0 * place.range) continue;
    PlacePattern& runout = maker.add_caused(
        Regressor::motor_torque, fmt::format("runout_{}", waves),
        "is a share of the motor's that repeats with the position", "a gear out of round",
        {sine, cosine},
        maker.share_line("tau*(sine*sin(2*pi*q/period) + cosine*cos(2*pi*q/period))"));
    runout.shape = period_shape(place.metre, place.turn / waves);
  }
}

/// The way from where the joint starts: each has its own, so that a group's is a state.
struct Way {
  std::string text;
  std::vector<std::string> constants, states;
};
Way way_of(const PatternPlace& place) {
  if (!place.of_group)
    return {"(q - start)", {constant_line("start", place.metre, place.start)}, {}};
  return {"way",
          {},
          {fmt::format("  way: {{unit: {}, initial: 0, derivative: qd, scale: {:.4g}}}\n",
                       place.metre, range_of(place))}};
}

/// What pulls back or stops a joint on one side: a cable that gets taut, something in the way.
void add_one_sided_springs(PatternMaker& maker) {
  const PatternPlace& place = maker.at();
  const double range = range_of(place);
  const Way way = way_of(place);
  for (const double share : kSlacks) {
    const auto add = [&](const std::string& side, const std::string& beyond) {
      PlacePattern& cable = maker.add_caused(
          Regressor::position, fmt::format("taut_{}_{:.0f}", side, 100.0 * share),
          "pulls back beyond a position", "a cable that gets taut, something in the way",
          {maker.one_sided("stiffness", place.metre, (1.0 - share) * range)},
          maker.line("-stiffness*" + beyond));
      cable.constants = way.constants;
      cable.states = way.states;
      cable.shape = slack_shape(place.metre, share * range, range);
    };
    add("up", fmt::format("max(0, {} - slack)", way.text));
    add("down", fmt::format("min(0, {} + slack)", way.text));
  }
}

void add_springs(PatternMaker& maker) {
  const PatternPlace& place = maker.at();
  const Way way = way_of(place);
  PlacePattern& spring = maker.add(Regressor::position, "spring",
                                   "grows with the distance from where the joint starts",
                                   {maker.parameter("stiffness", place.metre, range_of(place))},
                                   {maker.line("-stiffness*" + way.text)});
  spring.constants = way.constants;
  spring.states = way.states;
  add_one_sided_springs(maker);
}

/// Dry friction near one angle.
void add_spots(PatternMaker& maker) {
  const PatternPlace& place = maker.at();
  const double range = range_of(place), width = kSpotWidth * range;
  for (std::size_t k = 0; k < kSpots.size(); ++k) {
    PlacePattern& spot = maker.add_caused(
        Regressor::sign_of_speed, fmt::format("spot_{}", k),
        "acts against the motion near a position", "a tight spot", {maker.one_sided("level")},
        maker.line("-level*tanh(qd/rest)*exp(-((q - spot)/width)^2)"));
    const double at = place.start + kSpots[k] * range;
    spot.shape = {"spot", place.metre, at, width, at - 2.0 * width, at + 2.0 * width};
    spot.constants = {maker.rest_line(), constant_line("width", place.metre, width)};
  }
}

void add_weight(PatternMaker& maker) {
  const PatternPlace& place = maker.at();
  if (place.body.empty() || place.metre != "rad") return;
  maker.add(Regressor::gravity_direction, "weight", "turns with the direction of gravity",
            {maker.parameter("sine"), maker.parameter("cosine")},
            {maker.line(fmt::format("sine*sin({0}.angle) + cosine*cos({0}.angle)", place.body))});
}

}  // namespace

void add_joint_patterns(PatternMaker& maker) {
  const PatternPlace& place = maker.at();
  add_frictions(maker);
  const PatternParameter share{"share", "\"-\"", kShare};
  maker.add(Regressor::motor_torque, "scale", "is a share of the motor's", {share},
            {maker.share_line("share*tau")});
  maker
      .add(Regressor::torque_friction, "load_friction",
           "is a share of the motor's, against the motion", {share},
           {maker.share_line("-share*abs(tau)*tanh(qd/rest)")})
      .constants = {maker.rest_line()};
  maker.add(Regressor::time, "drift", "grows with time since the start",
            {maker.parameter("rate", "s", place.duration)}, {maker.line("rate*t")});
  add_worn_frictions(maker);
  add_losses(maker);
  add_springs(maker);

  if (place.of_group) return;  // each joint of one would have its own phase and place
  add_waves(maker);
  add_runouts(maker);
  add_spots(maker);
  add_weight(maker);
}

}  // namespace jaculus::diagnosis
