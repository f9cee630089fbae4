#include "jaculus/trajectory/column_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <sstream>
#include <string>
#include <vector>

#include "jaculus/core/error.h"
#include "support/input_error.h"

namespace jaculus::trajectory {
namespace {

using test::holds;
using test::input_error_of;

constexpr const char* kMap = R"yaml(format: jaculus-columns/1
rate_hz: 100
separator: ";"
skip_lines: 1
gaps: ["-", "lost"]
channels:
  time: {column: "t (us)", unit: us}
  front_a: {columns: [q0, q4], unit: deg, scale: -1, offset: 90}
  bus_voltage: {column: U, unit: mV}
)yaml";

ColumnMap map_of(const std::string& text) {
  return read_column_map(yaml::Node::parse(text, "map.yaml"));
}

Stream table_of(const std::string& text, std::vector<std::string>& notes,
                const std::string& map = kMap) {
  std::istringstream stream(text);
  return read_mapped_csv(stream, "log.txt", map_of(map), notes);
}

TEST(ColumnMap, ReadsForeignTables) {
  std::vector<std::string> notes;
  const Stream stream = table_of(
      "made by a logger\n\"t (us)\";q0;what;q4;U\n0;90;ok;90;15000\n10000;0;ok;-90;lost\n20000;0",
      notes);
  ASSERT_EQ(stream.channels, (std::vector<std::string>{"front_a", "bus_voltage", "front_a_apart"}));
  ASSERT_EQ(stream.time.size(), 2);
  EXPECT_NEAR(stream.time[1], 0.01, 1e-15);
  EXPECT_NEAR(stream.values(0, 0), 0.0, 1e-12);
  EXPECT_NEAR(stream.values(0, 1), 3.0 * 0.78539816339744831, 1e-12);
  EXPECT_NEAR(stream.values(1, 0), 15.0, 1e-12);
  EXPECT_TRUE(std::isnan(stream.values(1, 1)));
  // 90 and 90 deg, then 0 and -90, by the map's factor of -1.
  EXPECT_EQ(stream.units[2], "rad");
  EXPECT_NEAR(stream.values(2, 0), 0.0, 1e-12);
  EXPECT_NEAR(stream.values(2, 1), -1.5707963267948966, 1e-12);
  ASSERT_EQ(notes.size(), 3u);
  EXPECT_TRUE(holds(notes[0], "line 5, the last, is cut short"));
  EXPECT_TRUE(holds(notes[1], "front_a is the mean of the columns q0, q4"));
  EXPECT_TRUE(holds(notes[2], "front_a_apart is q0 less q4"));
}

TEST(ColumnMap, ReadsTablesWithoutAHeaderPartedByBlanks) {
  std::vector<std::string> notes;
  const Stream stream =
      table_of("  0   1.5 7\n 0.1\t-2  8\n", notes,
               "format: jaculus-columns/1\nseparator: space\nheader: false\nchannels:\n"
               "  time: {column: 1, unit: s}\n  tail: {column: 2, unit: rad}\n");
  EXPECT_EQ(stream.values(0, 1), -2.0);
}

TEST(ColumnMap, ReadsTorquesInTheUnitsThatLogsHave) {
  const auto torque_in = [](const std::string& unit) {
    std::vector<std::string> notes;
    const Stream stream =
        table_of("t,tau\n0,1500\n1,0\n", notes,
                 "format: jaculus-columns/1\nchannels:\n  time: {column: t, unit: s}\n"
                 "  tail_torque: {column: tau, unit: \"" +
                     unit + "\"}\n");
    EXPECT_EQ(stream.units[0], "N m") << unit;
    return stream.values(0, 0);
  };
  for (const char* unit : {"N mm", "Nmm", "N*mm", "N\u00b7mm", "mN m", "mNm"})
    EXPECT_NEAR(torque_in(unit), 1.5, 1e-12) << unit;
  for (const char* unit : {"N m", "Nm"}) EXPECT_EQ(torque_in(unit), 1500.0) << unit;
  EXPECT_NEAR(torque_in("Ncm"), 15.0, 1e-12);

  const std::string message = input_error_of([&] { (void)torque_in("Nmn"); });
  EXPECT_TRUE(holds(message, "column 'tail_torque [Nmn]': allowed: a unit such as '[N m]'"));
}

TEST(ColumnMap, BadFilesAndMapsNameThePlace) {
  const std::string head = "x\nt (us);q0;q4;U\n";
  struct Case {
    std::string text, message;
  };
  std::vector<std::string> notes;
  for (const Case& c : std::vector<Case>{
           {"", "log.txt: ends within the 1 lines to skip"},
           {"x\n", "log.txt: there is no header line"},
           {head, "log.txt: there is no row"},
           {"x\nt (us);q1;q4;U\n0;0;0;0\n",
            "log.txt:3: there is no column 'q0' for front_a, did you mean 'q1'?"},
           {head + "0;0;0;abc\n", "log.txt:3: column 'U': 'abc' is not a number"},
           {head + "0;0;0;nan\n", "log.txt:3: column 'U': 'nan' is not a number"},
           {head + "5;0;0;1\n4;0;0;1\n", "log.txt:4: time: 4e-06 s follows 5e-06 s"},
           {head + "5;0;0;1\n;0;0;1\n", "log.txt:4: time: an empty cell"},
           {head + "5;0\n6;0;0;1\n", "log.txt:3: the row has fewer cells than the others (4)"},
           {head + "5;0;0;1;2\n", "log.txt:3: the row has 5 cells; the others have 4"},
       })
    EXPECT_TRUE(holds(input_error_of([&] { (void)table_of(c.text, notes); }), c.message)) << c.text;
  struct Fault {
    std::string what, by, message;
  };
  for (const Fault& f : std::vector<Fault>{
           {"unit: us", "unit: m", "map.yaml:7: column 'time [m]'"},
           {"columns: [q0, q4], unit: deg", "columns: [q0, q4]",
            "map.yaml:8: column 'front_a' has no unit"},
           {"time: {column", "tme: {column",
            "map.yaml:7: channels: allowed: time and at least one more channel"},
           {"column: U", "colum: U", "map.yaml:9: channels.bus_voltage"},
           {"separator: \";\"", "separator: \"|\"", "map.yaml:3: separator"},
       }) {
    std::string text = kMap;
    text.replace(text.find(f.what), f.what.size(), f.by);
    EXPECT_TRUE(holds(input_error_of([&] { (void)map_of(text); }), f.message));
  }
}

TEST(ColumnMap, NamesTheSeparatorThatAFileHasInPlaceOfAComma) {
  std::vector<std::string> notes;
  const std::string map =
      "format: jaculus-columns/1\nchannels:\n  time: {column: t, unit: s}\n"
      "  front_a: {column: q, unit: rad}\n";
  try {
    (void)table_of("t;q\n0;1\n", notes, map);
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()),
              "log.txt:1: the header has semicolons but no comma; if they part the cells, the map "
              "needs separator: \";\"");
  }
}

}  // namespace
}  // namespace jaculus::trajectory
