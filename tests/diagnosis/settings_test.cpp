#include "jaculus/diagnosis/settings.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>
#include <string>

#include "support/input_error.h"
#include "support/temporary_folder.h"

namespace jaculus::diagnosis {
namespace {

TEST(Settings, AreInTheTableOnceEachWithUnitAndMeaning) {
  std::set<std::string> names;
  const std::string text = settings_text({});
  for (const SettingRow& row : setting_rows({})) {
    EXPECT_TRUE(names.insert(row.name).second) << row.name;
    EXPECT_FALSE(row.group.empty() || row.unit.empty() || row.meaning.empty()) << row.name;
    EXPECT_EQ(row.value, row.default_value) << row.name;
    EXPECT_TRUE(test::holds(text, "  " + row.name + " ")) << row.name;
    EXPECT_TRUE(test::holds(text, row.meaning)) << row.name;
    EXPECT_TRUE(test::holds(text, row.origin)) << row.name;
  }
  EXPECT_GT(names.size(), 100u);
}

TEST(Settings, SayWhereTheyComeFrom) {
  for (const SettingRow& row : setting_rows({})) {
    const std::string kind = row.origin.substr(0, row.origin.find_first_of(":, "));
    EXPECT_TRUE(kind == "derivation" || kind == "paper" || kind == "hardware" || kind == "batch" ||
                kind == "chosen")
        << row.name << ": " << row.origin;
    EXPECT_GT(row.origin.size(), kind.size() + 4) << row.name << ": " << row.origin;
  }
}

TEST(Settings, LieWithinTheirRange) {
  for (const SettingRow& row : setting_rows({})) {
    EXPECT_LT(row.range.lower, row.range.upper) << row.name;
    EXPECT_TRUE(row.range.contains(row.default_value)) << row.name;
    EXPECT_TRUE(std::isfinite(row.range.lower) && std::isfinite(row.range.upper)) << row.name;
  }
}

TEST(Settings, ThatMustNotPassOneAnotherHaveRangesApart) {
  std::map<std::string, Bounds> range;
  for (const SettingRow& row : setting_rows({})) range[row.name] = row.range;
  EXPECT_LE(range.at("least_step").upper, range.at("most_step").lower);    // of a clamp
  EXPECT_LE(range.at("grid").upper, range.at("force_step").lower);         // of a stride
  EXPECT_LE(range.at("fewest_samples").upper, range.at("samples").lower);  // else none is left
}

TEST(Settings, AFileReplacesWhatItNames) {
  const test::TemporaryFolder folder;
  const Settings read = read_settings(folder.write("s.yaml", "likely: 0.9\nwindows: 5\n"));
  EXPECT_EQ(read.likely, 0.9);
  EXPECT_EQ(read.windows, 5);
  EXPECT_EQ(read.listed, Settings{}.listed);
  EXPECT_NE(settings_text(read).find("(default 0.5)"), std::string::npos);
}

TEST(Settings, ThatNobodyKnowsAreRefused) {
  const test::TemporaryFolder folder;
  const auto message = [&](const std::string& text) {
    return test::input_error_of([&] { read_settings(folder.write("s.yaml", text)); });
  };
  const std::string unknown = message("shure: 0.9\n");
  EXPECT_TRUE(test::holds(unknown, "s.yaml:1"));
  EXPECT_TRUE(test::holds(unknown, "shure"));
  EXPECT_TRUE(test::holds(message("likely: high\n"), "s.yaml:1: likely"));
  EXPECT_TRUE(test::holds(message("windows: 2.5\n"), "s.yaml:1: windows"));
}

TEST(Settings, ThatWouldHangOrDivideByZeroAreRefused) {
  const test::TemporaryFolder folder;
  for (const std::string name :
       {"force_step", "one_off_bins", "hat_functions", "hat_functions_alone", "rows_of_hat", "grid",
        "window_length", "quiet_one_in", "line_search_lowest", "line_search_even", "time_folds",
        "variability_modes", "state_half_width", "shift_prior_segments", "force_box",
        "onset_step"}) {
    for (const std::string value : {"0", "-1"}) {
      const std::string text = "# settings\n" + name + ": " + value + "\n";
      const std::string message =
          test::input_error_of([&] { read_settings(folder.write("s.yaml", text)); });
      EXPECT_TRUE(test::holds(message, "s.yaml:2: " + name + ": " + value)) << message;
      EXPECT_TRUE(test::holds(message, "allowed: ")) << message;
    }
  }
}

TEST(Settings, BeyondTheirRangeAreRefusedWithIt) {
  const test::TemporaryFolder folder;
  const auto message = [&](const std::string& text) {
    return test::input_error_of([&] { read_settings(folder.write("s.yaml", text)); });
  };
  EXPECT_TRUE(test::holds(message("likely: 1.5\n"), "allowed: 0 to 1"));
  EXPECT_TRUE(test::holds(message("hat_functions: 1\n"), "allowed: a whole number from 2 to 1000"));
  EXPECT_TRUE(test::holds(message("largest_correlation: 1\n"), "allowed: 0 to 0.999"));
  EXPECT_TRUE(test::holds(message("grid: 1e-9\n"), "allowed: 0.0001 to 0.005"));
}

}  // namespace
}  // namespace jaculus::diagnosis
