#pragma once
// Tables of text with aligned columns, and colours for terminals.

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace jaculus::report {

/// Rows of cells under a header; columns after the first are aligned right. UTF-8 is counted by
/// characters.
class TextTable {
 public:
  explicit TextTable(std::vector<std::string> header) : header_(std::move(header)) {}
  void row(std::vector<std::string> cells);  ///< as many cells as the header has
  [[nodiscard]] std::string text() const;

 private:
  std::vector<std::string> header_;
  std::vector<std::vector<std::string>> rows_;
};

/// A number of JSON, "-" where there is none.
std::string json_cell(const nlohmann::ordered_json& value, const char* format = "{:.3f}");
/// A number with `digits` decimals, "-" for NaN.
std::string fixed(double value, int digits);
/// A ratio as per cent with sign, "+14.5 %", "-" for NaN.
std::string percent(double ratio, int digits = 1);
/// percent(), or where there is no ratio the change itself in `unit`: "+0.036 m/s^2".
std::string percent_or_change(double ratio, double change, const char* unit);

enum class Colour { red, green, yellow, bold };
/// The text in a terminal colour where `enabled`.
std::string coloured(const std::string& text, Colour colour, bool enabled);

}  // namespace jaculus::report
