#pragma once
// What all commands share: common flags, output, and how a command hangs into the program.

#include <CLI/CLI.hpp>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "jaculus/core/executor.h"
#include "jaculus/model/robot.h"
#include "jaculus/transcription/problem.h"

namespace jaculus::cli {

// Exit codes, see docs/commands.md.
inline constexpr int kDone = 0;
inline constexpr int kNotSolved = 1;
inline constexpr int kBadInput = 2;

/// Flags that every command has.
struct Common {
  std::string out;          ///< folder (or file, for export); empty where not given
  std::optional<int> seed;  ///< replaces the problem's
  int jobs = 1;
  bool quiet = false;
  bool json = false;
  std::string executor = "local";
  std::string slurm_options;      ///< of sbatch, a line
  std::optional<double> chunk_s;  ///< work of an element of an array [s]
  std::string figures;  ///< formats of static figures, "png,svg"; empty where not asked for
};

/// The action of the command that the user chose; set by parsing.
using Action = std::function<int()>;

/// A flag's value that must be one of `names`; the message names the nearest.
CLI::Validator one_of(const std::vector<std::string>& names);

CLI::Validator whole_number(int lower, int upper);

void add_common(CLI::App& command, Common& common, const std::string& out_help);

/// --executor and what belongs to it, for commands that repeat things.
void add_executor(CLI::App& command, Common& common);
/// The executor that was asked for, with its jobs in `folder`; null: here. InputError where the
/// flags don't belong together or there is no --out, which workers write into.
std::shared_ptr<const Executor> make_executor(const Common& common,
                                              const std::filesystem::path& folder);
/// Where the jobs of a command are that writes into `out`.
std::filesystem::path jobs_folder(const std::filesystem::path& out);

// One function a command, each in the file of its name.
void add_check(CLI::App& app, Action& chosen);
void add_export(CLI::App& app, Action& chosen);
void add_study(CLI::App& app, Action& chosen);
void add_view(CLI::App& app, Action& chosen);
void add_simulate(CLI::App& app, Action& chosen);
void add_import(CLI::App& app, Action& chosen);
void add_robot(CLI::App& app, Action& chosen);
void add_diagnose(CLI::App& app, Action& chosen);
void add_preflight(CLI::App& app, Action& chosen);
void add_testbed(CLI::App& app, Action& chosen);
void add_evaluate(CLI::App& app, Action& chosen);
void add_jobs(CLI::App& app, Action& chosen);

using Loaded = transcription::LoadedProblem;
/// What the command line changes of a problem.
struct ProblemChanges {
  std::string robot;                   ///< instead of the file's, relative to where one is
  std::vector<std::string> overrides;  ///< "PATH=VALUE", over the file's
};
/// `given` as find_problem_file() takes it.
Loaded load(const std::string& given, const Common& common, const ProblemChanges& changes = {});

/// Makes the folder and proves that files can be written into it; InputError otherwise.
void prepare_folder(const std::filesystem::path& folder);

/// Whether text on standard output may have colours: a terminal, and no NO_COLOR.
bool colours();
/// Whether progress is to be shown on standard error.
bool shows_progress(const Common& common);

/// Prints on standard output at once.
void print(const std::string& text);

}  // namespace jaculus::cli
