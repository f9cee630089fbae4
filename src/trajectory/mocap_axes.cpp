// From a take's axes to x forward, y left, z up, and from rotations to planar angles.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "jaculus/core/error.h"
#include "jaculus/core/yaml.h"
#include "jaculus/trajectory/optitrack.h"

namespace jaculus::trajectory {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

std::string axis_name(const Vector3d& axis) {
  Eigen::Index i = 0;
  axis.cwiseAbs().maxCoeff(&i);
  return fmt::format("{}{}", axis[i] < 0.0 ? '-' : '+', "xyz"[i]);
}

/// The axis that a name states, "+x".
Vector3d axis_of(const std::string& name) {
  return (name[0] == '-' ? -1.0 : 1.0) * Vector3d::Unit(name[1] - 'x');
}

/// Horizontal displacement from the first seen frame to the farthest from it.
Vector3d displacement(const MocapBody& body, const Vector3d& up) {
  Vector3d first = Vector3d::Constant(kNaN), farthest = Vector3d::Zero();
  for (Eigen::Index k = 0; k < body.position.cols(); ++k) {
    const Vector3d p = body.position.col(k);
    if (!p.allFinite()) continue;
    if (!first.allFinite()) first = p;
    const Vector3d d = (p - first) - (p - first).dot(up) * up;
    if (d.norm() > farthest.norm()) farthest = d;
  }
  return farthest;
}

Vector3d forward_of(const MocapBody& body, const MocapAxes& axes, const Vector3d& up,
                    std::vector<std::string>& notes) {
  if (axes.forward != MocapForward::automatic && axes.forward != MocapForward::motion) {
    const std::string name = mocap_forwards().name(axes.forward);
    const Vector3d forward = axis_of(name);
    if (std::abs(forward.dot(up)) > 0.5)
      throw InputError(fmt::format("forward: {} given while {} is up; allowed: a horizontal axis",
                                   name, mocap_ups().name(axes.up)));
    return forward;
  }

  constexpr double kLeast = 0.02;
  const Vector3d moved = displacement(body, up);
  if (moved.norm() < kLeast)
    throw InputError(
        fmt::format("body '{}' moves by {:.3g} m only, so forward can't be told from its motion; "
                    "allowed: forward +x, -x, +y, ...",
                    body.name, moved.norm()));

  const Vector3d along = moved.normalized();
  Vector3d nearest = Vector3d::Zero();
  for (int i = 0; i < 3; ++i) {
    for (const double sign : {1.0, -1.0}) {
      const Vector3d axis = sign * Vector3d::Unit(i);
      if (std::abs(axis.dot(up)) < 0.5 && axis.dot(along) > nearest.dot(along)) nearest = axis;
    }
  }

  const double off =
      std::acos(std::clamp(nearest.dot(along), -1.0, 1.0)) * 180.0 / std::numbers::pi;
  const bool snap = axes.forward == MocapForward::automatic && off < 15.0;
  notes.push_back(
      snap ? fmt::format("forward is taken as {} of the file: the body moves {:.1f} degrees off it",
                         axis_name(nearest), off)
           : fmt::format(
                 "forward is taken along the body's motion, {:.1f} degrees off {} of the file", off,
                 axis_name(nearest)));

  return snap ? nearest : along;
}

/// Mean pose over the frames seen within `rest` of the first one.
struct Pose0 {
  Vector3d position = Vector3d::Zero();
  Quaterniond rotation = Quaterniond::Identity();
};

Pose0 rest_pose(const MocapTake& take, const MocapBody& body, double rest) {
  Pose0 mean;
  Eigen::Vector4d sum = Eigen::Vector4d::Zero();
  int seen = 0;
  for (Eigen::Index k = 0; k < take.time.size() && take.time[k] <= take.time[0] + rest; ++k) {
    if (!body.position.col(k).allFinite()) continue;
    mean.position += body.position.col(k);
    const Eigen::Vector4d q = body.rotation.col(k);
    sum += q.dot(sum) < 0.0 ? Eigen::Vector4d(-q) : q;
    ++seen;
  }
  if (seen == 0)
    throw InputError(fmt::format("body '{}' is not seen in the first {} s, which are to be at rest",
                                 body.name, rest));
  mean.position /= seen;
  mean.rotation.coeffs() = sum.normalized();
  return mean;
}

double unwrapped(double angle, double before) {
  if (std::isnan(before)) return angle;
  return angle + 2.0 * std::numbers::pi * std::round((before - angle) / (2.0 * std::numbers::pi));
}

/// Rows x, y, z, pitch, roll, yaw of one body; x and y against `origin`.
Matrix planar_rows(const MocapTake& take, const MocapBody& body, const Matrix3d& R_WF,
                   const Pose0& pose) {
  Matrix rows = Matrix::Constant(6, take.time.size(), kNaN);
  double before = kNaN;
  for (Eigen::Index k = 0; k < take.time.size(); ++k) {
    if (!body.position.col(k).allFinite()) continue;
    const Vector3d moved = R_WF * (Vector3d(body.position.col(k)) - pose.position);
    const Quaterniond q(Eigen::Vector4d(body.rotation.col(k)));
    const Matrix3d R = R_WF * (q * pose.rotation.conjugate()).toRotationMatrix() * R_WF.transpose();
    before = unwrapped(std::atan2(-R(2, 0), R(0, 0)), before);
    rows.col(k) << moved.x(), moved.y(), moved.z() + (R_WF * pose.position).z(), before,
        std::atan2(-R(1, 2), R(1, 1)), std::asin(std::clamp(R(1, 0), -1.0, 1.0));
  }
  return rows;
}

const MocapBody& base_of(const MocapTake& take, const MocapAxes& axes,
                         std::vector<std::string>& notes) {
  std::vector<std::string> names;
  for (const MocapBody& body : take.bodies) {
    if (body.name == axes.body) return body;
    names.push_back(body.name);
  }
  if (!axes.body.empty()) {
    throw InputError(fmt::format("body: '{}' given{}; allowed: {}", axes.body,
                                 yaml::did_you_mean(axes.body, names), fmt::join(names, ", ")));
  }
  if (take.bodies.size() > 1)
    notes.push_back(fmt::format("of the bodies {} the first is taken as the robot's base",
                                fmt::join(names, ", ")));
  return take.bodies.front();
}

}  // namespace

