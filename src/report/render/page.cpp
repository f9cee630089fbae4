// report.html: the data and the viewer that draws it; without the viewer, what can be said in
// tables.

#include <fmt/format.h>

#include "jaculus/report/report.h"
#include "jaculus/trajectory/csv.h"
#include "report/document/html.h"
#include "report/document/json.h"
#include "report/document/thin.h"
#include "report/render/assets.h"

namespace jaculus::report {
namespace {

// of a report, which browsers and mail still take easily
constexpr std::size_t kMostBytes = 4'800'000;
// of a series, the first thing to give way where that is passed
constexpr std::size_t kMostPoints = 10'000;
constexpr const char* kPlainStyle =
    "body{font-family:sans-serif;margin:2em auto;max-width:70em;padding:0 "
    "1em}table{border-collapse:collapse;margin:1em 0}"
    "td,th{border-bottom:1px solid #999;padding:.2em .6em;text-align:left}";
constexpr const char* kNoViewer =
    "Charts and animation are missing: jaculus was built without its web assets, which need npm. "
    "The numbers stand in "
    "the files "
    "beside this one.";

std::string table_html(const ReportTable& table) {
  std::string text = fmt::format("<h3>{}</h3>\n<table>\n<tr>", html_escaped(table.title));
  for (const std::string& column : table.columns)
    text += fmt::format("<th>{}</th>", html_escaped(column));
  text += "</tr>\n";
  for (const auto& row : table.rows) {
    text += "<tr>";
    for (const std::string& cell : row) text += fmt::format("<td>{}</td>", html_escaped(cell));
    text += "</tr>\n";
  }
  return text + fmt::format("</table>\n<p>{}</p>\n", html_escaped(table.note));
}

std::string bars_html(const Bars& bars) {
  ReportTable table{bars.title, {"", "value", "from", "to", ""}, {}, bars.caption};
  for (const Bars::Item& i : bars.items) {
    table.rows.push_back({i.label, fmt::format("{:.4g}", i.value), fmt::format("{:.4g}", i.low),
                          fmt::format("{:.4g}", i.high), i.note});
  }
  return table_html(table);
}

/// What remains without a viewer.
std::string plain_body(const Document& document) {
  std::string text =
      fmt::format("<h1>{}</h1>\n<p>{}</p>\n<p><b>{}</b></p>\n", html_escaped(document.title),
                  html_escaped(document.caption), kNoViewer);
  for (const auto& [question, sentence] : document.summary)
    text += fmt::format("<p><b>{}</b> {}</p>\n", html_escaped(question), html_escaped(sentence));
  for (const std::string& notice : document.notices)
    text += fmt::format("<p>{}</p>\n", html_escaped(notice));
  ReportTable facts{"", {"", ""}, {}, ""};
  for (const auto& [name, value] : document.facts) facts.rows.push_back({name, value});
  text += table_html(facts);
  for (const Section& section : document.sections) {
    text += fmt::format("<h2>{}</h2>\n", html_escaped(section.title));
    for (const std::string& paragraph : section.text)
      text += fmt::format("<p>{}</p>\n", html_escaped(paragraph));
    for (const ReportTable& table : section.tables) text += table_html(table);
    for (const Bars& bars : section.bars) text += bars_html(bars);
  }
  return text;
}

/// The page with its viewer.
Page viewer_page(const Document& document, const std::string& script, const std::string& style) {
  Page page;
  page.script = script;
  page.style = style;
  page.data = document_json(document);
  page.body =
      "<noscript>This report needs JavaScript, which it brings along.</noscript>\n<main "
      "id=\"report\"></main>\n";
  return page;
}

}  // namespace

std::string report_html(const Report& report) {
  const Document& document = *report.document;
  const std::string title = fmt::format("{} \xC2\xB7 jaculus {}", document.title, document.kind);
  const auto script = web_asset("report.js");
  const auto style = web_asset("report.css");
  if (!script || !style) {
    Page page;
    page.title = title;
    page.style = kPlainStyle;
    page.body = plain_body(document);
    return html_page(page);
  }

  Page page = viewer_page(document, *script, *style);
  page.title = title;
  std::string text = html_page(page);
  for (std::size_t most = kMostPoints; text.size() > kMostBytes && most > 100; most /= 2) {
    page = viewer_page(thinned(document, most), *script, *style);
    page.title = title;
    text = html_page(page);
  }

  return text;
}

std::filesystem::path write_report(const Report& report, const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "report.html";
  trajectory::write_file(file, report_html(report));
  return file;
}

}  // namespace jaculus::report
