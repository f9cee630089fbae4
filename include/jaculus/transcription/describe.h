#pragma once
// A problem as understood, every default spelt out: as JSON for files, as text for people.

#include <nlohmann/json.hpp>
#include <string>

#include "jaculus/core/names.h"
#include "jaculus/model/robot.h"
#include "jaculus/transcription/problem.h"

namespace jaculus::transcription {

/// "held", "linear".
const NameTable<InputHold>& input_holds();
const char* name_of(InputHold hold);

/// Every key of the problem with its value, SI.
nlohmann::ordered_json describe_problem(const Problem& problem);

/// The same for people, with sizes of the robot; what `jaculus check` prints.
std::string describe_problem_text(const Problem& problem, const model::Robot& robot);

}  // namespace jaculus::transcription
