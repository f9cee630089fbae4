#include "jaculus/trajectory/optitrack.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <map>
#include <numbers>
#include <set>

#include "jaculus/core/error.h"
#include "jaculus/core/yaml.h"
#include "trajectory/line_reader.h"
#include "trajectory/open_input.h"

namespace jaculus::trajectory {
namespace {

using Cells = std::vector<std::string>;

/// Where a body's numbers stand in a frame's cells; -1 where there is no such column.
struct BodyColumns {
  std::string name;
  std::array<int, 3> position{-1, -1, -1};
  std::array<int, 4> rotation{-1, -1, -1, -1};  ///< x, y, z, w, or Euler x, y, z
};

Eigen::Quaterniond euler(const std::string& order, const Eigen::Vector3d& degrees) {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  for (const char axis : order) {
    const int i = axis - 'X';
    rotation = rotation *
               Eigen::AngleAxisd(degrees[i] * std::numbers::pi / 180.0, Eigen::Vector3d::Unit(i));
  }
  return rotation;
}

class OptitrackReader {
 public:
  OptitrackReader(std::istream& stream, const std::string& name) : reader_(stream, name) {}

  MocapTake read() {
    std::string_view line;
    if (!reader_.next(line)) throw InputError(fmt::format("{}: the file is empty", reader_.name()));
    split(line);
    if (cells_[0] == "Format Version") {
      read_keys();
      read_header();
      while (reader_.next(line)) grid_frame(line);
    } else {
      read_keyword_file();
    }
    return finish();
  }

 private:
  void split(std::string_view line) { split_cells(line, ',', reader_, cells_); }
  [[nodiscard]] const std::string& cell(std::size_t i) const {
    static const std::string none;
    return i < cells_.size() ? cells_[i] : none;
  }

  void read_keys() {
    std::map<std::string, std::string> keys;
    for (std::size_t i = 0; i + 1 < cells_.size(); i += 2) keys[cells_[i]] = cells_[i + 1];
    take_.version = keys["Format Version"];
    double version = 0.0;
    if (!parse_number(take_.version, version) || version < 1.1 || version >= 2.0)
      throw reader_.error(fmt::format("Format Version '{}' given; allowed: 1.1 and later 1.x",
                                      shown(take_.version)));
    for (const char* key : {"Export Frame Rate", "Capture Frame Rate"}) {
      double rate = 0.0;
      if (std::isnan(take_.rate_hz) && parse_number(keys[key], rate) && rate > 0.0)
        take_.rate_hz = rate;
    }
    read_units(keys["Length Units"]);
    read_rotation(keys["Rotation Type"]);
    if (const std::string& space = keys["Coordinate Space"]; space == "Local")
      throw reader_.error(
          "Coordinate Space 'Local' given; allowed: Global (export again in global coordinates)");
  }

  void read_units(const std::string& unit) {
    const std::map<std::string, double> units = {
        {"Meters", 1.0}, {"Centimeters", 0.01}, {"Millimeters", 0.001}};
    if (unit.empty()) {
      take_.notes.emplace_back("no Length Units are stated: metres are taken");
      return;
    }
    const auto found = units.find(unit);
    if (found == units.end())
      throw reader_.error(fmt::format(
          "Length Units '{}' given; allowed: Meters, Centimeters, Millimeters", shown(unit)));
    scale_ = found->second;
    take_.notes.push_back(fmt::format("lengths are in {} as the file states", unit));
  }

  void read_rotation(const std::string& type) {
    if (type.empty() || type == "Quaternion") {
      take_.notes.emplace_back(type.empty() ? "no Rotation Type is stated: quaternions are taken"
                                            : "rotations are quaternions as the file states");
      return;
    }
    std::string letters = type;
    std::sort(letters.begin(), letters.end());
    if (letters != "XYZ")
      throw reader_.error(fmt::format(
          "Rotation Type '{}' given; allowed: Quaternion, or an order of X, Y, Z", shown(type)));
    order_ = type;
    take_.notes.push_back(fmt::format(
        "rotations are Euler angles {} in degrees, taken as turns about the body's own axes",
        type));
  }

