#include "jaculus/trajectory/trajectory.h"

#include <algorithm>
#include <cassert>
#include <cstddef>

namespace jaculus {
namespace {

/// Whether a coordinate or joint is measured in metres. A joint that is no coordinate follows from a loop, hence is an
/// angle.
bool linear(const Trajectory& t, const std::string& name) {
  const auto found = std::find(t.coordinates.begin(), t.coordinates.end(), name);
  return found != t.coordinates.end() && !t.angular[static_cast<std::size_t>(found - t.coordinates.begin())];
}

class Columns {
 public:
  explicit Columns(Eigen::Index samples) : samples_(samples) {}

  void add(std::string name, const char* unit, const Eigen::Ref<const Eigen::RowVectorXd>& values) {
    table_.columns.push_back({std::move(name), unit});
    rows_.emplace_back(values);
  }

  /// One column for each of `names` that `keep` takes; nothing where the quantity is absent (a matrix without rows).
  template <class Unit, class Keep>
  void add(const std::vector<std::string>& names, const char* suffix, Unit unit, const Matrix& values, Keep keep) {
    if (values.rows() == 0) return;
    assert(values.rows() == static_cast<Eigen::Index>(names.size()) && values.cols() == samples_);
    for (std::size_t i = 0; i < names.size(); ++i)
      if (keep(names[i])) add(names[i] + suffix, unit(names[i]), values.row(static_cast<Eigen::Index>(i)));
  }
  template <class Unit>
  void add(const std::vector<std::string>& names, const char* suffix, Unit unit, const Matrix& values) {
    add(names, suffix, unit, values, [](const std::string&) { return true; });
  }

  Table finish(std::vector<std::string> phase) {
    table_.values.resize(samples_, static_cast<Eigen::Index>(rows_.size()));
    for (std::size_t i = 0; i < rows_.size(); ++i)
      table_.values.col(static_cast<Eigen::Index>(i)) = rows_[i].transpose();
    table_.phase = std::move(phase);
    return std::move(table_);
  }

 private:
  Eigen::Index samples_;
  Table table_;
  std::vector<Eigen::RowVectorXd> rows_;
};

std::vector<std::string> phase_of_samples(const Trajectory& t) {
  if (t.phases.empty()) return {};
  std::vector<std::string> names(static_cast<std::size_t>(t.samples()));
  for (const PhaseSpan& span : t.phases) {
    assert(0 <= span.first && span.first <= span.last && span.last < t.samples());
    std::fill(names.begin() + span.first, names.begin() + span.last + 1, span.name);
  }
  return names;
}

}  // namespace

Table to_table(const Trajectory& t) {
  assert(t.coordinates.size() == t.angular.size());
  const auto unit = [&t](const char* metres, const char* radians) {
    return [&t, metres, radians](const std::string& name) { return linear(t, name) ? metres : radians; };
  };
  const auto always = [](const char* name) { return [name](const std::string&) { return name; }; };
  const auto no_joint = [&t](const std::string& name) {
    return std::find(t.joints.begin(), t.joints.end(), name) == t.joints.end();
  };

  Columns columns(t.samples());
  columns.add("time", "s", t.time.transpose());
  columns.add(t.coordinates, "", unit("m", "rad"), t.position, no_joint);
  columns.add(t.joints, "", unit("m", "rad"), t.joint_position);
  columns.add(t.coordinates, "_velocity", unit("m/s", "rad/s"), t.velocity, no_joint);
  columns.add(t.joints, "_velocity", unit("m/s", "rad/s"), t.joint_velocity);
  columns.add(t.coordinates, "_acceleration", unit("m/s^2", "rad/s^2"), t.acceleration);
  columns.add(t.motors, "_torque", unit("N", "N m"), t.torque);
  columns.add(t.motors, "_motor_torque", always("N m"), t.motor_torque);
  columns.add(t.motors, "_current", always("A"), t.current);
  columns.add(t.motors, "_voltage", always("V"), t.voltage);
  columns.add(t.feet, "_force_x", always("N"), t.force_x);
  columns.add(t.feet, "_force_z", always("N"), t.force_z);
  return columns.finish(phase_of_samples(t));
}

}  // namespace jaculus
