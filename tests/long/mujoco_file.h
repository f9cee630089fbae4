#pragma once
// Robot files as MuJoCo reads them, for the checks that set jaculus beside it.

#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>
#include <string>

#include "core/text_file.h"
#include "jaculus/core/error.h"
#include "jaculus/model/mjcf.h"
#include "model/mjcf_load.h"
#include "model/urdf_check.h"

namespace jaculus::test {

using MujocoModel = std::unique_ptr<mjModel, void (*)(mjModel*)>;

/// MuJoCo has a body of this name already.
inline const std::string kWorld = "\"world\"";
inline const std::string kOtherWorld = "\"jaculus_world\"";

/// A URDF file as MuJoCo takes it: without what jaculus skips, and the root a body of its own.
inline std::string urdf_for_mujoco(const std::filesystem::path& file) {
  model::Assumptions assumptions(file, false);
  std::string text =
      model::check_urdf_text(read_text_file(file, "a URDF file"), file, assumptions).text;
  for (std::size_t at = text.find(kWorld); at != std::string::npos; at = text.find(kWorld, at))
    text.replace(at, kWorld.size(), kOtherWorld);
  const std::size_t head = text.find('>', text.find("<robot")) + 1;
  text.insert(head,
              "<mujoco><compiler fusestatic=\"false\" balanceinertia=\"true\" boundmass=\"1e-12\" "
              "boundinertia=\"1e-14\"/></mujoco>");
  return text;
}

/// Reads URDF or MJCF text. InputError with MuJoCo's own words.
inline MujocoModel load_mujoco_text(const std::string& text) {
  std::array<char, 1000> error{};
  const std::unique_ptr<mjVFS> files = std::make_unique<mjVFS>();
  mj_defaultVFS(files.get());
  mj_makeEmptyFileVFS(files.get(), "robot.xml", static_cast<int>(text.size()));
  std::copy(text.begin(), text.end(), static_cast<char*>(files->filedata[0]));
  MujocoModel result{mj_loadXML("robot.xml", files.get(), error.data(), 1000), mj_deleteModel};
  mj_deleteVFS(files.get());
  if (!result) throw InputError(fmt::format("MuJoCo refuses it: {}", error.data()));
  return result;
}

/// Reads a URDF or MJCF file, of a newer MJCF what this MuJoCo knows. InputError with MuJoCo's own
/// words where it refuses that too.
inline MujocoModel load_mujoco(const std::filesystem::path& file) {
  if (!model::is_mjcf(file)) return load_mujoco_text(urdf_for_mujoco(file));
  return model::load_mjcf(file, model::Reading::lenient).model;
}

}  // namespace jaculus::test
