#include "jaculus/trajectory/csv.h"

#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include "jaculus/core/error.h"
#include "jaculus/core/yaml.h"
#include "trajectory/line_reader.h"
#include "trajectory/open_input.h"

namespace jaculus::trajectory {
namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

class Parser {
 public:
  Parser(std::istream& stream, const std::string& name) : reader_(stream, name), name_(name) {}

  Table parse() {
    std::string_view line;
    if (!next_line(line))
      throw InputError({.file = name_}, "the file is empty; a header line and rows are expected");
    header(line);
    while (next_line(line)) row(line);
    if (cells_.empty() && table_.phase.empty())
      throw InputError({name_, 1}, "there is a header but no row");
    const auto columns = std::ssize(table_.columns);
    table_.values =
        Eigen::Map<const RowMajor>(cells_.data(), std::ssize(cells_) / columns, columns);
    return std::move(table_);
  }

 private:
  [[nodiscard]] InputError error(const std::string& what) const { return reader_.error(what); }

  /// The next line that is not blank; blank lines may stand at the end only.
  bool next_line(std::string_view& line) {
    int blank = 0;
    while (reader_.next(line)) {
      if (trim(line).empty()) {
        if (blank == 0) blank = reader_.line();
        continue;
      }
      if (blank > 0)
        throw InputError({name_, blank},
                         fmt::format("a blank line stands {}",
                                     columns_ == 0 ? "before the header" : "between the rows"));
      return true;
    }
    return false;
  }

  /// Takes the next cell off `line`; `more` tells whether a comma followed. Quoted text with
  /// doubled quotes goes through unquoted_.
  std::string_view next_cell(std::string_view& line, bool& more) {
    const auto start = line.find_first_not_of(" \t");
    if (start != std::string_view::npos && line[start] == '"')
      return quoted_cell(line, start + 1, more);
    const auto end = line.find(',');
    const std::string_view cell = line.substr(0, end);
    more = end != std::string_view::npos;
    line.remove_prefix(more ? end + 1 : line.size());
    return trim(cell);
  }

  std::string_view quoted_cell(std::string_view& line, std::size_t at, bool& more) {
    unquoted_.clear();
    for (;; ++at) {
      if (at >= line.size()) throw error("a quoted cell has no closing quote on its line");
      if (line[at] != '"') {
        unquoted_ += line[at];
      } else if (at + 1 < line.size() && line[at + 1] == '"') {
        unquoted_ += line[at++];
      } else {
        break;
      }
    }

    line.remove_prefix(at + 1);
    const auto end = line.find(',');
    if (!trim(line.substr(0, end)).empty())
      throw error(
          fmt::format("'{}' stands behind a closing quote", shown(trim(line.substr(0, end)))));

    more = end != std::string_view::npos;
    line.remove_prefix(more ? end + 1 : line.size());
    return trim(unquoted_);
  }

  void header(std::string_view line) {
    if (line.find(',') == std::string_view::npos && line.find(';') != std::string_view::npos)
      throw error("the header has semicolons but no comma; cells are to be separated by commas");
    std::set<std::string> seen;
    for (bool more = true; more;) {
      const Column column = parse_column(next_cell(line, more));
      if (!seen.insert(column.name).second)
        throw error(fmt::format("column '{}' stands twice", shown(column.name)));
      if (column.name == "phase" && column.unit.empty()) {
        phase_column_ = columns_;
      } else {
        table_.columns.push_back(column);
      }
      ++columns_;
    }
    if (table_.columns.empty()) throw error("there is no column of numbers");
  }

  [[nodiscard]] Column parse_column(std::string_view cell) const {
    const auto bracket = cell.find('[');
    const std::string_view name = trim(cell.substr(0, bracket));
    if (name.empty()) throw error("a column has no name; 'name [unit]' is expected");
    if (double number = 0.0; parse_number(name, number))
      throw error(fmt::format(
          "'{}' stands where a column name is expected; the first line is to be a header",
          shown(name)));
    if (bracket == std::string_view::npos) return {std::string(name), ""};
    if (!cell.ends_with(']') || cell.find_first_of("[]", bracket + 1) != cell.size() - 1)
      throw error(fmt::format("column '{}': 'name [unit]' is expected", shown(cell)));
    const std::string_view unit = trim(cell.substr(bracket + 1, cell.size() - bracket - 2));
    if (unit.empty())
      throw error(fmt::format("column '{}': the brackets hold no unit; '[-]' stands for none",
                              shown(cell)));
    return {std::string(name), std::string(unit)};
  }

  void row(std::string_view line) {
    int cells = 0;
    std::size_t numbers = 0;
    for (bool more = true; more; ++cells) {
      const std::string_view cell = next_cell(line, more);
      if (cells >= columns_) continue;  // counted, to say how many there are
      if (cells == phase_column_) {
        table_.phase.emplace_back(cell);
        continue;
      }

      double value = kNaN;
      if (!cell.empty() && !parse_number(cell, value))
        throw error(
            fmt::format("column '{}': '{}' is not a number; a finite number, or an empty cell for "
                        "a gap, is expected",
                        table_.columns[numbers].name, shown(cell)));
      cells_.push_back(value);
      ++numbers;
    }

    if (cells != columns_)
      throw error(fmt::format("the row has {} cell{}; the header has {}", cells,
                              cells == 1 ? "" : "s", columns_));
  }

