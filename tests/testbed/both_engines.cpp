#include "testbed/both_engines.h"

#include <gtest/gtest.h>

#include <cmath>

#include "jaculus/model/robot.h"
#include "jaculus/simulation/simulate.h"
#include "jaculus/testbed/effects.h"

namespace jaculus::test {
namespace {

using testbed::Changes;

testbed::TrialSpec exact_spec(double after) {
  testbed::TrialSpec spec;
  spec.exact = true;
  spec.trials = 1;
  spec.after = after;
  return spec;
}

}  // namespace

Motion on_testbed(const trajectory::Dataset& asked, const Changes& changes, double after) {
  const trajectory::Dataset run = testbed::run_trials(asked, changes, exact_spec(after));
  const trajectory::Stream& mocap = *run.trials.front().stream("mocap");
  return {mocap.time, mocap.values};
}

Motion on_plant(const trajectory::Dataset& asked, const effects::Effect* effect,
                const Vector& theta, const Vector& time) {
  const model::PlanarModel model =
      model::read_robot(model::find_robot(asked.robot, kModels)).planar;
  simulation::Plant plant = simulation::nominal_plant(model);
  for (const auto& [joint, stop] : asked.stops)
    plant.stops.push_back({joint, stop.range, stop.restitution});
  if (effect != nullptr) effect->apply(theta, plant);
  simulation::Controller controller = simulation::stated_controller(asked, model, {});
  controller.after_end = asked.controller.after_end.value_or(trajectory::AfterEnd::hold);
  simulation::StartState start = simulation::reference_start(plant, controller.reference);
  if (const auto z = asked.initial.find("z"); z != asked.initial.end())
    start.q[model.coordinate_index("z")] = z->second;
  simulation::SimulationOptions options;
  options.duration = time[time.size() - 1];
  options.sample_times = time;
  options.relative_tolerance = 1e-8;
  options.absolute_tolerance = 1e-10;
  const simulation::Simulation run = simulation::simulate(plant, controller, start, options);
  EXPECT_EQ(run.status, simulation::SimulationStatus::done) << run.message;
  Motion motion{time, Matrix(3, time.size())};
  int row = 0;
  for (const char* name : {"x", "z", "pitch"})
    motion.base.row(row++) = run.q.row(model.coordinate_index(name));
  for (const int i : {0, 2}) motion.base.row(i).array() -= motion.base(i, 0);
  return motion;
}

void expect_agreement(const trajectory::Dataset& asked, double after) {
  const Motion bench = on_testbed(asked, {}, after);
  const Motion plant = on_plant(asked, nullptr, {}, bench.time);
  const Matrix difference = bench.base - plant.base;
  EXPECT_LT(difference.row(0).cwiseAbs().maxCoeff(), kHalfPosition) << "x";
  EXPECT_LT(difference.row(1).cwiseAbs().maxCoeff(), kHalfPosition) << "z";
  EXPECT_LT(difference.row(2).cwiseAbs().maxCoeff(), kHalfAngle) << "pitch";
}

void expect_the_same_gap(const trajectory::Dataset& asked, const std::string& name, double value,
                         double after) {
  const auto known = testbed::bench_effects(model::find_robot(asked.robot, kModels));
  const testbed::BenchEffect* bench_effect = testbed::find_bench_effect(known, name);
  const effects::Effect* effect = effects::find_effect(name);
  ASSERT_NE(bench_effect, nullptr);
  ASSERT_NE(effect, nullptr);
  Vector theta = effect->nominal();
  std::vector<double> values;
  for (const testbed::BenchParameter& p : bench_effect->parameters) values.push_back(p.usual);
  values[0] = value;
  for (int i = 0; i < count_of(values); ++i) theta[i] = values[i];
  Changes changes;
  bench_effect->apply(values, changes);
  const Motion still = on_testbed(asked, {}, after), bench = on_testbed(asked, changes, after);
  const Motion plant = on_plant(asked, effect, theta, bench.time);
  const Vector floor = Eigen::Vector3d(2.0 * kHalfPosition, 2.0 * kHalfPosition, 2.0 * kHalfAngle);
  const auto size = [&](const Matrix& m) {
    return std::sqrt((floor.cwiseInverse().asDiagonal() * m).squaredNorm() /
                     static_cast<double>(m.size()));
  };
  const double gap = size(bench.base - still.base), left = size(bench.base - plant.base);
  EXPECT_GT(gap, 1.0) << "the effect is too small to tell anything";
  EXPECT_LT(left, 0.15 * gap + 0.2) << "gap " << gap;
}

}  // namespace jaculus::test
