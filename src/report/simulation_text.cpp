// What `jaculus simulate` prints.

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "jaculus/report/dataset_report.h"
#include "report/document/text_table.h"

namespace jaculus::report {
namespace {

using Json = nlohmann::ordered_json;

/// Which of the recipe's starts lie before the command's, by more than clocks are off: noise was
/// taken for motion, and what follows from it means nothing.
std::string mistaken_starts(const Json& trials) {
  constexpr double kBefore = -0.02;  // [s]; streams are some 10 ms off, by whole samples at 120 Hz
  std::string names;
  for (const Json& trial : trials) {
    const Json& recipe = trial["leap"]["recipe"];
    if (!recipe.is_object() || !recipe["start_s"].is_number() ||
        recipe["start_s"].get<double>() > kBefore)
      continue;
    names += (names.empty() ? "" : ", ") + trial["name"].get<std::string>();
  }
  return names.empty() ? "" : "the recipe took noise for the start of " + names + "\n";
}

std::string leap_text(const Json& trials) {
  TextTable table({"trial", "start [s]", "recipe v/T", "bias", "without noise", "bias",
                   "v/T at plan end", "lift-off [s]", "v at lift-off", "landing pitch"});

  for (const Json& trial : trials) {
    const Json& leap = trial["leap"];
    const auto at = [&](const char* part, const char* key) {
      return leap[part].is_object() ? leap[part][key] : Json(nullptr);
    };
    table.row({trial["name"].get<std::string>(), json_cell(at("recipe", "start_s"), "{:.4f}"),
               json_cell(at("recipe", "acceleration_m_s2")),
               json_cell(at("recipe", "bias_m_s2"), "{:+.3f}"),
               json_cell(at("recipe_without_noise", "acceleration_m_s2")),
               json_cell(at("recipe_without_noise", "bias_m_s2"), "{:+.3f}"),
               json_cell(at("plan_end", "acceleration_m_s2")),
               json_cell(at("lift_off", "time_s"), "{:.4f}"),
               json_cell(at("lift_off", "speed_m_s")),
               json_cell(at("plan_end", "landing_pitch_rad"))});
  }

  return table.text() +
         "recipe: the authors' way from motion capture to v/T [m/s^2], with its bias against the "
         "simulated state at "
         "the plan's end\n" +
         mistaken_starts(trials);
}

bool any_left_the_ground(const Json& trials) {
  return std::any_of(trials.begin(), trials.end(), [](const Json& trial) {
    return trial.contains("leap") && trial["leap"]["lift_off"].is_object();
  });
}

std::string trials_text(const Json& trials) {
  TextTable table({"trial", "status", "end [s]", "stream", "samples", "gaps", "events"});
  for (const Json& trial : trials) {
    bool first = true;
    for (const Json& stream : trial["streams"]) {
      table.row({first ? trial["name"].get<std::string>() : "",
                 first ? trial["status"].get<std::string>() : "",
                 first ? json_cell(trial["end_time_s"]) : "", stream["name"].get<std::string>(),
                 stream["samples"].dump(), stream["gaps"].dump(),
                 first ? fmt::format("{}", trial["events"].size()) : ""});
      first = false;
    }
    if (first)
      table.row({trial["name"].get<std::string>(), trial["status"].get<std::string>(),
                 json_cell(trial["end_time_s"]), "-", "0", "0", "0"});
  }
  return table.text();
}

/// One line for each joint that leaves its range, of the trial where it goes furthest.
std::string ranges_text(const Json& trials) {
  std::map<std::string, std::pair<Json, std::string>> furthest;
  for (const Json& trial : trials)
    for (const Json& left : trial.value("ranges_left", Json::array())) {
      auto& own = furthest[left["joint"].get<std::string>()];
      if (own.first.is_null() || own.first["beyond"] < left["beyond"])
        own = {left, trial["name"].get<std::string>()};
    }

  std::string text;
  for (const auto& [joint, own] : furthest)
    text += fmt::format(
        "note: {} leaves its range of {} to {} {} by {} from {} s on ({}); the file's ranges are "
        "no stops, `stops:` of the experiment are\n",
        joint, json_cell(own.first["range"][0], "{:.4g}"),
        json_cell(own.first["range"][1], "{:.4g}"), own.first["unit"].get<std::string>(),
        json_cell(own.first["beyond"], "{:.3g}"), json_cell(own.first["time_s"], "{:.3g}"),
        own.second);
  return text;
}

/// One line for the motors that were told more than their limits let them give, with the trial
/// where each was first.
std::string limits_text(const Json& trials) {
  std::map<std::string, std::pair<double, std::string>> motors;
  for (const Json& trial : trials)
    for (const Json& event : trial["events"]) {
      if (event["kind"] != "limit") continue;
      const std::pair one{event["time_s"].get<double>(), trial["name"].get<std::string>()};
      auto& first = motors.try_emplace(event["what"].get<std::string>(), one).first->second;
      first = std::min(first, one);
    }

  std::string text;
  for (const auto& [joint, own] : motors)
    text += fmt::format("{}{} at {:.3g} s of {}", text.empty() ? "" : ", ", joint, own.first,
                        own.second);
  return text.empty()
             ? ""
             : "note: commands beyond what a motor's limits let it give, first: " + text + "\n";
}

}  // namespace

std::string simulation_text(const simulation::Experiment& experiment, const Json& summary) {
  const trajectory::StatedController& c = experiment.setup.controller;
  std::string text =
      fmt::format("{}: {} on {}, {} controller ({}) at {} Hz, effects: {}\n", experiment.name,
                  name_of(experiment.setup.experiment), experiment.setup.robot, name_of(c.kind),
                  name_of(c.quantity), c.rate_hz, summary["effects"].get<std::string>());
  for (const std::string& note : experiment.setup.notes) text += "note: " + note + "\n";
  text += trials_text(summary["trials"]);
  text += ranges_text(summary["trials"]);
  text += limits_text(summary["trials"]);

  for (const Json& trial : summary["trials"])
    if (trial.contains("message"))
      text += fmt::format("{}: {}\n", trial["name"].get<std::string>(),
                          trial["message"].get<std::string>());
  if (experiment.setup.experiment == trajectory::ExperimentKind::leap)
    text += any_left_the_ground(summary["trials"])
                ? "\n" + leap_text(summary["trials"])
                : "\nno trial left the ground: there are no figures of a leap\n";
  return text;
}

}  // namespace jaculus::report
