#pragma once
// Sections of a problem file that fill the members of a struct: each key is declared once, beside
// its member. Its default is what the struct's own is.

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <type_traits>

#include "jaculus/transcription/key.h"

namespace jaculus::transcription {

/// A key and the member of S that it fills.
template <class S>
struct Field {
  Key key;
  std::function<void(S&, const yaml::Node&)> read;
};

namespace fields {

inline double read(const yaml::Node& node, const key::Number& kind) {
  return node.number(kind.dimension, kind.allowed);
}
inline int read(const yaml::Node& node, const key::Integer& kind) {
  return node.integer(kind.lower, kind.upper);
}
inline bool read(const yaml::Node& node, const key::Flag&) { return node.boolean(); }
inline std::string read(const yaml::Node& node, const key::Choice& kind) {
  return node.choice(kind.words);
}

/// A value as a user would write it; that of an enum is the word in its place.
template <class T>
std::string written(const T& value, const key::Kind& kind) {
  if constexpr (std::is_enum_v<T>)
    return std::get<key::Choice>(kind).words.at(static_cast<std::size_t>(value));
  else
    return fmt::format("{}", value);
}

}  // namespace fields

/// Declares a key of the section that fills S. A member of an enum type takes the word's place
/// among the choices.
template <class S, class T, class Kind>
Field<S> field(const std::string& name, T S::*member, const Kind& kind,
               const std::string& meaning) {
  const auto read = [member, kind](S& section, const yaml::Node& node) {
    if constexpr (std::is_enum_v<T>) {
      const std::string word = fields::read(node, kind);
      const auto place = std::find(kind.words.begin(), kind.words.end(), word);
      section.*member = static_cast<T>(place - kind.words.begin());
    } else {
      section.*member = fields::read(node, kind);
    }
  };
  return {{name, kind, meaning, {.value = fields::written(S{}.*member, kind)}}, read};
}

template <class S>
std::vector<Key> keys_of(const std::vector<Field<S>>& fields) {
  std::vector<Key> keys;
  for (const Field<S>& field : fields) keys.push_back(field.key);
  return keys;
}

/// Changes what the node says; the rest stays as it is. Unknown keys and bad values: InputError.
template <class S>
void read_fields(const yaml::Node& node, const std::vector<Field<S>>& fields, S& section) {
  std::vector<std::string> known;
  for (const Field<S>& field : fields) known.push_back(field.key.name);
  node.only(known);

  for (const Field<S>& field : fields) {
    if (const auto value = node.find(field.key.name)) field.read(section, *value);
  }
}

}  // namespace jaculus::transcription
