#include "jaculus/trajectory/openlog.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <sstream>
#include <string>
#include <vector>

#include "support/input_error.h"

namespace jaculus::trajectory {
namespace {

using test::holds;
using test::input_error_of;

constexpr const char* kFormat = R"(format: jaculus-openlog/1
rate_hz: 100
byte_order: little
header: {until: [0x0A, 0x0A]}
sync: [0xAA, 0x55]
checksum: {kind: sum8}
fields:
  - {name: t, type: uint16, scale: 0.001, unit: s, channel: time}
  - {name: left, type: float32, unit: rad, scale: -1, offset: 1, channel: front_a}
  - {name: right, type: int16, unit: deg, channel: front_a}
  - {skip: 1}
  - {name: battery, type: uint8, scale: 100, unit: mV, channel: bus_voltage}
  - {name: mode, type: uint8}
)";

OpenLogFormat format_of(const std::string& text) {
  return read_openlog_format(yaml::Node::parse(text, "log.yaml"));
}

void append(std::string& out, std::uint64_t bits, int bytes, bool big_endian = false) {
  for (int i = 0; i < bytes; ++i) {
    const int shift = 8 * (big_endian ? bytes - 1 - i : i);
    out += static_cast<char>(bits >> shift & 0xFF);
  }
}

std::string record(unsigned milliseconds, float left, int right, unsigned battery,
                   bool big_endian = false) {
  std::string body;
  append(body, milliseconds & 0xFFFF, 2, big_endian);
  append(body, std::bit_cast<std::uint32_t>(left), 4, big_endian);
  append(body, static_cast<std::uint64_t>(right), 2, big_endian);
  body += '\x7F';
  append(body, battery, 1);
  append(body, 3, 1);
  unsigned sum = 0;
  for (const char c : body) sum += static_cast<unsigned char>(c);
  return "\xAA\x55" + body + static_cast<char>(sum & 0xFF);
}

Stream log_of(const std::string& bytes, std::vector<std::string>& notes,
              const std::string& format = kFormat) {
  std::istringstream stream(bytes);
  return read_openlog(stream, "log.bin", format_of(format), notes);
}

bool any_holds(const std::vector<std::string>& notes, const std::string& part) {
  for (const std::string& note : notes)
    if (note.find(part) != std::string::npos) return true;
  return false;
}

TEST(OpenLog, ReadsTypesScalesMeansAndAWrappingClock) {
  std::vector<std::string> notes;
  const Stream stream = log_of(
      "two lines\nof text\n\n" + record(65530, 0.5f, -90, 158) + record(10, 0.25f, 45, 157), notes);
  ASSERT_EQ(stream.channels, (std::vector<std::string>{"front_a", "bus_voltage", "front_a_apart"}));
  EXPECT_EQ(stream.units, (std::vector<std::string>{"rad", "V", "rad"}));
  EXPECT_EQ(stream.rate_hz, 100.0);
  ASSERT_EQ(stream.time.size(), 2);
  EXPECT_NEAR(stream.time[1] - stream.time[0], 0.016, 1e-12);
  EXPECT_NEAR(stream.values(0, 0), ((1.0 - 0.5) - 1.5707963267948966) / 2.0, 1e-12);
  EXPECT_NEAR(stream.values(0, 1), ((1.0 - 0.25) + 0.7853981633974483) / 2.0, 1e-12);
  EXPECT_NEAR(stream.values(1, 0), 15.8, 1e-12);
  EXPECT_NEAR(stream.values(2, 0), (1.0 - 0.5) + 1.5707963267948966, 1e-12);
  EXPECT_NEAR(stream.values(2, 1), (1.0 - 0.25) - 0.7853981633974483, 1e-12);
  EXPECT_TRUE(any_holds(notes, "2 records of 14 bytes"));
  EXPECT_TRUE(any_holds(notes, "the clock wrapped 1 times"));
  EXPECT_TRUE(any_holds(notes, "front_a is the mean of 2 fields"));
  EXPECT_TRUE(any_holds(notes, "front_a_apart is the first of its fields less the second"));
}

TEST(OpenLog, PassesOverRubbishBadSumsAndATruncatedTail) {
  std::string bad = record(20, 0.0f, 0, 158);
  bad[6] ^= 1;
  std::vector<std::string> notes;
  const Stream stream =
      log_of("\n\n" + record(10, 0.5f, 0, 158) + "rub\xAA" + record(15, 0.5f, 0, 158) + bad +
                 record(30, 0.5f, 0, 158) + record(40, 0.5f, 0, 158).substr(0, 9),
             notes);
  EXPECT_EQ(stream.time.size(), 3);
  // 4 of rubbish and the 14 of the bad record
  EXPECT_TRUE(any_holds(notes, "18 bytes belong to no record"));
  EXPECT_TRUE(any_holds(notes, "1 records have a wrong checksum"));
  EXPECT_TRUE(any_holds(notes, "9 of 14 bytes"));
}

TEST(OpenLog, ReadsBigEndianAndLogsBeyondOneBlock) {
  std::string format = kFormat;
  format.replace(format.find("little"), 6, "big");
  std::string bytes = "\n\n";
  const unsigned count = 60000;  // wraps the clock nine times and takes four blocks
  for (unsigned k = 0; k < count; ++k) bytes += record(10 * k, static_cast<float>(k), 0, 158, true);
  std::vector<std::string> notes;
  const Stream stream = log_of(bytes, notes, format);
  ASSERT_EQ(stream.time.size(), count);
  EXPECT_NEAR(stream.time[count - 1], 0.01 * (count - 1), 1e-9);
  EXPECT_NEAR(stream.values(0, count - 1), (1.0 - (count - 1)) / 2.0, 1e-9);
}

TEST(OpenLog, WindowGivesWhatTheWholeLogGivesThere) {
  std::string log = "\n\n";
  constexpr int kRecords = 40000;  // the clock of 16 bit wraps on the way
  for (int k = 0; k < kRecords; ++k)
    log += record(static_cast<unsigned>(10 * k), 0.001f * static_cast<float>(k % 100), 0,
                  k == 31234 ? 200U : 150U);
  std::vector<std::string> notes;
  const Stream whole = log_of(log, notes);
  ASSERT_EQ(whole.time.size(), kRecords);
  const auto check = [&](const LogWindow& window, int zero, int first, int last, bool stops) {
    std::istringstream stream(log);
    std::vector<std::string> said;
    const Stream part = read_openlog(stream, "log.bin", format_of(kFormat), window, said);
    ASSERT_EQ(part.time.size(), last - first + 1);
    EXPECT_EQ(part.channels, whole.channels);
    EXPECT_EQ(part.values, whole.values.middleCols(first, last - first + 1));
    const Vector time = whole.time.segment(first, last - first + 1).array() - whole.time[zero];
    EXPECT_LT((part.time - time).cwiseAbs().maxCoeff(), 1e-9);
    EXPECT_EQ(any_holds(said, "reading ended behind the cut"), stops);
  };
  check({{}, "", 0.0, {0.5, 1.0}}, 0, 50, 100, true);
  check({100.0, "", 0.0, {-0.2, 0.1}}, 10000, 9980, 10010, true);
  check({{}, "bus_voltage", 19.0, {-2.0, 1.0}}, 31234, 31034, 31334, true);
  check({{}, "bus_voltage", 19.0, {0.1, 0.2}}, 31234, 31244, 31254, true);
  check({{}, "bus_voltage", 19.0, {-2.0, kInfinity}}, 31234, 31034, kRecords - 1, false);
  check({{}, "", 0.0, {}}, 0, 0, kRecords - 1, false);
}

TEST(OpenLog, WindowsThatHoldNothingAreSaid) {
  const std::string log = "\n\n" + record(10, 0.5f, 0, 158) + record(20, 0.5f, 0, 158);
  const auto fault = [&](const LogWindow& window) {
    std::istringstream stream(log);
    std::vector<std::string> notes;
    return input_error_of(
        [&] { (void)read_openlog(stream, "log.bin", format_of(kFormat), window, notes); });
  };
  EXPECT_TRUE(holds(fault({{}, "bus_voltage", 20.0, {}}), "log.bin: bus_voltage never passes 20"));
  EXPECT_TRUE(holds(fault({{}, "bus_voltag", 20.0, {}}), "did you mean 'bus_voltage'?"));
  EXPECT_TRUE(holds(fault({{}, "", 0.0, {1.0, 2.0}}),
                    "no sample lies within the cut, 1 to 2 s about 0.01 s"));
  EXPECT_TRUE(holds(fault({0.5, "", 0.0, {-0.1, 0.1}}), "no sample lies within the cut"));
}

TEST(OpenLog, BadLogsAndDescriptionsAreSaid) {
  std::vector<std::string> notes;
  EXPECT_TRUE(holds(input_error_of([&] { (void)log_of("no end of the header", notes); }),
                    "log.bin: the bytes that end the header are nowhere in it"));
  EXPECT_TRUE(holds(input_error_of([&] { (void)log_of("\n\n", notes); }),
                    "log.bin: no record of 14 bytes"));
  EXPECT_TRUE(holds(input_error_of([&] {
                      (void)log_of("\n\n" + record(20, 0, 0, 1) + record(10, 0, 0, 1), notes);
                    }),
                    "log.bin: byte 16, record 2: time 0.01 s follows 0.02 s"));
  struct Case {
    std::string what, by, message;
  };
  const std::vector<Case> cases = {
      {"float32", "float31",
       "log.yaml:9: fields[1].type: 'float31' given, did you mean 'float32'?"},
      {"0x55", "0x555", "log.yaml:5: sync[1]: 0x555 given; allowed: a byte"},
      {"unit: s,", "unit: m,", "log.yaml:8: column 'time [m]': allowed: a unit such as '[s]'"},
      {"unit: rad,", "", "log.yaml:9: column 'front_a' has no unit"},
      {"channel: time", "channel: x", "column 'x [s]': allowed: a unit such as '[m]'"},
      {"sum8", "crc", "checksum.kind: 'crc' given"},
      {"rate_hz: 100", "record_bytes: 3",
       "the fields, sync and checksum take 14 bytes; record_bytes says 3"},
      {"scale: -1", "scale: 0", "fields[1].scale: 0 given"},
  };
  for (const Case& c : cases) {
    std::string text = kFormat;
    text.replace(text.find(c.what), c.what.size(), c.by);
    EXPECT_TRUE(holds(input_error_of([&] { (void)format_of(text); }), c.message));
  }
}

}  // namespace
}  // namespace jaculus::trajectory