  /// The rows between the first line and "Frame,Time ...". Which is which is told by their first
  /// two cells or their content.
  void read_header() {
    std::vector<Cells> rows;
    constexpr std::size_t kMostRows = 12;
    for (std::string_view line; reader_.next(line) && rows.size() <= kMostRows;) {
      split(line);
      if (cells_[0] == "Frame") {
        assign_columns(rows);
        return;
      }
      if (!trim(line).empty()) rows.push_back(cells_);
    }
    throw reader_.error(
        "no line 'Frame,Time (Seconds),...' follows the header; the file is cut short or no Motive "
        "export");
  }

  void assign_columns(const std::vector<Cells>& rows) {
    frame_cells_ = cells_.size();
    const auto has = [](const Cells& row, std::string_view text) {
      return std::any_of(row.begin(), row.end(),
                         [text](const std::string& c) { return c == text; });
    };

    const auto kinds = std::find_if(rows.begin(), rows.end(),
                                    [&](const Cells& row) { return has(row, "Rigid Body"); });
    const auto parts = std::find_if(rows.begin(), rows.end(),
                                    [&](const Cells& row) { return has(row, "Position"); });

    if (kinds == rows.end() || kinds + 1 == rows.end())
      throw reader_.error(
          "there is no rigid body in this export; allowed: an export with rigid bodies");
    if (parts == rows.end())
      throw reader_.error("no header row says which columns are Position and which Rotation");

    const Cells& names = *(kinds + 1);
    for (std::size_t i = 2; i < frame_cells_; ++i) {
      if (i >= kinds->size() || (*kinds)[i] != "Rigid Body" || i >= names.size() ||
          i >= parts->size())
        continue;
      assign_column((*parts)[i], names[i], cells_[i], static_cast<int>(i));
    }

    check_columns();
  }

  void assign_column(const std::string& part, const std::string& name, const std::string& axis,
                     int index) {
    auto body = std::find_if(columns_.begin(), columns_.end(),
                             [&](const BodyColumns& b) { return b.name == name; });
    if (body == columns_.end())
      body = columns_.insert(columns_.end(), BodyColumns{name, {-1, -1, -1}, {-1, -1, -1, -1}});
    const std::size_t at = std::string_view("XYZW").find(axis);
    if (axis.size() != 1 || at == std::string_view::npos) return;  // an error column
    int* place = nullptr;
    if (part == "Position" && at < 3) place = &body->position[at];
    if (part == "Rotation") place = &body->rotation[at];
    if (place == nullptr) return;
    if (*place >= 0)
      throw reader_.error(
          fmt::format("body '{}' has two columns {} {}; allowed: bodies of different names",
                      shown(name), part, axis));
    *place = index;
  }

  void check_columns() {
    const std::size_t parts = order_.empty() ? 4 : 3;
    for (const BodyColumns& body : columns_) {
      const bool whole =
          std::all_of(body.position.begin(), body.position.end(), [](int i) { return i >= 0; }) &&
          std::all_of(body.rotation.begin(), body.rotation.begin() + parts,
                      [](int i) { return i >= 0; });
      if (!whole)
        throw reader_.error(
            fmt::format("body '{}' lacks columns; allowed: Position X, Y, Z and Rotation {}",
                        shown(body.name), order_.empty() ? "X, Y, Z, W" : "X, Y, Z"));
    }
    if (columns_.empty()) throw reader_.error("there is no rigid body in this export");
    samples_.resize(columns_.size());
  }