  LineReader reader_;
  std::string name_;
  int columns_ = 0;        ///< of the file, the phase's among them
  int phase_column_ = -1;  ///< its place in the file
  std::string unquoted_;   ///< the text of the last quoted cell
  std::vector<double> cells_;
  Table table_;
};

void append_text(std::string& out, const std::string& text) {
  // An empty text needs its quotes where it would be all that stands on a line; elsewhere they do
  // no harm.
  if (!text.empty() && text.find_first_of(",\"") == std::string::npos &&
      trim(text).size() == text.size()) {
    out += text;
    return;
  }
  out += '"';
  for (const char c : text) out.append(c == '"' ? 2 : 1, c);
  out += '"';
}

std::string header_of(const Column& column) {
  return column.unit.empty() ? column.name : column.name + " [" + column.unit + "]";
}

}  // namespace

int Table::column(const std::string& name) const {
  for (int i = 0; i < count_of(columns); ++i)
    if (columns[i].name == name) return i;
  return -1;
}

Table parse_csv(std::string_view text, const std::string& name) {
  ViewStream stream(text);
  return Parser(stream, name).parse();
}

Table read_csv(const std::filesystem::path& file) {
  std::ifstream stream = open_input(file, "a CSV file");
  return Parser(stream, file.string()).parse();
}

Vector quantity(const Table& table, const std::string& name, const Dimension& dimension,
                const std::filesystem::path& file) {
  const int index = table.column(name);
  if (index < 0) {
    std::vector<std::string> names;
    for (const Column& column : table.columns) names.push_back(column.name);
    const std::optional<std::string> near = yaml::nearest_name(name, names);
    throw InputError({file.string(), 1},
                     fmt::format("column '{} [{}]' is missing{}", name, unit_name(dimension),
                                 near ? fmt::format("; did you mean '{}'?", *near) : ""));
  }

  const std::string& unit = table.columns[index].unit;
  double factor = 1.0;
  if (unit.empty() || unit == "-") {
    if (dimension != dimension::none)
      throw InputError({file.string(), 1},
                       fmt::format("column '{}' has no unit; '{} [{}]' is expected", name, name,
                                   unit_name(dimension)));
  } else {
    try {
      factor = parse_quantity("1 " + unit, dimension);
    } catch (const InputError& error) {
      throw InputError({file.string(), 1, fmt::format("column '{} [{}]'", name, unit)},
                       error.what());
    }
  }

  return factor * table.values.col(index);
}

namespace {

/// One line: `cell(i)` appends cell i to `out`; the phase stands second where there is one.
template <class Cell>
void append_line(std::string& out, std::size_t cells, const std::string* phase, const Cell& cell) {
  for (std::size_t i = 0; i < cells; ++i) {
    if (i > 0) out += ',';
    cell(i);
    if (i == 0 && phase != nullptr) {
      out += ',';
      append_text(out, *phase);
    }
  }
  out += '\n';
}

void append_header(std::string& out, const std::vector<Column>& columns, bool with_phase) {
  const std::string phase = "phase";
  append_line(out, columns.size(), with_phase ? &phase : nullptr,
              [&](std::size_t i) { append_text(out, header_of(columns[i])); });
}

void append_row(std::string& out, const Matrix& values, Eigen::Index row,
                const std::string* phase) {
  const std::size_t cells = values.cols();
  append_line(out, cells, phase, [&](std::size_t i) {
    const double value = values(row, i);
    if (!std::isnan(value)) {
      fmt::format_to(std::back_inserter(out), "{}", value);
    } else if (cells == 1) {
      out += "\"\"";  // a blank line at the end would not count as a row
    }
  });
}

}  // namespace

std::string format_csv(const Table& table) {
  std::string out;
  out.reserve(20 * table.values.size() + 1024);
  append_header(out, table.columns, !table.phase.empty());
  for (Eigen::Index row = 0; row < table.values.rows(); ++row)
    append_row(out, table.values, row, table.phase.empty() ? nullptr : &table.phase[row]);
  return out;
}

void write_csv(const Table& table, const std::filesystem::path& file) {
  write_file(file, format_csv(table));
}

void write_csv(const std::vector<Column>& columns, const std::function<Matrix(Eigen::Index)>& block,
               const std::filesystem::path& file) {
  Eigen::Index row = 0;
  bool begun = false;
  write_file(file, [&] {
    std::string out;
    if (!std::exchange(begun, true)) append_header(out, columns, false);
    const Matrix rows = block(row);
    for (Eigen::Index k = 0; k < rows.rows(); ++k) append_row(out, rows, k, nullptr);
    row += rows.rows();
    return out;
  });
}

}  // namespace jaculus::trajectory
