#pragma once
// The families of effects; catalogue.cpp lists them.

#include "effects/groups.h"

namespace jaculus::effects {

// transmission.cpp
Effect compliance(const Group& group);
Effect backlash(const Group& group);
Effect coulomb_friction(const Group& group);
Effect viscous_friction(const Group& group);
Effect stribeck_friction(const Group& group);
Effect load_friction(const Group& group);
Effect stop_restitution();

// actuation.cpp
Effect actuation_delay();
Effect late_start();
Effect controller_gains();
Effect torque_constant();
Effect voltage_limit();
Effect current_limit();
Effect battery_sag();
Effect winding_heating();

// aerodynamics.cpp
Effect drag_coefficient();
Effect drag_without_translation();
Effect wind();

// inertia.cpp
Effect rotor_inertia(const Group& group);
Effect link_inertia(const Group& group);
Effect link_mass(const Group& group);
Effect payload();
Effect com_shift();
Effect body_inertia();

// contact.cpp
Effect foot_friction();
Effect ground_compliance();
Effect foot_radius();

// sensing.cpp
Effect joint_offset(const Group& group);
Effect sensor_latency();
Effect mocap_scale();
Effect joint_scale(const Group& group);

}  // namespace jaculus::effects