  void grid_frame(std::string_view line) {
    if (trim(line).empty()) return;
    require_whole();
    split(line);

    // Motive ends lines with a comma
    while (cells_.size() > frame_cells_ && cells_.back().empty()) cells_.pop_back();
    if (cells_.size() > frame_cells_)
      throw reader_.error(
          fmt::format("the frame has {} cells; the header has {}", cells_.size(), frame_cells_));

    if (cells_.size() + 1 < frame_cells_) {
      short_line_ = reader_.line();
      return;
    }

    add_time(1);
    for (std::size_t b = 0; b < columns_.size(); ++b) {
      std::array<double, 7> values{};
      for (std::size_t i = 0; i < 3; ++i) values[i] = number(columns_[b].position[i]);
      for (std::size_t i = 0; i < 4; ++i) values[3 + i] = number(columns_[b].rotation[i]);
      add_sample(b, values);
    }
  }

  /// A frame cut short may only be the last.
  void require_whole() {
    if (short_line_ == 0) return;
    throw InputError(fmt::format("{}:{}: the frame has fewer cells than the header ({})",
                                 reader_.name(), short_line_, frame_cells_));
  }

  [[nodiscard]] double number(int index) const {
    if (index < 0) return kNaN;
    const std::string& text = cell(index);
    double value = kNaN;
    if (!text.empty() && !parse_number(text, value))
      throw reader_.error(fmt::format(
          "'{}' is not a number; a number, or an empty cell for a gap, is expected", shown(text)));
    return value;
  }

  void add_time(std::size_t index) {
    double time = kNaN;
    if (!parse_number(cell(index), time))
      throw reader_.error(fmt::format("'{}' is not a time", shown(cell(index))));
    if (!times_.empty() && !(time > times_.back()))
      throw reader_.error(fmt::format("time {:.10g} s follows {:.10g} s; allowed: rising times",
                                      time, times_.back()));
    times_.push_back(time);
  }

  /// x, y, z, then the rotation's numbers. A quaternion that is none (all zero) is a gap.
  void add_sample(std::size_t body, const std::array<double, 7>& v) {
    Eigen::Matrix<double, 7, 1> sample = Eigen::Matrix<double, 7, 1>::Constant(kNaN);
    sample.head<3>() = scale_ * Eigen::Vector3d(v[0], v[1], v[2]);
    Eigen::Quaterniond rotation(v[6], v[3], v[4], v[5]);
    if (!order_.empty()) rotation = euler(order_, {v[3], v[4], v[5]});
    const double norm = rotation.norm();
    if (norm > 1e-6 && std::isfinite(norm)) sample.tail<4>() = rotation.coeffs() / norm;
    if (!sample.allFinite()) sample.setConstant(kNaN);
    samples_[body].push_back(sample);
  }

  // Version 1.1
  // -----------------------------------------------------------------------------------------------

  void read_keyword_file() {
    std::set<std::string> seen;
    for (std::string_view line; true; split(line)) {
      const std::string keyword = cells_[0];
      if (keyword == "frame") {
        require_whole();
        keyword_frame();
      } else if (keyword == "info" && cell(1) == "version") {
        take_.version = cell(2);
      } else if (keyword == "lefthanded") {
        throw reader_.error("left-handed coordinates given; allowed: righthanded");
      } else if (keyword == "rigidbody" && times_.empty()) {
        if (!seen.insert(cell(2)).second)
          throw reader_.error(fmt::format("body id '{}' stands twice", shown(cell(2))));
        columns_.push_back({cell(1), {-1, -1, -1}, {-1, -1, -1, -1}});
        ids_.push_back(cell(2));
        samples_.emplace_back();
      } else if (!keyword.empty() && keyword != "comment" && keyword != "righthanded" &&
                 keyword != "info" && keyword != "rigidbody") {
        throw reader_.error(
            fmt::format("'{}' begins the line; allowed: 'Format Version' at the top, or the "
                        "keywords of version 1.1 (comment, "
                        "righthanded, info, rigidbody, frame)",
                        shown(keyword)));
      }
      if (!reader_.next(line)) break;
    }

    if (take_.version.empty())
      throw InputError(
          fmt::format("{}: no 'Format Version' and no 'info,version' here", reader_.name()));
    if (columns_.empty()) throw reader_.error("there is no rigid body in this export");
    take_.notes.emplace_back("format version 1.1: metres and quaternions are taken");
  }

