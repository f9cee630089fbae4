// Motive exports, and their way into the robot's axes.

#include "jaculus/trajectory/optitrack.h"

#include <sstream>

#include "fuzz/target.h"

using namespace jaculus;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  fuzz::refuse_politely([&] {
    std::istringstream stream(fuzz::text_of(data + 1, size - 1));
    const trajectory::MocapTake take = trajectory::read_optitrack(stream, "fuzz.csv");
    trajectory::MocapAxes axes;
    axes.up = data[0] % 2 == 0 ? trajectory::MocapUp::y : trajectory::MocapUp::z;
    axes.forward =
        data[0] % 3 == 0 ? trajectory::MocapForward::automatic : trajectory::MocapForward::plus_x;
    std::vector<std::string> notes;
    const trajectory::Stream out = trajectory::mocap_stream(take, axes, notes);
    if (out.values.rows() != std::ssize(out.channels) || out.values.cols() != out.time.size())
      __builtin_trap();
  });
  return 0;
}
