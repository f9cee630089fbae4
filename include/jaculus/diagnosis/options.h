#pragma once
// What a diagnosis may be told.

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "jaculus/diagnosis/physical.h"
#include "jaculus/diagnosis/settings.h"
#include "jaculus/effects/effect.h"

namespace jaculus::diagnosis {

struct DiagnoseOptions {
  Settings settings;
  std::vector<const effects::Effect*> effects;  ///< empty: all of `catalogue`
  /// In place of the library's, as with effects that users wrote; the diagnosis keeps it.
  std::shared_ptr<const effects::Catalogue> catalogue{};
  Accuracy accuracy{};                               ///< that the augmented model must have
  std::function<void(const std::string&)> progress;  ///< a line on what is going on
};

}  // namespace jaculus::diagnosis
