#include "jaculus/transcription/guess.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "transcription/guess_from_plan.h"

namespace jaculus::transcription {

namespace {

double middle(double lower, double upper) {
  if (std::isfinite(lower) && std::isfinite(upper)) return 0.5 * (lower + upper);
  return std::isfinite(lower)   ? std::max(lower, 0.0)
         : std::isfinite(upper) ? std::min(upper, 0.0)
                                : 0.0;
}

// Spread of random guesses: durations by factors within exp(+-spread), motions by this share of
// the bounds' width.
constexpr double kDurationSpread = 0.5;
constexpr double kMotionSpread = 0.08;

/// A motion to sample: positions at s in [0, 1] of the whole plan.
struct GuessMotion {
  std::vector<Vector> poses;      // equally spaced in s
  std::vector<double> durations;  // of the phases [s]
};

/// Value of a list of equally spaced vectors at s in [0, 1], linear between.
Vector sample(const std::vector<Vector>& list, double s) {
  if (list.size() == 1) return list.front();
  const double at = std::clamp(s, 0.0, 1.0) * static_cast<double>(list.size() - 1);
  const auto k = std::min<std::ptrdiff_t>(std::lround(std::floor(at)), std::ssize(list) - 2);
  const double f = at - static_cast<double>(k);
  return (1.0 - f) * list[k] + f * list[k + 1];
}

class GuessBuilder {
 public:
  GuessBuilder(NonlinearProgram& program, const GuessSpec& spec)
      : program_(program),
        spec_(spec),
        layout_(program.layout()),
        model_(program.equations().model()),
        motion_(program.equations().tree()) {}

  Vector build(std::uint64_t seed, const trajectory::Trajectory* earlier) {
    x_ = Vector(layout_.columns());
    for (int i = 0; i < x_.size(); ++i) x_[i] = middle(layout_.lower[i], layout_.upper[i]);
    for (int i = 0; i < count_of(layout_.extra_guess); ++i)
      x_[layout_.first_extra + i] = layout_.extra_guess[i];
    if (spec_.kind == "static") fill({{standing_pose()}, durations()});
    if (spec_.kind == "line") fill(line());
    if (spec_.kind == "random") fill(random_motion(seed));
    if (spec_.kind == "file" && earlier) {
      fill({{standing_pose()}, durations()});
      copy_plan(*earlier, layout_, model_, x_);
    }
    return x_.cwiseMax(layout_.lower).cwiseMin(layout_.upper);
  }

