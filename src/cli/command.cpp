#include "cli/command.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <system_error>

#include "jaculus/core/error.h"
#include "jaculus/core/installation.h"
#include "jaculus/core/yaml.h"
#include "jaculus/trajectory/csv.h"

namespace jaculus::cli {

CLI::Validator one_of(const std::vector<std::string>& names) {
  const auto check = [names](std::string& given) -> std::string {
    if (std::find(names.begin(), names.end(), given) != names.end()) return {};
    return fmt::format("'{}' given{}; allowed: {}", given, yaml::did_you_mean(given, names),
                       fmt::join(names, ", "));
  };
  return CLI::Validator(check, fmt::format("{}", fmt::join(names, "|")), "one of");
}

CLI::Validator whole_number(int lower, int upper) {
  const auto check = [lower, upper](std::string& given) -> std::string {
    int value = 0;
    const auto [end, code] = std::from_chars(given.data(), given.data() + given.size(), value);
    if (code == std::errc() && end == given.data() + given.size() && value >= lower &&
        value <= upper)
      return {};
    return fmt::format("'{}' given; allowed: a whole number from {} to {}", given, lower, upper);
  };
  return CLI::Validator(check, fmt::format("{}..{}", lower, upper), "whole number");
}

void add_common(CLI::App& command, Common& common, const std::string& out_help) {
  command.add_option("--out", common.out, out_help);
  command.add_option("--seed", common.seed, "seed of everything random, instead of the problem's")
      ->check(whole_number(0, 2147483647));
  command.add_option("--jobs", common.jobs, "processes at a time")->check(whole_number(1, 1024));
  command.add_flag("--quiet", common.quiet, "print nothing but errors");
  command.add_flag("--json", common.json,
                   "machine-readable result on standard output, nothing else there");
}

namespace {

/// Stands for a file in messages about the lines that arguments are turned into.
const char* const kCommandLine = "command line";

/// A fault of an argument is told by the argument: neither by the line that stands for it nor by
/// the problem's file, whose words it gives a meaning.
InputError told_by_argument(const std::string& what, const ProblemChanges& changes) {
  const std::size_t place = what.find(std::string(kCommandLine) + ":");
  if (place == std::string::npos) {
    std::string given = changes.robot.empty() ? "" : "--robot " + changes.robot;
    for (const std::string& change : changes.overrides)
      given += fmt::format("{}--override {}", given.empty() ? "" : " ", change);
    return InputError(fmt::format("with {}: {}", given, what));
  }

  std::string fault = what.substr(what.find(": ", place) + 2);
  constexpr std::string_view kOverride = "override.";
  if (fault.starts_with(kOverride)) fault[kOverride.size() - 1] = ' ';
  return InputError("--" + fault);
}

/// A problem that extends the file by what the command line says.
yaml::Node changed(const std::filesystem::path& file, const ProblemChanges& changes) {
  const std::string name = yaml::Node::load(file).at("name").text();
  std::string text =
      fmt::format("format: jaculus-problem/1\nextends: {}\nname: {}\n",
                  yaml::quoted(std::filesystem::absolute(file).string()), yaml::quoted(name));
  if (!changes.robot.empty()) text += "robot: " + yaml::quoted(changes.robot) + "\n";
  if (!changes.overrides.empty()) text += "override:\n";
  for (const std::string& change : changes.overrides) {
    const std::size_t equals = change.find('=');
    if (equals == 0 || equals == std::string::npos || equals + 1 == change.size()) {
      throw InputError(fmt::format(
          "--override: '{}' given; allowed: PATH=VALUE, as in attach.tail.kind=none", change));
    }
    text += fmt::format("  {}: {}\n", yaml::quoted(change.substr(0, equals)),
                        change.substr(equals + 1));
  }
  return yaml::Node::parse(text, kCommandLine);
}

Loaded load_problem(const yaml::Node& node, const Common& common) {
  Loaded loaded = transcription::load_problem(node);
  if (common.seed) loaded.problem.solver.seed = *common.seed;
  return loaded;
}

}  // namespace

Loaded load(const std::string& given, const Common& common, const ProblemChanges& changes) {
  const std::filesystem::path file = find_problem_file(given);
  const bool as_it_is = changes.robot.empty() && changes.overrides.empty();
  if (as_it_is) return load_problem(yaml::Node::load(file), common);
  const yaml::Node node = changed(file, changes);
  try {
    if (!changes.robot.empty()) static_cast<void>(model::find_robot(changes.robot, "."));
  } catch (const InputError& error) {
    throw InputError(fmt::format("--robot: {}", error.what()));
  }
  try {
    return load_problem(node, common);
  } catch (const InputError& error) {
    throw told_by_argument(error.what(), changes);
  }
}

void prepare_folder(const std::filesystem::path& folder) {
  std::error_code code;
  if (std::filesystem::exists(folder, code) && !std::filesystem::is_directory(folder, code)) {
    throw InputError(fmt::format("--out {}: is a file; allowed: a folder", folder.string()));
  }
  std::filesystem::create_directories(folder, code);
  if (code) {
    throw InputError(
        fmt::format("--out {}: can't be made ({}); allowed: a folder that can be written",
                    folder.string(), code.message()));
  }
  if (::access(folder.c_str(), W_OK | X_OK) != 0) {
    throw InputError(fmt::format(
        "--out {}: can't be written; allowed: a folder that can be written", folder.string()));
  }
}

bool colours() {
  const char* off = std::getenv("NO_COLOR");
  return ::isatty(STDOUT_FILENO) == 1 && (off == nullptr || *off == '\0');
}

bool shows_progress(const Common& common) {
  // With --json a pipe may lead to a program that has the terminal for itself.
  struct stat out {};
  const bool pipe = ::fstat(STDOUT_FILENO, &out) == 0 && S_ISFIFO(out.st_mode);
  return !common.quiet && !(common.json && pipe) && ::isatty(STDERR_FILENO) == 1;
}

void print(const std::string& text) {
  std::fwrite(text.data(), 1, text.size(), stdout);
  std::fflush(stdout);
}

}  // namespace jaculus::cli
