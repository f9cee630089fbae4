// Reads a problem file over the files that it extends.

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "jaculus/core/installation.h"
#include "jaculus/transcription/robot_size.h"
#include "transcription/problem_keys.h"
#include "transcription/problem_read.h"

namespace jaculus::transcription {
namespace {

using problem_read::at_place;
using problem_read::came_later;
using yaml::Node;

/// The files that led here, outermost first, each with the node that names the next.
struct Step {
  std::filesystem::path file;
  Node extends;
};

struct Section {
  std::string_view key;
  void (*read)(Problem&, const Node&);
};

constexpr Section kSections[] = {
    {"robot", problem_read::robot},
    {"override", problem_read::overrides},
    {"lock", problem_read::locks},
    {"limits", problem_read::limits},
    {"bounds", problem_read::bounds},
    {"phases", problem_read::phases},
    {"initial", problem_read::initial},
    {"final", problem_read::final},
    {"constraints", problem_read::constraints},
    {"objective", problem_read::objective},
    {"transcription", problem_read::transcription},
    {"guess", problem_read::guess},
    {"solver", problem_read::solver},
    {"refinement", problem_read::refinement},
    {"reference", problem_read::reference},
};

std::string checked_name(const Node& node) {
  const std::string name = node.text();
  const auto valid = [](unsigned char c) { return std::isalnum(c) != 0 || c == '_' || c == '-'; };
  if (!std::all_of(name.begin(), name.end(), valid)) {
    throw node.error(fmt::format(
        "'{}' given; allowed: letters, digits, _ and -, since it names a folder", name));
  }
  return name;
}

/// The file that `extends` names: beside this one, or among the problems that come with jaculus.
std::filesystem::path base_file(const Node& extends) {
  namespace fs = std::filesystem;
  const fs::path given = extends.text();
  const fs::path beside =
      (given.is_relative() ? extends.file().parent_path() / given : given).lexically_normal();
  if (fs::is_regular_file(beside)) return beside;
  for (const fs::path& folder : data_folders()) {
    const fs::path shipped = folder / "problems" / given;
    if (given.is_relative() && fs::is_regular_file(shipped)) return shipped.lexically_normal();
  }
  throw extends.error(
      fmt::format("file '{}' not found; allowed: a problem file, relative to this one, or one that "
                  "comes with jaculus, as leap_template.yaml",
                  beside.string()));
}

/// The robot that a file, or the nearest one that it extends, names; empty where none does.
std::filesystem::path robot_of(Node node) {
  constexpr int kMost = 100;  // files; a chain that leads back is told by base_of()
  for (int k = 0; k < kMost; ++k) {
    if (const auto robot = node.find("robot"))
      return model::find_robot(robot->text(), robot->file());
    const auto extends = node.find("extends");
    if (!extends) break;
    node = Node::load(base_file(*extends));
  }
  return {};
}

/// Units of the robot's size, read when one is asked for. The robot is that of the outermost file.
std::shared_ptr<const OwnUnits> units_of_robot(const Node& outermost) {
  const auto units = std::make_shared<std::vector<OwnUnit>>();
  return std::make_shared<const OwnUnits>([outermost, units]() -> const std::vector<OwnUnit>& {
    if (!units->empty()) return *units;
    const std::filesystem::path folder = robot_of(outermost);
    if (!folder.empty()) *units = robot_units(robot_size(model::read_robot(folder)));
    return *units;
  });
}

Problem read_file(const Node& node, std::vector<Step>& steps,
                  const std::shared_ptr<const OwnUnits>& units);

Problem base_of(const Node& node, std::vector<Step>& steps,
                const std::shared_ptr<const OwnUnits>& units) {
  const auto extends = node.find("extends");
  if (!extends) return {};
  const std::filesystem::path file = base_file(*extends);

  steps.push_back({std::filesystem::weakly_canonical(node.file()), *extends});
  const auto canonical = std::filesystem::weakly_canonical(file);
  for (const Step& step : steps) {
    if (step.file != canonical) continue;
    throw extends->error(fmt::format(
        "leads back to '{}', which extends '{}' at {}:{}; allowed: files that don't extend "
        "themselves",
        file.string(), step.extends.text(), step.extends.file().string(), step.extends.line()));
  }

  return read_file(Node::load(file), steps, units);
}

/// One file over what it extends. Requirements that a base may leave open are checked by finish().
Problem read_file(const Node& plain, std::vector<Step>& steps,
                  const std::shared_ptr<const OwnUnits>& units) {
  const Node node = plain.with_units(units);
  if (!node.is_map())
    throw node.error("not a map; allowed: a problem file, `format: jaculus-problem/1` first");
  yaml::refuse_other_kind(node, "jaculus-problem/1");
  node.only(problem_keys::names(problem_keys::of("")));
  static_cast<void>(node.at("format").choice({"jaculus-problem/1"}));
  Problem problem = base_of(node, steps, units);
  problem.name = checked_name(node.at("name"));
  const auto caption = node.find("caption");
  problem.caption = caption ? caption->text() : "";
  problem.file = node.file();
  problem.node = node;
  for (const Section& section : kSections) {
    if (const auto value = node.find(section.key)) section.read(problem, *value);
  }
  return problem;
}

std::string show(const Bounds& b) {
  return b.fixed() ? fmt::format("{:g}", b.lower) : fmt::format("[{:g}, {:g}]", b.lower, b.upper);
}

/// The values of a locked coordinate must agree with the lock; then they say nothing and go.
void apply_lock(std::map<std::string, Bounds>& values, const Problem& problem,
                const std::string& prefix, const std::string& name, double locked) {
  const auto found = values.find(name);
  if (found == values.end()) return;
  constexpr double kRounding = 1e-9;
  if (!Bounds{found->second.lower - kRounding, found->second.upper + kRounding}.contains(locked)) {
    const Node& value = problem_read::place_of(problem, prefix + name);
    const Node& lock = problem.places.at("lock." + name);
    if (came_later(problem, lock, value))
      throw lock.error(fmt::format("{:g} contradicts {}{}: {} ({}); allowed: a value within that",
                                   locked, prefix, name, show(found->second), at_place(value)));
    throw value.error(
        fmt::format("{0} contradicts lock.{1}; allowed: {2:g}, where the lock holds it",
                    show(found->second), name, locked));
  }
  values.erase(found);
}

void apply_locks(Problem& problem) {
  for (const auto& [name, value] : problem.locks) {
    apply_lock(problem.position_bounds, problem, "bounds.position.", name, value);
    apply_lock(problem.velocity_bounds, problem, "bounds.velocity.", name, 0.0);
    apply_lock(problem.initial.position, problem, "initial.position.", name, value);
    apply_lock(problem.initial.velocity, problem, "initial.velocity.", name, 0.0);
    apply_lock(problem.final.position, problem, "final.position.", name, value);
    apply_lock(problem.final.velocity, problem, "final.velocity.", name, 0.0);
    problem.guess.pose.erase(name);
    for (auto& pose : problem.guess.poses) pose.erase(name);
  }
}

/// Ends of the plan that the bounds of the whole plan forbid.
void check_ends(const Problem& problem, const std::map<std::string, Bounds>& values,
                const std::map<std::string, Bounds>& whole, const std::string& prefix,
                const std::string& where) {
  for (const auto& [name, bounds] : values) {
    const auto all = whole.find(name);
    if (all == whole.end()) continue;
    if (bounds.lower <= all->second.upper && bounds.upper >= all->second.lower) continue;
    const Node& value = problem_read::place_of(problem, prefix + name);
    const Node& bound = problem_read::place_of(problem, fmt::format("bounds.{}.{}", where, name));
    if (came_later(problem, bound, value))
      throw bound.error(fmt::format("{} leaves out {}{}: {} ({}); allowed: bounds that hold it",
                                    show(all->second), prefix, name, show(bounds),
                                    at_place(value)));
    throw value.error(fmt::format("{} lies outside bounds.{}.{}; allowed: within {}", show(bounds),
                                  where, name, show(all->second)));
  }
}

void check_rest(const Problem& problem, const BoundarySpec& spec, const std::string& prefix) {
  if (!spec.at_rest) return;
  for (const auto& [name, bounds] : spec.velocity) {
    if (bounds.contains(0.0)) continue;
    const Node& value = problem_read::place_of(problem, prefix + name);
    const auto rest = spec.node.find("at_rest");
    if (rest && came_later(problem, *rest, value))
      throw rest->error(fmt::format("true contradicts {}{}: {} ({}); allowed: false, or 0 there",
                                    prefix, name, show(bounds), at_place(value)));
    throw value.error(fmt::format("{} contradicts at_rest: true; allowed: 0", show(bounds)));
  }
}

/// Phases that terms name.
void check_phase_names(const Problem& problem) {
  std::vector<std::string> phases;
  for (const PhaseSpec& phase : problem.phases) phases.push_back(phase.name);

  for (const auto* terms : {&problem.constraints, &problem.objective}) {
    for (const TermSpec& term : *terms) {
      try {
        term.values.check_names(key::Of::phase, phases);
      } catch (const InputError& error) {
        const Node& first = problem.phases.front().node;
        if (!came_later(problem, first, term.node)) throw;
        throw first.error(fmt::format("other phases than those of the file it extends, and {}: {}",
                                      at_place(term.node), error.fault()));
      }
    }
  }
}

/// Durations of the guess, one a phase and within its bounds.
void check_durations(const Problem& problem) {
  const std::vector<double>& durations = problem.guess.durations;
  if (durations.empty()) return;
  const Node node = problem.guess.node.at("durations");
  if (durations.size() != problem.phases.size()) {
    const Node& phase = problem.phases.front().node;
    if (came_later(problem, phase, node))
      throw phase.error(fmt::format(
          "{} in all; allowed: as many phases as the guess has durations: {} ({}), or a "
          "guess of this file's own",
          problem.phases.size(), durations.size(), at_place(node)));
    throw node.error(
        fmt::format("{} given; allowed: {}, one a phase", durations.size(), problem.phases.size()));
  }

  for (int i = 0; i < count_of(durations); ++i) {
    const Bounds& allowed = problem.phases[i].duration;
    if (allowed.contains(durations[i])) continue;
    const Node phase = problem.phases[i].node.at("duration");
    if (came_later(problem, phase, node))
      throw phase.error(
          fmt::format("{} s leaves out the guess's {:g} s ({}); allowed: bounds that "
                      "hold it, or a guess of this file's own",
                      show(allowed), durations[i], at_place(node)));
    throw node.error(
        fmt::format("{:g} s given for phase '{}'; allowed: {} s, the bounds of its duration",
                    durations[i], problem.phases[i].name, show(allowed)));
  }
}

/// What can only be told once a file and all that it extends are read.
void finish(Problem& problem, const TermCatalogue& catalogue) {
  // A key that no file of the chain gave is an error of the outermost file, at() says which.
  if (problem.robot.empty()) static_cast<void>(problem.node.at("robot"));
  if (problem.phases.empty()) static_cast<void>(problem.node.at("phases"));
  if (problem.objective.empty()) static_cast<void>(problem.node.at("objective"));

  problem_read::apply_robot_words(problem);
  apply_locks(problem);
  const auto &positions = problem.position_bounds, &velocities = problem.velocity_bounds;
  check_ends(problem, problem.initial.position, positions, "initial.position.", "position");
  check_ends(problem, problem.initial.velocity, velocities, "initial.velocity.", "velocity");
  check_ends(problem, problem.final.position, positions, "final.position.", "position");
  check_ends(problem, problem.final.velocity, velocities, "final.velocity.", "velocity");
  check_rest(problem, problem.initial, "initial.velocity.");
  check_rest(problem, problem.final, "final.velocity.");

  problem_read::declare_terms(problem, catalogue);
  check_phase_names(problem);
  check_durations(problem);
}

}  // namespace

Problem read_problem(const yaml::Node& node, const TermCatalogue& catalogue) {
  std::vector<Step> steps;
  Problem problem = read_file(node, steps, units_of_robot(node));
  finish(problem, catalogue);
  return problem;
}

Problem read_problem(const std::filesystem::path& file, const TermCatalogue& catalogue) {
  return read_problem(yaml::Node::load(file), catalogue);
}

}  // namespace jaculus::transcription