 private:
  /// Middle of the bounds, replaced by what the start fixes and by the pose of the file.
  Vector pose(const std::map<std::string, double>& named) const {
    const NodeBlock &first = layout_.nodes.front(),
                    &other = layout_.nodes[std::min<std::size_t>(1, layout_.nodes.size() - 1)];
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

  /// Lowers or raises the base until the lowest foot that the first phase stands on touches the
  /// ground.
  Vector stand(Vector q, bool keep_z) const {
    const int z = model_.coordinate_index("z");
    const std::vector<int>& feet = layout_.phases.front().feet;
    if (z < 0 || feet.empty() || keep_z) return q;
    const dynamics::AbsoluteTree& tree = program_.equations().tree();
    dynamics::Motion motion(tree);
    if (!dynamics::set_configuration(tree, q, motion)) return q;
    double lowest = kInfinity;
    for (int foot : feet) lowest = std::min(lowest, position(tree.feet[foot], motion.pose).y());
    q[z] -= lowest;
    return q;
  }

  Vector standing_pose() const { return stand(pose(spec_.pose), spec_.pose.count("z") > 0); }

  std::vector<double> durations() const {
    std::vector<double> result = spec_.durations;
    for (std::size_t p = result.size(); p < layout_.phases.size(); ++p) {
      const int column = layout_.phases[p].duration;
      result.push_back(middle(layout_.lower[column], layout_.upper[column]));
    }
    return result;
  }

  /// Straight lines between the poses; a plan that starts at rest moves along them with constant
  /// acceleration.
  GuessMotion line() const {
    std::vector<Vector> corners;
    for (const auto& named : spec_.poses)
      corners.push_back(stand(pose(named), named.count("z") > 0));
    const NodeBlock &first = layout_.nodes.front(), &last = layout_.nodes.back();
    const auto fixed_at_rest = [&](const NodeBlock& node) {
      return layout_.lower.segment(node.v, layout_.n).isZero(0.0) &&
             layout_.upper.segment(node.v, layout_.n).isZero(0.0);
    };
    const bool accelerate = fixed_at_rest(first) && !fixed_at_rest(last);
    GuessMotion motion{{}, durations()};
    constexpr int kSamples = 41;
    for (int k = 0; k < kSamples; ++k) {
      const double s = static_cast<double>(k) / (kSamples - 1);
      motion.poses.push_back(sample(corners, accelerate ? s * s : s));
    }
    return motion;
  }

  /// The problem's own poses, or a standing start that reaches the rates the end asks for, with a
  /// smooth random motion on top.
  GuessMotion random_motion(std::uint64_t seed) const {
    std::mt19937_64 rng(seed);
    const auto uniform = [&rng] {
      return 2.0 * (static_cast<double>(rng() >> 11) * 0x1.0p-53) - 1.0;
    };
    GuessMotion motion = spec_.poses.empty() ? GuessMotion{{}, durations()} : line();

    double total = 0.0;
    for (std::size_t p = 0; p < layout_.phases.size(); ++p) {
      const int column = layout_.phases[p].duration;
      motion.durations[p] = std::clamp(motion.durations[p] * std::exp(kDurationSpread * uniform()),
                                       layout_.lower[column], layout_.upper[column]);
      total += motion.durations[p];
    }

    constexpr int kSamples = 41;
    const bool standing = motion.poses.empty();
    if (standing) motion.poses.assign(kSamples, standing_pose());

    const NodeBlock &inner = layout_.nodes[std::min<std::size_t>(1, layout_.nodes.size() - 1)],
                    &last = layout_.nodes.back();
    for (int i = 0; i < layout_.n; ++i) {
      const double width = layout_.upper[inner.q + i] - layout_.lower[inner.q + i];
      const double amplitude = std::isfinite(width) ? kMotionSpread * width : kMotionSpread;

      // Nearest rate to zero that the end allows, reached from rest: q = q_0 + v T s^2 / 2.
      const double rate =
          standing ? std::clamp(0.0, layout_.lower[last.v + i], layout_.upper[last.v + i]) : 0.0;
      const double c[4] = {uniform(), uniform(), uniform(), uniform()};

      for (int k = 0; k < kSamples; ++k) {
        const double s = static_cast<double>(k) / (kSamples - 1);
        double value = c[0] * s * s;
        for (int m = 1; m <= 3; ++m) value += c[m] * std::sin(m * std::numbers::pi * s) / m;
        motion.poses[k][i] += amplitude * s * value + 0.5 * rate * total * s * s;
      }
    }

    return motion;
  }

  /// Moves q so that the feet stay at `anchors` (x, z a foot), the base as little as possible.
  /// Damped Gauss-Newton.
  Vector pin_feet(Vector q, const std::vector<int>& feet, const Vector& anchors) const {
    const dynamics::AbsoluteTree& tree = program_.equations().tree();
    const int rows = 2 * count_of(feet);
    if (rows == 0) return q;
    Vector mobility = Vector::Ones(layout_.n);  // squares of how readily a coordinate moves
    for (int c : tree.cyclic) mobility[c] = 1e-3;
    if (model_.coordinate_index("pitch") >= 0) mobility[model_.coordinate_index("pitch")] = 1e-2;

    for (int iteration = 0; iteration < 15; ++iteration) {
      if (!dynamics::set_configuration(tree, q, motion_)) return q;
      Matrix J(rows, layout_.n);
      Vector error(rows);
      for (int k = 0; k < rows / 2; ++k) {
        const dynamics::Path& path = tree.feet[feet[k]];
        error.segment<2>(2 * k) = position(path, motion_.pose) - anchors.segment<2>(2 * k);
        dynamics::jacobian_columns(path, motion_.pose, motion_.columns);
        J.middleRows(2 * k, 2).setZero();
        for (int c = 0; c < motion_.columns.count; ++c) {
          J.row(2 * k) += motion_.columns.x[c] * motion_.G.row(motion_.columns.index[c]);
          J.row(2 * k + 1) += motion_.columns.z[c] * motion_.G.row(motion_.columns.index[c]);
        }
      }

      const Matrix weighted = J * mobility.asDiagonal();
      Matrix normal = weighted * J.transpose();
      normal.diagonal().array() += 1e-8;
      q = within(q - weighted.transpose() * normal.ldlt().solve(error));
    }

    return q;
  }

  /// Keeps positions inside the bounds of an inner node.
  Vector within(const Vector& q) const {
    const int at = layout_.nodes[std::min<std::size_t>(1, layout_.nodes.size() - 1)].q;
    return q.cwiseMax(layout_.lower.segment(at, layout_.n))
        .cwiseMin(layout_.upper.segment(at, layout_.n));
  }

  Vector foot_positions(const Vector& q, const std::vector<int>& feet) const {
    const dynamics::AbsoluteTree& tree = program_.equations().tree();
    Vector anchors(2 * count_of(feet));
    dynamics::set_configuration(tree, q, motion_);
    for (int k = 0; k < count_of(feet); ++k)
      anchors.segment<2>(2 * k) = Vec2(position(tree.feet[feet[k]], motion_.pose).x(), 0.0);
    return anchors;
  }

  /// Torques whose accelerations come nearest to those wanted (the accelerations are linear in the
  /// torques).
  Vector fitting_torque(const Vector& q, const Vector& v, const Vector& a,
                        const std::vector<int>& feet) const {
    const components::Equations& equations = program_.equations();
    components::EquationsPoint point(equations, feet);
    const Vector none = Vector::Zero(layout_.n_u);
    if (!equations.evaluate(q, v, none, point)) return none;
    equations.differentiate(point);
    // Legs that close a chain with the ground press against each other by torques that move
    // nothing: what is left of those by rounding is no direction to go.
    constexpr double kIndependent = 1e-9;
    Eigen::CompleteOrthogonalDecomposition<Matrix> by_u;
    by_u.setThreshold(kIndependent);
    by_u.compute(point.Z.topRightCorner(layout_.n, layout_.n_u));
    return by_u.solve(a - point.a);
  }

  void fill(const GuessMotion& motion) {
    double total = 0.0, begin = 0.0;
    for (double t : motion.durations) total += t;

    for (std::size_t p = 0; p < layout_.phases.size(); ++p) {
      const PhaseBlock& phase = layout_.phases[p];
      x_[phase.duration] = motion.durations[p];
      const Vector start =
          p == 0 ? sample(motion.poses, 0.0)
                 : Vector(x_.segment(layout_.nodes[layout_.phases[p - 1].last_node].q, layout_.n));
      const Vector anchors = foot_positions(start, phase.feet);

      double done = 0.0;
      for (int node = phase.first_node; node <= phase.last_node; ++node) {
        const bool shared = p > 0 && phase.landing.empty() && node == phase.first_node;
        if (!shared) {
          const double s = (begin + done * motion.durations[p]) / total;
          x_.segment(layout_.nodes[node].q, layout_.n) =
              pin_feet(sample(motion.poses, s), phase.feet, anchors);
        }
        const int k = phase.first_interval + node - phase.first_node;
        if (k <= phase.last_interval) done += layout_.intervals[k].fraction;
      }
      begin += motion.durations[p];
    }

    fill_rates();
    fill_torques();
  }

  /// Velocities as differences of the positions of neighbouring nodes.
  void fill_rates() {
    const int last = count_of(layout_.nodes) - 1;
    std::vector<double> times(layout_.nodes.size(), 0.0);
    for (const IntervalBlock& interval : layout_.intervals) {
      const double h = interval.fraction * x_[layout_.phases[interval.phase].duration];
      times[interval.last] = times[interval.first] + h;
      const bool next_is_new =
          interval.last < last &&
          interval.number + 1 == layout_.phases[interval.phase].last_interval -
                                     layout_.phases[interval.phase].first_interval + 1;
      if (next_is_new) times[interval.last + 1] = times[interval.last];
    }

    for (int k = 0; k <= last; ++k) {
      const int a = k > 0 ? k - 1 : k, b = std::min(k + 1, last);
      const NodeBlock& node = layout_.nodes[k];
      if (times[b] <= times[a]) continue;
      x_.segment(node.v, layout_.n) =
          (x_.segment(layout_.nodes[b].q, layout_.n) - x_.segment(layout_.nodes[a].q, layout_.n)) /
          (times[b] - times[a]);
    }

    x_.segment(layout_.nodes.front().v, layout_.n) =
        x_.segment(layout_.nodes.front().v, layout_.n)
            .cwiseMax(layout_.lower.segment(layout_.nodes.front().v, layout_.n))
            .cwiseMin(layout_.upper.segment(layout_.nodes.front().v, layout_.n));
  }

  void fill_torques() {
    for (const IntervalBlock& interval : layout_.intervals) {
      const PhaseBlock& phase = layout_.phases[interval.phase];
      const NodeBlock &first = layout_.nodes[interval.first],
                      &second = layout_.nodes[interval.last];
      const auto q = [&](const NodeBlock& n) { return x_.segment(n.q, layout_.n); };
      const auto v = [&](const NodeBlock& n) { return x_.segment(n.v, layout_.n); };
      const Vector a = (v(second) - v(first)) / (interval.fraction * x_[phase.duration]);
      const Vector u =
          fitting_torque(0.5 * (q(first) + q(second)), 0.5 * (v(first) + v(second)), a, phase.feet);
      x_.segment(interval.u_first, layout_.n_u) = u;
      x_.segment(interval.u_last, layout_.n_u) = u;
    }
  }

  NonlinearProgram& program_;
  const GuessSpec& spec_;
  const Layout& layout_;
  const model::PlanarModel& model_;
  Vector x_;
  mutable dynamics::Motion motion_;
};

}  // namespace

Vector initial_guess(NonlinearProgram& program, const GuessSpec& spec, std::uint64_t seed,
                     const trajectory::Trajectory* earlier) {
  return GuessBuilder(program, spec).build(seed, earlier);
}

std::vector<std::string> guess_gaps(const NonlinearProgram& program,
                                    const trajectory::Trajectory& earlier) {
  std::vector<std::string> gaps;
  const auto missing = [](const auto& list, const std::string& name) {
    return std::find(list.begin(), list.end(), name) == list.end();
  };
  const auto add = [&gaps](const char* what, const std::string& name) {
    gaps.push_back("the earlier plan has no " + std::string(what) + " '" + name +
                   "': the guess takes a static posture's");
  };

  const model::PlanarModel& model = program.equations().model();
  const std::vector<PhaseBlock>& phases = program.layout().phases;

  for (std::size_t p = earlier.phases.size(); p < phases.size(); ++p)
    add("phase for", phases[p].name);
  if (earlier.phases.size() > phases.size())
    gaps.push_back(
        "the earlier plan has more phases than this one: its last ones are left out of the guess");

  for (const model::Coordinate& c : model.coordinates)
    if (missing(earlier.coordinates, c.name)) add("coordinate", c.name);
  for (const model::PlanarMotor& motor : model.motors)
    if (missing(earlier.motors, motor.joint)) add("motor", motor.joint);

  return gaps;
}

}  // namespace jaculus::transcription
