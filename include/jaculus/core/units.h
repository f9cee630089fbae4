#pragma once
// Physical dimensions and the units in which users may write them.

#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace jaculus {

/// Dimension as exponents of the SI base units that occur here, radians kept as a unit of their
/// own.
struct Dimension {
  int metre = 0;
  int kilogram = 0;
  int second = 0;
  int ampere = 0;
  int radian = 0;
  bool operator==(const Dimension&) const = default;
};

namespace dimension {
inline constexpr Dimension none{};
inline constexpr Dimension length{1, 0, 0, 0, 0};
inline constexpr Dimension area{2, 0, 0, 0, 0};
inline constexpr Dimension mass{0, 1, 0, 0, 0};
inline constexpr Dimension time{0, 0, 1, 0, 0};
inline constexpr Dimension frequency{0, 0, -1, 0, 0};
inline constexpr Dimension angle{0, 0, 0, 0, 1};
inline constexpr Dimension velocity{1, 0, -1, 0, 0};
inline constexpr Dimension angular_velocity{0, 0, -1, 0, 1};
inline constexpr Dimension acceleration{1, 0, -2, 0, 0};
inline constexpr Dimension angular_acceleration{0, 0, -2, 0, 1};
inline constexpr Dimension force{1, 1, -2, 0, 0};
inline constexpr Dimension torque{2, 1, -2, 0, 0};
inline constexpr Dimension energy{2, 1, -2, 0, 0};
inline constexpr Dimension inertia{2, 1, 0, 0, 0};
inline constexpr Dimension density{-3, 1, 0, 0, 0};
inline constexpr Dimension current{0, 0, 0, 1, 0};
inline constexpr Dimension voltage{2, 1, -3, -1, 0};
inline constexpr Dimension resistance{2, 1, -3, -2, 0};
inline constexpr Dimension torque_constant{2, 1, -2, -1, 0};    // N m/A, equally V s/rad
inline constexpr Dimension saturation_linear{-2, -1, 2, 1, 0};  // A/(N m)
inline constexpr Dimension saturation_cubic{-6, -3, 6, 1, 0};   // A/(N m)^3
inline constexpr Dimension angular_stiffness{2, 1, -2, 0, -1};  // N m/rad
inline constexpr Dimension angular_damping{2, 1, -1, 0, -1};    // N m s/rad
}  // namespace dimension

/// A unit beside the physical ones, as of one robot: its leg's length.
struct OwnUnit {
  std::string symbol;   ///< letters and _
  double factor = 1.0;  ///< to SI
  Dimension dimension;
};
/// Gives them when a text has a symbol that is no physical unit; may read files and throw
/// InputError.
using OwnUnits = std::function<const std::vector<OwnUnit>&()>;

/// Parses "16 V", "15 deg", "4 ms", "0.0954 N m/A": a number, then unit symbols with powers (m^2,
/// s^-1) joined by spaces, '*' or '/'. Returns the value in SI. A unit of another dimension, or
/// none, throws InputError (without location). `own`: further units; may be null.
double parse_quantity(std::string_view text, const Dimension& expected,
                      const OwnUnits* own = nullptr);

/// Dimension of a unit in the same notation: "N m/A". InputError (without location) where it is
/// none.
Dimension unit_dimension(std::string_view unit);

/// The SI unit of a dimension as a user reads it: "N m", "rad/s", "-".
std::string unit_name(const Dimension& dimension);

/// A unit as it follows a number in a text: " N m", nothing where there is none ("-").
std::string after_number(const std::string& unit);

}  // namespace jaculus
