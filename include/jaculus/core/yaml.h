#pragma once
// Strict YAML reader: every key must be known, every value typed, dimensioned and in range. Nothing
// is ignored or defaulted silently. Messages read "file:line: key: what was given; what is
// allowed", with the nearest valid name where there is one.

#include <filesystem>
#include <initializer_list>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "jaculus/core/error.h"
#include "jaculus/core/types.h"
#include "jaculus/core/units.h"

namespace jaculus::yaml {

/// One node of a document with its place in the file: path "phases[0].duration" and line. Cheap to
/// copy.
class Node {
 public:
  Node();  ///< an empty map without a file, for values built in code

  /// Reads a file. Not found, not readable, not YAML, larger than 10 MB, duplicate keys, cyclic
  /// aliases: InputError.
  static Node load(const std::filesystem::path& file);
  /// The same from text; `name` stands for the file in messages.
  static Node parse(const std::string& text, const std::string& name);

  /// The same node; numbers of it and of all below may be in these units too.
  [[nodiscard]] Node with_units(std::shared_ptr<const OwnUnits> units) const;

  [[nodiscard]] bool is_map() const;
  [[nodiscard]] bool is_list() const;
  [[nodiscard]] bool is_scalar() const;

  /// Throws on any key of this map that is not among `keys`, naming the nearest valid one.
  void only(std::initializer_list<std::string_view> keys) const;
  void only(const std::vector<std::string>& keys) const;

  [[nodiscard]] bool has(std::string_view key) const;
  /// The value of a key that must be there.
  [[nodiscard]] Node at(std::string_view key) const;
  /// The value of a key that may be absent.
  [[nodiscard]] std::optional<Node> find(std::string_view key) const;
  [[nodiscard]] std::vector<Node> items() const;  ///< of a list, or InputError
  /// of a map in file order, or InputError
  [[nodiscard]] std::vector<std::pair<std::string, Node>> entries() const;

  /// A number in SI: plain, or a string with its unit. NaN and infinity are refused; out of
  /// `allowed` is InputError.
  [[nodiscard]] double number(const Dimension& dimension, const Bounds& allowed = {}) const;
  /// A whole number in [lower, upper].
  [[nodiscard]] int integer(int lower, int upper) const;
  [[nodiscard]] bool boolean() const;
  [[nodiscard]] std::string text() const;  ///< a non-empty string
  /// One of `choices`, or InputError with the nearest.
  [[nodiscard]] std::string choice(const std::vector<std::string>& choices) const;
  /// [lower, upper] in one dimension, lower <= upper; a single number gives a fixed value.
  [[nodiscard]] Bounds bounds(const Dimension& dimension) const;
  [[nodiscard]] Vec2 vec2(const Dimension& dimension) const;  ///< a list of two numbers (x, z)
  [[nodiscard]] std::vector<double> numbers(const Dimension& dimension) const;
  [[nodiscard]] std::vector<std::string> texts() const;

  /// An error at this node's place: "file:line: path: what".
  [[nodiscard]] InputError error(const std::string& what) const;
  [[nodiscard]] std::string path() const;            ///< "phases[0].duration"
  [[nodiscard]] int line() const;                    ///< 1-based, 0 where built in code
  [[nodiscard]] std::filesystem::path file() const;  ///< empty where built in code
  [[nodiscard]] std::string dump() const;            ///< the node as YAML text

  struct Impl;

 private:
  explicit Node(std::shared_ptr<const Impl> impl);
  std::shared_ptr<const Impl> impl_;
};

/// Refuses a file of another of our kinds by what its key `format` says ("a problem
/// (jaculus-problem/1)"), before its other keys are called unknown. Says nothing about any other
/// file.
void refuse_other_kind(const Node& file, std::string_view wanted);

/// A scalar in double quotes that reads back as `text`, whatever it holds.
std::string quoted(const std::string& text);

/// The candidate nearest to `given` by edit distance, or nothing where none is near.
std::optional<std::string> nearest_name(std::string_view given,
                                        const std::vector<std::string>& candidates);
/// ", did you mean 'voltage'?" of that candidate, for a message; empty where none is near.
std::string did_you_mean(std::string_view given, const std::vector<std::string>& candidates);

}  // namespace jaculus::yaml
