#pragma once
// What a diagnosis may be told.

#include <functional>
#include <string>
#include <vector>

#include "jaculus/diagnosis/physical.h"
#include "jaculus/diagnosis/settings.h"
#include "jaculus/effects/effect.h"

namespace jaculus::diagnosis {

struct DiagnoseOptions {
  Settings settings;
  std::vector<const effects::Effect*> effects;       ///< empty: the catalogue
  Accuracy accuracy{};                               ///< that the augmented model must have
  std::function<void(const std::string&)> progress;  ///< a line on what is going on
};

}  // namespace jaculus::diagnosis
