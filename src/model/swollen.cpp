#include "model/swollen.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "jaculus/model/propose.h"
#include "model/inertia.h"

namespace jaculus::model {
namespace {

double volume(const SpatialShape& shape) {
  const Vec3& s = shape.size;
  const double sphere = 4.0 / 3.0 * M_PI * s[0] * s[0] * s[0];
  const double cylinder = 2.0 * M_PI * s[0] * s[0] * s[2];
  switch (shape.kind) {
    case ShapeKind::sphere:
      return sphere;
    case ShapeKind::box:
      return 8.0 * s.prod();
    case ShapeKind::cylinder:
      return cylinder;
    case ShapeKind::capsule:
      return cylinder + sphere;
  }
  return 0.0;
}

/// Moments of a unit of mass, spread evenly over a shape, along its axes [m^2]; a capsule counts as
/// a cylinder.
Vec3 moments(const SpatialShape& shape) {
  const Vec3 s = shape.size.cwiseAbs2();
  if (shape.kind == ShapeKind::sphere) return Vec3::Constant(0.4 * s[0]);
  if (shape.kind == ShapeKind::box) return Vec3(s[1] + s[2], s[0] + s[2], s[0] + s[1]) / 3.0;
  const double across = s[0] / 4.0 + s[2] / 3.0;
  return {across, across, s[0] / 2.0};
}

}  // namespace

SwollenLinks swollen_links(const SpatialTree& tree) {
  Eigen::AlignedBox3d box;
  for (const SpatialLink& link : tree.links) {
    box.extend(link.p_BL);
    box.extend(Vec3(link.p_BL + link.R_BL * link.com));
  }

  SwollenLinks swollen;
  swollen.size = box.isEmpty() ? 0.0 : box.sizes().norm();
  for (int l = 0; l < count_of(tree.links); ++l) {
    const SpatialLink& link = tree.links[l];
    if (!(link.mass > 0.0) || swollen.size == 0.0) continue;
    const double moment = Eigen::SelfAdjointEigenSolver<Mat3>(link.inertia, Eigen::EigenvaluesOnly)
                              .eigenvalues()
                              .maxCoeff();
    const double radius = std::sqrt(moment / link.mass);
    if (radius <= swollen.size) continue;
    swollen.links.push_back(l);
    swollen.farthest = std::max(swollen.farthest, radius);
  }
  return swollen;
}

std::vector<std::string> take_inertias_of_shapes(SpatialTree& tree) {
  std::vector<std::string> names;
  for (const int l : swollen_links(tree).links) {
    SpatialLink& link = tree.links[l];
    names.push_back(link.name);
    link.inertia = sphere_moment(link.mass) * Mat3::Identity();
    const auto largest = std::max_element(
        link.shapes.begin(), link.shapes.end(),
        [](const SpatialShape& a, const SpatialShape& b) { return volume(a) < volume(b); });
    if (largest == link.shapes.end() || !(volume(*largest) > 0.0)) continue;
    const Mat3& R = largest->rotation;
    link.inertia = link.mass * R * moments(*largest).asDiagonal() * R.transpose();
  }
  return names;
}

}  // namespace jaculus::model
