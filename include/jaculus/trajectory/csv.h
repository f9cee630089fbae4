#pragma once
// CSV with units: the first line holds column names with units in brackets, "time [s], x [m],
// phase".
//
// What is read: commas between cells, '.' as decimal point, LF or CRLF, an optional byte-order
// mark, cells in double quotes (no line breaks inside), blanks around cells, blank lines at the
// end. An empty cell is a gap (NaN). "nan" and "inf" are refused.

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "jaculus/core/types.h"
#include "jaculus/core/units.h"

namespace jaculus::trajectory {

struct Column {
  std::string name;  ///< "front_a_torque"
  std::string unit;  ///< "N m"; empty where the header has none
};

/// A table of numbers; an empty cell is NaN. `phase` is a column of its own, text, empty where the
/// file has none.
struct Table {
  std::vector<Column> columns;     ///< numeric columns, in order
  Matrix values;                   ///< rows x columns, in the unit of the column
  std::vector<std::string> phase;  ///< one a row, or empty

  [[nodiscard]] int column(const std::string& name) const;  ///< index, -1 where there is none
};

/// Reads a CSV file in one pass. Not found, empty, no rows, ragged, not a number, duplicate column:
/// InputError with file:line.
Table read_csv(const std::filesystem::path& file);

/// The same from text; `name` stands for the file in messages.
Table parse_csv(std::string_view text, const std::string& name);

/// Column `name` of a table read from `file`, converted to SI; gaps stay NaN. No such column (the
/// nearest is named), no unit where the dimension needs one, or a unit of another dimension:
/// InputError.
Vector quantity(const Table& table, const std::string& name, const Dimension& dimension,
                const std::filesystem::path& file);

/// The text of a CSV file: a header, then numbers in the shortest form that reads back the same (at
/// most 17 digits), NaN as an empty cell. `phase` stands second where the table has it.
std::string format_csv(const Table& table);

/// Writes format_csv(table). The file appears whole or not at all.
void write_csv(const Table& table, const std::filesystem::path& file);

/// The same for numbers that come block by block: `block(first row)` gives rows x columns, none at
/// the end.
void write_csv(const std::vector<Column>& columns, const std::function<Matrix(Eigen::Index)>& block,
               const std::filesystem::path& file);

/// Writes text to `file` by way of a temporary neighbour and a rename, so that a reader, or a kill
/// at any moment, meets the old file or the new one. The folder must exist; unwritable: InputError.
/// Anything but a regular file is written in place.
void write_file(const std::filesystem::path& file, const std::string& text);
/// The same for text that comes in pieces, an empty one at the end.
void write_file(const std::filesystem::path& file, const std::function<std::string()>& piece);

}  // namespace jaculus::trajectory
