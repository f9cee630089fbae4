#include "diagnosis/remainder/push_place.h"

#include <fmt/format.h>

#include "diagnosis/remainder/pattern_file.h"
#include "diagnosis/remainder/pattern_maker.h"
#include "jaculus/diagnosis/summary.h"

namespace jaculus::diagnosis {
namespace {

constexpr double kTimeSpread = 0.25;  ///< deviation of start and length, of the length [chosen]
constexpr double kTimeReach = 4.0;    ///< of a length, either way [chosen]

std::string push_file(const ForceEvent& push, const model::PlanarModel& robot) {
  const bool of_body = !push.along.empty(), moment = push.along == "pitch";
  const std::string what = moment    ? "moment on the body"
                           : of_body ? "force on the body along " + push.along
                                     : "push at " + in_words(push.joint);
  const std::string at = of_body ? base_place(robot) : fmt::format("{{joint: {}}}", push.joint);

  const double length = push.to - push.from;
  const std::string half_sine = "peak*sin(pi*max(0, min(1, (t - start)/length)))";
  const std::string key = moment ? "moment" : push.unit == "N m" ? "torque" : "force";
  std::string formula = fmt::format("{}: \"{}\"\n", key, half_sine);
  if (of_body && !moment) formula = along(push.along, half_sine).front();

  return fmt::format(
      "format: jaculus-effect/1\nname: found_push\ncaption: {} for a while in every trial\nat: {}\n"
      "parameters:\n{}{}{}{}",
      what, at, size_line("peak", push.unit, push.peak),
      parameter_line("start", "s", push.from, {push.from - length, push.to}, kTimeSpread * length),
      parameter_line("length", "s", length, {length / kTimeReach, kTimeReach * length},
                     kTimeSpread * length),
      formula);
}

}  // namespace

RemainderPlace push_place(const ForceEvent& push, const model::PlanarModel& robot) {
  RemainderPlace place;
  place.joint = push.along.empty() ? push.joint : push.along;
  place.place = push.along.empty() ? "joint" : "body";
  place.unit = push.unit;
  place.by_simulation = true;

  Dependence own;
  own.regressor = Regressor::time;
  own.form = fmt::format("acts in every trial from {:.3g} to {:.3g} s", push.from, push.to);
  own.brief = true;
  own.selected = push.probability;
  own.coefficients = {push.peak};
  own.hypothesis = push_file(push, robot);
  place.follows = {std::move(own)};
  return place;
}

}  // namespace jaculus::diagnosis
