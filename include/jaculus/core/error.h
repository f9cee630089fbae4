#pragma once
// The one exception of jaculus: bad input. Misuse of the library is an assertion, numerical failure
// is a status.

#include <stdexcept>
#include <string>

namespace jaculus {

/// Bad input from a user. The message is complete as it stands: file:line, key, what was given,
/// what is allowed.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace jaculus
