#pragma once
// Runs the built program as a user would and catches what it says.

#include <string>
#include <vector>

namespace jaculus::test {

struct Outcome {
  int exit_code = -1;  ///< -1 where it did not end by itself
  std::string out;     ///< standard output
  std::string err;     ///< standard error
};

/// Runs `jaculus` with these arguments, in `folder` where given.
Outcome run_program(const std::vector<std::string>& arguments, const std::string& folder = "");

/// The same with standard error on a terminal (a pseudo-terminal of the kernel): `err` is what it received.
Outcome run_on_terminal(const std::vector<std::string>& arguments);

}  // namespace jaculus::test
