#pragma once
// Whether formulas have the units that they must have, by what they do when the units change.
//
// A formula f of quantities x_i of dimensions d_i is of dimension D where for every base unit u and
// factor c (Buckingham 1914, "On physically similar systems")
//     f(x_i c^d_i(u)) = c^D(u) f(x_i).
// A formula that adds a length to a time has no such D; so has one that takes the sine of a length,
// or has a number in it that is a rate or a torque in disguise. It is tried at random positive and
// negative x_i with the metre, the kilogram, the second and the ampere; angles count as pure
// numbers, so that sin(q) has a unit. No tree of the expression is needed, and branches are seen
// where some x_i takes them.

#include "effects/user/program.h"

namespace jaculus::effects {

/// InputError at the first formula whose unit is another one than its key asks for, or none.
void check_units(Program& program);

/// InputError where an action does something at nominal parameters (and a torque_scale is not 1).
void check_nominal(const EffectSpec& spec, Program& program);

}  // namespace jaculus::effects
