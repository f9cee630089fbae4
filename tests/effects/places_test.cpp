// How many places an effect has: its function and its row, in the file of its family; nothing
// behind the catalogue knows it by name.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>

#include "effects/families.h"
#include "jaculus/core/installation.h"

namespace jaculus::effects {
namespace {

namespace fs = std::filesystem;

const fs::path kSource = source_folder() / "src";

std::string text_of_file(const fs::path& file) {
  std::ifstream stream(file);
  std::stringstream text;
  text << stream.rdbuf();
  return text.str();
}

std::map<fs::path, std::string> texts_in(const fs::path& folder) {
  std::map<fs::path, std::string> texts;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const fs::path extension = entry.path().extension();
    if (extension == ".cpp" || extension == ".h") texts[entry.path()] = text_of_file(entry.path());
  }
  return texts;
}

int count(const std::string& text, const std::regex& pattern) {
  return static_cast<int>(
      std::distance(std::sregex_iterator(text.begin(), text.end(), pattern), {}));
}

/// Functions that stand in a row of a family: those after the family's `std::vector<Row>`.
std::set<std::string> functions_in_rows(const std::string& text) {
  std::set<std::string> functions;
  const std::size_t start = text.find("\nstd::vector<Row> ");
  if (start == std::string::npos) return functions;

  const std::string rows = text.substr(start);
  const std::regex defined("\nEffect (\\w+)\\(");
  for (std::sregex_iterator f(text.begin(), text.end(), defined), end; f != end; ++f) {
    const std::string name = (*f)[1];
    if (count(rows, std::regex("\\b" + name + "\\b")) > 0) functions.insert(name);
  }
  return functions;
}

TEST(Places, OfAnEffectAreAFunctionAndARowInOneFile) {
  const std::map<fs::path, std::string> texts = texts_in(kSource / "effects");
  int effects = 0;
  for (const auto& [file, text] : texts) {
    if (file.extension() != ".cpp") continue;
    for (const std::string& name : functions_in_rows(text)) {
      ++effects;
      const std::regex called("[^.\\w\"]" + name + "(?=[,}(])");
      EXPECT_EQ(count(text, called), 2) << name << ": its function and its row";
      for (const auto& [other, elsewhere] : texts) {
        if (other == file) continue;
        EXPECT_EQ(count(elsewhere, called), 0) << name << " in " << other;
      }
    }
  }

  std::size_t rows = 0;
  for (const auto family : {transmission, actuation, aerodynamics, inertia, contact, sensing})
    rows += family().size();
  EXPECT_EQ(effects, static_cast<int>(rows)) << "one row an effect";
}

TEST(Places, BehindTheCatalogueNoneKnowsAnEffectByName) {
  for (const char* module : {"diagnosis", "evaluation", "report", "cli"}) {
    for (const auto& [file, text] : texts_in(kSource / module)) {
      // A baseline's dictionary: which term of its regression means which effect.
      if (file.filename() == "residual_torque.cpp") continue;
      for (const Effect& effect : effect_catalogue())
        EXPECT_EQ(text.find('"' + effect.name + '"'), std::string::npos)
            << effect.name << " in " << file;
    }
  }
}

}  // namespace
}  // namespace jaculus::effects
