#pragma once
// What the tests' tasks answer.

#include <cstdint>
#include <string>

#include "jaculus/core/tasks.h"

namespace jaculus::test {

/// Some bytes that depend on the index alone, zeros among them.
inline std::string answer(int index) {
  std::string bytes;
  std::uint64_t state = task_seed(7, static_cast<std::uint64_t>(index));
  for (int i = 0; i < 40 + 10 * index; ++i) {
    state = task_seed(state, 0);
    bytes.push_back(static_cast<char>(state & 0x3f));
  }
  return bytes;
}

}  // namespace jaculus::test
