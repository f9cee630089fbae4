#pragma once
// Expectations on messages of bad input.

#include <gtest/gtest.h>

#include <string>

#include "jaculus/core/error.h"

namespace jaculus::test {

/// Runs `action` and returns the message of the InputError that it must throw; a failure and ""
/// where it throws none.
template <class Action>
std::string input_error_of(Action&& action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  ADD_FAILURE() << "no InputError was thrown";
  return "";
}

/// Whether `message` holds `part`, with both in the failure.
inline ::testing::AssertionResult holds(const std::string& message, const std::string& part) {
  if (message.find(part) != std::string::npos) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << "'" << part << "' is not in '" << message << "'";
}

}  // namespace jaculus::test
