// The shaft. Its flexible part, from the pivot to where the scoop begins, is cut into n equal
// pieces with a hinge in the middle of each. A force F across the tail at distance d turns hinge i
// at s_i by F (d - s_i)/k, which moves the place d by the sum of F (d - s_i)^2/k; as an angle about
// the pivot per moment F d this is 1/K = sum (d - s_i)^2/(k d^2), so that
//   k = K sum (d - s_i)^2/d^2.

#include <algorithm>
#include <cmath>

#include "testbed/mjcf.h"
#include "testbed/parts.h"

namespace jaculus::testbed {
namespace {

constexpr double kFreeFootImpedance = 0.98;  ///< feet then yield by less than a micrometre [-]
constexpr double kFreeFootStep = 0.6;        ///< of the step of other robots [-]

/// Of a uniform rod from the pivot [m].
double shaft_length(const RobotFiles& files, const model::SpatialLink& link) {
  const Vec2& along = files.drags.front().direction;
  return 2.0 * link.com.dot(model::Vec3(along.x(), 0.0, along.y()));
}

}  // namespace

double hinge_stiffness(const RobotFiles& files, const Changes& changes,
                       const std::vector<double>& hinges) {
  const double d = files.drags.front().point_distance;
  double sum = 0.0;
  for (const double s : hinges) sum += (d - s) * (d - s);
  return changes.shaft_stiffness * sum / (d * d);
}

Numerics numerics_for(const RobotFiles& files, const Changes& changes, Numerics numerics) {
  // The foot of a leg that no pin ties lifts off and lands again every millisecond where the floor
  // is as hard as can be, each time a little further on.
  if (files.pins.empty() && !files.toes.empty()) {
    numerics.impedance = std::min(numerics.impedance, kFreeFootImpedance);
    numerics.step *= kFreeFootStep;
  }

  double fastest = 0.0;  // [rad/s]
  if (const std::vector<double> hinges = shaft_hinges(files, changes); !hinges.empty()) {
    const model::SpatialLink& link =
        files.tree.links[files.tree.link_index(files.drag_links.front())];
    const double piece = hinges.size() > 1 ? hinges[1] - hinges[0] : hinges[0];
    const double inertia = link.mass * piece / shaft_length(files, link) * piece * piece / 12.0;
    fastest = std::sqrt(4.0 * hinge_stiffness(files, changes, hinges) / inertia);
  }
  if (std::isfinite(changes.floor_stiffness)) {
    fastest = std::max(fastest, std::sqrt(changes.floor_stiffness / kPlateMass));
  }
  if (fastest == 0.0) return numerics;
  numerics.runge_kutta = false;
  // Euler rings where Runge-Kutta does not yet
  numerics.stiffness_steps = std::max(2.0, numerics.stiffness_steps);
  numerics.step = std::min(1e-4, 0.4 / fastest);
  return numerics;
}

std::vector<double> shaft_hinges(const RobotFiles& files, const Changes& changes) {
  std::vector<double> hinges;
  if (changes.shaft_segments <= 0 || files.drags.empty()) return hinges;
  const double piece = files.drags.front().start / changes.shaft_segments;
  for (int i = 0; i < changes.shaft_segments; ++i) hinges.push_back((i + 0.5) * piece);
  return hinges;
}

}  // namespace jaculus::testbed
