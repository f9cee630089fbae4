#include "jaculus/transcription/guess.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace jaculus {

namespace {

double middle(double lower, double upper) {
  if (std::isfinite(lower) && std::isfinite(upper)) return 0.5 * (lower + upper);
  return std::isfinite(lower) ? std::max(lower, 0.0) : std::isfinite(upper) ? std::min(upper, 0.0) : 0.0;
}

/// A motion to sample: positions at s in [0, 1] of the whole plan.
struct GuessMotion {
  std::vector<Vector> poses;      // equally spaced in s
  std::vector<double> durations;  // of the phases [s]
  std::vector<Vector> torques;    // equally spaced in s; empty: static torques
};

/// Value of a list of equally spaced vectors at s in [0, 1], linear between.
Vector sample(const std::vector<Vector>& list, double s) {
  if (list.size() == 1) return list.front();
  const double at = std::clamp(s, 0.0, 1.0) * static_cast<double>(list.size() - 1);
  const auto k = std::min(static_cast<size_t>(at), list.size() - 2);
  const double f = at - static_cast<double>(k);
  return (1.0 - f) * list[k] + f * list[k + 1];
}

class GuessBuilder {
 public:
  GuessBuilder(Programme& programme, const GuessSpec& spec)
      : programme_(programme), spec_(spec), layout_(programme.layout()), model_(programme.equations().model()) {}

  Vector build(std::uint64_t seed, const Trajectory* earlier) {
    x_ = Vector(layout_.columns());
    for (int i = 0; i < x_.size(); ++i) x_[i] = middle(layout_.lower[i], layout_.upper[i]);
    for (size_t i = 0; i < layout_.extra_guess.size(); ++i)
      x_[layout_.first_extra + static_cast<int>(i)] = layout_.extra_guess[i];
    if (spec_.kind == "static") fill({{standing_pose()}, durations(), {}});
    if (spec_.kind == "line") fill(line());
    if (spec_.kind == "random") fill(random_motion(seed));
    if (spec_.kind == "file" && earlier) fill_from(*earlier);
    return x_.cwiseMax(layout_.lower).cwiseMin(layout_.upper);
  }

 private:
  /// Middle of the bounds, replaced by what the start fixes and by the pose of the file.
  Vector pose(const std::map<std::string, double>& named) const {
    const NodeBlock &first = layout_.nodes.front(),
                    &other = layout_.nodes[std::min<size_t>(1, layout_.nodes.size() - 1)];
    Vector q(layout_.n);
    for (int i = 0; i < layout_.n; ++i) {
      const bool fixed = layout_.lower[first.q + i] == layout_.upper[first.q + i];
      const int column = (fixed ? first.q : other.q) + i;
      q[i] = middle(layout_.lower[column], layout_.upper[column]);
    }
    for (const auto& [name, value] : named) {
      const int i = model_.coordinate_index(name);
      if (i >= 0) q[i] = value;
    }
    return q;
  }

  /// Lowers or raises the base until the lowest foot that the first phase stands on touches the ground.
  Vector stand(Vector q, bool keep_z) const {
    const int z = model_.coordinate_index("z");
    const std::vector<int>& feet = layout_.phases.front().feet;
    if (z < 0 || feet.empty() || keep_z) return q;
    const AbsoluteTree& tree = programme_.equations().tree();
    Motion motion(tree);
    if (!set_configuration(tree, q, motion)) return q;
    double lowest = kInfinity;
    for (int foot : feet) lowest = std::min(lowest, position(tree.feet[static_cast<size_t>(foot)], motion.pose).y());
    q[z] -= lowest;
    return q;
  }

  Vector standing_pose() const { return stand(pose(spec_.pose), spec_.pose.count("z") > 0); }

  std::vector<double> durations() const {
    std::vector<double> result = spec_.durations;
    for (size_t p = result.size(); p < layout_.phases.size(); ++p) {
      const int column = layout_.phases[p].duration;
      result.push_back(middle(layout_.lower[column], layout_.upper[column]));
    }
    return result;
  }

  GuessMotion line() const {
    GuessMotion motion{{}, durations(), {}};
    for (const auto& named : spec_.poses) motion.poses.push_back(stand(pose(named), named.count("z") > 0));
    return motion;
  }

  GuessMotion random_motion(std::uint64_t seed) const {
    std::mt19937_64 rng(seed);
    const auto uniform = [&rng] { return 2.0 * (static_cast<double>(rng() >> 11) * 0x1.0p-53) - 1.0; };
    GuessMotion motion;
    const Vector base = standing_pose();
    constexpr int kSamples = 41;
    motion.poses.assign(kSamples, base);
    motion.torques.assign(kSamples, Vector::Zero(layout_.n_u));
    const auto wave = [&](std::vector<Vector>& list, int i, double amplitude, bool drift) {
      const double c[4] = {drift ? uniform() : 0.0, uniform(), uniform(), uniform()};
      for (int k = 0; k < kSamples; ++k) {
        const double s = static_cast<double>(k) / (kSamples - 1);
        double value = c[0] * s;
        for (int m = 1; m <= 3; ++m) value += c[m] * std::sin(m * std::numbers::pi * s) / m;
        list[static_cast<size_t>(k)][i] += amplitude * value;
      }
    };
    const NodeBlock& inner = layout_.nodes[std::min<size_t>(1, layout_.nodes.size() - 1)];
    for (int i = 0; i < layout_.n; ++i) {
      const double width = layout_.upper[inner.q + i] - layout_.lower[inner.q + i];
      wave(motion.poses, i, std::isfinite(width) ? 0.08 * width : 0.1, true);
    }
    for (int m = 0; m < layout_.n_u; ++m)
      wave(motion.torques, m, 0.3 * layout_.scale[layout_.intervals.front().u_first + m], false);
    for (const PhaseBlock& phase : layout_.phases) {
      const double lower = layout_.lower[phase.duration], upper = layout_.upper[phase.duration];
      motion.durations.push_back(lower + (0.5 + 0.4 * uniform()) * (std::min(upper, lower + 2.0) - lower));
    }
    return motion;
  }

