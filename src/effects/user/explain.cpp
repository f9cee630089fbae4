// The help on effects of a user's own. A test holds it to what the reader takes (read.cpp).

#include "jaculus/effects/user_effect.h"

namespace jaculus::effects {

std::string explain_effect() {
  return R"(An effect of your own, for `simulate --effects`, `diagnose --effects`; `check` tries it.
Plain numbers are SI (rad); "0.1 N m", "15 deg" carry their unit. Unknown keys are errors.

  format          jaculus-effect/1 (required)
  name            in lower case, of no other effect (required)
  caption         a line for users (required)
  at              where it acts, one of these (required)
    joint           name
    joints          [name, ...]
    group           tail, legs or other
    body            name, with point: [x, z] in its frame
    point           of the robot, by name
    part            ground, battery or commands
    sensor          channel of a log
  component       where shares of a gap are counted; what `at` implies where absent
  experiment      in which `check` tries it, from this file's folder
  parameters      name: the first switches the effect on (required)
    unit            of SI, or - (required)
    nominal         where the effect is nothing, or its usual value (required)
    bounds          [lower, upper] (required)
    scale           standard deviation of the prior (required)
    probe           a value at which it shows; nominal and a scale where absent
  constants       name: a number in formulas that has a unit
    unit            of SI, or -
    value           number
  states          name: of the effect's own, integrated with the motion
    unit            of SI, or -
    initial         formula of parameters
    derivative      formula
    scale           its typical size; 1 where absent
  values          name: formulas for short, in order
    unit            of SI, or -
    value           formula
  torque          at a joint that turns [N m], of each of a pair
  force           at a joint that slides [N]; {x, z} in the world, on a body or point [N]
  moment          on a body or point, about y [N m]
  torque_scale    factor on the torque of a joint's motor
  bus_drop        what the battery's voltage lacks, at a joint or the battery [V]
  friction_scale  factor on the ground's friction
  delay           of the commands, of parameters alone [s]
  reading         what a sensor's log has, of its value and t

Formulas read parameters, constants, states, values; of the joint q, qd, tau, tau_limit, load,
current, voltage; of the body x, z, vx, vz, angle, omega; t and bus; of others elbow.q, tip.x.
Functions: sin cos tan asin acos atan atan2 sinh cosh tanh exp ln sqrt abs sign floor mod hypot
min max; a ? b : c; pi.
)";
}

}  // namespace jaculus::effects
