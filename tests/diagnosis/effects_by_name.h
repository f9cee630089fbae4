#pragma once
// Diagnoses among a few effects.

#include <initializer_list>

#include "jaculus/diagnosis/options.h"
#include "jaculus/effects/effect.h"

namespace jaculus::test {

/// Options whose candidates are these effects of the catalogue.
inline diagnosis::DiagnoseOptions among(std::initializer_list<const char*> names) {
  diagnosis::DiagnoseOptions options;
  for (const char* name : names) options.effects.push_back(effects::find_effect(name));
  return options;
}

}  // namespace jaculus::test
