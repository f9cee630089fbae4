#pragma once
// Effects that users write: a YAML file, no compiler. docs/commands.md has the format. Such an
// effect is an entry of a catalogue as any other; simulation gets it as a law
// (simulation/law.h).

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "jaculus/effects/effect.h"

namespace jaculus::effects {

struct UserEffect {
  Effect effect;
  std::filesystem::path file;
  std::filesystem::path experiment;  ///< that shows it; empty where the file names none
  /// InputError, with the place in the file, where a robot can't have it: no such joint, a torque
  /// at a joint that slides.
  std::function<void(const model::PlanarModel&)> require;
};

/// InputError, with file, line and key, where the file says what none may: unknown names in a
/// formula, other units than a key has, bounds in the wrong order, an effect at nominal.
UserEffect read_user_effect(const std::filesystem::path& file);
/// The same of a file's text; `name`: what errors call it.
UserEffect parse_user_effect(const std::string& text, const std::string& name);

/// Every key of such a file with its meaning and unit.
std::string explain_effect();

/// The library's effects, those of files and `coded` ones (coded_effect.h), which all of `robots`
/// must be able to have. InputError as of read_user_effect, and where two have one name.
Catalogue catalogue_with(const std::vector<std::string>& files,
                         const std::vector<model::PlanarModel>& robots,
                         const std::vector<UserEffect>& coded = {});

}  // namespace jaculus::effects
