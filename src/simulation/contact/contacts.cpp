#include "simulation/contact/contacts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "jaculus/core/error.h"

namespace jaculus::simulation::detail {

namespace {

Unilateral point_contact(const Plant& plant, const model::PlanarPoint& point) {
  Unilateral u;
  u.name = point.name;
  u.body = point.body;
  u.position = point.position;
  u.count = point.count;
  u.mu = plant.ground.friction;
  return u;
}

/// One for each end of the range that is finite.
void add_stop(const model::PlanarModel& model, const JointStop& stop,
              std::vector<Unilateral>& out) {
  const int body = model.body_of_joint(stop.joint);
  if (body < 0) throw InputError(fmt::format("stop: the robot has no joint '{}'", stop.joint));

  for (const double side : {1.0, -1.0}) {
    const double bound = side > 0.0 ? stop.range.lower : stop.range.upper;
    if (std::isinf(bound)) continue;
    Unilateral u;
    u.name = stop.joint;
    u.body = body;
    u.side = side;
    u.bound = bound;
    u.restitution = stop.restitution;
    out.push_back(u);
  }
}

}  // namespace

std::vector<Unilateral> unilaterals_of(const Plant& plant) {
  const model::PlanarModel& model = plant.model;
  std::vector<Unilateral> all;

  for (int f = 0; f < count_of(model.feet); ++f) {
    all.push_back(point_contact(plant, model.feet[f]));
    all.back().radius = plant.ground.foot_radius;
    all.back().foot = f;
  }

  for (const std::string& name : plant.ground_points) {
    const auto found = std::find_if(model.points.begin(), model.points.end(),
                                    [&](const auto& point) { return point.name == name; });
    if (found == model.points.end())
      throw InputError(fmt::format("ground point: the robot has no point '{}'", name));
    all.push_back(point_contact(plant, *found));
  }

  for (const JointStop& stop : plant.stops) add_stop(model, stop, all);
  return all;
}

void set_contact(const Mechanism& mechanism, const Unilateral& u, double floor, const double* q,
                 const double* v, ContactState& out) {
  if (u.stop()) {
    JointState joint;
    mechanism.joint(u.body, q, v, joint);
    out.gap = u.side * (joint.value - u.bound);
    out.normal_rate = u.side * joint.rate;
    out.normal_bias = u.side * joint.bias;
    out.tangential_rate = out.tangential_bias = 0.0;
    for (int k = 0; k < mechanism.n; ++k) {
      out.normal[k] = u.side * joint.row[k];
      out.tangential[k] = 0.0;
    }
    return;
  }

  PointState point;
  mechanism.point(u.body, u.position, point);
  out.gap = point.pz - u.radius - floor;
  out.normal_rate = point.vz;
  out.tangential_rate = point.vx;
  out.normal_bias = point.az;
  out.tangential_bias = point.ax;
  out.normal = point.jz;
  out.tangential = point.jx;
  if (u.radius == 0.0) return;

  // it rolls
  const Frame& f = mechanism.frame(u.body);
  out.tangential_rate -= u.radius * f.omega;
  out.tangential_bias -= u.radius * f.alpha;
  for (int k = 0; k < mechanism.n; ++k) out.tangential[k] -= u.radius * f.w[k];
}

}  // namespace jaculus::simulation::detail
