#include "jaculus/trajectory/csv.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "jaculus/core/error.h"
#include "support/input_error.h"
#include "support/shared_data.h"
#include "support/temporary_folder.h"

namespace jaculus::trajectory {
namespace {

using test::holds;
using test::input_error_of;
using test::TemporaryFolder;

TEST(Csv, ReadsNamesUnitsNumbersAndGaps) {
  const Table table = parse_csv(
      "time [s], x [m],phase,node\n0,-1.5e-3,push,1\n 0.5 , ,\"fly, \"\"high\"\"\",+2\n", "t.csv");
  ASSERT_EQ(table.columns.size(), 3u);
  EXPECT_EQ(table.columns[1].name, "x");
  EXPECT_EQ(table.columns[1].unit, "m");
  EXPECT_EQ(table.columns[2].unit, "");
  ASSERT_EQ(table.values.rows(), 2);
  EXPECT_EQ(table.values(0, 1), -1.5e-3);
  EXPECT_TRUE(std::isnan(table.values(1, 1)));
  EXPECT_EQ(table.values(1, 2), 2.0);
  EXPECT_EQ(table.phase, (std::vector<std::string>{"push", "fly, \"high\""}));
  EXPECT_EQ(table.column("node"), 2);
  EXPECT_EQ(table.column("phase"), -1);
}

TEST(Csv, ToleratesByteOrderMarkCarriageReturnsQuotesAndBlankEnd) {
  const Table table =
      parse_csv("\xEF\xBB\xBF\"time [s]\",\"x\"\r\n1,\"2\"\r\n3,\r\n\r\n  \n", "t.csv");
  ASSERT_EQ(table.values.rows(), 2);
  EXPECT_EQ(table.columns[0].name, "time");
  EXPECT_EQ(table.values(0, 1), 2.0);
  EXPECT_TRUE(std::isnan(table.values(1, 1)));
  EXPECT_EQ(parse_csv("x\n7", "t.csv").values(0, 0), 7.0) << "no line feed at the end";
}

TEST(Csv, BadFilesNameThePlace) {
  struct Case {
    std::string text, message;
  };
  const std::vector<Case> cases = {
      {"", "t.csv: the file is empty"},
      {"\xEF\xBB\xBF\n \n", "t.csv: the file is empty"},
      {"time [s],x [m]\n", "t.csv:1: there is a header but no row"},
      {"time [s],x [m]\n1,2\n3\n", "t.csv:3: the row has 1 cell; the header has 2"},
      {"time [s],x [m]\n1,2,3\n", "t.csv:2: the row has 3 cells; the header has 2"},
      {"time [s],x [m]\n1,2,\n", "t.csv:2: the row has 3 cells; the header has 2"},
      {"time [s],x [m]\n1,2\n\n3,4\n", "t.csv:3: a blank line stands between the rows"},
      {"x [m]\n1\n\n2\n", "t.csv:3: a blank line stands between the rows"},
      {"time [s],x [m]\n1,two\n", "t.csv:2: column 'x': 'two' is not a number"},
      {"time [s],x [m]\n1,2 m\n", "t.csv:2: column 'x': '2 m' is not a number"},
      {"time [s],x [m]\n1,nan\n", "t.csv:2: column 'x': 'nan' is not a number"},
      {"time [s],x [m]\n1,-inf\n", "t.csv:2: column 'x': '-inf' is not a number"},
      {"time [s],x [m]\n1,1e999\n", "t.csv:2: column 'x': '1e999' is not a number"},
      {"time [s],x [m]\n1,+-2\n", "t.csv:2: column 'x': '+-2' is not a number"},
      {"time [s],x [m]\n1,0x10\n", "t.csv:2: column 'x': '0x10' is not a number"},
      {"phase,x [m]\npush,1\npush,a\n", "t.csv:3: column 'x': 'a' is not a number"},
      {"x [m],phase,x [mm]\n1,a,2\n", "t.csv:1: column 'x' stands twice"},
      {"phase,phase,x\na,b,2\n", "t.csv:1: column 'phase' stands twice"},
      {"phase\npush\n", "t.csv:1: there is no column of numbers"},
      {"x [m],,z [m]\n1,2,3\n", "t.csv:1: a column has no name"},
      {"x [m],[s]\n1,2\n", "t.csv:1: a column has no name"},
      {"x [m,z\n1,2\n", "t.csv:1: column 'x [m': 'name [unit]' is expected"},
      {"x [m] a,z\n1,2\n", "t.csv:1: column 'x [m] a': 'name [unit]' is expected"},
      {"x [[m]],z\n1,2\n", "t.csv:1: column 'x [[m]]': 'name [unit]' is expected"},
      {"x [],z\n1,2\n", "t.csv:1: column 'x []': the brackets hold no unit"},
      {"0,1\n1,2\n", "t.csv:1: '0' stands where a column name is expected"},
      {"x [m];z [m]\n1;2\n", "t.csv:1: the header has semicolons"},
      {"x,z\n1,\"2\n", "t.csv:2: a quoted cell has no closing quote"},
      {"x,z\n\"1\"0,2\n", "t.csv:2: '0' stands behind a closing quote"},
      {std::string("x,z\n1,\0\n", 8), "t.csv:2: column 'z': '?' is not a number"},
      {"x,z\n1," + std::string(500, 'a') + "\n",
       "'" + std::string(40, 'a') + "...' is not a number"},
  };
  for (const Case& c : cases)
    EXPECT_TRUE(holds(input_error_of([&] { parse_csv(c.text, "t.csv"); }), c.message)) << c.text;
}

TEST(Csv, MissingFileAndFolderAreBadInput) {
  const TemporaryFolder folder;
  EXPECT_TRUE(holds(input_error_of([&] { read_csv(folder / "none.csv"); }),
                    "none.csv: there is no such file"));
  EXPECT_TRUE(
      holds(input_error_of([&] { read_csv(folder.path()); }), "a folder; a CSV file is expected"));
}

TEST(Csv, QuantityConvertsToSi) {
  const Table table = parse_csv("time [ms],x,duty [-],pitch [rad]\n2000,3,0.5,\n", "t.csv");
  EXPECT_DOUBLE_EQ(quantity(table, "time", dimension::time, "t.csv")[0], 2.0);
  EXPECT_EQ(quantity(table, "duty", dimension::none, "t.csv")[0], 0.5);
  EXPECT_EQ(quantity(table, "x", dimension::none, "t.csv")[0], 3.0);
  EXPECT_TRUE(std::isnan(quantity(table, "pitch", dimension::angle, "t.csv")[0]));
}

TEST(Csv, QuantityRefusesMissingColumnsAndUnits) {
  const Table table = parse_csv("time [s],x,z [V]\n1,3,4\n", "t.csv");
  const auto message = [&](const std::string& name, const Dimension& dimension) {
    return input_error_of([&] { quantity(table, name, dimension, "t.csv"); });
  };
  EXPECT_TRUE(holds(message("tme", dimension::time),
                    "t.csv:1: column 'tme [s]' is missing; did you mean 'time'?"));
  EXPECT_TRUE(holds(message("x", dimension::length),
                    "t.csv:1: column 'x' has no unit; 'x [m]' is expected"));
  EXPECT_TRUE(holds(message("z", dimension::length), "t.csv:1: column 'z [V]': "));
}

TEST(Csv, NumbersReadBackTheSameBits) {
  std::mt19937_64 random(7);
  Table table{{{"a", "m"}, {"b, \"odd\"", "-"}, {"c", ""}}, Matrix(2000, 3), {}};
  for (Eigen::Index i = 0; i < table.values.size(); ++i) {
    double value = kNaN;
    while (!std::isfinite(value))
      value = std::bit_cast<double>(static_cast<std::uint64_t>(random()));
    table.values.data()[i] = value;
  }
  table.values(0, 0) = -0.0;
  table.values(1, 0) = std::numeric_limits<double>::denorm_min();
  table.values(2, 0) = std::numeric_limits<double>::max();
  table.values(3, 1) = kNaN;
  table.phase.assign(2000, "all feet, \"1\"");
  table.phase[5] = "";
  const Table back = parse_csv(format_csv(table), "t.csv");
  ASSERT_EQ(back.values.rows(), table.values.rows());
  ASSERT_EQ(back.values.cols(), table.values.cols());
  EXPECT_EQ(back.phase, table.phase);
  EXPECT_EQ(back.columns[1].name, "b, \"odd\"");
  EXPECT_TRUE(std::isnan(back.values(3, 1)));
  for (Eigen::Index i = 0; i < table.values.size(); ++i) {
    if (std::isnan(table.values.data()[i])) continue;
    EXPECT_EQ(std::bit_cast<std::uint64_t>(back.values.data()[i]),
              std::bit_cast<std::uint64_t>(table.values.data()[i]));
  }
}

TEST(Csv, GapsOfASingleColumnAreKept) {
  Table table{{{"a", "m"}}, Matrix(3, 1), {}};
  table.values << kNaN, 1.0, kNaN;
  EXPECT_EQ(format_csv(table), "a [m]\n\"\"\n1\n\"\"\n");
  EXPECT_EQ(parse_csv(format_csv(table), "t.csv").values.rows(), 3);
}

TEST(WriteFile, ReplacesWholeAndLeavesNothingElse) {
  const TemporaryFolder folder;
  write_file(folder / "a.txt", "first, and longer");
  write_file(folder / "a.txt", "second");
  EXPECT_EQ(test::bytes_of(folder / "a.txt"), "second");
  std::filesystem::create_symlink("a.txt", folder / "link.txt");
  write_file(folder / "link.txt", "third");
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "link.txt"));
  EXPECT_EQ(test::bytes_of(folder / "a.txt"), "third");
  const std::filesystem::directory_iterator files(folder.path());
  EXPECT_EQ(std::distance(begin(files), end(files)), 2);
}

