#pragma once
namespace jaculus::diagnosis {
struct Dev {
  double structural_zero = 1e-4, structural_angle = 0.01, size_within = 0.05;
  int size_steps = 8;
  double chirp_lowest = 0.5, chirp_highest = 5.0, stronger_command = 1.5, lower_voltage = 0.8,
         payload = 0.2, new_torque_noise = 0.02, new_current_noise = 0.2, new_voltage_noise = 0.05,
         new_bus_noise = 0.02, new_imu_noise = 5e-3, new_imu_rate_noise = 0.02;
};
inline constexpr Dev kDev;
}  // namespace jaculus::diagnosis
