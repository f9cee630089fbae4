// A term is declared in one place: reading, help and checks follow. The test of its derivatives is
// that of the whole catalogue.

#include "transcription/own_term.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>
#include <stdexcept>

#include "jaculus/core/installation.h"
#include "support/input_error.h"
#include "transcription/example_problems.h"

namespace jaculus::transcription {
namespace {

using test::extended_problem;
using test::holds;
using test::on_grid;

Problem leap_with(const std::string& keys) {
  return extended_problem("leap_tail", "constraints: [{type: pitch_rate, " + keys + "}]",
                          test::catalogue_with_own_term());
}

std::string error_of(const std::string& keys) {
  return test::input_error_of([&] { static_cast<void>(test::make_program(leap_with(keys))); });
}

TEST(OwnTerm, IsReadByItsDeclaration) {
  const TermSpec spec = leap_with("limit: 90 deg/s").constraints.back();
  EXPECT_EQ(spec.type, "pitch_rate");
  EXPECT_NEAR(spec.values.number("limit"), 1.5707963267948966, 1e-15);
  EXPECT_FALSE(spec.values.has("phases"));
}

TEST(OwnTerm, HasItsRowsWhereItsKeysSay) {
  const auto rows = [](const std::string& keys) {
    return test::make_program(on_grid(leap_with(keys), {3, 2})).rows();
  };
  const int without = test::make_program(on_grid(extended_problem("leap_tail", ""), {3, 2})).rows();
  EXPECT_EQ(rows("limit: 5, phases: [rear_feet]") - without, 2 * 2 + 1);
  EXPECT_EQ(rows("limit: 5") - without, (2 * 3 + 1) + (2 * 2 + 1));
}

TEST(OwnTerm, RefusesWhatItsDeclarationDoesNotAllow) {
  EXPECT_TRUE(holds(error_of("limt: 5"), "did you mean 'limit'?"));
  EXPECT_TRUE(holds(error_of("phases: [rear_feet]"), "'limit' is missing"));
  EXPECT_TRUE(holds(error_of("limit: 5 m/s"), "rad/s"));
  EXPECT_TRUE(holds(error_of("limit: 500"), "allowed"));
  EXPECT_TRUE(holds(error_of("limit: 5, phases: [rear_fet]"), "did you mean 'rear_feet'?"));
  EXPECT_TRUE(holds(error_of("limit: 5, weight: 2"), "unknown key 'weight'"));
}

TEST(OwnTerm, IsUnknownToTheLibrarysCatalogue) {
  const std::string message = test::input_error_of([] {
    static_cast<void>(extended_problem("leap_tail", "constraints: [{type: pitch_rate, limit: 5}]"));
  });
  EXPECT_TRUE(holds(message, "unknown constraint type 'pitch_rate'"));
}

TEST(OwnTerm, IsExplained) {
  const TermType own = test::pitch_rate();
  const std::string text = explain_problem(test::catalogue_with_own_term());
  for (const std::string& part :
       {std::string("constraints: pitch_rate"), own.meaning, std::string("limit [rad/s]"),
        own.keys[0].meaning, std::string("{type: pitch_rate, limit: 300 deg/s, ")}) {
    EXPECT_NE(text.find(part), std::string::npos) << part;
  }
}

TEST(OwnTerm, CantReadWhatItDoesNotDeclare) {
  const KeyValues values = leap_with("limit: 5").constraints.back().values;
  EXPECT_THROW(static_cast<void>(values.number("limt")), std::logic_error);
  EXPECT_THROW(static_cast<void>(values.has("limt")), std::logic_error);
  EXPECT_THROW(static_cast<void>(values.choice("limit")), std::logic_error);
  EXPECT_THROW(static_cast<void>(values.interval("limit")), std::logic_error);
}

// ---- places to touch

std::string text_of(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

/// Files of the sources that hold `what`.
std::set<std::string> files_with(const std::regex& what) {
  const std::filesystem::path root = source_folder();
  std::set<std::string> files;
  for (const char* folder : {"include", "src"}) {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(root / folder)) {
      const std::string kind = entry.path().extension().string();
      if (kind != ".h" && kind != ".cpp") continue;
      if (!std::regex_search(text_of(entry.path()), what)) continue;
      files.insert(std::filesystem::relative(entry.path(), root).string());
    }
  }
  return files;
}

TEST(Catalogue, ATermStandsInTwoFiles) {
  const std::string terms = "src/transcription/terms/", table = "src/transcription/catalogue.cpp";
  for (const TermType& type : term_catalogue()) {
    SCOPED_TRACE(type.name);
    std::set<std::string> files = files_with(std::regex("TermType " + type.name + "\\(\\)"));
    EXPECT_EQ(files.erase(table), 1U);
    ASSERT_EQ(files.size(), 1U);
    EXPECT_EQ(files.begin()->rfind(terms, 0), 0U) << *files.begin();

    // Words that mean other things as well, like "friction" and "time", can't be told apart.
    if (type.name.find('_') == std::string::npos) continue;
    EXPECT_EQ(files_with(std::regex("\"" + type.name + "\"")), files);
  }
}

}  // namespace
}  // namespace jaculus::transcription
