#pragma once
// Initial guesses, all inside the bounds and reproducible from the problem file and a seed.
//
//   middle   the middle of every variable's bounds (Norby et al. 2021)
//   static   one posture at every node, feet on the ground, at rest
//   line     straight lines between stated poses, rates to match
// and for static, line and random: feet in stance stay where they stand, torques come nearest to
// the accelerations of the motion
//   random   the stated poses (or a standing start that gathers the rates asked for at the end)
//            plus a smooth random motion, q(s) = q_0(s) + A s (c_0 s^2 + sum_k c_k sin(k pi s)/k),
//            k = 1..3, c uniform in [-1, 1], A a fraction of the bounds' width, and durations times
//            a random factor
//   file     an earlier plan, matched phase by phase and by names, so that grid and robot may
//            differ

#include <cstdint>

#include "jaculus/trajectory/trajectory.h"
#include "jaculus/transcription/nonlinear_program.h"

namespace jaculus::transcription {

/// The guess that the problem asks for; `seed` matters for `random` alone. `earlier` must be given
/// for `file`.
Vector initial_guess(NonlinearProgram& program, const GuessSpec& spec, std::uint64_t seed,
                     const trajectory::Trajectory* earlier = nullptr);

/// What a guess from an earlier plan does not find there and takes from a static posture: phases,
/// coordinates, motors; one sentence each. Phases are matched by their number, the others by name.
std::vector<std::string> guess_gaps(const NonlinearProgram& program,
                                    const trajectory::Trajectory& earlier);

/// The plan that x stands for: nodes and middles of the intervals, with accelerations, forces and
/// electrical quantities.
trajectory::Trajectory to_trajectory(NonlinearProgram& program, const ConstVectorRef& x);

}  // namespace jaculus::transcription
