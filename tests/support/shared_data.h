#pragma once
// The authors' plans and the robot's logs, which are not part of the repository: JACULUS_DATA, or
// ../shared/data beside the source tree. Where they are absent a test says so and is skipped; in CI
// (environment variable CI set) it fails.

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "jaculus/core/installation.h"

namespace jaculus::test {

/// The folder of the real data; empty where there is none.
inline std::filesystem::path shared_data() {
  if (const char* given = std::getenv("JACULUS_DATA"); given != nullptr && *given != '\0')
    return given;
  const auto beside = source_folder() / ".." / "shared" / "data";
  return std::filesystem::is_directory(beside) ? beside : std::filesystem::path();
}

inline bool in_ci() {
  const char* ci = std::getenv("CI");
  return ci != nullptr && *ci != '\0' && std::string(ci) != "false" && std::string(ci) != "0";
}

}  // namespace jaculus::test

/// Opens a test that needs the real data: declares `folder` as their path.
#define JACULUS_REQUIRE_SHARED_DATA(folder)                                                      \
  const std::filesystem::path folder = ::jaculus::test::shared_data();                           \
  if (!std::filesystem::is_directory(folder)) {                                                  \
    if (::jaculus::test::in_ci()) FAIL() << "the shared data are absent: set JACULUS_DATA";      \
    GTEST_SKIP()                                                                                 \
        << "the shared data are absent (JACULUS_DATA, or ../shared/data beside the repository)"; \
  }                                                                                              \
  static_assert(true)
