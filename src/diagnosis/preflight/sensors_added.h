#pragma once
// The planned experiment with one more kind of sensor that its robot could have.
//
// Joint positions, rates, torques, currents, voltages, duties under commanded torques, bus voltage,
// motion capture and an IMU's pitch and rate: those that the experiment does not record. What a
// script commands is no measurement. Noise and rates: settings of the group `Next experiment`.

#include "diagnosis/preflight/experiments.h"

namespace jaculus::diagnosis {

std::vector<NamedExperiment> with_one_more_sensor(const simulation::Experiment& planned,
                                                  const model::PlanarModel& model,
                                                  const Settings& settings);

}  // namespace jaculus::diagnosis
