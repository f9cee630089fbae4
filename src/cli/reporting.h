#pragma once
// What commands that compute share: the report and the figures beside their results, and the bar
// that shows how far they are.

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "cli/command.h"
#include "jaculus/core/tasks.h"
#include "jaculus/report/report.h"

namespace jaculus::cli {

/// Adds --figures to a command that writes a report.
void add_figures(CLI::App& command, Common& common);

/// InputError where --figures can't be met: without --out, without matplotlib. To be called before
/// the work.
void check_figures(const Common& common);

/// Writes report.html, and the figures where they are asked for, into --out (nothing where that is
/// not given), and prints where they lie unless --quiet or --json. The last thing that a command
/// prints.
void write_reporting(const report::Report& report, const Common& common);

/// "2 min 05 s"; "?" for what is not known.
std::string duration(double seconds);

/// Prints messages on standard error unless --quiet, for TaskOptions::notice and the like.
std::function<void(const std::string&)> notices(const Common& common);

/// A bar with the remaining time on standard error, for TaskOptions::progress and the like; empty
/// where `common` shows no progress.
std::function<void(const TaskProgress&)> progress_bar(const Common& common,
                                                      const std::string& what);

/// The same for work of named stages, called where one begins; the seconds of the present one and
/// of all go on until the last copy of the function is gone. `shares`: the part of the whole time
/// that usually lies behind at its beginning, by name; the remaining time is estimated from it,
/// another stage is only named.
std::function<void(const std::string&)> stage_bar(
    const Common& common, const std::vector<std::pair<std::string, double>>& shares);

/// Wipes what a bar or another line of progress left.
void clear_progress(const Common& common);

}  // namespace jaculus::cli
