#include "diagnosis/remainder/pattern_maker.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "diagnosis/remainder/pattern_file.h"

namespace jaculus::diagnosis {
namespace {

/// What an effect of the catalogue does at a joint: an offset of its torque, dry and viscous
/// friction, a scale, friction with load.
bool is_listed(const std::string& place, Regressor regressor) {
  const bool has_effect = regressor == Regressor::constant ||
                          regressor == Regressor::sign_of_speed || regressor == Regressor::speed ||
                          regressor == Regressor::motor_torque ||
                          regressor == Regressor::torque_friction;
  return place == "joint" && has_effect;
}

/// Lower-case letters, digits and _, as names of effects are.
std::string plain_name(std::string name) {
  for (char& c : name) {
    c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
  }
  return "found_" + name;
}

}  // namespace

PlacePattern& PatternMaker::add(Regressor regressor, const std::string& kind,
                                const std::string& caption,
                                std::vector<PatternParameter> parameters,
                                std::vector<std::string> formulas) {
  PlacePattern pattern{place_.place, place_.at, regressor};
  pattern.name = plain_name(place_.at + "_" + kind);
  pattern.caption = place_.what + " that " + caption;
  pattern.where = place_.where;
  pattern.parameters = std::move(parameters);
  pattern.formulas = std::move(formulas);
  pattern.listed = is_listed(place_.place, regressor);
  made.push_back(std::move(pattern));
  return made.back();
}

PlacePattern& PatternMaker::add_caused(Regressor regressor, const std::string& kind,
                                       const std::string& caption, const std::string& cause,
                                       std::vector<PatternParameter> parameters,
                                       const std::string& formula) {
  PlacePattern& pattern = add(regressor, kind, caption, std::move(parameters), {formula});
  pattern.form = caption + ": " + cause;
  pattern.listed = false;
  return pattern;
}

PatternParameter PatternMaker::parameter(const std::string& name, const std::string& per,
                                         double size) const {
  const std::string unit = per.empty() ? (place_.by_limit() ? "\"-\"" : place_.force)
                                       : fmt::format("{}/({})", place_.force, per);
  return {name, unit, place_.large / std::max(1e-9, size)};
}

PatternParameter PatternMaker::one_sided(const std::string& name, const std::string& per,
                                         double size) const {
  PatternParameter own = parameter(name, per, size);
  own.lower = 0.0;
  return own;
}

PatternParameter PatternMaker::lost() const {
  PatternParameter own = share();
  own.lower = 0.0;
  own.upper = 1.0;
  return own;
}

PatternParameter PatternMaker::share() const {
  return {"share", "\"-\"", place_.large / place_.limit};
}

std::string PatternMaker::line(const std::string& formula) const {
  return share_line(place_.by_limit() ? fmt::format("tau_limit*({})", formula) : formula);
}

std::string PatternMaker::share_line(const std::string& formula) const {
  return fmt::format("{}: \"{}\"\n", place_.key, formula);
}

std::string PatternMaker::rest_line() const {
  return constant_line("rest", place_.metre + "/s", std::max(1e-6, place_.rest));
}

std::vector<std::string> along(const std::string& axis, const std::string& formula) {
  const std::string none = "0*(" + formula + ")";
  return {axis == "x" ? fmt::format("force:\n  x: \"{}\"\n  z: \"{}\"\n", formula, none)
                      : fmt::format("force:\n  x: \"{}\"\n  z: \"{}\"\n", none, formula)};
}

}  // namespace jaculus::diagnosis
