#include "jaculus/core/installation.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "jaculus/core/error.h"

namespace jaculus {
namespace {

namespace fs = std::filesystem;

TEST(Installation, ANameIsAProblemThatShips) {
  EXPECT_EQ(find_problem_file("leap_tail"), source_folder() / "problems" / "leap_tail.yaml");
  EXPECT_EQ(find_problem_file("fig4_shaft"), source_folder() / "problems" / "fig4_shaft.yaml");
}

TEST(Installation, APathStaysAsItIs) {
  EXPECT_EQ(find_problem_file("leap_tail.yaml"), "leap_tail.yaml");
  EXPECT_EQ(find_problem_file("mine/leap_tail"), "mine/leap_tail");
}

TEST(Installation, AFileComesBeforeAName) {
  const fs::path before = fs::current_path();
  const fs::path folder =
      fs::temp_directory_path() / ("installation_" + std::to_string(::getpid()));
  fs::create_directories(folder);
  fs::current_path(folder);
  std::ofstream("leap_tail") << "mine\n";
  EXPECT_EQ(find_problem_file("leap_tail"), "leap_tail");
  fs::current_path(before);
  fs::remove_all(folder);
}

TEST(Installation, AnUnknownNameIsToldWithTheNearest) {
  try {
    static_cast<void>(find_problem_file("leap_tial"));
    FAIL();
  } catch (const InputError& error) {
    const std::string what = error.what();
    EXPECT_NE(what.find("did you mean 'leap_tail'?"), std::string::npos) << what;
  }
}

}  // namespace
}  // namespace jaculus
