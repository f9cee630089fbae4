#include "trajectory/line_reader.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <system_error>
#include <utility>

namespace jaculus::trajectory {

LineReader::LineReader(std::istream& stream, std::string name)
    : stream_(stream), name_(std::move(name)) {
  fill();
  if (std::string_view(buffer_).starts_with("\xEF\xBB\xBF")) at_ = 3;
}

bool LineReader::fill() {
  constexpr std::size_t kBlock = std::size_t{1} << 18;
  if (ended_) return false;
  buffer_.erase(0, at_);
  at_ = 0;
  const std::size_t before = buffer_.size();
  buffer_.resize(before + kBlock);
  stream_.read(buffer_.data() + before, kBlock);
  const std::size_t got = stream_.gcount();
  buffer_.resize(before + got);
  if (stream_.bad()) throw InputError(fmt::format("{}: can't be read", name_));
  ended_ = got < kBlock;
  return got > 0;
}

bool LineReader::next(std::string_view& line) {
  std::size_t end = buffer_.find('\n', at_);
  while (end == std::string::npos) {
    const std::size_t searched = buffer_.size() - at_;
    if (searched > kLongestLine) {
      ++line_;
      throw error(
          fmt::format("the line has more than {} bytes; this is no table of text", kLongestLine));
    }
    if (!fill()) break;
    end = buffer_.find('\n', at_ + searched);
  }

  const bool last = end == std::string::npos;
  if (last && at_ == buffer_.size()) return false;
  if (last) end = buffer_.size();

  line = std::string_view(buffer_).substr(at_, end - at_);
  if (line.ends_with('\r')) line.remove_suffix(1);
  at_ = last ? end : end + 1;
  ++line_;
  return true;
}

InputError LineReader::error(const std::string& what) const {
  return InputError({name_, line_}, what);
}

std::string_view trim(std::string_view text) {
  const auto first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

std::string shown(std::string_view text) {
  constexpr std::size_t kLongest = 40;
  std::string out;
  for (const char c : text.substr(0, kLongest))
    out += static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? '?' : c;
  return text.size() > kLongest ? out + "..." : out;
}

bool parse_number(std::string_view cell, double& value) {
  if (cell.starts_with('+') && !cell.starts_with("+-")) cell.remove_prefix(1);
  const auto [end, status] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  return status == std::errc() && end == cell.data() + cell.size() && std::isfinite(value);
}

void split_cells(std::string_view line, char separator, const LineReader& reader,
                 std::vector<std::string>& cells) {
  std::size_t count = 0;
  const auto cell = [&]() -> std::string& {
    if (count == cells.size()) cells.emplace_back();
    return cells[count++];
  };

  for (bool more = true; more;) {
    const std::string_view rest = trim(line);
    if (!rest.empty() && rest.front() == '"') {
      std::string& text = cell();
      text.clear();
      std::size_t at = line.find('"') + 1;
      for (;; ++at) {
        if (at >= line.size()) throw reader.error("a quoted cell has no closing quote on its line");
        if (line[at] == '"' && !(at + 1 < line.size() && line[at + 1] == '"')) break;
        text += line[at];
        if (line[at] == '"') ++at;
      }
      line.remove_prefix(at + 1);
      if (const std::string_view tail = trim(line.substr(0, line.find(separator))); !tail.empty())
        throw reader.error(fmt::format("'{}' stands behind a closing quote", shown(tail)));
    } else {
      cell() = trim(line.substr(0, line.find(separator)));
    }

    const std::size_t end = line.find(separator);
    more = end != std::string_view::npos;
    line.remove_prefix(more ? end + 1 : line.size());
  }

  cells.resize(count);
}

}  // namespace jaculus::trajectory
