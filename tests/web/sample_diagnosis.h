#pragma once
// A diagnosis with everything that its report can show, made up around a pendulum.

#include <string>

#include "jaculus/diagnosis/diagnose.h"

namespace jaculus {

/// `name` stands wherever a file could put a name.
diagnosis::Diagnosis sample_diagnosis(const std::string& name);

}  // namespace jaculus
