#include "jaculus/core/units.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "core/unit_symbols.h"
#include "jaculus/core/error.h"
#include "jaculus/core/yaml.h"

namespace jaculus {
namespace {

struct Unit {
  std::string_view symbol;
  double factor;  ///< to SI
  Dimension dimension;
};

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr Dimension kPower{2, 1, -3, 0, 0};
constexpr Dimension kPressure{-1, 1, -2, 0, 0};

constexpr std::array kUnits = {
    Unit{"m", 1.0, dimension::length},
    Unit{"cm", 1e-2, dimension::length},
    Unit{"mm", 1e-3, dimension::length},
    Unit{"km", 1e3, dimension::length},
    Unit{"kg", 1.0, dimension::mass},
    Unit{"g", 1e-3, dimension::mass},
    Unit{"s", 1.0, dimension::time},
    Unit{"ms", 1e-3, dimension::time},
    Unit{"us", 1e-6, dimension::time},
    Unit{"min", 60.0, dimension::time},
    Unit{"h", 3600.0, dimension::time},
    Unit{"Hz", 1.0, dimension::frequency},
    Unit{"kHz", 1e3, dimension::frequency},
    Unit{"rad", 1.0, dimension::angle},
    Unit{"mrad", 1e-3, dimension::angle},
    Unit{"deg", kDegree, dimension::angle},
    Unit{"\u00b0", kDegree, dimension::angle},
    Unit{"rev", kTurn, dimension::angle},
    Unit{"rpm", kTurn / 60.0, dimension::angular_velocity},
    Unit{"N", 1.0, dimension::force},
    Unit{"kN", 1e3, dimension::force},
    Unit{"mN", 1e-3, dimension::force},
    Unit{"J", 1.0, dimension::energy},
    Unit{"W", 1.0, kPower},
    Unit{"kW", 1e3, kPower},
    Unit{"Pa", 1.0, kPressure},
    Unit{"kPa", 1e3, kPressure},
    Unit{"A", 1.0, dimension::current},
    Unit{"mA", 1e-3, dimension::current},
    Unit{"V", 1.0, dimension::voltage},
    Unit{"kV", 1e3, dimension::voltage},
    Unit{"mV", 1e-3, dimension::voltage},
    Unit{"ohm", 1.0, dimension::resistance},
    Unit{"mohm", 1e-3, dimension::resistance},
    Unit{"\u03a9", 1.0, dimension::resistance},
    Unit{"%", 1e-2, dimension::none},
    Unit{"-", 1.0, dimension::none},
    Unit{"1", 1.0, dimension::none},
};

struct Name {
  Dimension dimension;
  std::string_view text;
};

constexpr std::array kNames = {
    Name{dimension::none, "-"},
    Name{dimension::length, "m"},
    Name{dimension::area, "m^2"},
    Name{dimension::mass, "kg"},
    Name{dimension::time, "s"},
    Name{dimension::frequency, "Hz"},
    Name{dimension::angle, "rad"},
    Name{dimension::velocity, "m/s"},
    Name{dimension::angular_velocity, "rad/s"},
    Name{dimension::acceleration, "m/s^2"},
    Name{dimension::angular_acceleration, "rad/s^2"},
    Name{dimension::force, "N"},
    Name{dimension::torque, "N m"},
    Name{dimension::inertia, "kg m^2"},
    Name{dimension::density, "kg/m^3"},
    Name{dimension::current, "A"},
    Name{dimension::voltage, "V"},
    Name{dimension::resistance, "ohm"},
    Name{dimension::torque_constant, "N m/A"},
    Name{dimension::saturation_linear, "A/(N m)"},
    Name{dimension::saturation_cubic, "A/(N m)^3"},
    Name{dimension::angular_stiffness, "N m/rad"},
    Name{dimension::angular_damping, "N m s/rad"},
    Name{kPower, "W"},
    Name{kPressure, "Pa"},
    Name{Dimension{1, 1, -1, 0, 0}, "N s"},
    Name{Dimension{2, 1, -1, 0, 0}, "N m s"},
    Name{Dimension{0, 1, -2, 0, 0}, "N/m"},
    Name{Dimension{0, 1, -1, 0, 0}, "N s/m"},
};

/// A unit expression's value: factor to SI and dimension.
struct Value {
  double factor = 1.0;
  Dimension dimension;
};

Value power(const Value& v, int n) {
  const Dimension& d = v.dimension;
  return {std::pow(v.factor, n),
          {d.metre * n, d.kilogram * n, d.second * n, d.ampere * n, d.radian * n}};
}

Value product(const Value& a, const Value& b) {
  const Dimension& p = a.dimension;
  const Dimension& q = b.dimension;
  return {a.factor * b.factor,
          {p.metre + q.metre, p.kilogram + q.kilogram, p.second + q.second, p.ampere + q.ampere,
           p.radian + q.radian}};
}

/// "N m" of "Nm": two units that were written as one; nothing where a name is none.
std::optional<std::string> parted(std::string_view name, const std::vector<std::string>& known) {
  const auto is_known = [&](std::string_view part) {
    return std::find(known.begin(), known.end(), part) != known.end();
  };
  for (std::size_t at = 1; at < name.size(); ++at)
    if (is_known(name.substr(0, at)) && is_known(name.substr(at)))
      return fmt::format("{} {}", name.substr(0, at), name.substr(at));
  return {};
}

std::vector<std::string> known_symbols() {
  std::vector<std::string> known;
  for (const Unit& unit : kUnits) known.emplace_back(unit.symbol);
  return known;
}

/// Recursive descent over "factor { [space | * | /] factor }"; '/' divides by the next factor
/// alone.
class UnitParser {
 public:
  explicit UnitParser(std::string_view text, const OwnUnits* own = nullptr)
      : text_(text), own_(own) {}

