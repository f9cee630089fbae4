#include "cli/reporting.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstdio>
#include <memory>
#include <mutex>
#include <thread>

#include "jaculus/core/error.h"

namespace jaculus::cli {
namespace {

constexpr int kWidth = 30;  ///< of a bar [characters]

std::string bar(double share) {
  const auto filled = static_cast<std::size_t>(std::lround(kWidth * std::clamp(share, 0.0, 1.0)));
  return fmt::format("[{:-<{}}]", std::string(filled, '#'), kWidth);
}

/// The line of work in stages, written anew every second until nobody holds it any more.
class StageLine {
 public:
  explicit StageLine(std::vector<std::pair<std::string, double>> shares)
      : shares_(std::move(shares)), clock_([this] { tick(); }) {}
  ~StageLine() {
    {
      const std::lock_guard lock(mutex_);
      done_ = true;
    }
    wake_.notify_all();
    clock_.join();
  }
  StageLine(const StageLine&) = delete;
  StageLine& operator=(const StageLine&) = delete;

  void begin(const std::string& stage) {
    const std::lock_guard lock(mutex_);
    for (const auto& [name, share] : shares_)
      if (name == stage) behind_ = std::max(behind_, share);  // stages may come again
    stage_ = stage;
    began_ = Clock::now();
    show();
  }

 private:
  using Clock = std::chrono::steady_clock;

  void tick() {
    constexpr std::chrono::seconds kPeriod{1};  // what is shown counts in seconds
    std::unique_lock lock(mutex_);
    while (!wake_.wait_for(lock, kPeriod, [this] { return done_; }))
      if (!stage_.empty()) show();
  }

  void show() const {
    const auto since = [now = Clock::now()](Clock::time_point start) {
      return std::chrono::duration<double>(now - start).count();
    };
    const double all = since(start_);
    constexpr double kEnough = 0.2;  // of the work, before which a guess of the rest misleads
    const std::string left =
        behind_ > kEnough
            ? fmt::format(", about {} to go", duration(all * (1.0 - behind_) / behind_))
            : "";
    fmt::print(stderr, "\r\x1b[K{} {}  {}, {} in all{}", bar(behind_), stage_,
               duration(since(began_)), duration(all), left);
    std::fflush(stderr);
  }

  std::vector<std::pair<std::string, double>> shares_;  ///< that lie behind, by stage
  std::string stage_;
  double behind_ = 0.0;
  Clock::time_point start_ = Clock::now(), began_ = start_;
  bool done_ = false;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::thread clock_;  ///< last: it reads the others
};

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
  return [line = std::make_shared<StageLine>(shares)](const std::string& stage) {
    line->begin(stage);
  };
}

void clear_progress(const Common& common) {
  if (!shows_progress(common)) return;
  fmt::print(stderr, "\r\x1b[K");
  std::fflush(stderr);
}

}  // namespace jaculus::cli
