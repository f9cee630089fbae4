// The help on experiment files. A test holds it to what the reader takes (read.cpp).

#include "jaculus/simulation/experiment.h"
#include "trajectory/dataset_yaml.h"

namespace jaculus::simulation {
namespace {

const char* const kBeforeSetup =
    R"(An experiment: trials on a plant, as on a robot. Plain numbers are SI (rad); "16 V",
"15 deg" carry their unit. Unknown keys are errors.

  format          jaculus-experiment/1 (required)
  name            of its dataset (required)
)";

const char* const kAfterSetup =
    R"(  duration        of the recording from the command's start [s]; to 0.1 s after the
                  command's end where absent
  lead            recorded before it, at rest [s]; 0 where absent
  trials          how many; 1 where absent
  seed            of all that is random; 1 where absent
  scatter         coordinate: standard deviation of its start, or [from, to] [rad or m]
  streams         name: sensors on one clock; mocap at 240 Hz and joints at 1 kHz where absent
    rate_hz         [Hz]
    channels        coordinates (x, pitch), joints with a motor (front_a; "*": all), each also
                    with _velocity, motors with _torque, _current, _voltage, _duty; bus_voltage,
                    imu_pitch
    noise           channel ("*_torque": all): standard deviation, in the channel's unit; that of
                    usual sensors where absent
    dropout         share of the samples that are lost [-]
    dropout_length  samples lost in a row, in the mean
    time_shift      of its clock, each trial's: standard deviation or [from, to] [s]
  uncertainties   path of a model value: standard deviation, also in %, or [from, to]; for
                  `simulate --perturb`
  touchdown_height  of the base, at which the landing pitch is taken [m]; none is where absent
)";

}  // namespace

std::string explain_experiment() {
  return kBeforeSetup + trajectory::explain_setup() + kAfterSetup;
}

}  // namespace jaculus::simulation
