#pragma once
// Text files line by line, however large: only a block and the present line are in memory.

#include <istream>
#include <streambuf>
#include <string>
#include <string_view>
#include <vector>

#include "jaculus/core/error.h"

namespace jaculus::trajectory {

/// A stream over text in memory that is not copied.
class ViewStream : private std::streambuf, public std::istream {
 public:
  explicit ViewStream(std::string_view text) : std::istream(static_cast<std::streambuf*>(this)) {
    char* begin = const_cast<char*>(text.data());  // never written to: there is no put area
    setg(begin, begin, begin + text.size());
  }
};

class LineReader {
 public:
  static constexpr std::size_t kLongestLine = std::size_t{1} << 22;

  /// `name` stands for the file in messages. Skips a byte-order mark.
  LineReader(std::istream& stream, std::string name);

  /// The next line without its LF or CRLF, valid until the next call; false at the end. A line of
  /// more than kLongestLine bytes, or a stream that can't be read: InputError.
  bool next(std::string_view& line);
  [[nodiscard]] int line() const { return line_; }  ///< of the last next(), 1-based
  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] InputError error(const std::string& what) const;  ///< "name:line: what"

 private:
  bool fill();

  std::istream& stream_;
  std::string name_;
  std::string buffer_;
  std::size_t at_ = 0;
  int line_ = 0;
  bool ended_ = false;
};

/// Without blanks and tabs at the ends.
std::string_view trim(std::string_view text);
/// Text as it may stand in a message: short, and printable whatever the file holds.
std::string shown(std::string_view text);
/// A finite number in decimal notation and nothing else.
bool parse_number(std::string_view cell, double& value);

/// The cells of a line, trimmed; a cell in double quotes may hold separators and doubled quotes.
/// `line` as error() has it.
void split_cells(std::string_view line, char separator, const LineReader& reader,
                 std::vector<std::string>& cells);

}  // namespace jaculus::trajectory
