#pragma once
// Small plants for closed forms.

#include <string>
#include <vector>

#include "dynamics/planar_builder.h"
#include "jaculus/dynamics/rigid_body.h"
#include "jaculus/simulation/simulate.h"

namespace jaculus::test {

using test_support::link;
using test_support::with_coordinates;

/// A controller that commands nothing.
inline simulation::Controller no_controller() {
  simulation::Controller controller;
  controller.rate_hz = kInfinity;
  controller.after_end = simulation::AfterEnd::relax;
  return controller;
}

/// One rigid body with feet at given places in its frame; its origin is the centre of mass.
inline model::PlanarModel body_with_feet(double mass, double inertia,
                                         const std::vector<Vec2>& feet) {
  model::PlanarModel model;
  model.bodies = {link("body", -1, Vec2::Zero(), mass, Vec2::Zero(), inertia)};
  model.bodies[0].joint = "";
  model = with_coordinates(model, {});
  for (std::size_t k = 0; k < feet.size(); ++k)
    model.feet.push_back({"foot_" + std::to_string(k), 0, feet[k], 1});
  return model;
}

/// A mass on a vertical rail, the joint "rail" its height.
inline model::PlanarModel mass_on_rail(double mass) {
  model::PlanarModel model = test_support::on_fixed_base(
      {link("rail", 0, Vec2::Zero(), mass, Vec2::Zero(), 0.0)}, {"rail"});
  model.bodies[1].kind = model::JointKind::prismatic;
  model.bodies[1].axis = Vec2(0.0, 1.0);
  return model;
}

inline simulation::Plant plant_of(const model::PlanarModel& model, double friction) {
  simulation::Plant plant = simulation::nominal_plant(model);
  plant.ground.friction = friction;
  return plant;
}

inline simulation::SimulationOptions options_for(double duration, int samples = 101) {
  simulation::SimulationOptions options;
  options.duration = duration;
  options.sample_times = Vector::LinSpaced(samples, 0.0, duration);
  options.relative_tolerance = 1e-8;
  options.absolute_tolerance = 1e-10;
  return options;
}

inline simulation::StartState start_at(std::vector<double> q, std::vector<double> v) {
  simulation::StartState start;
  start.q = Eigen::Map<Vector>(q.data(), q.size());
  start.v = Eigen::Map<Vector>(v.data(), v.size());
  return start;
}

/// The time of the first event of a kind at `what`; NaN where there is none.
inline double event_time(const simulation::Simulation& s, simulation::EventKind kind,
                         const std::string& what) {
  for (const simulation::Event& event : s.events)
    if (event.kind == kind && event.what == what) return event.time;
  return kNaN;
}

/// Kinetic and potential energy of the robot at a state [J].
inline double energy(const model::PlanarModel& model, const Vector& q, const Vector& v) {
  const dynamics::AbsoluteTree tree(model);
  dynamics::Motion motion(tree);
  EXPECT_TRUE(dynamics::set_configuration(tree, q, motion));
  dynamics::set_rates(tree, v, motion);
  return dynamics::kinetic_energy(tree, motion, v) + dynamics::potential_energy(tree, motion);
}

}  // namespace jaculus::test
