#include "jaculus/transcription/layout.h"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "jaculus/components/motor.h"

namespace jaculus::transcription {

namespace {

struct Writer {
  const Problem& problem;
  const model::PlanarModel& model;
  Layout& layout;

  int append(const std::string& name, const std::string& unit, const Bounds& bounds, double scale) {
    const int column = layout.columns();
    const auto grow = [&](Vector& v, double value) {
      v.conservativeResize(column + 1);
      v[column] = value;
    };
    grow(layout.lower, bounds.lower);
    grow(layout.upper, bounds.upper);
    grow(layout.scale, scale);
    layout.names.push_back(name);
    layout.units.push_back(unit);
    return column;
  }
};

std::string unit_of(const model::Coordinate& c, bool rate) {
  if (c.angular) return rate ? "rad/s" : "rad";
  return rate ? "m/s" : "m";
}

Bounds find_or(const std::map<std::string, Bounds>& map, const std::string& name,
               const Bounds& otherwise) {
  const auto it = map.find(name);
  return it == map.end() ? otherwise : it->second;
}

NodeBlock append_node(Writer& w, int phase, int number) {
  NodeBlock node{phase, number, w.layout.columns(), 0};
  const std::string where = fmt::format("{}, node {}: ", w.problem.phases[phase].name, number);
  for (const model::Coordinate& c : w.model.coordinates) {
    w.append(where + c.name, unit_of(c, false), find_or(w.problem.position_bounds, c.name, c.range),
             c.angular ? 1.0 : 0.3);
  }
  node.v = w.layout.columns();
  for (const model::Coordinate& c : w.model.coordinates) {
    w.append(where + c.name + " velocity", unit_of(c, true),
             find_or(w.problem.velocity_bounds, c.name, {}), c.angular ? 10.0 : 1.0);
  }
  return node;
}

/// What dry friction leaves of a motor's torque, at the joint.
double left_to_move(const Problem& problem, const model::PlanarModel& model,
                    const model::PlanarMotor& motor) {
  const double largest = usable_torque(problem, model, motor), left = largest - motor.dry_friction;
  if (motor.dry_friction > 0.0 && !(left > 0.0))
    throw InputError(fmt::format(
        "motors.{}: dry_friction: {:g} given, and at most {:g} of torque at the joint, which "
        "leaves nothing to move it with; allowed: less friction, or a stronger motor",
        motor.joint, motor.dry_friction, largest));
  return left;
}

int append_input(Writer& w, int phase, int number) {
  const int column = w.layout.columns();
  for (const model::PlanarMotor& motor : w.model.motors) {
    const double limit = left_to_move(w.problem, w.model, motor);
    w.append(fmt::format("{}, {} {}: {} torque", w.problem.phases[phase].name,
                         w.layout.held ? "interval" : "node", number, motor.joint),
             w.model.slides(motor) ? "N" : "N m", {-limit, limit},
             std::isfinite(limit) ? limit : 1.0);
  }
  return column;
}

std::vector<double> fractions(const PhaseSpec& spec) {
  std::vector<double> f = spec.mesh.empty() ? std::vector<double>(spec.intervals, 1.0) : spec.mesh;
  double sum = 0.0;
  for (double value : f) sum += value;
  for (double& value : f) value /= sum;
  return f;
}

void append_phase(Writer& w, int p) {
  Layout& layout = w.layout;
  const PhaseSpec& spec = w.problem.phases[p];
  PhaseBlock phase;
  phase.name = spec.name;
  for (const std::string& foot : spec.contacts) phase.feet.push_back(w.model.foot_index(foot));
  std::sort(phase.feet.begin(), phase.feet.end());

  if (p > 0) {
    const std::vector<int>& before = layout.phases.back().feet;
    std::set_difference(phase.feet.begin(), phase.feet.end(), before.begin(), before.end(),
                        std::back_inserter(phase.landing));
  }
  if (p == 0 || !phase.landing.empty()) layout.nodes.push_back(append_node(w, p, 0));

  phase.first_node = count_of(layout.nodes) - 1;
  phase.first_interval = count_of(layout.intervals);
  int input = append_input(w, p, 0);

  const std::vector<double> mesh = fractions(spec);
  double begin = 0.0;
  for (int k = 0; k < spec.intervals; ++k) {
    IntervalBlock interval;
    interval.phase = p;
    interval.number = k;
    interval.first = count_of(layout.nodes) - 1;
    interval.last = interval.first + 1;
    interval.u_first = interval.u_last = input;
    interval.fraction = mesh[k];
    interval.begin = begin;
    begin += interval.fraction;

    layout.nodes.push_back(append_node(w, p, k + 1));
    if (!layout.held || k + 1 < spec.intervals) input = append_input(w, p, k + 1);
    if (!layout.held) interval.u_last = input;
    layout.intervals.push_back(interval);
  }

  phase.last_interval = count_of(layout.intervals) - 1;
  phase.last_node = count_of(layout.nodes) - 1;
  layout.phases.push_back(phase);
}

/// Narrows the bounds of one column; bounds that leave nothing are the user's contradiction.
void tighten(const BoundarySpec& spec, Layout& layout, int column, const Bounds& bounds) {
  const double lower = std::max(layout.lower[column], bounds.lower);
  const double upper = std::min(layout.upper[column], bounds.upper);
  if (lower > upper) {
    throw spec.node.error(fmt::format(
        "{}: [{}, {}] {} leaves nothing of the bounds [{}, {}]", layout.names[column], bounds.lower,
        bounds.upper, layout.units[column], layout.lower[column], layout.upper[column]));
  }
  layout.lower[column] = lower;
  layout.upper[column] = upper;
}

/// Turns values given for joints into values of the coordinates they make up; each coordinate needs
/// all its joints.
std::map<std::string, Bounds> on_coordinates(const std::map<std::string, Bounds>& given,
                                             const model::PlanarModel& model, bool rate,
                                             const BoundarySpec& spec) {
  std::map<std::string, Bounds> result;
  std::map<std::string, double> joints;
  for (const auto& [name, bounds] : given) {
    if (model.coordinate_index(name) >= 0) {
      result[name] = bounds;
    } else if (model.body_of_joint(name) < 0) {
      throw spec.node.error(fmt::format("{}: not a coordinate or joint of this robot", name));
    } else if (!bounds.fixed()) {
      throw spec.node.error(
          fmt::format("{}: a range is possible on a coordinate only; give one value, or bound the "
                      "coordinate that the joint belongs to",
                      name));
    } else {
      joints[name] = bounds.lower;
    }
  }
  if (joints.empty()) return result;

  // theta = T q + offset restricted to the given joints; solved for the coordinates that they
  // determine.
  Matrix rows(count_of(joints), model.size());
  Vector values(count_of(joints));
  int i = 0;
  for (const auto& [name, value] : joints) {
    const int body = model.body_of_joint(name);
    rows.row(i) = model.joint_map.row(body);
    values[i++] = value - (rate ? 0.0 : model.joint_offset[body]);
  }

  const Eigen::CompleteOrthogonalDecomposition<Matrix> solver(rows);
  const Vector q = solver.solve(values);
  if ((rows * q - values).cwiseAbs().maxCoeff() > 1e-9)
    throw spec.node.error(
        "the values given for joints contradict one another or name a dependent joint");

  // A coordinate is determined where its unit vector lies in the row space.
  const Matrix projector = solver.pseudoInverse() * rows;
  for (int c = 0; c < model.size(); ++c) {
    const bool touched = rows.col(c).cwiseAbs().maxCoeff() > 0.0;
    const bool determined = std::abs(projector(c, c) - 1.0) < 1e-9;
    const std::string& name = model.coordinates[c].name;
    if (touched && !determined)
      throw spec.node.error(
          fmt::format("{} is only partly given: name all joints that it combines", name));
    if (determined) result[name] = {q[c], q[c]};
  }

  return result;
}

void apply_boundary(const BoundarySpec& spec, const model::PlanarModel& model,
                    const NodeBlock& node, Layout& layout) {
  for (const auto& [name, bounds] : on_coordinates(spec.position, model, false, spec))
    tighten(spec, layout, node.q + model.coordinate_index(name), bounds);
  for (const auto& [name, bounds] : on_coordinates(spec.velocity, model, true, spec))
    tighten(spec, layout, node.v + model.coordinate_index(name), bounds);
}

/// Jacobian of the feet that a phase stands on, in the middle of a node's bounds: 2 rows a foot.
Matrix stance_jacobian(const dynamics::AbsoluteTree& tree, const PhaseBlock& phase,
                       const NodeBlock& node, const Layout& layout) {
  Vector q(layout.n);
  for (int i = 0; i < layout.n; ++i) {
    const double lower = layout.lower[node.q + i], upper = layout.upper[node.q + i];
    q[i] = std::isfinite(lower) && std::isfinite(upper) ? 0.5 * (lower + upper) : 0.0;
  }
  Matrix J = Matrix::Zero(2 * count_of(phase.feet), layout.n);
  dynamics::Motion motion(tree);
  if (!dynamics::set_configuration(tree, q, motion)) return J;
  for (int k = 0; k < count_of(phase.feet); ++k) {
    dynamics::jacobian_columns(tree.feet[phase.feet[k]], motion.pose, motion.columns);
    for (int c = 0; c < motion.columns.count; ++c) {
      J.row(2 * k) += motion.columns.x[c] * motion.G.row(motion.columns.index[c]);
      J.row(2 * k + 1) += motion.columns.z[c] * motion.G.row(motion.columns.index[c]);
    }
  }
  return J;
}

/// Zero rates at a node. Where a phase that stands on feet ends, the stance already holds as many
/// combinations of rates at zero as its Jacobian J has rank (but for integration error); only rates
/// independent of those are fixed, the base's first. Fixing all of them would leave dependent rows.
void apply_rest(const BoundarySpec& spec, const Matrix& J, const NodeBlock& node, Layout& layout) {
  Matrix basis(layout.n, 0);
  const auto extends = [&basis](Vector direction) {
    const double size = direction.norm();
    for (int pass = 0; pass < 2; ++pass) direction -= basis * (basis.transpose() * direction);
    if (direction.norm() <= 1e-6 * size) return false;
    basis.conservativeResize(Eigen::NoChange, basis.cols() + 1);
    basis.rightCols(1) = direction.normalized();
    return true;
  };
  for (int r = 0; r < J.rows(); ++r) extends(J.row(r).transpose());
  for (int i = 0; i < layout.n; ++i)
    if (extends(Vector::Unit(layout.n, i))) tighten(spec, layout, node.v + i, {0.0, 0.0});
}

}  // namespace

double usable_torque(const Problem& problem, const model::PlanarModel& model,
                     const model::PlanarMotor& motor) {
  return components::largest_joint_torque(limited_motor(problem, model, motor)).value;
}

int Layout::add_variable(const ExtraVariable& variable) {
  Vector* const vectors[3] = {&lower, &upper, &scale};
  const double values[3] = {variable.bounds.lower, variable.bounds.upper, variable.scale};
  const int column = columns();
  for (int i = 0; i < 3; ++i) {
    vectors[i]->conservativeResize(column + 1);
    (*vectors[i])[column] = values[i];
  }
  names.push_back(variable.name);
  units.push_back(variable.unit);
  extra_guess.push_back(variable.guess);
  return column;
}

Layout make_layout(const Problem& problem, const components::Equations& equations) {
  const model::PlanarModel& model = equations.model();
  Layout layout;
  layout.n = model.size();
  layout.n_u = equations.inputs();
  layout.held = problem.transcription.inputs == InputHold::held;
  Writer writer{problem, model, layout};

  for (int p = 0; p < count_of(problem.phases); ++p) append_phase(writer, p);
  for (std::size_t p = 0; p < problem.phases.size(); ++p) {
    const Bounds& bounds = problem.phases[p].duration;
    const double scale = std::clamp(std::sqrt(bounds.lower * bounds.upper), 1e-3, 10.0);
    layout.phases[p].duration =
        writer.append(problem.phases[p].name + ": duration", "s", bounds, scale);
  }

  layout.first_extra = layout.columns();
  apply_boundary(problem.initial, model, layout.nodes.front(), layout);
  apply_boundary(problem.final, model, layout.nodes.back(), layout);
  if (problem.initial.at_rest)
    apply_rest(problem.initial, Matrix(0, layout.n), layout.nodes.front(), layout);
  if (problem.final.at_rest) {
    const Matrix J =
        stance_jacobian(equations.tree(), layout.phases.back(), layout.nodes.back(), layout);
    apply_rest(problem.final, J, layout.nodes.back(), layout);
  }

  return layout;
}

}  // namespace jaculus::transcription
