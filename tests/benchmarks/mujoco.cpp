// The plant beside MuJoCo at equal accuracy, on one core in one run: errors are each engine's own,
// against its own tight reference.
//
//   double pendulum, 1 s of free swing: smooth, the same equations in both. Runge-Kutta (4) with
//   fixed steps in MuJoCo.
//   leap, feed-forward and PD at 1 kHz: the plant against the testbed's robot (soft contact, pins
//   as constraints, left and right legs, distributed drag). MuJoCo's constraints soften with its
//   step, so that its error falls with the step to the first order or so; `from_plant` is the
//   distance of the two engines. The time to build its model, which a batch could share, is left
//   out and shown as `building_ms`. Rates are those of the processor's time.
// The argument is the decade of the plant's tolerance, or MuJoCo's step in microseconds.

#include <benchmark/benchmark.h>

#include <cmath>
#include <filesystem>

#include "jaculus/core/installation.h"
#include "jaculus/model/robot.h"
#include "jaculus/simulation/simulate.h"
#include "jaculus/testbed/trials.h"

#ifdef JACULUS_HAS_MUJOCO
#include <mujoco/mujoco.h>

#include <ctime>
#include <functional>
#include <memory>

#include "jaculus/testbed/playback.h"
#include "testbed/mjcf.h"
#include "testbed/robot_files.h"
#endif

