#pragma once
// What the fuzzers share. A reader may refuse its input with an InputError; anything else that it
// throws, any crash, leak, overflow or hang is a finding.

#include <cstddef>
#include <cstdint>
#include <string>

#include "jaculus/core/error.h"

namespace jaculus::fuzz {

/// Runs a reader on text. A message must name the place it was given.
template <class Action>
void refuse_politely(Action&& action) {
  try {
    action();
  } catch (const InputError& error) {
    if (std::string(error.what()).empty()) __builtin_trap();
  }
}

inline std::string text_of(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

}  // namespace jaculus::fuzz
