#pragma once
// Any CSV log through a map of its columns, in YAML:
//
//   format: jaculus-columns/1
//   stream: joints
//   rate_hz: 500                     # optional, as stated
//   separator: ","                   # or ";", "tab", "space"
//   skip_lines: 0                    # before the header
//   header: true                     # false: there is none, and columns are numbers from 1
//   gaps: ["nan", "NaN"]             # texts that mean a gap, besides an empty cell
//   channels:
//     time: {column: "t (us)", unit: us}
//     front_a: {columns: [q0, q4], unit: deg, scale: -1, offset: 90} # SI of scale * mean + offset
//
// Columns that are not named are passed over. Of two columns that make up a joint's position, left
// and right, the first less the second stands beside their mean, as `front_a_apart`. Line by line,
// one pass.

#include <filesystem>
#include <istream>
#include <string>
#include <vector>

#include "jaculus/core/yaml.h"
#include "jaculus/trajectory/dataset.h"

namespace jaculus::trajectory {

struct MappedChannel {
  std::string channel;
  std::vector<std::string> columns;  ///< the mean of these
  std::string unit;                  ///< SI unit of the channel
  double scale = 1.0;                ///< SI = scale * mean + shift
  double shift = 0.0;
  /// channel of what two columns of a joint's position differ by, "front_a_apart"; else empty, as
  /// where the map states it itself
  std::string apart{};
};

struct ColumnMap {
  std::string stream = kJointStream;
  double rate_hz = kNaN;
  char separator = ',';
  int skip_lines = 0;
  bool header = true;
  std::vector<std::string> gaps;
  std::vector<MappedChannel> channels;  ///< time among them
};

/// Checks a map. Faults: InputError with the node's place.
ColumnMap read_column_map(const yaml::Node& description);

/// Reads a log in one pass. A column that is not there, a cell that is no number, time that does
/// not rise, a short row: InputError with file:line. A last row that is cut short is dropped, with
/// a note.
Stream read_mapped_csv(std::istream& stream, const std::string& name, const ColumnMap& map,
                       std::vector<std::string>& notes);
Stream read_mapped_csv(const std::filesystem::path& file, const ColumnMap& map,
                       std::vector<std::string>& notes);

}  // namespace jaculus::trajectory