  Value parse() {
    const Value value = expression(0);
    if (at_ != text_.size()) fail(fmt::format("unexpected '{}'", text_.substr(at_)));
    return value;
  }

 private:
  // Deeper nesting than any unit has; bounds the recursion on hostile text.
  static constexpr int kMaxDepth = 8;

  Value expression(int depth) {
    Value value = factor(depth);
    for (;;) {
      skip_spaces();
      if (at_ == text_.size() || text_[at_] == ')') return value;
      const bool divide = text_[at_] == '/';
      if (divide || text_[at_] == '*') {
        ++at_;
      } else if (starts_with("\u00b7")) {
        at_ += 2;
      }
      const Value next = factor(depth);
      value = product(value, divide ? power(next, -1) : next);
    }
  }

  Value factor(int depth) {
    skip_spaces();
    if (at_ < text_.size() && text_[at_] == '(') {
      if (depth >= kMaxDepth) fail("brackets are nested too deeply");
      ++at_;
      const Value inner = expression(depth + 1);
      if (at_ == text_.size()) fail("')' is missing");
      ++at_;
      return power(inner, exponent());
    }
    const Value unit = symbol();
    return power(unit, exponent());
  }

  Value symbol() {
    const std::size_t begin = at_;
    if (at_ < text_.size() && (text_[at_] == '1' || text_[at_] == '-' || text_[at_] == '%')) {
      ++at_;
    } else {
      while (at_ < text_.size() && is_symbol_byte()) ++at_;
    }

    const std::string_view name = text_.substr(begin, at_ - begin);
    for (const Unit& unit : kUnits) {
      if (unit.symbol == name) return {unit.factor, unit.dimension};
    }
    if (name.empty())
      fail(at_ == text_.size() ? "a unit is missing"
                               : "unexpected '" + std::string(1, text_[at_]) + "'");

    std::vector<std::string> known = known_symbols();
    if (own_ != nullptr && *own_) {
      for (const OwnUnit& unit : (*own_)()) {
        if (unit.symbol == name) return {unit.factor, unit.dimension};
        known.push_back(unit.symbol);
      }
    }
    std::optional<std::string> near = parted(name, known);
    if (!near) near = yaml::nearest_name(name, known);
    fail(fmt::format("unknown unit '{}'{}", name,
                     near ? fmt::format(", did you mean '{}'?", *near) : ""));
  }

  /// Letters, _, and the bytes of UTF-8 symbols other than superscript digits and the middle dot.
  [[nodiscard]] bool is_symbol_byte() const {
    if (starts_with("\u00b2") || starts_with("\u00b3") || starts_with("\u00b7")) return false;
    const auto c = static_cast<unsigned char>(text_[at_]);
    return std::isalpha(c) != 0 || c == '_' || c >= 0x80;
  }

