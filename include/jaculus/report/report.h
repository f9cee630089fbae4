#pragma once
// Reports: pages that open from disk without a network, and static figures of them for papers. Each
// kind of result has a builder (plan_report.h, compare_report.h, dataset_report.h,
// diagnosis_report.h, study_report.h, score_report.h) that makes a Report of it.

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace jaculus::report {

struct Document;

/// What a result has to show.
struct Report {
  std::shared_ptr<const Document> document;  ///< its text, tables and charts; never null
};

/// The text of report.html. Without the built web assets it holds tables and a notice that charts
/// are missing.
std::string report_html(const Report& report);

/// Writes `folder`/report.html and returns its path. The folder must exist; unwritable: InputError.
std::filesystem::path write_report(const Report& report, const std::filesystem::path& folder);

/// Formats of figures as given on a command line, "png,svg". InputError on another word.
std::vector<std::string> figure_formats(const std::string& given);

/// InputError where figures can't be drawn here, so that a command can say so before its work.
void require_figures();

/// Draws every chart, bars and heat map as `folder`/figures/<id>.<format> by matplotlib, at the
/// width of a journal's column. Returns the files. InputError where python3 with matplotlib is not
/// there.
std::vector<std::filesystem::path> write_figures(const Report& report,
                                                 const std::filesystem::path& folder,
                                                 const std::vector<std::string>& formats);

}  // namespace jaculus::report
