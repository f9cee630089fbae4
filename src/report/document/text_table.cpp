#include "report/document/text_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>

namespace jaculus::report {
namespace {

std::size_t characters(const std::string& text) {
  return std::count_if(text.begin(), text.end(),
                       [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; });
}

std::string padded(const std::string& text, std::size_t width, bool right) {
  const std::string space(width - std::min(width, characters(text)), ' ');
  return right ? space + text : text + space;
}

}  // namespace

void TextTable::row(std::vector<std::string> cells) {
  assert(cells.size() == header_.size());
  rows_.push_back(std::move(cells));
}

std::string TextTable::text() const {
  std::vector<std::size_t> widths;
  for (std::size_t c = 0; c < header_.size(); ++c) {
    std::size_t width = characters(header_[c]);
    for (const auto& cells : rows_) width = std::max(width, characters(cells[c]));
    widths.push_back(width);
  }

  const auto line = [&](const std::vector<std::string>& cells) {
    std::string text;
    for (std::size_t c = 0; c < cells.size(); ++c)
      text += (c > 0 ? "  " : "") + padded(cells[c], widths[c], c > 0);
    while (!text.empty() && text.back() == ' ') text.pop_back();
    return text + "\n";
  };

  std::string text = line(header_);
  std::size_t total = 0;
  for (std::size_t width : widths) total += width + 2;
  text += std::string(total - 2, '-') + "\n";
  for (const auto& cells : rows_) text += line(cells);
  return text;
}

std::string json_cell(const nlohmann::ordered_json& value, const char* format) {
  return value.is_number() ? fmt::format(fmt::runtime(format), value.get<double>()) : "-";
}

std::string fixed(double value, int digits) {
  return std::isnan(value) ? std::string("-") : fmt::format("{:.{}f}", value, digits);
}

std::string percent(double ratio, int digits) {
  return std::isnan(ratio) ? std::string("-") : fmt::format("{:+.{}f} %", 100.0 * ratio, digits);
}

std::string percent_or_change(double ratio, double change, const char* unit) {
  if (!std::isnan(ratio) || std::isnan(change)) return percent(ratio);
  return fmt::format("{:+.2g} {}", change, unit);
}

std::string coloured(const std::string& text, Colour colour, bool enabled) {
  if (!enabled) return text;
  const int code = colour == Colour::red      ? 31
                   : colour == Colour::green  ? 32
                   : colour == Colour::yellow ? 33
                                              : 1;
  return fmt::format("\x1b[{}m{}\x1b[0m", code, text);
}

}  // namespace jaculus::report
