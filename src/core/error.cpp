#include "jaculus/core/error.h"

namespace jaculus {
namespace {

std::string message_of(const InputPlace& place, const std::string& fault) {
  std::string message = place.file;
  if (place.line > 0) message += (message.empty() ? "line " : ":") + std::to_string(place.line);
  if (!place.key.empty()) message += (message.empty() ? "" : ": ") + place.key;
  return message.empty() ? fault : message + ": " + fault;
}

}  // namespace

InputError::InputError(const std::string& message)
    : std::runtime_error(message),
      details_(std::make_shared<const Details>(Details{{}, message})) {}

InputError::InputError(const InputPlace& place, const std::string& fault)
    : std::runtime_error(message_of(place, fault)),
      details_(std::make_shared<const Details>(Details{place, fault})) {}

}  // namespace jaculus
