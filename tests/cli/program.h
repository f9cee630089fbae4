#pragma once
// Runs the built program as a user would and catches what it says.

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "jaculus/core/installation.h"

namespace jaculus::test {

/// Where the problems stand that are shipped, with the slash.
inline const std::string kProblems = source_folder().string() + "/problems/";

struct Outcome {
  int exit_code = -1;  ///< -1 where it did not end by itself
  std::string out;     ///< standard output
  std::string err;     ///< standard error
};

/// Runs `jaculus` with these arguments, in `folder` where given.
Outcome run_program(const std::vector<std::string>& arguments, const std::string& folder = "");

/// The same with standard error on a terminal (a pseudo-terminal of the kernel): `err` is what it
/// received. Standard output goes to a file, or into a pipe (what it holds must fit into one).
enum class Output { file, pipe };
Outcome run_on_terminal(const std::vector<std::string>& arguments, Output output = Output::file);

/// Bad input, as every command refuses it: exit code 2, nothing on standard output, one line of
/// message.
inline void expect_refusal(const Outcome& outcome) {
  EXPECT_EQ(outcome.exit_code, 2) << outcome.err;
  EXPECT_EQ(outcome.out, "");
  EXPECT_TRUE(outcome.err.starts_with("jaculus: ")) << outcome.err;
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
}

}  // namespace jaculus::test
