#include "model/assumptions.h"

#include <fmt/format.h>

#include <algorithm>

#include "model/urdf_check.h"

namespace jaculus::model {

void Assumptions::assume(int line, const std::string& fault, const std::string& taken) {
  if (strict_) refuse(line, fault);

  const std::string text = fault.substr(0, fault.find("; ")) + ": " + taken;
  const auto old = std::find_if(items_.begin(), items_.end(),
                                [&](const Item& item) { return item.text == text; });
  if (old != items_.end()) {
    ++old->count;
  } else {
    items_.push_back({text, line});
  }
}

void Assumptions::refuse(int line, const std::string& fault) const {
  throw urdf_error(file_, line, fault);
}

std::vector<std::string> Assumptions::notes() const {
  std::vector<std::string> notes;
  for (const Item& item : items_) {
    notes.push_back(item.count == 1 ? fmt::format("assumed: {} (line {})", item.text, item.line)
                                    : fmt::format("assumed: {} ({} times, first in line {})",
                                                  item.text, item.count, item.line));
  }
  return notes;
}

}  // namespace jaculus::model
