#include "transcription/problem_keys.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>

namespace jaculus::transcription::problem_keys {

namespace {

namespace dim = dimension;
using key::Other;

const key::Absent kNone = {.words = "none"};
const key::Absent kRobots = {.words = "the robot's"};
const key::Absent kFree = {.words = "free"};
const key::Absent kMiddle = {.words = "middle of bounds"};
const key::Absent kItsType = {.words = "its type"};

std::vector<Key> file_keys() {
  return {
      {"format", Other{}, "jaculus-problem/1"},
      {"extends", Other{},
       "a problem file (relative to this one, or one of jaculus's) to start from: maps are merged "
       "key by key, a null "
       "(~) drops a key, constraints and costs replace those of the same name, other lists "
       "replace the base's",
       kNone},
      {"name", Other{},
       "short name for tables and folders: letters, digits, _ and -; never inherited"},
      {"caption", Other{}, "one line for people; never inherited", {.words = "empty"}},
      {"robot", Other{},
       "a folder with robot.urdf and robot.yaml, relative to this file, or a name under models/"},
      {"override", Other{},
       "model values by path, {tail.drag.coefficient: 2.0}, or a motor anew, {motors.tail: {kind: "
       "ideal}}; `jaculus check ROBOT` lists the paths",
       kNone},
      {"lock", Other{"rad or m"},
       "coordinates held fixed, {tail: -90 deg}; the motor there does nothing", kNone},

      {"limits", Other{}, "what a plan may use of the robot", {.words = "the robot's own"}},
      {"bounds",
       Other{},
       "of coordinates over the whole plan; also the scale of each and the middle for guesses",
       {.words = "the robot's ranges"}},
      {"phases", Other{}, "the contact schedule, in order"},
      {"initial", Other{}, "state at the start", kFree},
      {"final", Other{}, "state at the end", kFree},
      {"constraints", Other{},
       "a list of {type: ..., ...}; dynamics, stance, loop closure and impacts are implied", kNone},
      {"objective", Other{}, "a weighted sum of costs"},
      {"transcription", Other{}, "how the plan is cut into intervals", {.words = "see there"}},
      {"guess", Other{}, "where the solver starts", {.words = "see there"}},
      {"solver", Other{}, "tolerance, iterations, starts", {.words = "see there"}},
      {"refinement", Other{},
       "splitting of intervals where the local error is large or a limit is passed", kNone},
      {"reference", Other{}, "published figures to print beside the result", kNone},
  };
}

std::vector<Section> plan_sections() {
  const Key at_rest = {"at_rest", key::Flag{}, "all velocities zero", {.value = "false"}};
  const Key pose = {
      "pose", Other{},
      "rest (rest_pose of robot.yaml) or stretched (feet below their legs, these at 92 "
      "%): values of coordinates that `position` doesn't name",
      kNone};
  const Key legs = {
      "legs_at_rest", Other{},
      "feet whose legs don't move against the body: zero rates of the coordinates that "
      "move them",
      kNone};
  return {
      {"bounds",
       {{"position", Other{"rad or m"}, "[lower, upper] by coordinate", kRobots},
        {"velocity", Other{"rad/s or m/s"}, "[lower, upper] by coordinate", kNone}}},
      {"phases[]",
       {{"name", Other{}, "unique in the file"},
        {"contacts", Other{}, "feet on the ground; [] is flight"},
        {"intervals", key::Integer{1, 10000}, "collocation intervals, 1 to 10000"},
        {"duration", key::Interval{dim::time},
         "[lower, upper], or one number where it is fixed; positive"},
        {"mesh", Other{"-"}, "relative lengths of the intervals, one each", {.words = "uniform"}}}},

      {"initial",
       {at_rest,
        pose,
        legs,
        {"position", Other{"rad or m"}, "by coordinate or joint: a number, or [lower, upper]",
         kFree},
        {"velocity", Other{"rad/s or m/s"}, "by coordinate or joint: a number, or [lower, upper]",
         kFree}}},
      {"final",
       {at_rest,
        pose,
        legs,
        {"position", Other{"rad or m"}, "as for initial", kFree},
        {"velocity", Other{"rad/s or m/s"}, "as for initial", kFree}}},
      {"objective",
       {{"maximise", Other{}, "a list of costs that shall be large", kNone},
        {"minimise", Other{},
         "a list of costs that shall be small; beside `maximise` they are subtracted", kNone}}},
  };
}

Section guess_section() {
  return {"guess",
          {{"kind",
            key::Choice{{"static", "middle", "random", "line", "file"}},
            "static (a standing posture), middle (of the bounds), random (smooth), line (between "
            "poses), file",
            {.value = "static"}},
           {"file",
            Other{},
            "solution.json of an earlier solve, relative to this file",
            {.words = "required for file"}},
           {"poses",
            Other{"rad or m"},
            "two or more poses, {coordinate or joint: value}, along the plan; `pose: rest` or "
            "`pose: stretched` among them as for initial",
            {.words = "required for line"}},
           {"pose", Other{"rad or m"}, "values of a static posture", kMiddle},
           {"durations", Other{"s"}, "of the phases, one each", kMiddle}}};
}

/// Keys of summary.json, and what hardware did.
Section reference_section() {
  const auto figure = [](const char* name, const Dimension& dimension, const char* meaning) {
    return Key{name, key::Number{dimension}, meaning, kNone};
  };
  return {
      "reference",
      {figure("average_acceleration_m_s2", dim::acceleration,
              "v_x of the base at the end over the duration, as planned"),
       figure("average_acceleration_com_m_s2", dim::acceleration, "the same of the centre of mass"),
       figure("measured_acceleration_m_s2", dim::acceleration, "on hardware"),
       figure("measured_duration_s", dim::time, "published beside it"),
       figure("duration_s", dim::time, "of the whole plan"),
       figure("first_phase_s", dim::time, "of the first phase"),
       figure("liftoff_velocity_m_s", dim::velocity, "v_x of the base at the end"),
       figure("tail_momentum_share", dim::none, "share of the forward momentum that drag gave"),
       figure("objective", dim::none, "value of the objective")}};
}

std::vector<Section> term_list_sections() {
  const Key type = {"type", Other{}, "one of those below"};
  const Key name = {"name", Other{}, "unique; only needed where a type occurs twice", kItsType};
  const Key weight = {"weight", key::Number{}, "positive", {.value = "1"}};
  return {{"constraints[]", {type, name}}, {"objective.*[]", {type, name, weight}}};
}

/// Every section but those of the terms.
const std::vector<Section>& own_sections() {
  static const std::vector<Section> all = [] {
    std::vector<Section> list = {{"", file_keys()}, {"limits", limits()}};
    for (Section& section : plan_sections()) list.push_back(std::move(section));
    list.push_back({"transcription", problem_keys::transcription()});
    list.push_back(guess_section());
    list.push_back({"solver", solver()});
    list.push_back({"refinement", refinement()});
    list.push_back(reference_section());
    for (Section& section : term_list_sections()) list.push_back(std::move(section));
    return list;
  }();
  return all;
}

}  // namespace

const std::vector<Key>& of(std::string_view section) {
  const auto same = [&](const Section& s) { return s.name == section; };
  const auto found = std::find_if(own_sections().begin(), own_sections().end(), same);
  assert(found != own_sections().end());
  return found->keys;
}

std::vector<std::string> names(const std::vector<Key>& keys) {
  std::vector<std::string> result;
  for (const Key& key : keys) result.push_back(key.name);
  return result;
}

std::vector<Section> sections(const TermCatalogue& catalogue) {
  std::vector<Section> all;
  for (const Section& section : own_sections()) {
    all.push_back(section);
    const bool costs = section.name == "objective.*[]";
    if (!costs && section.name != "constraints[]") continue;
    for (const TermType& type : catalogue) {
      if (type.cost != costs) continue;
      all.push_back({fmt::format("{}: {}", costs ? "objective" : "constraints", type.name),
                     type.keys, type.meaning, type.in_file()});
    }
  }
  return all;
}

}  // namespace jaculus::transcription::problem_keys
