#pragma once
// Experiments on a plant, as one would do them on a robot: a set-up (robot, commands, controller),
// sensors, trials.
//
//   format: jaculus-experiment/1
//   name: leap_tail
//   experiment: leap                 # leap | self_righting | tail_bench (base and all that is not
//                                    # commanded held) | pendulum
//   robot: minitaur_tail
//   override: {friction: 0.7}        # model values that this robot has
//   plan: plan.csv                   # or input: {voltage: {tail: [[0, 16 V], [0.2, 0 V]]}}, or
//                                    # input: {quantity, file}
//   initial: {z: 1 m}                # where the plan does not say
//   stops: {tail: {range: [-90 deg, 90 deg], restitution: 0}}
//   controller: {kind: feedforward_pd, quantity: torque, rate_hz: 1000, kp: {...}, kd: {...}}
//     # as in dataset.yaml; gains known, of the motors, or with gains_at: joint of the joints
//     after_end: hold                # in it, after the plan: hold | relax | repeat |
//                                    # {pose: {"*": 60 deg, tail: 0}, within: 50 ms}
//   duration: 0.3 s                  # of the recording from the command's start; default: to 0.1 s
//                                    # after the plan's end
//   lead: 0.3 s                      # recorded before it, at rest
//   trials: 6
//   seed: 1
//   scatter: {pitch: 0.3 deg}        # of the initial coordinates: deviation or [from, to]
//   streams:
//     mocap:  {rate_hz: 240, channels: [x, z, pitch], noise: {x: 0.3 mm}, dropout: 0.01,
//             dropout_length: 3, time_shift: 2 ms}
//     joints: {rate_hz: 1000, channels: ["*", "*_velocity", bus_voltage], noise: {"*": 1e-3 rad}}
//   uncertainties: {friction: [0.6, 1], bodies.base.mass: 5 %}     # of model values, for replays
//   touchdown_height: 0.2078 m       # of the base, at which the landing pitch is taken
//
// "*" stands for every joint with a motor. mocap's x and pitch count from rest. Noise not stated is
// kDefaultNoise.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "jaculus/core/tasks.h"
#include "jaculus/model/robot.h"
#include "jaculus/simulation/simulate.h"
#include "jaculus/trajectory/leap_speed.h"

