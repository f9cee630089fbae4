#include "jaculus/trajectory/column_map.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>

#include "jaculus/core/error.h"
#include "trajectory/line_reader.h"
#include "trajectory/mapped_channel.h"
#include "trajectory/open_input.h"

namespace jaculus::trajectory {
namespace {

class ColumnMapReader {
 public:
  ColumnMapReader(std::istream& stream, const std::string& name, const ColumnMap& map)
      : reader_(stream, name), map_(map) {
    for (int c = 0; c < count_of(map.channels); ++c)
      if (!map.channels[c].apart.empty()) sides_.push_back(c);
  }

  Stream read(std::vector<std::string>& notes) {
    std::string_view line;
    for (int i = 0; i < map_.skip_lines; ++i)
      if (!reader_.next(line))
        throw InputError(
            fmt::format("{}: ends within the {} lines to skip", reader_.name(), map_.skip_lines));

    if (map_.header) {
      if (!reader_.next(line))
        throw InputError(fmt::format("{}: there is no header line", reader_.name()));
      split(line);
      names_ = cells_;
      if (names_.size() == 1 && map_.separator == ',' && names_[0].find(';') != std::string::npos)
        throw reader_.error(
            "the header has semicolons but no comma; if they part the cells, the map needs "
            "separator: \";\"");
    }

    while (reader_.next(line)) row(line);
    if (times_.empty()) throw InputError(fmt::format("{}: there is no row", reader_.name()));

    if (short_line_ > 0)
      notes.push_back(fmt::format("line {}, the last, is cut short and was dropped", short_line_));
    for (const MappedChannel& channel : map_.channels)
      if (channel.columns.size() > 1)
        notes.push_back(fmt::format("{} is the mean of the columns {}", channel.channel,
                                    fmt::join(channel.columns, ", ")));
    for (const int c : sides_)
      notes.push_back(fmt::format("{} is {} less {}", map_.channels[c].apart,
                                  map_.channels[c].columns[0], map_.channels[c].columns[1]));

    return finish();
  }

 private:
  void split(std::string_view line) {
    if (map_.separator != ' ') {
      split_cells(line, map_.separator, reader_, cells_);
      return;
    }
    cells_.clear();  // runs of blanks part the cells
    for (std::string_view rest = trim(line); !rest.empty();) {
      const std::size_t end = rest.find_first_of(" \t");
      cells_.emplace_back(rest.substr(0, end));
      rest = end == std::string_view::npos ? std::string_view() : trim(rest.substr(end));
    }
  }

  /// Where the channels' columns stand, once the width is known.
  void find_columns() {
    if (!map_.header)
      for (std::size_t i = 0; i < cells_.size(); ++i) names_.push_back(fmt::format("{}", i + 1));
    for (const MappedChannel& channel : map_.channels) {
      places_.emplace_back();
      for (const std::string& column : channel.columns) {
        const auto found = std::find(names_.begin(), names_.end(), column);
        if (found == names_.end()) {
          throw reader_.error(fmt::format("there is no column '{}' for {}{}; allowed: {}", column,
                                          channel.channel, yaml::did_you_mean(column, names_),
                                          shown_names()));
        }
        if (std::count(names_.begin(), names_.end(), column) > 1)
          throw reader_.error(fmt::format("column '{}' stands twice", shown(column)));
        places_.back().push_back(found - names_.begin());
      }
    }
  }

  [[nodiscard]] std::string shown_names() const {
    std::vector<std::string> names;
    for (const std::string& name : names_) names.push_back(shown(name));
    return fmt::format("{}", fmt::join(names, ", "));
  }

  void row(std::string_view line) {
    if (trim(line).empty()) return;
    if (short_line_ > 0)
      throw InputError(fmt::format("{}:{}: the row has fewer cells than the others ({})",
                                   reader_.name(), short_line_, names_.size()));

    split(line);
    if (places_.empty()) find_columns();

    if (cells_.size() < names_.size()) {
      short_line_ = reader_.line();
      return;
    }
    if (cells_.size() > names_.size() &&
        !(cells_.size() == names_.size() + 1 && cells_.back().empty()))
      throw reader_.error(
          fmt::format("the row has {} cells; the others have {}", cells_.size(), names_.size()));

    for (std::size_t c = 0; c < map_.channels.size(); ++c) {
      double sum = 0.0;
      for (const std::size_t place : places_[c]) sum += number(place);
      const MappedChannel& channel = map_.channels[c];
      const double value =
          channel.scale * sum / static_cast<double>(places_[c].size()) + channel.shift;
      if (channel.channel == "time") {
        add_time(value);
      } else {
        values_.push_back(value);
      }
    }
    for (const int c : sides_)
      values_.push_back(map_.channels[c].scale * (number(places_[c][0]) - number(places_[c][1])));
  }

