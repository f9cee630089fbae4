#include "jaculus/trajectory/trajectory.h"

#include <algorithm>
#include <cassert>
#include <cstddef>

#include "jaculus/trajectory/quantity.h"

namespace jaculus::trajectory {
namespace {

/// Whether a coordinate or joint is measured in metres. A joint that is no coordinate follows from
/// a loop, hence is an angle.
bool linear(const Trajectory& t, const std::string& name) {
  const auto found = std::find(t.coordinates.begin(), t.coordinates.end(), name);
  return found != t.coordinates.end() && !t.angular[found - t.coordinates.begin()];
}

class Columns {
 public:
  explicit Columns(const Trajectory& trajectory)
      : trajectory_(trajectory), samples_(trajectory.samples()) {}

  void add(std::string name, std::string unit, const Eigen::Ref<const Eigen::RowVectorXd>& values) {
    table_.columns.push_back({std::move(name), std::move(unit)});
    rows_.emplace_back(values);
  }

  /// One column for each of `names` that `keep` takes; nothing where the quantity is absent (a
  /// matrix without rows).
  template <class Keep>
  void add(const std::vector<std::string>& names, Quantity quantity, const Matrix& values,
           Keep keep) {
    if (values.rows() == 0) return;

    assert(values.rows() == std::ssize(names) && values.cols() == samples_);
    for (int i = 0; i < count_of(names); ++i) {
      if (!keep(names[i])) continue;
      // A motor turns before its gear, whatever it moves.
      const bool slides = quantity != Quantity::motor_torque && linear(trajectory_, names[i]);
      add(channel_name(names[i], quantity), unit_of(quantity, slides), values.row(i));
    }
  }
  void add(const std::vector<std::string>& names, Quantity quantity, const Matrix& values) {
    add(names, quantity, values, [](const std::string&) { return true; });
  }

  Table finish(std::vector<std::string> phase) {
    table_.values.resize(samples_, rows_.size());
    for (int i = 0; i < count_of(rows_); ++i) table_.values.col(i) = rows_[i].transpose();
    table_.phase = std::move(phase);
    return std::move(table_);
  }

 private:
  const Trajectory& trajectory_;
  Eigen::Index samples_;
  Table table_;
  std::vector<Eigen::RowVectorXd> rows_;
};

std::vector<std::string> phase_of_samples(const Trajectory& t) {
  if (t.phases.empty()) return {};
  std::vector<std::string> names(t.samples());
  for (const PhaseSpan& span : t.phases) {
    assert(0 <= span.first && span.first <= span.last && span.last < t.samples());
    std::fill(names.begin() + span.first, names.begin() + span.last + 1, span.name);
  }
  return names;
}

}  // namespace

Table to_table(const Trajectory& t) {
  assert(t.coordinates.size() == t.angular.size());
  const auto no_joint = [&t](const std::string& name) {
    return std::find(t.joints.begin(), t.joints.end(), name) == t.joints.end();
  };

  Columns columns(t);
  columns.add("time", "s", t.time.transpose());
  columns.add(t.coordinates, Quantity::position, t.position, no_joint);
  columns.add(t.joints, Quantity::position, t.joint_position);
  columns.add(t.coordinates, Quantity::velocity, t.velocity, no_joint);
  columns.add(t.joints, Quantity::velocity, t.joint_velocity);
  columns.add(t.coordinates, Quantity::acceleration, t.acceleration);
  columns.add(t.motors, Quantity::torque, t.torque);
  columns.add(t.motors, Quantity::motor_torque, t.motor_torque);
  columns.add(t.motors, Quantity::current, t.current);
  columns.add(t.motors, Quantity::voltage, t.voltage);
  columns.add(t.feet, Quantity::force_x, t.force_x);
  columns.add(t.feet, Quantity::force_z, t.force_z);
  return columns.finish(phase_of_samples(t));
}

}  // namespace jaculus::trajectory