  void keyword_frame() {
    constexpr std::size_t kFirst = 4, kCells = 11;
    int count = 0;
    double number_of_bodies = 0.0;

    if (!parse_number(cell(3), number_of_bodies) || number_of_bodies < 0.0 ||
        number_of_bodies > 1000.0) {
      if (cells_.size() > 3)
        throw reader_.error(fmt::format("'{}' is no number of bodies", shown(cell(3))));
      short_line_ = reader_.line();
      return;
    }

    count = static_cast<int>(number_of_bodies);
    frame_cells_ = kFirst + count * kCells;
    if (cells_.size() < frame_cells_) {
      short_line_ = reader_.line();
      return;
    }

    add_time(2);
    std::vector<bool> present(ids_.size(), false);
    for (std::size_t first = kFirst; first < frame_cells_; first += kCells) {
      const auto id = std::find(ids_.begin(), ids_.end(), cell(first));
      if (id == ids_.end())
        throw reader_.error(fmt::format("body id '{}' was not declared", shown(cell(first))));

      const std::size_t body = id - ids_.begin();
      if (present[body])
        throw reader_.error(fmt::format("body id '{}' stands twice in the frame", shown(*id)));
      present[body] = true;

      std::array<double, 7> values{};
      for (std::size_t i = 0; i < 7; ++i) values[i] = number(static_cast<int>(first + 1 + i));
      add_sample(body, values);
    }

    std::array<double, 7> gap{};
    gap.fill(kNaN);
    for (std::size_t b = 0; b < present.size(); ++b)
      if (!present[b]) add_sample(b, gap);
  }

  MocapTake finish() {
    if (times_.empty())
      throw InputError(fmt::format("{}: there is a header but no frame", reader_.name()));
    if (short_line_ > 0)
      take_.notes.push_back(
          fmt::format("line {}, the last, is cut short and was dropped", short_line_));

    const auto frames = std::ssize(times_);
    take_.time = Eigen::Map<const Vector>(times_.data(), frames);
    if (std::isnan(take_.rate_hz) && frames > 1)
      take_.rate_hz = static_cast<double>(frames - 1) / (take_.time[frames - 1] - take_.time[0]);

    for (std::size_t b = 0; b < columns_.size(); ++b) {
      MocapBody body{columns_[b].name, Matrix(3, frames), Matrix(4, frames)};
      for (Eigen::Index k = 0; k < frames; ++k) {
        body.position.col(k) = samples_[b][k].head<3>();
        body.rotation.col(k) = samples_[b][k].tail<4>();
      }
      take_.bodies.push_back(std::move(body));
    }

    return std::move(take_);
  }

  LineReader reader_;
  MocapTake take_;
  Cells cells_;
  double scale_ = 1.0;
  std::string order_;  ///< of Euler angles; empty: quaternions
  std::size_t frame_cells_ = 0;
  int short_line_ = 0;
  std::vector<BodyColumns> columns_;
  std::vector<std::string> ids_;  ///< version 1.1
  std::vector<double> times_;
  std::vector<std::vector<Eigen::Matrix<double, 7, 1>>> samples_;  ///< by body, by frame
};

}  // namespace

MocapTake read_optitrack(std::istream& stream, const std::string& name) {
  return OptitrackReader(stream, name).read();
}

MocapTake read_optitrack(const std::filesystem::path& file) {
  std::ifstream stream = open_input(file, "a CSV export of Motive");
  return read_optitrack(stream, file.string());
}

}  // namespace jaculus::trajectory
