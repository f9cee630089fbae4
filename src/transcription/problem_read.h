#pragma once
// Readers of the sections of a problem file. Each starts from what `problem` already holds (from a
// file that this one extends) and changes what the node says; a null drops what the base said.

#include "jaculus/transcription/problem.h"

namespace jaculus::transcription::problem_read {

bool is_null(const yaml::Node& node);

/// Where a named value stands ("initial.position.x"); of one that a pose gave, its section.
const yaml::Node& place_of(const Problem& problem, const std::string& name);

/// Whether a contradiction of two values is told at the other one: it stands in the file that is
/// read, the value itself in one that this file extends.
bool came_later(const Problem& problem, const yaml::Node& other, const yaml::Node& value);

/// "base.yaml:7", for messages that name two places.
std::string at_place(const yaml::Node& node);

void robot(Problem& problem, const yaml::Node& node);
void overrides(Problem& problem, const yaml::Node& node);
void locks(Problem& problem, const yaml::Node& node);
void limits(Problem& problem, const yaml::Node& node);
void bounds(Problem& problem, const yaml::Node& node);
void phases(Problem& problem, const yaml::Node& node);
void initial(Problem& problem, const yaml::Node& node);
void final(Problem& problem, const yaml::Node& node);
void constraints(Problem& problem, const yaml::Node& node);
void objective(Problem& problem, const yaml::Node& node);
void transcription(Problem& problem, const yaml::Node& node);
void guess(Problem& problem, const yaml::Node& node);
void solver(Problem& problem, const yaml::Node& node);
void refinement(Problem& problem, const yaml::Node& node);
void reference(Problem& problem, const yaml::Node& node);

/// Writes out poses and legs at rest as values of coordinates; what is named wins.
void apply_robot_words(Problem& problem);

/// Finds the types of all terms in the catalogue and reads their keys. Unknown types, unknown keys
/// and bad values: InputError.
void declare_terms(Problem& problem, const TermCatalogue& catalogue);

}  // namespace jaculus::transcription::problem_read
