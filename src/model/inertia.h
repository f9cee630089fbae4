#pragma once
// Masses and inertias of links as files have them, made such that a body can have them.

#include "jaculus/model/urdf.h"
#include "model/assumptions.h"

namespace jaculus::model {

/// A body's inertia is that of a mass distribution: positive definite, and no principal moment
/// above the sum of the others. Where it isn't,
///   a mass of zero     is a link without mass and inertia,
///   moments of zero    are those of a solid sphere of water of that mass: I = 2/5 m r^2,
///                      r = (3 m / (4 pi 1000 kg/m^3))^(1/3),
///   other impossible   ones are used as they are: the plane takes one moment of them.
/// A negative mass is InputError.
void settle_inertia(SpatialLink& link, Assumptions& assumptions);

/// Sums of mass times distance squared along the axes of a frame turned by phi about +y, from the
/// inertia of the same mass: of x, (I_yy + I_zz - I_xx)/2, of x z, -I_xz [kg m^2].
Vec2 squares_along(double phi, const Mat3& inertia);

/// The sphere's moment [kg m^2] of a mass [kg].
double sphere_moment(double mass);

}  // namespace jaculus::model
