#pragma once
// An MJCF file through MuJoCo's own reader, newer files than it knows included.
//
// MuJoCo's schema grows: files of today have attributes, and words for them, that a reader of some
// years ago refuses, most of them about looks and integration. What the reader says that it doesn't
// know is left out of the text, a note each, until it reads the rest; so it is that reader who
// decides what is mechanics. Since MuJoCo 3 a range by itself is a limit (`autolimits`), which
// older ones have to be told.

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#ifdef JACULUS_HAS_MUJOCO
#include <mujoco/mujoco.h>

#include "jaculus/model/urdf.h"

namespace jaculus::model {

struct LoadedMjcf {
  std::unique_ptr<mjModel, void (*)(mjModel*)> model;
  std::vector<std::string> notes;  ///< what was left out or assumed, "assumed: ..."
};

/// InputError where MuJoCo refuses the file for anything else, or `reading` is strict, with its
/// message about the file as it is.
LoadedMjcf load_mjcf(const std::filesystem::path& file, Reading reading);

}  // namespace jaculus::model
#endif
