// Motive exports, and their way into the robot's axes.

#include "jaculus/trajectory/optitrack.h"

#include <sstream>

#include "fuzz/target.h"

using namespace jaculus;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  fuzz::refuse_politely([&] {
    std::istringstream stream(fuzz::text_of(data + 1, size - 1));
    const MocapTake take = read_optitrack(stream, "fuzz.csv");
    MocapAxes axes;
    axes.up = data[0] % 2 == 0 ? "y" : "z";
    axes.forward = data[0] % 3 == 0 ? "auto" : "+x";
    std::vector<std::string> notes;
    const Stream out = mocap_stream(take, axes, notes);
    if (out.values.rows() != static_cast<Eigen::Index>(out.channels.size()) || out.values.cols() != out.time.size())
      __builtin_trap();
  });
  return 0;
}