const NameTable<MocapUp>& mocap_ups() {
  static const NameTable<MocapUp> table({{MocapUp::y, "y"}, {MocapUp::z, "z"}});
  return table;
}

const NameTable<MocapForward>& mocap_forwards() {
  static const NameTable<MocapForward> table({{MocapForward::automatic, "auto"},
                                              {MocapForward::motion, "motion"},
                                              {MocapForward::plus_x, "+x"},
                                              {MocapForward::minus_x, "-x"},
                                              {MocapForward::plus_y, "+y"},
                                              {MocapForward::minus_y, "-y"},
                                              {MocapForward::plus_z, "+z"},
                                              {MocapForward::minus_z, "-z"}});
  return table;
}

Stream mocap_stream(const MocapTake& take, const MocapAxes& axes, std::vector<std::string>& notes) {
  const Vector3d up = axes.up == MocapUp::y ? Vector3d::UnitY() : Vector3d::UnitZ();
  const MocapBody& base = base_of(take, axes, notes);
  const Vector3d forward = forward_of(base, axes, up, notes);
  Matrix3d R_WF;
  R_WF << forward.transpose(), up.cross(forward).transpose(), up.transpose();

  Stream stream;
  stream.name = kMocapStream;
  stream.rate_hz = take.rate_hz;
  stream.time = take.time;
  stream.values.resize(6 * std::ssize(take.bodies), take.time.size());
  const auto add = [&](const MocapBody& body, const std::string& prefix) {
    const auto row = std::ssize(stream.channels);
    stream.values.middleRows(row, 6) =
        planar_rows(take, body, R_WF, rest_pose(take, body, axes.rest));
    for (const char* name : {"x", "y", "z", "pitch", "roll", "yaw"}) {
      stream.channels.push_back(prefix + name);
      stream.units.emplace_back(
          stream.channels.size() % 6 >= 1 && stream.channels.size() % 6 <= 3 ? "m" : "rad");
    }
    const auto gaps = stream.values.row(row).array().isNaN().count();
    if (gaps > 0)
      notes.push_back(fmt::format("body '{}' has {} frames without data: gaps", body.name, gaps));
  };
  add(base, "");
  for (const MocapBody& body : take.bodies)
    if (&body != &base) add(body, body.name + "_");
  return stream;
}

}  // namespace jaculus::trajectory
