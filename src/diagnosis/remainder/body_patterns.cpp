#include "diagnosis/remainder/body_patterns.h"

#include <fmt/format.h>

#include <algorithm>

#include "diagnosis/remainder/pattern_file.h"

namespace jaculus::diagnosis {
namespace {

constexpr double kNearFloor = 5e-3;  ///< within which a foot feels the floor [m]
constexpr double kLeastWay = 0.05;   ///< of the body, for sizes [m]
const std::vector<double> kHertz = {1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0};
const std::vector<double> kBodySlacks = {0.02, 0.05, 0.1, 0.2};  ///< [m]
const std::vector<double> kLooseRates = {10.0, 20.0, 40.0};      ///< of a mass on a spring [rad/s]

void add_cables(PatternMaker& maker) {
  const PatternPlace& place = maker.at();
  for (const double slack : kBodySlacks) {
    if (slack > place.range) continue;
    PlacePattern& cable =
        maker.add(Regressor::position, fmt::format("x_cable_{:.0f}_mm", 1e3 * slack),
                  "grows with the way once a cable is taut",
                  {maker.one_sided("stiffness", "m", std::max(kLeastWay, place.range - slack))},
                  along("x", "-stiffness*max(0, x - start - slack)"));
    cable.constants = {constant_line("start", "m", place.start)};
    cable.shape = slack_shape("m", slack, slack);
  }
}

/// What is not seen whole once is no repetition: half a wave is a push, less a drift.
void add_sways(PatternMaker& maker, const std::string& axis) {
  for (const double hertz : kHertz) {
    if (hertz * maker.at().duration < 1.0) continue;
    maker
        .add(Regressor::periodic_in_time, fmt::format("{}_sway_{:.0f}_mhz", axis, 1e3 * hertz),
             "repeats in time", {maker.parameter("sine"), maker.parameter("cosine")},
             along(axis, "sine*sin(2*pi*t/period) + cosine*cos(2*pi*t/period)"))
        .shape = period_shape("s", 1.0 / hertz);
  }
}

/// A mass m on a spring in the body, at rest with it at the start: with its way y and the body's
/// own s, y'' = w^2 (s - y), and the body feels -m y''.
void add_loose_masses(PatternMaker& maker) {
  for (const double rate : kLooseRates) {
    PlacePattern& mass =
        maker.add(Regressor::acceleration, fmt::format("x_loose_{:.0f}", rate),
                  "a mass on a spring in it makes", {{"mass", "kg", maker.at().mass, 0.0}},
                  along("x", "-mass*pull"));
    mass.shape = width_shape("rad/s", rate);
    mass.values = {"  pull: {unit: m/s^2, value: \"width^2*(moved - way)\"}\n"};
    mass.states = {"  moved: {unit: m, initial: 0, derivative: vx}\n",
                   "  way: {unit: m, initial: 0, derivative: rate}\n",
                   "  rate: {unit: m/s, initial: 0, derivative: pull}\n"};
    mass.form = "goes with the acceleration: a mass that is loose in it";
  }
}

}  // namespace

void add_body_patterns(PatternMaker& maker, const std::string& axis) {
  const PatternPlace& place = maker.at();
  const std::string v = "v" + axis;
  maker.add(Regressor::constant, axis + "_offset", "is always there", {maker.parameter("offset")},
            along(axis, "offset"));
  maker
      .add(Regressor::position, axis + "_spring", "grows with the way from the start",
           {maker.parameter("stiffness", "m", std::max(kLeastWay, place.range))},
           along(axis, "-stiffness*(" + axis + " - start)"))
      .constants = {constant_line("start", "m", place.start)};
  if (axis == "x") add_cables(maker);

  maker.add(Regressor::speed, axis + "_damping", "grows with the speed",
            {maker.parameter("damping", "m/s", place.speed)}, along(axis, "-damping*" + v));
  maker.add(Regressor::speed_squared, axis + "_drag", "grows with the square of the speed",
            {maker.parameter("drag", "m^2/s^2", place.speed * place.speed)},
            along(axis, "-drag*abs(" + v + ")*" + v));
  maker.add(Regressor::time, axis + "_drift", "grows with time since the start",
            {maker.parameter("rate", "s", place.duration)}, along(axis, "rate*t"));
  add_sways(maker, axis);
  if (axis == "x") add_loose_masses(maker);
}

void add_moment_patterns(PatternMaker& maker) {
  const auto moment = [](const std::string& formula) {
    return std::vector<std::string>{fmt::format("moment: \"{}\"\n", formula)};
  };
  maker.add(Regressor::constant, "pitch_offset", "is always there", {maker.parameter("offset")},
            moment("offset"));
  maker.add(Regressor::speed, "pitch_damping", "grows with the speed",
            {maker.parameter("damping", "rad/s", maker.at().speed)}, moment("-damping*omega"));
}

void add_foot_patterns(PatternMaker& maker) {
  const std::string near = "max(0, min(1, 1 - z/range))",
                    range = constant_line("range", "m", kNearFloor);
  maker
      .add(Regressor::constant, "held", "holds it to the floor", {maker.parameter("level")},
           along("z", "-level*" + near))
      .constants = {range};
  maker
      .add(Regressor::constant, "pulled", "pulls along the floor", {maker.parameter("level")},
           along("x", "level*" + near))
      .constants = {range};
  maker
      .add(Regressor::position, "reach", "pushes it off from a height on",
           {maker.parameter("stiffness", "m", kNearFloor)},
           along("z", "stiffness*max(0, range - z)"))
      .constants = {range};
  maker
      .add(Regressor::sign_of_speed, "rub", "acts against its motion along the floor",
           {maker.parameter("level")}, along("x", "-level*tanh(vx/rest)*" + near))
      .constants = {range, maker.rest_line()};
}

}  // namespace jaculus::diagnosis
