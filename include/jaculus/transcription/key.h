#pragma once
// The keys of a term in a problem file, each declared once: name, kind, unit, range, default and
// meaning. Reading, its checks, `jaculus check --explain` and the tests follow from the
// declaration.
//
//   Key{"coefficient", key::Number{dimension::none, {1e-6, 10.0}}, "mu in |f_x| <= mu f_z",
//       {.words = "limits.friction"}}

#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "jaculus/core/yaml.h"

namespace jaculus::transcription {

/// What a key may hold.
namespace key {

/// A number, plain (SI) or with its unit.
struct Number {
  Dimension dimension = dimension::none;
  Bounds allowed = {};  ///< [SI]
};

/// [lower, upper], or a single number where both are equal.
struct Interval {
  Dimension dimension = dimension::none;
};

/// A whole number within [lower, upper].
struct Integer {
  int lower = 0;
  int upper = std::numeric_limits<int>::max();
};

/// true or false.
struct Flag {};

/// One of some words.
struct Choice {
  std::vector<std::string> words;
};

/// What a name is a name of; phases are the problem's, feet and motors the robot's.
enum class Of { phase, foot, motor };

/// One name.
struct Name {
  Of of = Of::phase;
};

/// A list of names.
struct Names {
  Of of = Of::phase;
};

/// What the declaring code reads by itself; `unit` stands in the help.
struct Other {
  std::string unit = {};
};

using Kind = std::variant<Number, Interval, Integer, Flag, Choice, Name, Names, Other>;

/// What counts where a key is absent: nothing (the key must be there), a value as a user would
/// write it, or what the words say.
struct Absent {
  std::string value = {};
  std::string words = {};
};

}  // namespace key

/// The declaration of one key.
struct Key {
  std::string name;
  key::Kind kind;
  std::string meaning;      ///< for help, in a few words
  key::Absent absent = {};  ///< required where left out

  [[nodiscard]] bool required() const { return absent.value.empty() && absent.words.empty(); }
  [[nodiscard]] std::string unit() const;  ///< "N", "-" for a plain number, empty for words
};

/// What a file gives for declared keys. The accessors are std::logic_errors on a key that is not
/// declared, is of another kind, or is neither given nor has a default value: has() tells.
class KeyValues {
 public:
  KeyValues() = default;

  /// Reads a map. A key that is neither declared nor among `others`, a required key that is
  /// missing, a value of the wrong kind, unit or range: InputError with file:line.
  KeyValues(const yaml::Node& map, const std::vector<Key>& keys,
            const std::vector<std::string>& others = {});

  [[nodiscard]] bool has(std::string_view key) const;  ///< given, or by a default value
  [[nodiscard]] double number(std::string_view key) const;
  [[nodiscard]] double number_or(std::string_view key, double otherwise) const;
  [[nodiscard]] Bounds interval(std::string_view key) const;
  [[nodiscard]] int integer(std::string_view key) const;
  [[nodiscard]] bool flag(std::string_view key) const;
  [[nodiscard]] std::string choice(std::string_view key) const;
  /// A name at its place, and what it is a name of.
  [[nodiscard]] std::pair<key::Of, yaml::Node> name(std::string_view key) const;
  /// A list of names, empty where the key is absent.
  [[nodiscard]] std::pair<key::Of, std::vector<yaml::Node>> names(std::string_view key) const;

  /// InputError on a name of that kind which is not among `known`.
  void check_names(key::Of of, const std::vector<std::string>& known) const;

 private:
  [[nodiscard]] const Key& declaration(std::string_view key) const;
  template <class Kind>
  [[nodiscard]] const Kind& declared(std::string_view key) const;
  [[nodiscard]] const yaml::Node& value(std::string_view key) const;

  std::vector<Key> keys_;
  std::map<std::string, yaml::Node, std::less<>> values_;
};

/// The index of a name among `known`; InputError, with the nearest one, where it is not there.
int index_of_name(const yaml::Node& name, key::Of of, const std::vector<std::string>& known);

}  // namespace jaculus::transcription
