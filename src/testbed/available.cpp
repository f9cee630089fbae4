// Whether this build has MuJoCo, and what stands in for the robot where it has not.

#include "jaculus/core/error.h"
#include "jaculus/testbed/playback.h"
#include "jaculus/testbed/trials.h"
#include "testbed/mjcf.h"
#include "testbed/static_tests.h"

namespace jaculus::testbed {

#ifdef JACULUS_HAS_MUJOCO

bool available() { return true; }

#else

bool available() { return false; }

namespace {

[[noreturn]] void refuse() {
  throw InputError(
      "the testbed needs MuJoCo, which this build was made without; install libmujoco-dev (Debian) "
      "and build again");
}

}  // namespace

Recording play(const RobotFiles&, const Changes&, const Commands&, const PlayOptions&,
               const Numerics&) {
  refuse();
}

std::vector<double> measured_parameters(const std::string&, const std::vector<double>&,
                                        const RobotFiles&, const Changes&) {
  refuse();
}

#endif

}  // namespace jaculus::testbed
