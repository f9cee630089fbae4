#include "components/authors_plan.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "jaculus/components/motor.h"
#include "jaculus/dynamics/rigid_body.h"
#include "jaculus/trajectory/csv.h"

namespace jaculus::test {

namespace {

double cell(const trajectory::Table& table, Eigen::Index row, const std::string& name) {
  const int column = table.column(name);
  EXPECT_GE(column, 0) << name;
  return column < 0 ? kNaN : table.values(row, column);
}

Eigen::Vector3d base(const trajectory::Table& table, Eigen::Index row, const std::string& suffix) {
  return {cell(table, row, "x" + suffix), cell(table, row, "z" + suffix),
          cell(table, row, "pitch" + suffix)};
}

PlanNode read_node(const trajectory::Table& table, Eigen::Index row,
                   const model::PlanarModel& model) {
  const int bodies = count_of(model.bodies), motors = count_of(model.motors);
  PlanNode node;
  node.phase = std::stoi(table.phase[row]);
  node.index = static_cast<int>(cell(table, row, "node"));
  node.time = cell(table, row, "time");
  node.base_q = base(table, row, "");
  node.base_v = base(table, row, "_velocity");
  node.base_a = base(table, row, "_acceleration");
  node.joints = node.joint_v = node.joint_a = Vector::Zero(bodies);
  for (int b = 1; b < bodies; ++b) {
    const std::string& joint = model.bodies[b].joint;
    node.joints[b] = cell(table, row, joint);
    if (std::find(model.dependent.begin(), model.dependent.end(), b) != model.dependent.end())
      continue;
    node.joint_v[b] = cell(table, row, joint + "_velocity");
    node.joint_a[b] = cell(table, row, joint + "_acceleration");
  }
  node.u = node.duty = Vector(motors);
  for (int m = 0; m < motors; ++m) {
    node.u[m] = cell(table, row, model.motors[m].joint + "_torque");
    node.duty[m] = cell(table, row, model.motors[m].joint + "_duty");
  }
  node.force = node.foot = Vector(2 * count_of(model.feet));
  for (int f = 0; f < node.foot.size() / 2; ++f) {
    const std::string& name = model.feet[f].name;
    node.force.segment<2>(2 * f) << cell(table, row, name + "_force_x"),
        cell(table, row, name + "_force_z");
    node.foot.segment<2>(2 * f) << cell(table, row, name + "_x"), cell(table, row, name + "_z");
  }
  return node;
}

std::vector<int> feet_in_contact(const PlanNode& node) {
  std::vector<int> feet;
  for (int f = 0; f < node.force.size() / 2; ++f)
    if (!node.force.segment<2>(2 * f).isZero(0.0)) feet.push_back(f);
  return feet;
}

/// M a + h - B u - J_f^T f - Q_drag (n). The equations solve the balance for (a, f): what the
/// plan's own leave over is its departure from that solution.
Vector balance_rows(const components::Equations& equations, const Coordinates& c, const Vector& u,
                    const PlanNode& node, components::EquationsPoint& p) {
  EXPECT_TRUE(equations.evaluate(c.q, c.v, u, p));
  Vector difference = -p.force;
  for (int k = 0; k < count_of(p.feet); ++k)
    difference.segment<2>(2 * k) += node.force.segment<2>(2 * p.feet[k]);
  return dynamics::mass_matrix(equations.tree(), p.motion) * (c.a - p.a) -
         dynamics::foot_jacobian(equations.tree(), p.motion, p.feet).transpose() * difference;
}

/// Rows and columns of the map from the coordinates to (base, motors' joints).
Matrix to_joints(const model::PlanarModel& model) {
  const int n = model.size();
  Matrix S = Matrix::Zero(n, n);
  S.topLeftCorner(3, 3).setIdentity();
  for (int m = 0; m < n - 3; ++m) S.row(3 + m) = model.joint_map.row(model.motors[m].body);
  return S;
}

Vector per_motor(Vector rows, const model::PlanarModel& model) {
  for (int m = 0; m < count_of(model.motors); ++m) rows[3 + m] /= model.motors[m].count;
  return rows;
}

/// The loops' Jacobian in the open robot's coordinates, and V^T d2c V at the rates of `motion`.
struct Closure {
  Matrix C;
  Vector curvature;
};

Closure closure(const dynamics::AbsoluteTree& loops, const dynamics::AbsoluteTree& open,
                const dynamics::Motion& motion) {
  const int rows = 2 * count_of(loops.loops);
  Matrix C = Matrix::Zero(rows, open.N);
  Vector curvature(rows);
  dynamics::PointColumns J;
  for (int l = 0; l < rows / 2; ++l) {
    const dynamics::LoopPaths& loop = loops.loops[l];
    for (const dynamics::Path* path : {&loop.a, &loop.b}) {
      const double sign = path == &loop.a ? 1.0 : -1.0;
      dynamics::jacobian_columns(*path, motion.pose, J);
      for (int k = 0; k < J.count; ++k)
        C.block<2, 1>(2 * l, J.index[k]) += sign * Vec2(J.x[k], J.z[k]);
    }
    curvature.segment<2>(2 * l) = dynamics::quadratic(loop.a, motion.pose, motion.V) -
                                  dynamics::quadratic(loop.b, motion.pose, motion.V);
  }
  return {C * open.P, curvature};
}

/// The open robot's state with the knees' rates and accelerations from the loops, and its motions
/// that the loops allow.
struct OpenState {
  Coordinates c;
  Matrix allowed;  ///< open coordinates x (base, motors' joints)
};

OpenState open_state(const PlanChecker& checker, const PlanNode& node) {
  const dynamics::AbsoluteTree& tree = checker.open.tree();
  const int n = tree.n, motors = count_of(checker.model.motors);
  OpenState s{{Vector(n), Vector(n), Vector(n)}, Matrix::Zero(n, 3 + motors)};
  s.c.q << node.base_q, node.joints.tail(n - 3);
  s.c.v << node.base_v, node.joint_v.tail(n - 3);
  s.c.a << node.base_a, node.joint_a.tail(n - 3);
  dynamics::Motion motion(tree);
  EXPECT_TRUE(dynamics::set_configuration(tree, s.c.q, motion));
  dynamics::set_rates(tree, s.c.v, motion);
  Closure loops = closure(checker.closed.tree(), tree, motion);
  const int nd = count_of(checker.model.dependent);
  Matrix C_d(nd, nd);
  for (int k = 0; k < nd; ++k) C_d.col(k) = loops.C.col(2 + checker.model.dependent[k]);
  const Eigen::PartialPivLU<Matrix> lu(C_d);
  const auto put_knees = [&](const Vector& values, auto&& out) {
    for (int k = 0; k < nd; ++k) out[2 + checker.model.dependent[k]] = values[k];
  };
  put_knees(-lu.solve(loops.C * s.c.v), s.c.v);
  dynamics::set_rates(tree, s.c.v, motion);
  loops = closure(checker.closed.tree(), tree, motion);
  put_knees(-lu.solve(loops.C * s.c.a + loops.curvature), s.c.a);
  s.allowed.topLeftCorner(3, 3).setIdentity();
  for (int m = 0; m < motors; ++m) s.allowed(2 + checker.model.motors[m].body, 3 + m) = 1.0;
  for (int j = 0; j < s.allowed.cols(); ++j)
    put_knees(-lu.solve(loops.C * s.allowed.col(j)), s.allowed.col(j));
  return s;
}

}  // namespace

Plan read_plan(const std::filesystem::path& file, const model::PlanarModel& model) {
  const trajectory::Table table = trajectory::read_csv(file);
  Plan plan{file.stem().string(), model, {}};
  for (Eigen::Index row = 0; row < table.values.rows(); ++row)
    plan.nodes.push_back(read_node(table, row, model));
  return plan;
}

Coordinates coordinates(const model::PlanarModel& model, const PlanNode& node) {
  const int n = model.size(), motors = count_of(model.motors);
  EXPECT_EQ(n, 3 + motors) << "a free base and a motor for every other coordinate";
  const Eigen::PartialPivLU<Matrix> S(to_joints(model));
  Vector q(n), v(n), a(n);
  q.head<3>() = node.base_q;
  v.head<3>() = node.base_v;
  a.head<3>() = node.base_a;
  for (int m = 0; m < motors; ++m) {
    const int body = model.motors[m].body;
    q[3 + m] = node.joints[body] - model.joint_offset[body];
    v[3 + m] = node.joint_v[body];
    a[3 + m] = node.joint_a[body];
  }
  return {S.solve(q), S.solve(v), S.solve(a)};
}

model::PlanarModel opened(const model::PlanarModel& model) {
  model::PlanarModel open = model;
  const int joints = count_of(model.bodies) - 1;
  open.loops.clear();
  open.dependent.clear();
  open.coordinates.resize(3);
  open.joint_map = Matrix::Zero(joints + 1, 3 + joints);
  open.joint_map.bottomRightCorner(joints, joints).setIdentity();
  open.joint_offset = Vector::Zero(joints + 1);
  for (int b = 1; b <= joints; ++b) open.coordinates.push_back({model.bodies[b].joint, true, {}});
  return open;
}

PlanChecker::PlanChecker(const model::PlanarModel& m)
    : model(m), closed(m, 0.0), open(opened(m), 0.0) {}

NodeResiduals PlanChecker::residuals(const PlanNode& node) const {
  NodeResiduals r;
  const OpenState state = open_state(*this, node);
  components::EquationsPoint at_plan(open, feet_in_contact(node)),
      at_closed(closed, feet_in_contact(node));
  r.open = per_motor(state.allowed.transpose() * balance_rows(open, state.c, node.u, node, at_plan),
                     model);
  const Vector rows = balance_rows(closed, coordinates(model, node), node.u, node, at_closed);
  r.closed = per_motor(to_joints(model).transpose().partialPivLu().solve(rows), model);

  const dynamics::AbsoluteTree& tree = open.tree();
  for (const dynamics::LoopPaths& loop : closed.tree().loops)
    r.gap = std::max(r.gap, (dynamics::position(loop.a, at_plan.motion.pose) -
                             dynamics::position(loop.b, at_plan.motion.pose))
                                .norm());
  for (int k = 0; k < count_of(model.dependent); ++k)
    r.knee = std::max(r.knee, std::abs(at_closed.motion.d[k] - node.joints[model.dependent[k]]));
  for (int f = 0; f < count_of(tree.feet); ++f)
    r.foot = std::max(
        r.foot,
        (dynamics::foot_position(tree, at_plan.motion, f) - node.foot.segment<2>(2 * f)).norm());
  for (int f : at_plan.feet) {
    const Vec2 force = node.force.segment<2>(2 * f);
    const Vec2 arm = dynamics::foot_position(tree, at_plan.motion, f) - node.base_q.head<2>();
    const Matrix J = dynamics::foot_jacobian(tree, at_plan.motion, {f}) * state.allowed;
    for (int i = 0; i < J.cols(); ++i) {
      const int k = i < 3 ? i : 2 + model.motors[i - 3].body;
      r.rate_term = std::max(r.rate_term, J.col(i).norm() * std::abs(state.c.v[k]));
      r.second_term = std::max(r.second_term, J.col(i).norm() * std::abs(state.c.a[k]));
    }
    r.foot_rate = std::max(r.foot_rate, dynamics::foot_velocity(tree, at_plan.motion, f).norm());
    r.foot_second = std::max(
        r.foot_second,
        dynamics::point_acceleration(dynamics::foot_point(tree, f), at_plan.motion, state.c.a)
            .norm());
    r.contact_force = std::max(r.contact_force, force.norm());
    r.contact_moment =
        std::max(r.contact_moment, std::abs(arm.y() * force.x() - arm.x() * force.y()));
  }
  for (int m = 0; m < node.u.size(); ++m) {
    const model::PlanarMotor& motor = model.motors[m];
    const double voltage =
        components::motor_voltage(motor, node.u[m], node.joint_v[motor.body]).value;
    r.voltage = std::max(r.voltage, std::abs(voltage - 7.0 * node.duty[m]));
  }
  return r;
}

Vector PlanChecker::locked_rows(const PlanNode& node, int motor, double value) const {
  const model::PlanarMotor& held = model.motors[motor];
  const model::PlanarModel locked = model::lock(model, held.joint, value);
  const components::Equations equations(locked, 0.0);
  Vector u(node.u.size() - 1);
  u << node.u.head(motor), node.u.tail(node.u.size() - motor - 1);
  components::EquationsPoint p(equations, feet_in_contact(node));
  const Vector rows = balance_rows(equations, coordinates(locked, node), u, node, p);
  return per_motor(to_joints(locked).transpose().partialPivLu().solve(rows), locked);
}

namespace {

/// Momentum, moment about the world's origin and energy at a node, with their rates of change.
struct Totals {
  Vec2 momentum, force;
  double moment, torque, energy, power;
  double foot_force, foot_moment, motor_power;  ///< magnitudes
};

Totals totals(const PlanChecker& checker, const PlanNode& node) {
  const dynamics::AbsoluteTree& tree = checker.open.tree();
  components::EquationsPoint p(checker.open, {});
  const Coordinates c = open_state(checker, node).c;
  EXPECT_TRUE(checker.open.evaluate(c.q, c.v, node.u, p));
  const Vec2 weight(0.0, -tree.total_mass * tree.gravity),
      com = dynamics::centre_of_mass(tree, p.motion);
  Totals t{};
  t.momentum = dynamics::linear_momentum(tree, p.motion);
  t.moment = dynamics::angular_momentum(tree, p.motion, Vec2::Zero());
  t.energy =
      dynamics::kinetic_energy(tree, p.motion, c.v) + dynamics::potential_energy(tree, p.motion);
  t.force = weight + checker.open.drag_force(p);
  t.torque = checker.open.drag_moment(p) - com.x() * weight.y();
  for (int f = 0; f < node.force.size() / 2; ++f) {
    const Vec2 force = node.force.segment<2>(2 * f),
               at = dynamics::foot_position(tree, p.motion, f);
    const Vec2 arm = at - node.base_q.head<2>();
    t.force += force;
    t.torque += at.y() * force.x() - at.x() * force.y();
    t.foot_force += force.norm();
    t.foot_moment += std::abs(arm.y() * force.x() - arm.x() * force.y());
  }
  const Vector motor_force = tree.input_map * node.u;
  t.motor_power = c.v.cwiseProduct(motor_force).cwiseAbs().sum();
  t.power = c.v.dot(motor_force) + checker.open.drag_power(p);
  return t;
}

}  // namespace

PhaseBalance balance(const PlanChecker& checker, const Plan& plan, int phase, int last) {
  std::vector<Totals> t;
  std::vector<double> time;
  for (const PlanNode& node : plan.nodes) {
    if (node.phase != phase || node.index > last) continue;
    t.push_back(totals(checker, node));
    time.push_back(node.time);
  }
  EXPECT_EQ(t.size() % 2, 1U) << "nodes and midpoints of whole intervals";
  PhaseBalance b;
  b.momentum = t.back().momentum - t.front().momentum;
  b.moment = t.back().moment - t.front().moment;
  b.energy = t.back().energy - t.front().energy;
  for (std::size_t i = 0; i + 2 < t.size(); i += 2) {
    const double h = time[i + 2] - time[i];
    const auto simpson = [&](auto f) {
      return h / 6.0 * (f(t[i]) + 4.0 * f(t[i + 1]) + f(t[i + 2]));
    };
    b.momentum.x() -= simpson([](const Totals& x) { return x.force.x(); });
    b.momentum.y() -= simpson([](const Totals& x) { return x.force.y(); });
    b.moment -= simpson([](const Totals& x) { return x.torque; });
    b.energy -= simpson([](const Totals& x) { return x.power; });
    b.impulse_scale += simpson([](const Totals& x) { return x.foot_force; });
    b.moment_scale += simpson([](const Totals& x) { return x.foot_moment; });
    b.work_scale += simpson([](const Totals& x) { return x.motor_power; });
  }
  return b;
}

}  // namespace jaculus::test
