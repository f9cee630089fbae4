#include "cli/reporting.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>

#include "jaculus/core/error.h"

namespace jaculus::cli {
namespace {

/// "2 min 05 s"
std::string duration(double seconds) {
  if (!std::isfinite(seconds)) return "?";
  const int whole = static_cast<int>(std::lround(seconds));
  if (whole < 60) return fmt::format("{} s", whole);
  if (whole < 3600) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
  return fmt::format("{} h {:02} min", whole / 3600, whole / 60 % 60);
}

}  // namespace

void add_figures(CLI::App& command, Common& common) {
  command.add_option("--figures", common.figures,
                     "static figures for papers besides: png, svg, pdf, several with commas");
}

void check_figures(const Common& common) {
  if (common.figures.empty()) return;
  static_cast<void>(figure_formats(common.figures));
  if (common.out.empty()) throw InputError("--figures: given without --out; allowed: with the folder for the results");
  require_figures();
}

void write_reporting(const Report& report, const Common& common) {
  if (common.out.empty()) return;
  const std::filesystem::path folder = common.out;
  std::size_t figures = 0;
  if (!common.figures.empty()) figures = write_figures(report, folder, figure_formats(common.figures)).size();
  const std::filesystem::path file = write_report(report, folder);
  if (common.quiet || common.json) return;
  if (figures > 0) print(fmt::format("figures: {} in {}\n", figures, (folder / "figures").string()));
  print(fmt::format("report: {}\n", file.string()));
}

std::function<void(const TaskProgress&)> progress_bar(const Common& common, const std::string& what) {
  if (!shows_progress(common)) return {};
  return [what](const TaskProgress& p) {
    constexpr int kWidth = 30;
    const int filled = p.total > 0 ? kWidth * p.done / p.total : kWidth;
    fmt::print(stderr, "\r\x1b[K{}{}[{:-<{}}] {}/{}  {}, {} to go", what, what.empty() ? "" : " ",
               std::string(static_cast<std::size_t>(filled), '#'), kWidth, p.done, p.total, duration(p.elapsed_s),
               duration(p.remaining_s));
    std::fflush(stderr);
  };
}

void clear_progress(const Common& common) {
  if (!shows_progress(common)) return;
  fmt::print(stderr, "\r\x1b[K");
  std::fflush(stderr);
}

}  // namespace jaculus::cli
