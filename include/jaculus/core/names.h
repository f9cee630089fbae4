#pragma once
// The names that an enumeration's values have in files and messages, each stated once.

#include <cassert>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace jaculus {

/// Values and their names, in the order in which messages list them.
template <class Value>
class NameTable {
 public:
  using Row = std::pair<Value, const char*>;
  explicit NameTable(std::vector<Row> rows) : rows_(std::move(rows)) {}

  /// Misuse: a value that has no row.
  [[nodiscard]] const char* name(Value value) const {
    for (const auto& [own, name] : rows_)
      if (own == value) return name;

    assert(false && "every value has a row");
    return "";
  }

  /// The value of a name, or nothing.
  [[nodiscard]] std::optional<Value> find(std::string_view given) const {
    for (const auto& [value, name] : rows_)
      if (given == name) return value;

    return std::nullopt;
  }

  [[nodiscard]] std::vector<std::string> names() const {
    std::vector<std::string> all;
    for (const Row& row : rows_) all.emplace_back(row.second);
    return all;
  }

  /// The rows of some values, in the order given.
  [[nodiscard]] NameTable only(const std::vector<Value>& values) const {
    std::vector<Row> rows;
    for (const Value value : values) rows.emplace_back(value, name(value));
    return NameTable(std::move(rows));
  }

 private:
  std::vector<Row> rows_;
};

}  // namespace jaculus
