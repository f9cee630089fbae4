// The help on problem files, from the declarations of their keys.

#include <fmt/format.h>

#include "jaculus/transcription/problem.h"
#include "transcription/problem_keys.h"

namespace jaculus::transcription {

namespace {

constexpr std::size_t kIndent = 37;

/// `text` in lines of at most 116 characters, those after the first indented.
std::string wrapped(const std::string& text) {
  constexpr std::size_t kWidth = 116;
  std::string result, rest = text;
  while (rest.size() > kWidth) {
    const std::size_t space = rest.rfind(' ', kWidth);
    if (space == std::string::npos || space <= kIndent) break;
    result += rest.substr(0, space) + "\n";
    rest = std::string(kIndent, ' ') + rest.substr(space + 1);
  }
  return result + rest + "\n";
}

std::string absent(const Key& key) {
  if (key.required()) return "required";
  return "else: " + (key.absent.value.empty() ? key.absent.words : key.absent.value);
}

std::string line(const Key& key) {
  const std::string unit = key.unit().empty() ? "" : fmt::format(" [{}]", key.unit());
  return wrapped(fmt::format("  {:<34} {} ({})", key.name + unit, key.meaning, absent(key)));
}

}  // namespace

std::string explain_problem(const TermCatalogue& catalogue) {
  std::string text =
      "A problem file (format jaculus-problem/1). Plain numbers are SI (rad, not degrees); a value "
      "may instead carry its\n"
      "unit: 7 V, 15 deg, 4 ms. Unknown keys, units of another dimension and values out of range "
      "are errors.\n"
      "Numbers may also be in units of the robot (as its files give it, overrides aside): "
      "leg_length [m], the longest leg\n"
      "stretched; standing_height [m], of the base over the feet in rest_pose; body_weight [N]; "
      "leg_time [s], sqrt(leg_length/g);\n"
      "floor_friction [-]. 0.5 leg_length/leg_time, 0.25 body_weight leg_length.\n";

  for (const problem_keys::Section& section : problem_keys::sections(catalogue)) {
    text += fmt::format("\n{}\n", section.name.empty() ? "the file" : section.name);
    if (!section.meaning.empty()) text += fmt::format("  {}\n", section.meaning);
    for (const Key& key : section.keys) text += line(key);
    if (!section.example.empty()) text += fmt::format("  example: {}\n", section.example);
  }
  return text;
}

}  // namespace jaculus::transcription
