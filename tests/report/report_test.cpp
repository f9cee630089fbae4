// Reports as files: nothing in them is markup, numbers come back, large ones are thinned without
// losing peaks.

#include "jaculus/report/report.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <cstring>

#include "jaculus/core/error.h"
#include "jaculus/report/study_report.h"
#include "report/document/html.h"
#include "report/document/json.h"
#include "report/document/thin.h"
#include "report/study_parts.h"
#include "support/temporary_folder.h"

namespace jaculus::report {
namespace {

const std::string kHostile = "</script><script>alert(1)</script><!-- \"'& \xE2\x80\xA8 \xFF";

std::size_t count(const std::string& text, const std::string& what) {
  std::size_t n = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++n;
  return n;
}

/// A report that holds `name` wherever a name can stand.
Document named(const std::string& name) {
  Document report{name, name, name, {{name, name}}, {name}, {}};
  Section section{name, {name}};
  section.tables.push_back({name, {name}, {{name}}, name});
  section.bars.push_back({"b", name, name, {{name, 0.5, 0.1, 0.9, name}}, name});
  section.heat_maps.push_back({"h", name, name, name, {name}, {name}, {{1.0}}, name});
  section.drawings.push_back({"d", name, {{name, {Vec2(0, 0), Vec2(1, 0)}, 0.1, 0.5, name}}, name});
  section.charts.push_back(
      {"c", name, name, {name, name}, {name, name}, {{name, {0.0, 1.0}, {0.0, 1.0}}}, {{name}}});
  Actor actor;
  actor.name = name;
  actor.time = {0.0, 1.0};
  actor.bodies = {{name, BodyKind::link, 1, {0.0, 0.0, 1.0, 1.0}}};
  actor.phases = {{name, 0.0, 1.0}};
  section.animations.push_back({"a", name, {{name, {actor}}}, name});
  report.sections.push_back(section);
  report.summary = {{name, name}};
  const Drawing panel{
      "p", name, {{name, {Vec2(0, 0), Vec2(1, 0)}, 0.1, kNaN, name, "force"}}, name};
  report.picture = {"picture", name, {panel}, {{"force", name}}, name};
  return report;
}

std::vector<float> decoded(const std::string& text) {
  static const std::string kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  unsigned block = 0;
  int bits = 0;
  for (const char c : text) {
    if (c == '=') break;
    block = block << 6 | static_cast<unsigned>(kDigits.find(c));
    bits += 6;
    if (bits < 8) continue;
    bits -= 8;
    bytes += static_cast<char>(block >> bits & 0xFFU);
  }
  std::vector<float> values(bytes.size() / sizeof(float));
  std::memcpy(values.data(), bytes.data(), values.size() * sizeof(float));
  return values;
}

TEST(Report, NamesNeverBecomeMarkup) {
  const std::string html = report_html(finished(named(kHostile)));
  EXPECT_EQ(html.find("<script>alert"), std::string::npos);
  EXPECT_EQ(html.find("<!--"), std::string::npos);
  // The page's own elements: its data and its viewer; an end each.
  EXPECT_EQ(count(html, "</script>"), count(report_html(finished(named("plain"))), "</script>"));
  EXPECT_EQ(html.find("\xE2\x80\xA8", html.find("id=\"data\"")), std::string::npos)
      << "a line separator ends a line of script";
}

TEST(Report, DataReadBackAsTheyWere) {
  const nlohmann::ordered_json data = {{"name", "</script> <b> & \xE2\x80\xA8 \\u003c"},
                                       {"x", {1.5, nullptr}}};
  EXPECT_EQ(nlohmann::ordered_json::parse(json_for_script(data)), data);
}

TEST(Report, NothingIsAskedFor) {
  const std::string html = report_html(finished(named("plain")));
  EXPECT_NE(html.find("default-src 'none'"), std::string::npos);
  EXPECT_EQ(count(html, " src=\"http"), 0U);
  EXPECT_EQ(count(html, "@import"), 0U);
  EXPECT_EQ(count(html, "<link rel=\"stylesheet"), 0U);
}

TEST(Report, NumbersComeBackAndEqualOnesAreKeptOnce) {
  Document report = named("plain");
  Chart& chart = report.sections[0].charts[0];
  const std::vector<double> x{0.0, 0.1, 1e-30, -7.25, kNaN};
  chart.series = {{"one", x, x}, {"two", x, {1.0, 2.0, 3.0, 4.0, 5.0}}};
  const nlohmann::ordered_json json = document_json(report);
  const auto& series = json["sections"][0]["charts"][0]["series"];
  EXPECT_EQ(series[0]["x"], series[1]["x"]);
  EXPECT_EQ(series[0]["x"], series[0]["y"]);
  const std::vector<float> back = decoded(json["arrays"][series[0]["x"].get<std::size_t>()]);
  ASSERT_EQ(back.size(), x.size());
  for (std::size_t i = 0; i + 1 < x.size(); ++i) EXPECT_EQ(back[i], static_cast<float>(x[i]));
  EXPECT_TRUE(std::isnan(back.back()));
  for (std::size_t n = 1; n < 5; ++n) {  // every length of padding
    chart.series = {{"one", std::vector<double>(n, 2.5), std::vector<double>(n, 2.5)}};
    const nlohmann::ordered_json again = document_json(report);
    const auto index = again["sections"][0]["charts"][0]["series"][0]["x"].get<std::size_t>();
    EXPECT_EQ(decoded(again["arrays"][index]), std::vector<float>(n, 2.5F));
  }
}

TEST(Report, ThinningKeepsPeaksAndGaps) {
  Document report = named("plain");
  std::vector<double> x, y;
  for (int i = 0; i < 100'000; ++i) {
    x.push_back(i);
    y.push_back(std::sin(1e-3 * i));
  }
  y[54'321] = 50.0;
  y[77'777] = -60.0;
  y[12'345] = kNaN;
  report.sections[0].charts[0].series = {{"spiky", x, y, SeriesStyle::line, 0, y, y}};
  const Series thin = thinned(report, 1000).sections[0].charts[0].series[0];
  EXPECT_LE(thin.y.size(), 1100U);
  EXPECT_EQ(thin.x.size(), thin.y.size());
  EXPECT_EQ(thin.low.size(), thin.y.size());
  EXPECT_EQ(thin.x.front(), 0.0);
  EXPECT_EQ(thin.x.back(), 99'999.0);
  EXPECT_NE(std::find(thin.y.begin(), thin.y.end(), 50.0), thin.y.end());
  EXPECT_NE(std::find(thin.y.begin(), thin.y.end(), -60.0), thin.y.end());
  EXPECT_TRUE(std::any_of(thin.y.begin(), thin.y.end(), [](double v) { return std::isnan(v); }));
  EXPECT_TRUE(std::is_sorted(thin.x.begin(), thin.x.end()));
}

TEST(Report, StaysUnderFiveMegabytesAndSaysWhatItLeftOut) {
  Document report = named("plain");
  Section& section = report.sections[0];
  section.charts.clear();
  for (int k = 0; k < 40; ++k) {
    std::vector<double> x, y;
    for (int i = 0; i < 40'000; ++i) {
      x.push_back(i);
      y.push_back(std::sin(1e-3 * i * k) + k);
    }
    section.charts.push_back(
        {"c" + std::to_string(k), "", "", {"x", "s"}, {"y", "V"}, {{"s", x, y}}});
  }
  const std::string html = report_html(finished(report));
  EXPECT_LT(html.size(), 5'000'000U);
  EXPECT_NE(html.find("To keep this file small"), std::string::npos);
}

TEST(Report, TenThousandSamplesOfFortyChannelsAreKeptWhole) {
  Document report = named("plain");
  std::vector<double> x;
  for (int i = 0; i < 10'000; ++i) x.push_back(1e-3 * i);
  for (int k = 0; k < 40; ++k) {
    std::vector<double> y;
    for (const double t : x) y.push_back(std::sin(t * k));
    report.sections[0].charts.push_back(
        {"w" + std::to_string(k), "", "", {"x", "s"}, {"y", "V"}, {{"s", x, y}}});
  }
  const std::string html = report_html(finished(report));
  EXPECT_LT(html.size(), 5'000'000U);
  EXPECT_EQ(html.find("To keep this file small"), std::string::npos);
}

TEST(Figures, FormatsAreChecked) {
  EXPECT_EQ(figure_formats("png,svg,png"), (std::vector<std::string>{"png", "svg"}));
  for (const char* bad : {"", "jpg", "png,", "png, svg"}) {
    try {
      static_cast<void>(figure_formats(bad));
      ADD_FAILURE() << bad;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find("png, svg, pdf"), std::string::npos) << error.what();
    }
  }
}

/// A report with one chart of two series.
Document with_chart() {
  Document report;
  report.kind = "study";
  report.title = "falling";
  Section section;
  section.title = "drop";
  Chart chart{"drop_height", "Height", "", {"time", "s"}, {"height", "m"}, {}};
  chart.series.push_back({"measured", {0.0, 0.1, 0.2}, {1.0, 0.95, 0.8}});
  chart.series.push_back({"model", {0.0, 0.1, 0.2}, {1.0, 0.951, 0.804}, SeriesStyle::dashed});
  chart.marks.push_back({"paper", MarkKind::published, 0.1, 0.94});
  section.charts.push_back(chart);
  report.sections.push_back(section);
  return report;
}

TEST(Figures, EveryFormatIsWrittenAsWhatItIs) {
  try {
    require_figures();
  } catch (const InputError& error) {
    GTEST_SKIP() << error.what();
  }
  const test::TemporaryFolder folder;
  const std::vector<std::pair<std::string, std::string>> begins = {
      {".png", "\x89PNG\r\n\x1A\n"}, {".svg", "<?xml"}, {".pdf", "%PDF-"}};
  const auto files = write_figures(finished(with_chart()), folder.path(), {"png", "svg", "pdf"});
  ASSERT_EQ(files.size(), begins.size());
  for (const auto& [extension, magic] : begins) {
    const std::filesystem::path file = folder.path() / "figures" / ("drop_height" + extension);
    EXPECT_NE(std::find(files.begin(), files.end(), file), files.end()) << file;
    const std::string bytes = test::bytes_of(file);
    EXPECT_GT(bytes.size(), 3000U) << file;
    EXPECT_EQ(bytes.substr(0, magic.size()), magic) << file;
    if (extension == ".svg") {
      EXPECT_NE(bytes.find("</svg>"), std::string::npos);
    }
    if (extension == ".pdf") {
      EXPECT_NE(bytes.find("%%EOF", bytes.size() - 16), std::string::npos);
    }
  }
}

TEST(Report, WithoutTheViewerItIsAPlainPageWithTheNumbers) {
  const test::TemporaryFolder empty;
  ASSERT_EQ(::setenv("JACULUS_WEB", empty.path().c_str(), 1), 0);
  const std::string html = report_html(finished(with_chart())),
                    hostile = report_html(finished(named(kHostile)));
  ::unsetenv("JACULUS_WEB");
  EXPECT_EQ(count(html, "<script"), 0U);
  for (const char* shown : {"falling", "drop", "Charts and animation are missing", "<table"})
    EXPECT_NE(html.find(shown), std::string::npos) << shown;
  EXPECT_EQ(count(hostile, "<script"), 0U);
  EXPECT_EQ(count(hostile, "</script"), 0U);
}

TEST(StudyReport, ColumnsBecomeNamesWithUnits) {
  EXPECT_EQ(column_axis("tail_inertia_kg_m2").name, "tail inertia");
  EXPECT_EQ(column_axis("tail_inertia_kg_m2").unit, "kg m²");
  EXPECT_EQ(column_axis("body_angle_at_end_deg").unit, "°");
  EXPECT_EQ(column_axis("time_s").unit, "s");
  EXPECT_EQ(column_axis("drag_factor_N_m_s2").unit, "N m s²");
  EXPECT_EQ(column_axis("effectiveness").name, "effectiveness");
  EXPECT_EQ(column_axis("effectiveness").unit, "-");
}

/// A grid of n x n points, of which the first `failed` failed.
studies::StudyResult grid_of(int n, int failed) {
  studies::StudyResult study{"grid", "motion", "", false, {"a", "b"}, {}, {}, {}};
  study.axes = {"a", "b"};
  for (int k = 0; k < 8; ++k) study.columns.push_back("output_" + std::to_string(k));
  for (int i = 0; i < n * n; ++i) {
    studies::StudyJson row{{"a", i / n}, {"b", i % n}};
    for (int k = 0; k < 8; ++k) row[study.columns[k + 2]] = std::sin(0.1 * i + k);
    study.rows.push_back(std::move(row));
    if (i < failed) study.notes.push_back("point " + std::to_string(i) + " failed: by accident");
  }
  return study;
}

TEST(StudyReport, StaysSmallHoweverManyPointsThereAre) {
  const std::string page = report_html(study_report({grid_of(316, 5000)}));
  EXPECT_LT(page.size(), 10'000'000u);
  EXPECT_NE(page.find("12 of 316 values of"), std::string::npos);
  EXPECT_NE(page.find("and 4900 more notes"), std::string::npos);
}

TEST(StudyReport, DrawsAllLinesOfASmallGrid) {
  const std::string page = report_html(study_report({grid_of(8, 3)}));
  EXPECT_EQ(page.find("8 values of"), std::string::npos);
  EXPECT_EQ(page.find("more notes"), std::string::npos);
}

}  // namespace
}  // namespace jaculus::report
