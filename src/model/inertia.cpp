#include "model/inertia.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <cmath>

namespace jaculus::model {

double sphere_moment(double mass) {
  constexpr double kWater = 1000.0;  // [kg/m^3]
  const double radius = std::cbrt(3.0 * mass / (4.0 * M_PI * kWater));
  return 0.4 * mass * radius * radius;
}

void settle_inertia(SpatialLink& link, Assumptions& assumptions) {
  const auto assume = [&](const std::string& fault, const std::string& taken) {
    assumptions.assume(link.line, "link '" + link.name + "': " + fault, taken);
  };

  if (!(link.mass > 0.0)) {
    const std::string fault = fmt::format("mass {:.10g} kg given; allowed: more than 0", link.mass);
    if (link.mass < 0.0) assumptions.refuse(link.line, "link '" + link.name + "': " + fault);
    assume(fault, "without mass and inertia");
    link.com.setZero();
    link.inertia.setZero();
    return;
  }

  const Vec3 moments =
      Eigen::SelfAdjointEigenSolver<Mat3>(link.inertia, Eigen::EigenvaluesOnly).eigenvalues();
  const std::string shown =
      fmt::format("inertia with principal moments {:.6g}, {:.6g}, {:.6g} kg m^2", moments[0],
                  moments[1], moments[2]);
  const std::string kept = "used as it is, for the plane takes one moment of it";

  if (!(moments[0] > 0.0)) {
    const bool usable = link.inertia.diagonal().minCoeff() > 0.0;
    const double sphere = sphere_moment(link.mass);
    assume(shown + " given; allowed: all above 0",
           usable ? kept
                  : fmt::format("that of a sphere of water of {:.4g} kg, {:.3g} kg m^2", link.mass,
                                sphere));
    if (!usable) link.inertia = sphere * Mat3::Identity();
    return;
  }

  // Files are rounded to a few digits, thin rods and plates sit on the limit.
  constexpr double kRounding = 1e-3;
  if (moments[2] > (moments[0] + moments[1]) * (1.0 + kRounding)) {
    assume(shown +
               " given, which no body can have; allowed: the largest at most the sum of the other "
               "two",
           kept);
  }
}

Vec2 squares_along(double phi, const Mat3& inertia) {
  const double half = 0.5 * inertia(1, 1), apart = 0.5 * (inertia(2, 2) - inertia(0, 0));
  const double c = std::cos(phi), s = std::sin(phi);
  const double xx = half + apart, zz = half - apart, xz = -inertia(0, 2);
  return {c * c * xx - 2.0 * c * s * xz + s * s * zz, s * s * xx + 2.0 * c * s * xz + c * c * zz};
}

}  // namespace jaculus::model