TEST(WriteFile, UnwritableIsBadInput) {
  const TemporaryFolder folder;
  EXPECT_TRUE(holds(input_error_of([&] { write_file(folder / "none/a.txt", ""); }),
                    "No such file or directory"));
  EXPECT_TRUE(holds(input_error_of([&] { write_file(folder.path(), ""); }),
                    "can't be written: it is a folder"));
  if (std::filesystem::exists("/dev/full")) {
    EXPECT_TRUE(
        holds(input_error_of([&] { write_file("/dev/full", "text"); }), "No space left on device"));
  }
}

TEST(Csv, AuthorsPlansAndLogsReadAsTheyAre) {
  JACULUS_REQUIRE_SHARED_DATA(data);
  int plans = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(data)) {
    if (entry.path().extension() != ".csv") continue;
    const Table table = read_csv(entry.path());
    const Vector time = quantity(table, "time", dimension::time, entry.path());
    EXPECT_GE((time.tail(time.size() - 1) - time.head(time.size() - 1)).minCoeff(), 0.0)
        << entry.path();
    if (entry.path().parent_path().filename() != "plans") continue;
    ++plans;
    EXPECT_EQ(table.phase.front(), "1") << entry.path();
    EXPECT_EQ(table.phase.back(), "2") << entry.path();
    EXPECT_GE(table.values.rows(), 62) << entry.path();
    EXPECT_TRUE(table.values.allFinite()) << entry.path();
  }
  EXPECT_EQ(plans, 8);
  const Table tailless = read_csv(data / "plans" / "notail_V7.csv");
  const double duration =
      quantity(tailless, "time", dimension::time, "")[tailless.values.rows() - 1];
  const double speed =
      quantity(tailless, "x_velocity", dimension::velocity, "")[tailless.values.rows() - 1];
  EXPECT_NEAR(speed / duration, 5.942, 5e-4);
}

}  // namespace
}  // namespace jaculus::trajectory
