#include "cli/reporting.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

#include "jaculus/core/error.h"

namespace jaculus::cli {
namespace {

constexpr int kWidth = 30;  ///< of a bar [characters]

std::string bar(double share) {
  const auto filled = static_cast<std::size_t>(std::lround(kWidth * std::clamp(share, 0.0, 1.0)));
  return fmt::format("[{:-<{}}]", std::string(filled, '#'), kWidth);
}

}  // namespace

std::string duration(double seconds) {
  if (!std::isfinite(seconds)) return "?";
  const int whole = static_cast<int>(std::lround(seconds));
  if (whole < 60) return fmt::format("{} s", whole);
  if (whole < 3600) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
  return fmt::format("{} h {:02} min", whole / 3600, whole / 60 % 60);
}

std::function<void(const std::string&)> notices(const Common& common) {
  if (common.quiet) return {};
  return [](const std::string& text) { fmt::print(stderr, "jaculus: {}\n", text); };
}

void add_figures(CLI::App& command, Common& common) {
  command.add_option("--figures", common.figures,
                     "static figures for papers besides: png, svg, pdf, several with commas");
}

void check_figures(const Common& common) {
  if (common.figures.empty()) return;
  static_cast<void>(report::figure_formats(common.figures));
  if (common.out.empty())
    throw InputError("--figures: given without --out; allowed: with the folder for the results");
  report::require_figures();
}

void write_reporting(const report::Report& report, const Common& common) {
  if (common.out.empty()) return;
  const std::filesystem::path folder = common.out;
  std::size_t figures = 0;
  if (!common.figures.empty())
    figures = report::write_figures(report, folder, report::figure_formats(common.figures)).size();
  const std::filesystem::path file = report::write_report(report, folder);
  if (common.quiet || common.json) return;
  if (figures > 0)
    print(fmt::format("figures: {} in {}\n", figures, (folder / "figures").string()));
  print(fmt::format("report: {}\n", file.string()));
}

std::function<void(const TaskProgress&)> progress_bar(const Common& common,
                                                      const std::string& what) {
  if (!shows_progress(common)) return {};
  return [what](const TaskProgress& p) {
    fmt::print(stderr, "\r\x1b[K{}{}{} {}/{}  {}, {} to go", what, what.empty() ? "" : " ",
               bar(p.total > 0 ? static_cast<double>(p.done) / p.total : 1.0), p.done, p.total,
               duration(p.elapsed_s), duration(p.remaining_s));
    std::fflush(stderr);
  };
}

std::function<void(const std::string&)> stage_bar(
    const Common& common, const std::vector<std::pair<std::string, double>>& shares) {
  if (!shows_progress(common)) return {};
  const auto start = std::chrono::steady_clock::now();
  return [shares, start, behind = 0.0](const std::string& stage) mutable {
    for (const auto& [name, share] : shares)
      if (name == stage) behind = std::max(behind, share);  // stages may come again
    const double elapsed =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    constexpr double kEnough = 0.2;  // of the work, before which a guess of the rest misleads
    const std::string left =
        behind > kEnough
            ? fmt::format(", about {} to go", duration(elapsed * (1.0 - behind) / behind))
            : "";
    fmt::print(stderr, "\r\x1b[K{} {}  {}{}", bar(behind), stage, duration(elapsed), left);
    std::fflush(stderr);
  };
}

void clear_progress(const Common& common) {
  if (!shows_progress(common)) return;
  fmt::print(stderr, "\r\x1b[K");
  std::fflush(stderr);
}

}  // namespace jaculus::cli
