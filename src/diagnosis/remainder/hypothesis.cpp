#include "diagnosis/remainder/hypothesis.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "diagnosis/remainder/pattern_file.h"

namespace jaculus::diagnosis {
namespace {

constexpr std::size_t kMost = 3;
constexpr double kPeriodSpread = 0.02;  ///< prior deviation of a period, of it
constexpr double kPeriodRange = 0.2;    ///< either way
constexpr double kPlaceSpread = 0.3;  ///< prior deviation of where a spring rests [rad], or tenths
                                      ///< of that where it slides [m]
constexpr double kPlaceReach = 10.0;  ///< of that deviation, either way

/// What a file says beside its name and place.
struct Body {
  std::string kind;         ///< of the name: "periodic"
  std::string caption;      ///< "repeats with the joint's angle"
  std::string parameters;   ///< lines
  std::string constants{};  ///< lines
  std::string formula;
};

/// Units at a joint: of its force, its position and its rate.
struct Units {
  std::string force, position;
  std::string per(const std::string& what) const { return fmt::format("{}/({})", force, what); }
};

std::string rest_constant(double rest, const Units& units) {
  return fmt::format("constants:\n  rest: {{unit: {}/s, value: {:.4g}}}\n", units.position, rest);
}

Body periodic(const Dependence& d, const Units& units) {
  const double amplitude = std::hypot(d.coefficients[0], d.coefficients[1]);
  Body body{"periodic", "repeats with the joint's position", "", "",
            "sine*sin(2*pi*q/period) + cosine*cos(2*pi*q/period)"};
  body.parameters =
      size_line("sine", units.force, amplitude) + size_line("cosine", units.force, amplitude) +
      parameter_line("period", units.position, d.period,
                     {(1.0 - kPeriodRange) * d.period, (1.0 + kPeriodRange) * d.period},
                     kPeriodSpread * d.period);
  return body;
}

Body spring(const Dependence& d, const Units& units, bool angular) {
  const double stiffness = -d.coefficients[0], straight = d.coefficients[1] / stiffness;
  const double spread = angular ? kPlaceSpread : 0.1 * kPlaceSpread;
  Body body{"spring", "grows with the distance from where a spring rests", "", "",
            "-stiffness*(q - straight)"};
  body.parameters =
      size_line("stiffness", units.per(units.position), stiffness) +
      parameter_line("straight", units.position, straight,
                     {straight - kPlaceReach * spread, straight + kPlaceReach * spread}, spread);
  return body;
}

Body drift(const Dependence& d, const Units& units) {
  Body body{"drift", "grows with time since the start", "", "", "rate*t + offset"};
  body.parameters = size_line("rate", units.per("s"), d.coefficients[0]) +
                    size_line("offset", units.force, d.coefficients[1]);
  return body;
}

/// Nothing where no formula reads what the force follows.
Body body_of(const Dependence& d, const RemainderPlace& place, const Units& units) {
  const double first = d.coefficients.front();
  const std::string rate = units.position + "/s", friction = rest_constant(place.rest, units);
  const std::string other = d.of + ".qd";

  switch (d.regressor) {
    case Regressor::constant:
      return {"offset", "is always there", size_line("offset", units.force, first), "", "offset"};
    case Regressor::sign_of_speed:
      return {"dry_friction", "acts against the motion", size_line("level", units.force, first),
              friction, "-level*tanh(qd/rest)"};
    case Regressor::speed:
      return {"damping", "grows with the speed", size_line("damping", units.per(rate), first), "",
              "-damping*qd"};
    case Regressor::speed_squared:
      return {"drag", "grows with the square of the speed",
              size_line("drag", units.per(fmt::format("{0}^2/s^2", units.position)), first), "",
              "-drag*abs(qd)*qd"};
    case Regressor::motor_torque:
      return {"scale", "is a share of the motor's", size_line("share", "\"-\"", first), "",
              "share*tau"};
    case Regressor::torque_friction:
      return {"load_friction", "is a share of the motor's, against the motion",
              size_line("share", "\"-\"", first), friction, "-share*abs(tau)*tanh(qd/rest)"};
    case Regressor::weight_friction:
      return {"weight_friction", "is a share of the load, against the motion",
              size_line("share", "\"-\"", first), friction, "-share*abs(load)*tanh(qd/rest)"};
    case Regressor::position:
      return spring(d, units, units.position == "rad");
    case Regressor::periodic:
      return periodic(d, units);
    case Regressor::time:
      return drift(d, units);
    case Regressor::other_speed:
      return {"coupling", "grows with the speed of " + d.of,
              size_line("coupling", units.per(rate), first), "", "coupling*" + other};
    default:
      return {};
  }
}

/// Lower-case letters, digits and _, a letter first, as names of effects are.
std::string effect_name(const std::string& joint, const std::string& kind) {
  std::string name = joint + "_" + kind;
  for (char& c : name) {
    c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
  }
  return std::isalpha(static_cast<unsigned char>(name[0])) != 0 ? name : "at_" + name;
}

std::string file_of(const Dependence& d, const RemainderPlace& place, const Body& body) {
  const bool turns = place.unit == "N m";
  const char* noun = turns ? "torque" : "force";
  return fmt::format(
      "# What is left at {0}, {1:.2g} {2} rms: {3:.0f} % of it ({4:.0f} to {5:.0f} %) follows "
      "this\n"
      "# formula. Scales are the sizes found.\n"
      "format: jaculus-effect/1\n"
      "name: found_{6}\n"
      "caption: {7} at {0} that {8}\n"
      "at: {{joint: {0}}}\n"
      "parameters:\n{9}{10}{7}: \"{11}\"\n",
      place.joint, place.rms, place.unit, 100.0 * d.share, 100.0 * d.ci95.lower,
      100.0 * d.ci95.upper, effect_name(place.joint, body.kind), noun, body.caption,
      body.parameters, body.constants, body.formula);
}

}  // namespace

std::vector<std::string> hypotheses_of(const Remainder& remainder,
                                       const model::PlanarModel& robot) {
  struct Part {
    const RemainderPlace* place;
    const Dependence* dependence;
    double size;
  };
  std::vector<Part> parts;
  for (const RemainderPlace& place : remainder.places)
    for (const Dependence& d : place.follows)
      parts.push_back({&place, &d,
                       !std::isfinite(d.share) ? 0.0
                       : place.by_simulation   ? d.share
                                               : place.rms * std::sqrt(std::max(0.0, d.share))});
  std::stable_sort(parts.begin(), parts.end(),
                   [](const Part& a, const Part& b) { return a.size > b.size; });

  std::vector<std::string> files;
  for (const Part& part : parts) {
    if (!part.dependence->hypothesis.empty()) {
      if (files.size() < kMost) files.push_back(part.dependence->hypothesis);
      continue;
    }
    const bool turns = part.place->unit == "N m";
    if (robot.body_of_joint(part.place->joint) < 0) continue;
    const Body body =
        body_of(*part.dependence, *part.place, {part.place->unit, turns ? "rad" : "m"});
    if (!body.formula.empty() && files.size() < kMost)
      files.push_back(file_of(*part.dependence, *part.place, body));
  }
  return files;
}

}  // namespace jaculus::diagnosis
