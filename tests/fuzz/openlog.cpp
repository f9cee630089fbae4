// Binary logs under several descriptions.

#include "jaculus/trajectory/openlog.h"

#include <sstream>

#include "fuzz/target.h"

namespace {

using namespace jaculus;

const trajectory::OpenLogFormat& format_of(unsigned index) {
  const auto read = [](const std::string& keys) {
    return trajectory::read_openlog_format(
        yaml::Node::parse("{format: jaculus-openlog/1, " + keys + "}", "format"));
  };
  static const trajectory::OpenLogFormat formats[] = {
      read("sync: [0xAA], checksum: {kind: xor8}, fields: [{name: t, type: uint8, unit: s, "
           "channel: time}, {name: a, "
           "type: int16, unit: "
           "rad, channel: tail}]"),
      read("header: {until: [10, 10]}, byte_order: big, record_bytes: 16, fields: [{name: t, type: "
           "float64, unit: s, "
           "channel: time}, "
           "{name: a, type: float32, unit: deg, channel: tail}, {skip: 1}]"),
      read("header: {bytes: 3}, fields: [{name: t, type: uint16, scale: 0.001, unit: s, channel: "
           "time}, {name: a, "
           "type: int64, unit: "
           "rad, channel: tail}, {name: b, type: uint64, unit: rad, channel: tail}]"),
      read("sync: [1, 2], checksum: {kind: sum8}, fields: [{name: t, type: uint32, unit: s, "
           "channel: time}, {name: a, "
           "type: int8, unit: "
           "V, channel: bus_voltage}]"),
  };
  return formats[index % 4];
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  fuzz::refuse_politely([&] {
    std::istringstream stream(fuzz::text_of(data + 1, size - 1));
    std::vector<std::string> notes;
    trajectory::LogWindow window{{}, (data[0] & 4) != 0 ? "tail" : "", 0.0, {-1.0, 100.0}};
    if ((data[0] & 8) != 0) window.zero = 10.0;
    if ((data[0] & 16) != 0) window.cut = {2.0, 5.0};
    const trajectory::Stream out =
        trajectory::read_openlog(stream, "fuzz.bin", format_of(data[0]), window, notes);
    if (out.time.size() != out.values.cols() || out.time.size() == 0) __builtin_trap();
  });
  fuzz::refuse_politely([&] {
    std::istringstream stream(fuzz::text_of(data + 1, size - 1));
    std::vector<std::string> notes;
    const trajectory::Stream out =
        trajectory::read_openlog(stream, "fuzz.bin", format_of(data[0]), notes);
    for (Eigen::Index k = 1; k < out.time.size(); ++k)
      if (!(out.time[k] > out.time[k - 1])) __builtin_trap();
  });
  return 0;
}
