#pragma once
// The one exception of jaculus: bad input. Misuse of the library is an assertion, numerical failure
// is a status.

#include <memory>
#include <stdexcept>
#include <string>

namespace jaculus {

/// Where a fault stands. What is not known is empty, a line 0.
struct InputPlace {
  std::string file = {};
  int line = 0;          ///< 1-based
  std::string key = {};  ///< "phases[0].duration", "column 'time'"
};

/// Bad input from a user. The message is complete as it stands: file:line, key, what was given,
/// what is allowed.
class InputError : public std::runtime_error {
 public:
  /// The message alone.
  explicit InputError(const std::string& message);
  /// A message that opens with its place: "file:line: key: fault".
  InputError(const InputPlace& place, const std::string& fault);

  [[nodiscard]] const InputPlace& place() const { return details_->place; }
  /// The message without its place.
  [[nodiscard]] const std::string& fault() const { return details_->fault; }

 private:
  struct Details {
    InputPlace place;
    std::string fault;
  };
  std::shared_ptr<const Details> details_;  // an exception is copied without throwing
};

}  // namespace jaculus