namespace jaculus::simulation {

/// A random quantity: normal about 0 (or about the nominal value) with `deviation`, or uniform in
/// `range`.
struct Spread {
  double deviation = 0.0;
  std::optional<Bounds> range;
  bool relative = false;  ///< deviation is a share of the nominal value
};

struct SensorStream {
  std::string name;
  double rate_hz = 240.0;
  std::vector<std::string> channels;    ///< joints in place of "*"
  std::map<std::string, double> noise;  ///< standard deviation by channel, SI
  double dropout = 0.0;                 ///< share of the samples that are lost [-]
  double dropout_length = 1.0;          ///< mean length of a gap [samples]
  Spread time_shift;                    ///< of a trial: stamps are late by it [s]
};

struct Experiment {
  std::string name;
  /// robot, commands, controller; no trials. setup.folder: what its paths are relative to
  trajectory::Dataset setup;
  std::filesystem::path plan_file;  ///< of setup.plan, for messages
  double lead = 0.0;
  double duration = 0.0;  ///< from the command's start [s]
  int trials = 1;
  int seed = 1;
  std::map<std::string, Spread> scatter;  ///< by coordinate
  std::vector<SensorStream> streams;
  std::map<std::string, Spread> uncertainties;  ///< by path of a model value
  std::optional<double> touchdown_height;       ///< [m]
};

/// Reads and checks an experiment, its robot too; what it names lies relative to its file.
/// InputError with the place.
Experiment read_experiment(const std::filesystem::path& file);
Experiment read_experiment(const yaml::Node& node);
/// Every key of an experiment file with its meaning, unit and default.
std::string explain_experiment();

/// The experiment that a plan is for: feed-forward torque and joint PD at 1 kHz, mocap and encoders
/// with the usual noise. `controller` in YAML in place of that, empty: none.
Experiment plan_experiment(const std::filesystem::path& plan, const std::string& robot,
                           const std::string& controller);

/// The robot of a dataset (or an experiment's set-up) with its overrides. InputError where it is
/// unknown.
model::Robot overridden_robot(const trajectory::Dataset& dataset);
/// The same as the experiment leaves it: in a tail bench the base and every coordinate without a
/// command are held where `initial` says, else at 0 (z: 1 m). InputError where the robot is
/// unknown.
model::Robot dataset_robot(const trajectory::Dataset& dataset);
/// Gains that are stated at the joint become the motor's, whose angle is gear times the joint's and
/// whose torque is the joint's over gear: they are divided by gear^2.
void put_gains_at_motors(const model::PlanarModel& model, trajectory::StatedController& controller);
/// When its commands end [s]: of its plan, else of its script. Misuse: neither.
double command_duration(const trajectory::Dataset& dataset);
/// nominal_plant() with the dataset's stops and bus voltage. InputError where the robot has no such
/// joint.
Plant dataset_plant(const trajectory::Dataset& dataset, const model::PlanarModel& model);
/// InputError where a joint that turns is logged in metres, or one that slides in radians.
void require_units(const trajectory::Dataset& dataset, const model::PlanarModel& model);
/// stated_controller() with known gains and the end that is stated. InputError where a gain is a
/// range or unknown.
Controller experiment_controller(const Experiment& experiment, const model::PlanarModel& model);

/// One trial: what the sensors saw, and what was so.
struct TrialRun {
  trajectory::Trial trial;
  Simulation truth;  ///< on a grid of 0.5 ms from the command's start
  StartState start;
};
TrialRun run_trial(const Experiment& experiment, const Plant& plant, const Controller& controller,
                   int index, std::uint64_t seed);

/// State of a leap where it counts. Speeds are the base's.
struct LeapState {
  double time = kNaN;   ///< [s]
  double speed = kNaN;  ///< forward [m/s]
  double pitch = kNaN;  ///< [rad]
  double landing_pitch =
      /// pitch when the base, in free flight from here, is back at the touchdown height [rad]
      kNaN;
};

/// A trial's figures, by the authors' recipe and as they are.
struct LeapFigures {
  double duration = kNaN;  ///< T of the plan [s]
  /// from the mocap stream; nothing where it has none or no start
  std::optional<trajectory::LeapSpeed> recipe;
  /// the same on the true x at the same instants: the recipe's own bias
  std::optional<trajectory::LeapSpeed> recipe_exact;
  LeapState plan_end;
  /// when the last foot left the floor; nothing where one stays
  std::optional<LeapState> lift_off;
};
LeapFigures leap_figures(const Experiment& experiment, const model::PlanarModel& model,
                         const TrialRun& run);

/// How near a replay comes to its limits, over the time of the commands. A share of 1 is the limit.
struct Margins {
  SimulationStatus status = SimulationStatus::done;
  /// largest |fx|/(mu fz) of a foot that carries more than 1 N; 1 where it slipped
  double friction_share = kNaN;
  double slip_time = 0.0;       ///< feet slid for that long, summed [s]
  double voltage_share = kNaN;  ///< largest |V| over the bus voltage
  double torque_share = kNaN;   ///< largest motor torque over its limit
  double current_share = kNaN;  ///< largest current over the driver's limit
  double landing_pitch = kNaN;  ///< [rad]
  double speed = kNaN;          ///< forward, at the plan's end [m/s]
};
struct Replay {
  std::map<std::string, double> values;  ///< of the uncertain quantities, as drawn
  Margins margins;
};

/// Replays under `experiment.uncertainties`: the first replay is nominal, then `count` drawn ones.
/// Sensors are left out. `apply` edits each plant (effects). InputError where an uncertainty names
/// no model value, or a draw can't be played. `tasks`: where they run, one a task; those before the
/// first that was interrupted come back.
std::vector<Replay> replays(const Experiment& experiment, int count, std::uint64_t seed,
                            const std::function<void(Plant&)>& apply = {},
                            const TaskOptions& tasks = {.workers = 1, .isolate = false});

}  // namespace jaculus::simulation
