// The help on dataset.yaml, and on the part of it that experiments have as well. A test holds it to
// what the readers take (dataset_yaml.cpp).

#include "jaculus/trajectory/dataset.h"
#include "trajectory/dataset_yaml.h"

namespace jaculus::trajectory {
namespace {

const char* const kSetup =
    R"(  experiment      (required) leap (after a plan, from rest), self_righting (falling),
                  tail_bench (the base and all that is not commanded held) or pendulum (any
                  robot on a fixed base)
  robot           (required) name of a robot that comes with jaculus, or a folder relative to
                  this file
  override        path of a model value: what this robot has in its place, `friction: 0.7`,
                  `motors.tail: {kind: ideal, torque_limit: 9 N m}`; `jaculus check ROBOT` lists
                  them
  plan            plan.csv that was commanded; or else
  input           {QUANTITY: {JOINT: VALUE or [[TIME, VALUE], ...]}}, QUANTITY torque, duty or
                  voltage, each value held up to the next, nothing before the first; at the
                  joint, behind the gear; or {quantity, file: input.csv}, of the controller's
                  quantity where none is stated
  initial         coordinate or joint: its value at the start, where the plan doesn't say [rad or
                  m]
  stops           joint: an end of its range that acts on it; ranges of the robot's files don't
    range           [lower, upper] [rad]
    restitution     share of the speed that comes back [-]; 0 where absent
  controller      (required) what turned commands into torques
    kind            feedforward_pd (the plan's command and gains on its positions and rates),
                    torque or voltage (a script), or measured (a logged quantity drove the
                    joints)
    quantity        what feedforward_pd commands: torque, duty or voltage; torque where absent
    rate_hz         of its loop [Hz]; 1000 where absent
    kp, kd          one for all joints, {JOINT: VALUE}, [lower, upper] or unknown, in `quantity`
                    for a rad and for a rad/s; unknown where absent
    gains_at        motor or joint: of which angle the gains are, and whose torque; motor where
                    absent
    bus_voltage     [V]; the robot's where absent
    input           of measured: torque, voltage, duty or current, the log's channels of that
                    name
    after_end       hold, relax, repeat or {pose: {JOINT: ANGLE, "*": ANGLE}, within: TIME},
                    after the plan's end; hold where absent, after a script repeat
)";

const char* const kBeforeSetup =
    R"(dataset.yaml: trials of a robot, a folder each beside it. Plain numbers are SI (rad);
"16 V", "15 deg" carry their unit. Unknown keys are errors; what is left open is said in a note.

  format          jaculus-dataset/1 (required)
)";

const char* const kAfterSetup =
    R"(  streams         (required) name: one clock's log, the same file in every trial
    file            CSV, columns named with their units: time [s], x [m], front_a_velocity
                    [rad/s]
    rate_hz         its nominal rate [Hz]; told by the stamps where absent
  trials          (required) list of the trials' folders
  provenance      where the logs come from
)";

}  // namespace

std::string explain_setup() { return kSetup; }

std::string explain_dataset() { return kBeforeSetup + explain_setup() + kAfterSetup; }

}  // namespace jaculus::trajectory
