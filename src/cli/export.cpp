// jaculus export: joint torque trajectories for robots.

#include "jaculus/export/export.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "cli/command.h"
#include "jaculus/core/error.h"
#include "jaculus/core/units.h"
#include "jaculus/model/robot.h"
#include "jaculus/trajectory/csv.h"

namespace jaculus::cli {
namespace {

using Json = nlohmann::ordered_json;
using transcription::input_holds;

struct ExportOptions {
  Common common;
  std::string solution;
  std::string format;
  std::string rate = "1000";
  std::string side = exporting::name_of(exporting::Side::joint);
  std::string hold;   ///< empty where not given
  std::string robot;  ///< empty where not given
  bool even_unsolved = false;
};

double parse_rate(const std::string& text) {
  constexpr double kLowest = 1.0, kHighest = 1e6;
  double rate = 0.0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), rate);
  if (code != std::errc() || end != text.data() + text.size()) {
    try {
      rate = parse_quantity(text, dimension::frequency);
    } catch (const InputError& error) {
      throw InputError(fmt::format("--rate: {}", error.what()));
    }
  }
  if (!(rate >= kLowest && rate <= kHighest)) {
    throw InputError(
        fmt::format("--rate: {} given; allowed: {:g} to {:g} Hz", text, kLowest, kHighest));
  }
  return rate;
}

std::vector<std::string> format_names() {
  std::vector<std::string> names;
  for (const exporting::Format& format : exporting::formats()) names.push_back(format.name);
  return names;
}

std::string text_of(const exporting::Export& plan, const std::string& format) {
  for (const exporting::Format& known : exporting::formats())
    if (known.name == format) return known.write(plan);
  throw std::logic_error("a format that the command line does not allow");
}

/// What to mind, on standard error: standard output may hold the plan itself.
bool report(const ExportOptions& options, const exporting::Source& source,
            const exporting::Export& plan) {
  bool exceeded = false;
  for (const exporting::LimitCheck& check : plan.checks) {
    if (!check.exceeded) continue;
    exceeded = true;
    fmt::print(stderr,
               "jaculus: limit exceeded after resampling at {:g} Hz: {} {} {:.4g} {} of {:.4g} at "
               "{:.4g} s\n",
               plan.rate, check.joint, name_of(check.quantity), check.peak, check.unit, check.limit,
               check.time);
  }

  if (options.common.quiet) return exceeded;
  if (!source.limits_known)
    fmt::print(stderr, "jaculus: no summary.json beside the plan, limits are not checked\n");
  if (!plan.file_joints_known) {
    fmt::print(stderr,
               "jaculus: joints have the plan's names: nothing says which of the robot's file they "
               "are (solve again, or --robot with a plan.csv alone)\n");
  }
  if (!source.converged)
    fmt::print(stderr, "jaculus: this plan is no solution, its solve did not converge\n");
  if (!source.verified) fmt::print(stderr, "jaculus: this plan failed its verification\n");

  return exceeded;
}

int run_export(const ExportOptions& options) {
  const double rate = parse_rate(options.rate);
  if (options.common.json && options.common.out.empty()) {
    throw InputError(
        "--json: given without --out; allowed: with --out FILE (the plan as JSON is --as json)");
  }
  if (std::filesystem::is_directory(options.common.out)) {
    throw InputError(fmt::format("--out {}: is a folder; allowed: a file", options.common.out));
  }

  std::optional<model::Robot> robot;
  if (!options.robot.empty())
    robot = model::read_robot(model::find_robot(options.robot, std::filesystem::current_path()));
  const exporting::Source source = exporting::read_source(
      options.solution, input_holds().find(options.hold), robot ? &robot->planar : nullptr);
  if (!source.converged && !options.even_unsolved) {
    throw InputError(fmt::format(
        "{}: its solve did not converge; allowed: a converged plan, or any with --even-unsolved",
        options.solution));
  }

  const exporting::Export plan =
      exporting::resample(source, rate, *exporting::sides().find(options.side));
  const std::string text = text_of(plan, options.format);
  if (options.common.out.empty()) {
    print(text);
  } else {
    trajectory::write_file(options.common.out, text);
  }

  const bool exceeded = report(options, source, plan);
  if (options.common.json) {
    const Json result = {{"file", options.common.out},
                         {"format", options.format},
                         {"samples", plan.time.size()},
                         {"rate_hz", plan.rate},
                         {"side", options.side},
                         {"plan_hold", name_of(plan.plan_hold)},
                         {"limits_checked", !plan.checks.empty()},
                         {"limits", exporting::checks_json(plan)}};
    print(result.dump(1) + "\n");
  } else if (!options.common.quiet && !options.common.out.empty()) {
    print(fmt::format("{}: {} samples at {:g} Hz, {} side, {} joints\n", options.common.out,
                      plan.time.size(), plan.rate, options.side, played_joints(plan).size()));
  }
  return exceeded || !source.converged ? kNotSolved : kDone;
}

}  // namespace

void add_export(CLI::App& app, Action& chosen) {
  auto options = std::make_shared<ExportOptions>();
  CLI::App* command =
      app.add_subcommand("export", "Writes the joint torque trajectories of a plan for a robot.");
  command->footer(
      "Exit code 1 where a limit is exceeded after resampling (the file is written, and says so).\n"
      "Example:\n  jaculus export leap --as joint_trajectory --rate 1000 --out leap.yaml");
  command
      ->add_option("solution", options->solution,
                   "folder of a solve, its plan.csv or its solution.json")
      ->required();

  command
      ->add_option("--as", options->format,
                   "csv, json, joint_trajectory (ROS) or c (header with arrays)")
      ->required()
      ->check(one_of(format_names()));
  command->add_option("--rate", options->rate, "samples a second [Hz], 1000 unless given");
  command
      ->add_option("--side", options->side,
                   "joint (behind the gear, the default) or motor (before it)")
      ->check(one_of(exporting::sides().names()));
  command
      ->add_option("--hold", options->hold,
                   "held or linear: how torques of a lone plan.csv go on between samples")
      ->check(one_of(input_holds().names()));
  command->add_option("--robot", options->robot,
                      "of a lone plan.csv: whose joints are written out, and whose limits count");
  command->add_flag("--even-unsolved", options->even_unsolved,
                    "export a plan whose solve did not converge");
  command->add_option("--out", options->common.out, "file; standard output unless given");
  command->add_flag("--quiet", options->common.quiet, "print nothing but errors");
  command->add_flag("--json", options->common.json,
                    "result of the limit check on standard output (with --out)");
  command->callback([options, &chosen] { chosen = [options] { return run_export(*options); }; });
}

}  // namespace jaculus::cli
