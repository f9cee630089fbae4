#pragma once
// Friction between a robot's geom and the floor, as MuJoCo's contacts have it.
//
// MuJoCo gives a contact the larger of both geoms' coefficients (of each kind: sliding is the one
// meant here), that of the geom of higher `priority` where these differ, and that of <pair> where
// the file states the two as one. Source: MuJoCo's documentation, "Contact parameters".

#ifdef JACULUS_HAS_MUJOCO
#include <mujoco/mujoco.h>

#include "jaculus/model/mjcf.h"

namespace jaculus::model {

/// Of a geom on the first plane or height field of the world that it collides with; its own where
/// the file has no floor. NaN where nothing but MuJoCo's default of 1 stands in the file, which
/// tells nothing of the robot, and where the contact is one without friction (condim 1). The link
/// is left open.
Surface surface_on_floor(const mjModel& model, int geom);

}  // namespace jaculus::model
#endif
