#pragma once
// The keys of a problem file, section by section, each declared once: readers take the valid keys
// from here and `jaculus check --explain` prints them. Those of terms stand with the terms.

#include <string>
#include <string_view>
#include <vector>

#include "jaculus/transcription/key.h"
#include "jaculus/transcription/term.h"

namespace jaculus::transcription::problem_keys {

/// A map of the file and what may stand in it.
struct Section {
  std::string name;  ///< "" for the file itself, "limits", "phases[]", "constraints: friction", ...
  std::vector<Key> keys;
  std::string meaning = {};  ///< one line; may be empty
  std::string example = {};  ///< of a term; may be empty
};

// Sections whose keys stand beside the members that they fill (problem_read_options.cpp).
std::vector<Key> limits();
std::vector<Key> transcription();
std::vector<Key> solver();
std::vector<Key> refinement();

/// All sections, in the order in which help prints them; those of the catalogue's terms last.
std::vector<Section> sections(const TermCatalogue& catalogue);

/// The keys of one section other than a term's.
const std::vector<Key>& of(std::string_view section);

/// Their names.
std::vector<std::string> names(const std::vector<Key>& keys);

}  // namespace jaculus::transcription::problem_keys