  [[nodiscard]] double number(std::size_t place) const {
    const std::string& text = cells_[place];
    double value = kNaN;
    if (text.empty() || std::find(map_.gaps.begin(), map_.gaps.end(), text) != map_.gaps.end())
      return kNaN;
    if (!parse_number(text, value))
      throw reader_.error(fmt::format(
          "column '{}': '{}' is not a number; allowed: a finite number, an empty cell, or what "
          "the map calls a gap (`gaps: [NA]`); lines before the names go by `skip_lines`",
          shown(names_[place]), shown(text)));
    return value;
  }

  void add_time(double time) {
    if (std::isnan(time))
      throw reader_.error("time: an empty cell given; allowed: a time in every row");
    if (!times_.empty() && !(time > times_.back()))
      throw reader_.error(
          fmt::format("time: {:.10g} s follows {:.10g} s; allowed: rising times, so "
                      "that a row which repeats a stamp has to go",
                      time, times_.back()));
    times_.push_back(time);
  }

  Stream finish() {
    Stream stream;
    stream.name = map_.stream;
    stream.rate_hz = map_.rate_hz;
    for (const MappedChannel& channel : map_.channels) {
      if (channel.channel == "time") continue;
      stream.channels.push_back(channel.channel);
      stream.units.push_back(channel.unit);
    }
    for (const int c : sides_) {
      stream.channels.push_back(map_.channels[c].apart);
      stream.units.push_back(map_.channels[c].unit);
    }
    const auto samples = std::ssize(times_);
    stream.time = Eigen::Map<const Vector>(times_.data(), samples);
    stream.values = Eigen::Map<const Matrix>(values_.data(), stream.channels.size(), samples);
    return stream;
  }

  LineReader reader_;
  const ColumnMap& map_;
  std::vector<std::string> cells_, names_;
  std::vector<std::vector<std::size_t>> places_;  ///< by channel
  std::vector<int> sides_;                        ///< channels that are the mean of two sides
  std::vector<double> times_, values_;
  int short_line_ = 0;
};

}  // namespace

ColumnMap read_column_map(const yaml::Node& node) {
  yaml::refuse_other_kind(node, "jaculus-columns/1");
  node.only(
      {"format", "stream", "rate_hz", "separator", "skip_lines", "header", "gaps", "channels"});
  (void)node.at("format").choice({"jaculus-columns/1"});

  ColumnMap map;
  if (const auto stream = node.find("stream")) map.stream = stream->text();
  if (const auto rate = node.find("rate_hz"))
    map.rate_hz = rate->number(dimension::frequency, {1e-12, kInfinity});
  if (const auto separator = node.find("separator")) {
    const std::map<std::string, char> separators = {
        {",", ','}, {";", ';'}, {"tab", '\t'}, {"space", ' '}};
    map.separator = separators.at(separator->choice({",", ";", "tab", "space"}));
  }

  if (const auto skip = node.find("skip_lines")) map.skip_lines = skip->integer(0, 1000000);
  if (const auto header = node.find("header")) map.header = header->boolean();
  if (const auto gaps = node.find("gaps")) map.gaps = gaps->texts();

  map.channels = read_mapped_channels(node.at("channels"), "column");
  const auto times =
      std::count_if(map.channels.begin(), map.channels.end(),
                    [](const MappedChannel& channel) { return channel.channel == "time"; });
  if (times != 1 || map.channels.size() < 2)
    throw node.at("channels").error("allowed: time and at least one more channel");

  return map;
}

Stream read_mapped_csv(std::istream& stream, const std::string& name, const ColumnMap& map,
                       std::vector<std::string>& notes) {
  return ColumnMapReader(stream, name, map).read(notes);
}

Stream read_mapped_csv(const std::filesystem::path& file, const ColumnMap& map,
                       std::vector<std::string>& notes) {
  std::ifstream stream = open_input(file, "a CSV file");
  return read_mapped_csv(stream, file.string(), map, notes);
}

}  // namespace jaculus::trajectory
