// jaculus: the command line. Parsing and exit codes; each command is in the file of its name.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include "cli/plan.h"
#include "jaculus/core/error.h"
#include "jaculus/core/installation.h"
#include "jaculus/core/interrupt.h"
#include "jaculus/core/yaml.h"

namespace jaculus::cli {
namespace {

std::vector<std::string> command_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    names.push_back(command->get_name());
  }
  return names;
}

std::vector<std::string> flag_names(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

/// The parser's own messages name neither the nearest command nor the nearest flag.
std::string parse_message(const CLI::App& app, const CLI::ParseError& error,
                          const std::vector<std::string>& arguments) {
  const std::vector<std::string> commands = command_names(app);
  if (!arguments.empty() && !arguments[0].starts_with('-') && app.get_subcommands().empty()) {
    return fmt::format("unknown command '{}'{}; allowed: {}", arguments[0],
                       yaml::did_you_mean(arguments[0], commands), fmt::join(commands, ", "));
  }

  const CLI::App* deepest = &app;
  std::string called;  // "robot import", which has flags of its own
  while (!deepest->get_subcommands().empty()) {
    deepest = deepest->get_subcommands().front();
    called += (called.empty() ? "" : " ") + deepest->get_name();
  }
  if (called.empty()) called = app.get_name();
  const CLI::App& command = *deepest;
  const std::vector<std::string> flags = flag_names(command);
  for (const std::string& argument : arguments) {
    const std::string flag = argument.substr(0, argument.find('='));
    if (!flag.starts_with("--") || std::find(flags.begin(), flags.end(), flag) != flags.end())
      continue;
    return fmt::format("{}: unknown flag '{}'{}; allowed: {}", called, flag,
                       yaml::did_you_mean(flag, flags), fmt::join(flags, ", "));
  }

  if (&command == &app)
    return fmt::format("no command given; allowed: {}", fmt::join(commands, ", "));
  const std::string what = error.what();
  const bool complete = what.find("allowed:") != std::string::npos;
  return fmt::format("{}: {}{}", called, what,
                     complete ? "" : fmt::format("; allowed: see jaculus {} --help", called));
}

int run(int argc, char** argv) {
  CLI::App app("Trajectory optimisation of planar legged robots with drag tails.", "jaculus");
  app.footer(
      "Exit codes: 0 done, 1 not solved or not converged, 2 bad input.\n"
      "Example:\n  jaculus compare problems/leap_tailless.yaml problems/leap_tail.yaml --out "
      "leaps");
  app.set_version_flag("--version", std::string(version()));
  app.require_subcommand(1);
  Action chosen;
  add_check(app, chosen);
  add_solve(app, chosen);
  add_compare(app, chosen);
  add_export(app, chosen);
  add_study(app, chosen);
  add_view(app, chosen);
  add_simulate(app, chosen);
  add_import(app, chosen);
  add_robot(app, chosen);
  add_diagnose(app, chosen);
  add_preflight(app, chosen);
  add_testbed(app, chosen);
  add_evaluate(app, chosen);
  add_jobs(app, chosen);

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help and --version
    const std::vector<std::string> arguments(argv + 1, argv + argc);
    fmt::print(stderr, "jaculus: {}\n", parse_message(app, error, arguments));
    return kBadInput;
  }

  return chosen();
}

}  // namespace
}  // namespace jaculus::cli

int main(int argc, char** argv) {
  try {
    jaculus::install_interrupt_handler();
    return jaculus::cli::run(argc, argv);
  } catch (const jaculus::WorkerDone& done) {
    return done.complete ? jaculus::cli::kDone : jaculus::cli::kNotSolved;
  } catch (const jaculus::InputError& error) {
    fmt::print(stderr, "jaculus: {}\n", error.what());
    return jaculus::cli::kBadInput;
  } catch (const std::exception& error) {
    fmt::print(stderr, "jaculus: internal error: {}\n", error.what());
    return jaculus::cli::kNotSolved;
  }
}