  /// Torques of least size that bring the accelerations at rest nearest to zero.
  Vector static_torque(const Vector& q, const std::vector<int>& feet) const {
    const Equations& equations = programme_.equations();
    EquationsPoint point(equations, feet);
    const Vector zero = Vector::Zero(layout_.n), none = Vector::Zero(layout_.n_u);
    if (!equations.evaluate(q, zero, none, point)) return none;
    equations.differentiate(point);
    const Matrix by_u = point.Z.topRightCorner(layout_.n, layout_.n_u);
    return -by_u.completeOrthogonalDecomposition().solve(point.a);
  }

  void fill(const GuessMotion& motion) {
    double total = 0.0;
    for (double t : motion.durations) total += t;
    double begin = 0.0;
    const double ds = 0.01;
    for (size_t p = 0; p < layout_.phases.size(); ++p) {
      const PhaseBlock& phase = layout_.phases[p];
      x_[phase.duration] = motion.durations[p];
      double done = 0.0;
      for (int k = phase.first_interval; k <= phase.last_interval; ++k) {
        const IntervalBlock& interval = layout_.intervals[static_cast<size_t>(k)];
        const double s0 = (begin + done * motion.durations[p]) / total;
        done += interval.fraction;
        const double s1 = (begin + done * motion.durations[p]) / total;
        for (const auto& [node, s] : {std::pair{interval.first, s0}, std::pair{interval.last, s1}}) {
          const NodeBlock& block = layout_.nodes[static_cast<size_t>(node)];
          const double a = std::max(0.0, s - ds), b = std::min(1.0, s + ds);
          x_.segment(block.q, layout_.n) = sample(motion.poses, s);
          x_.segment(block.v, layout_.n) = (sample(motion.poses, b) - sample(motion.poses, a)) / ((b - a) * total);
        }
        for (const auto& [column, s] : {std::pair{interval.u_first, s0}, std::pair{interval.u_last, s1}}) {
          x_.segment(column, layout_.n_u) =
              motion.torques.empty() ? static_torque(sample(motion.poses, s), phase.feet) : sample(motion.torques, s);
        }
      }
      begin += motion.durations[p];
    }
  }

  /// Copies what an earlier plan has by name: samples at the same fraction of the phase of the same number.
  void fill_from(const Trajectory& earlier) {
    fill({{standing_pose()}, durations(), {}});
    for (size_t p = 0; p < layout_.phases.size() && p < earlier.phases.size(); ++p) {
      const PhaseSpan& span = earlier.phases[p];
      const PhaseBlock& phase = layout_.phases[p];
      const double start = earlier.time[span.first], length = earlier.time[span.last] - start;
      x_[phase.duration] = length;
      double done = 0.0;
      for (int k = phase.first_interval; k <= phase.last_interval; ++k) {
        const IntervalBlock& interval = layout_.intervals[static_cast<size_t>(k)];
        const double t0 = start + done * length;
        done += interval.fraction;
        const double t1 = start + done * length;
        copy_node(earlier, span, t0, layout_.nodes[static_cast<size_t>(interval.first)]);
        copy_node(earlier, span, t1, layout_.nodes[static_cast<size_t>(interval.last)]);
        const double middle_time = 0.5 * (t0 + t1);
        copy_input(earlier, span, layout_.held ? middle_time : t0, interval.u_first);
        if (!layout_.held) copy_input(earlier, span, t1, interval.u_last);
      }
    }
  }

  /// Sample index and fraction for time t within a span.
  static std::pair<int, double> locate(const Trajectory& plan, const PhaseSpan& span, double t) {
    int k = span.first;
    while (k + 1 < span.last && plan.time[k + 1] <= t) ++k;
    const double h = plan.time[std::min(k + 1, span.last)] - plan.time[k];
    return {k, h > 0.0 ? std::clamp((t - plan.time[k]) / h, 0.0, 1.0) : 0.0};
  }

  void copy_node(const Trajectory& plan, const PhaseSpan& span, double t, const NodeBlock& node) {
    const auto [k, f] = locate(plan, span, t);
    const int next = std::min(k + 1, span.last);
    for (size_t c = 0; c < plan.coordinates.size(); ++c) {
      const int i = model_.coordinate_index(plan.coordinates[c]);
      const auto row = static_cast<int>(c);
      if (i < 0) continue;
      x_[node.q + i] = (1.0 - f) * plan.position(row, k) + f * plan.position(row, next);
      x_[node.v + i] = (1.0 - f) * plan.velocity(row, k) + f * plan.velocity(row, next);
    }
  }

  void copy_input(const Trajectory& plan, const PhaseSpan& span, double t, int column) {
    const int k = locate(plan, span, t).first;
    for (size_t m = 0; m < plan.motors.size(); ++m) {
      const int i = model_.motor_index(plan.motors[m]);
      if (i >= 0) x_[column + i] = plan.torque(static_cast<int>(m), k);
    }
  }

  Programme& programme_;
  const GuessSpec& spec_;
  const Layout& layout_;
  const PlanarModel& model_;
  Vector x_;
};

}  // namespace

Vector initial_guess(Programme& programme, const GuessSpec& spec, std::uint64_t seed, const Trajectory* earlier) {
  return GuessBuilder(programme, spec).build(seed, earlier);
}

}  // namespace jaculus
