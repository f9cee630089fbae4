// CSV of jaculus, and foreign CSV through column maps. What was read must come out of the writer
// the same.

#include "jaculus/trajectory/csv.h"

#include <cmath>
#include <sstream>

#include "fuzz/target.h"
#include "jaculus/trajectory/column_map.h"

namespace {

using namespace jaculus;

bool same(const trajectory::Table& a, const trajectory::Table& b) {
  if (a.phase != b.phase || a.values.rows() != b.values.rows() ||
      a.values.cols() != b.values.cols())
    return false;
  for (Eigen::Index i = 0; i < a.values.size(); ++i) {
    const double x = a.values.data()[i], y = b.values.data()[i];
    if (x != y && !(std::isnan(x) && std::isnan(y))) return false;
  }
  return true;
}

const trajectory::ColumnMap& map_of(unsigned index) {
  static const trajectory::ColumnMap maps[] = {
      trajectory::read_column_map(
          yaml::Node::parse("{format: jaculus-columns/1, separator: ';', skip_lines: 1, gaps: "
                            "[lost], channels: {time: "
                            "{column: t, unit: ms}, x: {columns: [a, b], unit: mm, scale: -2}}}",
                            "map")),
      trajectory::read_column_map(
          yaml::Node::parse("{format: jaculus-columns/1, separator: space, header: "
                            "false, channels: {time: {column: 1, "
                            "unit: s}, x: {column: 2, unit: m, offset: 1}}}",
                            "map")),
  };
  return maps[index % 2];
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string text = fuzz::text_of(data + 1, size - 1);
  if (data[0] % 3 == 0) {
    fuzz::refuse_politely([&] {
      const trajectory::Table table = trajectory::parse_csv(text, "fuzz.csv");
      if (!same(table, trajectory::parse_csv(trajectory::format_csv(table), "again.csv")))
        __builtin_trap();
    });
  } else {
    fuzz::refuse_politely([&] {
      std::istringstream stream(text);
      std::vector<std::string> notes;
      (void)trajectory::read_mapped_csv(stream, "fuzz.csv", map_of(data[0]), notes);
    });
  }
  return 0;
}