namespace jaculus {
namespace {

constexpr double kSwing = 1.0;  // [s]

/// Two rods of 0.5 m and 1 kg, hanging in line from a pin; they start level.
model::PlanarModel double_pendulum() {
  model::PlanarModel model;
  model.base_free = {false, false, false};
  model.bodies.resize(3);
  model.bodies[0].name = "base";
  for (int b = 1; b <= 2; ++b) {
    model::PlanarBody& rod = model.bodies[b];
    rod.name = rod.joint = "joint_" + std::to_string(b);
    rod.parent = b - 1;
    rod.origin = b == 1 ? Vec2::Zero() : Vec2(0.0, -0.5);
    rod.mass = 1.0;
    rod.com = Vec2(0.0, -0.25);
    rod.inertia = 0.5 * 0.5 / 12.0;
    model.coordinates.push_back({rod.joint, true, {}});
  }
  model.joint_map = Matrix::Zero(3, 2);
  model.joint_map(1, 0) = model.joint_map(2, 1) = 1.0;
  model.joint_offset = Vector::Zero(3);
  return model;
}

simulation::Simulation swing(const simulation::Plant& plant, double tolerance) {
  simulation::Controller none;
  none.rate_hz = kInfinity;
  none.after_end = simulation::AfterEnd::relax;
  simulation::SimulationOptions options;
  options.duration = kSwing;
  options.sample_times = Vector::Constant(1, kSwing);
  options.relative_tolerance = tolerance;
  options.absolute_tolerance = 1e-2 * tolerance;
  return simulation::simulate(plant, none, {(Vector(2) << -1.57, 0.5).finished(), Vector::Zero(2)},
                              options);
}

void pendulum_plant(benchmark::State& state) {
  const simulation::Plant plant = simulation::nominal_plant(double_pendulum());
  simulation::Simulation s;
  for (auto _ : state) {
    s = swing(plant, std::pow(10.0, -static_cast<double>(state.range(0))));
    benchmark::DoNotOptimize(s.q.data());
  }
  state.counters["error_rad"] = (s.q - swing(plant, 1e-13).q).cwiseAbs().maxCoeff();
  state.counters["simulations"] =
      benchmark::Counter(1, benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(pendulum_plant)->Arg(4)->Arg(6)->Arg(8)->Arg(10)->Unit(benchmark::kMillisecond);

struct Leap {
  std::filesystem::path robot = model::find_robot("minitaur_tail", "");
  model::PlanarModel model = model::read_robot(robot).planar;
  simulation::Plant plant = simulation::nominal_plant(model);
  simulation::Controller controller;
  simulation::StartState start;

  Leap() {
    const std::filesystem::path file = source_folder() / "problems" / "leap_tail_plan.csv";
    controller.reference = simulation::plan_reference(trajectory::read_csv(file), model,
                                                      trajectory::Quantity::torque, 16.0, file);
    const auto motors = std::ssize(controller.reference.motors);
    controller.kp = Vector::Constant(motors, 3.3);
    controller.kd = Vector::Constant(motors, 0.08);
    start = simulation::reference_start(plant, controller.reference);
  }
};

simulation::Simulation leap_on_plant(const Leap& leap, double tolerance) {
  simulation::SimulationOptions options;
  options.duration = leap.controller.reference.duration;
  options.sample_times = Vector::LinSpaced(47, 0.0, options.duration);
  options.relative_tolerance = tolerance;
  options.absolute_tolerance = 1e-2 * tolerance;
  return simulation::simulate(leap.plant, leap.controller, leap.start, options);
}

/// x, z and pitch.
Matrix base_of(const simulation::Simulation& s) { return s.q.topRows(3); }

void leap_plant(benchmark::State& state) {
  const Leap leap;
  simulation::Simulation s;
  for (auto _ : state) {
    s = leap_on_plant(leap, std::pow(10.0, -static_cast<double>(state.range(0))));
    benchmark::DoNotOptimize(s.q.data());
  }
  if (s.status != simulation::SimulationStatus::done) state.SkipWithError(s.message.c_str());
  state.counters["error_m_or_rad"] =
      (base_of(s) - base_of(leap_on_plant(leap, 1e-11))).cwiseAbs().maxCoeff();
  state.counters["simulations"] =
      benchmark::Counter(1, benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(leap_plant)->Arg(4)->Arg(6)->Arg(8)->Unit(benchmark::kMillisecond);

#ifdef JACULUS_HAS_MUJOCO

/// The double pendulum after kSwing; angles of both joints.
class Swing {
 public:
  explicit Swing(double step) {
    const std::string rod =
        R"(<joint type="hinge" axis="0 1 0"/><inertial pos="0 0 -0.25" mass="1" diaginertia=")" +
        std::to_string(1.0 / 48.0) + " " + std::to_string(1.0 / 48.0) + R"( 0.001"/>)";
    const std::string text = R"(<mujoco><option integrator="RK4" timestep=")" +
                             std::to_string(step) + R"(" gravity="0 0 -9.81"/><worldbody><body>)" +
                             rod + R"(<body pos="0 0 -0.5">)" + rod +
                             "</body></body></worldbody></mujoco>";
    mjVFS files;
    mj_defaultVFS(&files);
    mj_makeEmptyFileVFS(&files, "swing.xml", count_of(text));
    std::copy(text.begin(), text.end(), static_cast<char*>(files.filedata[0]));
    char error[500] = "";
    model_.reset(mj_loadXML("swing.xml", &files, error, sizeof error));
    mj_deleteVFS(&files);
    if (model_ == nullptr) throw std::runtime_error(error);
    model_->opt.timestep = step;
    data_.reset(mj_makeData(model_.get()));
  }
  Vector run() {
    mj_resetData(model_.get(), data_.get());
    data_->qpos[0] = -1.57;
    data_->qpos[1] = 0.5;
    const int steps = static_cast<int>(std::lround(kSwing / model_->opt.timestep));
    for (int i = 0; i < steps; ++i) mj_step(model_.get(), data_.get());
    return Eigen::Map<const Vector>(data_->qpos, 2);
  }

 private:
  struct Delete {
    void operator()(mjModel* m) const { mj_deleteModel(m); }
    void operator()(mjData* d) const { mj_deleteData(d); }
  };
  std::unique_ptr<mjModel, Delete> model_;
  std::unique_ptr<mjData, Delete> data_;
};

void pendulum_mujoco(benchmark::State& state) {
  Swing swing(1e-6 * static_cast<double>(state.range(0)));
  Vector q;
  for (auto _ : state) benchmark::DoNotOptimize((q = swing.run()).data());
  state.counters["error_rad"] = (q - Swing(1e-5).run()).cwiseAbs().maxCoeff();
  state.counters["simulations"] =
      benchmark::Counter(1, benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(pendulum_mujoco)
    ->Arg(10000)
    ->Arg(5000)
    ->Arg(2000)
    ->Arg(1000)
    ->Arg(500)
    ->Unit(benchmark::kMillisecond);

testbed::Commands commands_of(const Leap& leap) {
  const simulation::Reference& r = leap.controller.reference;
  testbed::Commands commands;
  commands.motors = r.motors;
  commands.time = r.time;
  commands.position = r.position;
  commands.velocity = r.velocity;
  commands.feedforward = r.feedforward;
  commands.linear = r.linear;
  for (int m = 0; m < count_of(r.motors); ++m) {
    commands.kp[r.motors[m]] = leap.controller.kp[m];
    commands.kd[r.motors[m]] = leap.controller.kd[m];
  }
  return commands;
}

testbed::Recording leap_on_mujoco(const Leap& leap, const testbed::RobotFiles& files, double step,
                                  bool runge_kutta, double duration) {
  testbed::PlayOptions options;
  options.duration = duration;
  options.level = true;
  for (int m = 0; m < count_of(leap.controller.reference.motors); ++m)
    options.start[leap.controller.reference.motors[m]] = leap.controller.reference.position(m, 0);
  options.start["pitch"] = leap.start.q[leap.model.coordinate_index("pitch")];
  testbed::Numerics numerics;
  numerics.step = step;
  numerics.runge_kutta = runge_kutta;
  if (!runge_kutta) numerics.stiffness_steps = 2.0;  // below, semi-implicit Euler rings
  return testbed::play(files, {}, commands_of(leap), options, numerics);
}

/// x, z, pitch from rest at the plant's samples.
Matrix base_of(const testbed::Recording& r, double duration) {
  const Vector times = Vector::LinSpaced(47, 0.0, duration);
  Matrix base(3, times.size());
  for (Eigen::Index i = 0; i < 3; ++i)
    base.row(i) =
        testbed::sample(r.time, r.base.row(i).transpose(), r.base_rate.row(i).transpose(), times)
            .transpose();
  for (const int i : {0, 2}) base.row(i).array() -= base(i, 0);
  return base;
}

/// Time of the processor, as the other rows' CPU column [s].
double seconds_of(const std::function<void()>& work) {
  const std::clock_t start = std::clock();
  work();
  return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
}

void leap_mujoco(benchmark::State& state) {
  const Leap leap;
  const testbed::RobotFiles files = testbed::read_robot_files(leap.robot);
  const double duration = leap.controller.reference.duration,
               step = 1e-6 * static_cast<double>(state.range(0));
  const bool runge_kutta = state.range(1) != 0;
  static const Matrix tight = base_of(leap_on_mujoco(leap, files, 5e-6, true, duration), duration);
  testbed::Recording r;
  double building = 0.0;
  for (auto _ : state) {
    building = seconds_of([&] { (void)leap_on_mujoco(leap, files, step, runge_kutta, 1e-9); });
    const double whole =
        seconds_of([&] { r = leap_on_mujoco(leap, files, step, runge_kutta, duration); });
    state.SetIterationTime(std::max(1e-9, whole - building));
  }
  if (r.diverged) state.SkipWithError("MuJoCo lost the robot");
  const Matrix base = base_of(r, duration);
  Matrix plant = base_of(leap_on_plant(leap, 1e-8));
  for (const int i : {0, 2}) plant.row(i).array() -= plant(i, 0);
  state.counters["error_m_or_rad"] = (base - tight).cwiseAbs().maxCoeff();
  state.counters["from_plant"] = (base - plant).cwiseAbs().maxCoeff();
  state.counters["building_ms"] = 1e3 * building;
  state.counters["simulations"] =
      benchmark::Counter(1, benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(leap_mujoco)
    ->ArgNames({"us", "runge_kutta"})
    ->ArgsProduct({{1000, 500, 200, 100, 50, 20}, {1}})
    ->ArgsProduct({{1000, 200, 50}, {0}})
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

#endif

}  // namespace
}  // namespace jaculus
