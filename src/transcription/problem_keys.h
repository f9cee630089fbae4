#pragma once
// Every key of a problem file, said once: the reader takes its sets of valid keys from this table and
// `jaculus check --explain` prints it, so that neither can know a key that the other doesn't.

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace jaculus::problem_keys {

struct Key {
  std::string_view section;  ///< "" for the file itself, "limits", "phases[]", "constraints: friction", ...
  std::string_view name;
  std::string_view unit;      ///< as a user writes it, "-" for none, empty for words, maps and lists
  std::string_view fallback;  ///< what counts where the key is absent, "required" where it must be there
  std::string_view meaning;
};

std::span<const Key> all();

/// The keys of one section, in the order of the table.
std::vector<std::string> of(std::string_view section);

}  // namespace jaculus::problem_keys