  int exponent() {
    if (starts_with("\u00b2") || starts_with("\u00b3")) {
      const int n = starts_with("\u00b2") ? 2 : 3;
      at_ += 2;
      return n;
    }
    if (at_ == text_.size() || text_[at_] != '^') return 1;
    ++at_;
    int n = 0;
    const char* begin = text_.data() + at_;
    const auto [end, code] = std::from_chars(begin, text_.data() + text_.size(), n);
    if (code != std::errc() || n == 0 || n < -9 || n > 9)
      fail("a power must be a whole number from -9 to 9, not 0");
    at_ += end - begin;
    return n;
  }

  void skip_spaces() {
    while (at_ < text_.size() && text_[at_] == ' ') ++at_;
  }

  [[nodiscard]] bool starts_with(std::string_view s) const {
    return text_.substr(at_).starts_with(s);
  }

  [[noreturn]] static void fail(const std::string& what) { throw InputError(what); }

  std::string_view text_;
  const OwnUnits* own_;
  std::size_t at_ = 0;
};

/// A torque constant may be written as volts a rad/s: energy balance makes N m/A and V s/rad the
/// same quantity.
bool accepts(const Dimension& expected, const Dimension& given) {
  if (given == expected) return true;
  Dimension back_emf = dimension::torque_constant;
  back_emf.radian = -1;
  return expected == dimension::torque_constant && given == back_emf;
}

std::string allowed(const Dimension& expected) {
  if (expected == dimension::none) return "allowed: a plain number without a unit";
  return fmt::format("allowed: a number in {}, or a string with such a unit", unit_name(expected));
}

}  // namespace

double parse_quantity(std::string_view text, const Dimension& expected, const OwnUnits* own) {
  const std::string shown(text.substr(0, 60));
  std::string_view rest = text;
  while (!rest.empty() && rest.front() == ' ') rest.remove_prefix(1);
  while (!rest.empty() && rest.back() == ' ') rest.remove_suffix(1);
  if (rest.starts_with('+')) rest.remove_prefix(1);

  double number = 0.0;
  const auto [end, code] = std::from_chars(rest.data(), rest.data() + rest.size(), number);
  if (code == std::errc::result_out_of_range) {
    throw InputError(
        fmt::format("'{}' is too large or too small for a number; {}", shown, allowed(expected)));
  }
  if (code != std::errc())
    throw InputError(fmt::format("'{}' is not a number; {}", shown, allowed(expected)));
  if (!std::isfinite(number))
    throw InputError(fmt::format("'{}' is not a finite number; {}", shown, allowed(expected)));

  std::string_view unit = rest.substr(end - rest.data());
  while (!unit.empty() && unit.front() == ' ') unit.remove_prefix(1);
  if (unit.empty()) {
    if (expected == dimension::none) return number;
    throw InputError(fmt::format("'{}' has no unit; {}", shown, allowed(expected)));
  }

  Value value;
  try {
    value = UnitParser(unit, own).parse();
  } catch (const InputError& e) {
    throw InputError(fmt::format("'{}': {}; {}", shown, e.what(), allowed(expected)));
  }

  if (!accepts(expected, value.dimension)) {
    throw InputError(
        fmt::format("'{}' is in {}; {}", shown, unit_name(value.dimension), allowed(expected)));
  }

  const double result = number * value.factor;
  if (!std::isfinite(result))
    throw InputError(fmt::format("'{}' is too large; {}", shown, allowed(expected)));
  return result;
}

Dimension unit_dimension(std::string_view unit) { return UnitParser(unit).parse().dimension; }

std::optional<std::string> parted_unit(std::string_view unit) {
  return parted(unit, known_symbols());
}

std::string after_number(const std::string& unit) { return unit == "-" ? "" : " " + unit; }

std::string unit_name(const Dimension& d) {
  for (const Name& name : kNames) {
    if (name.dimension == d) return std::string(name.text);
  }
  std::string text;
  const auto add = [&text](std::string_view symbol, int power) {
    if (power == 0) return;
    if (!text.empty()) text += ' ';
    text += symbol;
    if (power != 1) text += fmt::format("^{}", power);
  };
  add("kg", d.kilogram);
  add("m", d.metre);
  add("s", d.second);
  add("A", d.ampere);
  add("rad", d.radian);
  return text;
}

}  // namespace jaculus
