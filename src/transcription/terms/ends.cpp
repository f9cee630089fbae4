// Terms of the plan's end, and what is maximised there.

#include <fmt/format.h>

#include <numbers>

#include "transcription/terms/common.h"

namespace jaculus::transcription::terms {

namespace {

int last_node(const TermContext& context) { return count_of(context.layout.nodes) - 1; }

std::vector<int> duration_columns(const TermContext& context) {
  std::vector<int> columns;
  for (const PhaseBlock& phase : context.layout.phases) columns.push_back(phase.duration);
  return columns;
}

/// A velocity at the last node as a term over its columns (q, v): of one base coordinate, or of the
/// centre of mass.
NodeTerm velocity_term(const TermSpec& spec, TermContext& context) {
  const bool com = spec.values.choice("of") == "com";
  const bool up = spec.values.choice("direction") == "z";

  NodeTerm term;
  term.name = fmt::format("{} velocity of the {} at the end", up ? "z" : "x",
                          com ? "centre of mass" : "base");
  term.rows.push_back({term.name, "m/s", {}, 1.0});
  if (!com) {
    const int coordinate = needed_coordinate(up ? "z" : "x", spec, context);
    term.columns = {context.layout.nodes.back().v + coordinate};
    term.linear = true;
    term.evaluate = [](const ConstVectorRef& y, VectorRef values, Matrix* J, const ConstVectorRef*,
                       Matrix*) {
      values[0] = y[0];
      if (J) (*J)(0, 0) = 1.0;
      return true;
    };
    return term;
  }
  term.columns = node_columns(context, last_node(context));
  const dynamics::AbsoluteTree& tree = context.equations.tree();
  auto f = std::make_shared<PointFunction>(tree, dynamics::centre_of_mass_point(tree));
  const Vec2 axis(up ? 0.0 : 1.0, up ? 1.0 : 0.0), none = Vec2::Zero();
  term.evaluate = [f, &tree, axis, none](const ConstVectorRef& y, VectorRef values, Matrix* J,
                                         const ConstVectorRef* multipliers, Matrix* H) {
    const int n = tree.n;
    if (!dynamics::set_configuration(tree, y.head(n), f->motion)) return false;
    dynamics::set_rates(tree, y.tail(n), f->motion);
    dynamics::set_rate_sensitivity(tree, f->motion);
    values[0] = axis.dot(dynamics::point_velocity(f->point, f->motion));
    if (J) {
      f->gradient.setZero();
      dynamics::add_point_gradient(tree, f->motion, f->point, none, axis, f->gradient, f->scratch);
      J->row(0) = f->gradient.transpose();
    }
    if (H)
      dynamics::add_point_hessian(tree, f->motion, f->point, none, (*multipliers)[0] * axis, *H,
                                  f->scratch);
    return true;
  };
  return term;
}

struct MeanScratch {
  explicit MeanScratch(int size)
      : v(Vector::Zero(1)),
        multiplier(Vector::Zero(1)),
        J(Matrix::Zero(1, size)),
        H(Matrix::Zero(size, size)) {}
  Vector v, multiplier;
  Matrix J, H;
};

/// A linear function of the nonlinear program's variables.
NodeTerm linear_term(const std::string& name, const std::string& unit,
                     const std::vector<int>& columns, const std::vector<double>& factors) {
  NodeTerm term;
  term.name = name;
  term.rows.push_back({name, unit, {}, 1.0});
  term.columns = columns;
  term.linear = true;
  term.evaluate = [factors](const ConstVectorRef& y, VectorRef values, Matrix* J,
                            const ConstVectorRef*, Matrix*) {
    values[0] = 0.0;
    for (int i = 0; i < y.size(); ++i) {
      values[0] += factors[i] * y[i];
      if (J) (*J)(0, i) = factors[i];
    }
    return true;
  };
  return term;
}

void add_final_velocity(const TermSpec& spec, TermContext& context) {
  context.node_costs.emplace_back(velocity_term(spec, context), spec.weight);
}

void add_mean_acceleration(const TermSpec& spec, TermContext& context) {
  const NodeTerm velocity = velocity_term(spec, context);
  NodeTerm term = velocity;
  term.name = "mean acceleration: " + velocity.name + " over the duration";
  term.rows[0].unit = "m/s^2";
  term.linear = false;

  const int size = count_of(velocity.columns);
  for (int column : duration_columns(context)) term.columns.push_back(column);

  // c = v/T: dc = dv/T - v/T^2 dT, and the second derivatives that follow.
  auto s = std::make_shared<MeanScratch>(size);
  term.evaluate = [velocity, size, s](const ConstVectorRef& y, VectorRef values, Matrix* J,
                                      const ConstVectorRef* multipliers, Matrix* H) {
    const int durations = count_of(y) - size;
    const double T = y.tail(durations).sum();
    Vector& v = s->v;
    Matrix &J_v = s->J, &H_v = s->H;
    J_v.setZero();
    H_v.setZero();
    s->multiplier[0] = multipliers ? (*multipliers)[0] / T : 0.0;
    const ConstVectorRef scaled(s->multiplier);
    if (!(T > 0.0) || !velocity.evaluate(y.head(size), v, J ? &J_v : nullptr, H ? &scaled : nullptr,
                                         H ? &H_v : nullptr))
      return false;

    values[0] = v[0] / T;

    if (J) {
      J->row(0).head(size) = J_v.row(0) / T;
      J->row(0).tail(durations).setConstant(-v[0] / (T * T));
    }

    if (H) {
      const double m = (*multipliers)[0];
      H->topLeftCorner(size, size) += H_v;
      for (int d = size; d < size + durations; ++d) {
        H->col(d).head(size) -= m / (T * T) * J_v.row(0).transpose();
        H->row(d).head(size) -= m / (T * T) * J_v.row(0);
      }
      H->bottomRightCorner(durations, durations).array() += 2.0 * m * v[0] / (T * T * T);
    }
    return true;
  };

  context.node_costs.emplace_back(term, spec.weight);
}

void add_distance(const TermSpec& spec, TermContext& context) {
  const int x = needed_coordinate("x", spec, context);
  const std::vector<int> columns = {context.layout.nodes.back().q + x,
                                    context.layout.nodes.front().q + x};
  context.node_costs.emplace_back(
      linear_term("distance travelled by the base", "m", columns, {1.0, -1.0}), spec.weight);
}

void add_height(const TermSpec& spec, TermContext& context) {
  const int z = needed_coordinate("z", spec, context);
  context.node_costs.emplace_back(
      linear_term("height of the base at the end", "m", {context.layout.nodes.back().q + z}, {1.0}),
      spec.weight);
}

void add_time(const TermSpec& spec, TermContext& context) {
  const std::vector<int> columns = duration_columns(context);
  context.node_costs.emplace_back(
      linear_term("duration", "s", columns, std::vector<double>(columns.size(), 1.0)), spec.weight);
}

/// Ballistic flight after the end: base height z + v_z t - g t^2/2 = h on the way down, there pitch
/// + rate t is as asked.
void add_touchdown_pitch(const TermSpec& spec, TermContext& context) {
  const double height = spec.values.number("height");
  const Bounds pitch = spec.values.interval("pitch");
  const double g = context.model().gravity;
  const NodeBlock& node = context.layout.nodes.back();
  const int z = needed_coordinate("z", spec, context),
            p = needed_coordinate("pitch", spec, context);
  const int t =
      context.layout.add_variable({"time of flight to touchdown", "s", {0.0, 2.0}, 0.1, 0.1});
  NodeTerm term;
  term.name = "touchdown";
  term.columns = {node.q + z, node.q + p, node.v + z, node.v + p, t};
  term.rows = {{"touchdown: height of the base", "m", {height, height}, 0.1},
               {"touchdown: pitch", "rad", pitch, 0.1},
               {"touchdown: on the way down", "m/s", {-kInfinity, 0.0}, 1.0}};
  term.sensitivity = {"touchdown pitch", "deg", [](int row, double multiplier, const auto*) {
                        return row == 1 ? multiplier * std::numbers::pi / 180.0 : 0.0;
                      }};

  term.evaluate = [g](const ConstVectorRef& y, VectorRef values, Matrix* J,
                      const ConstVectorRef* multipliers, Matrix* H) {
    const double time = y[4];
    values << y[0] + y[2] * time - 0.5 * g * time * time, y[1] + y[3] * time, y[2] - g * time;
    if (J) {
      (*J)(0, 0) = (*J)(1, 1) = (*J)(2, 2) = 1.0;
      (*J)(0, 2) = (*J)(1, 3) = time;
      (*J)(0, 4) = y[2] - g * time;
      (*J)(1, 4) = y[3];
      (*J)(2, 4) = -g;
    }
    if (H) {
      const ConstVectorRef& m = *multipliers;
      (*H)(2, 4) = (*H)(4, 2) = m[0];
      (*H)(3, 4) = (*H)(4, 3) = m[1];
      (*H)(4, 4) = -g * m[0];
    }
    return true;
  };
  context.node_rows.push_back(term);
}

}  // namespace

TermType touchdown_pitch() {
  return {.name = "touchdown_pitch",
          .meaning = "pitch where the ballistic flight after the plan has the base at a height",
          .keys = {{"height", key::Number{dimension::length}, "of the base on landing"},
                   {"pitch", key::Interval{dimension::angle}, "a number or [lower, upper]"}},
          .example = "height: 0.2 m, pitch: [-5 deg, 5 deg]",
          .make = add_touchdown_pitch};
}

TermType mean_acceleration() {
  return {.name = "mean_acceleration",
          .meaning = "velocity at the end over the total duration",
          .cost = true,
          .unit = "m/s^2",
          .keys = {of_key(), direction_key()},
          .example = "of: com",
          .make = add_mean_acceleration};
}

TermType final_velocity() {
  return {.name = "final_velocity",
          .meaning = "velocity at the end",
          .cost = true,
          .unit = "m/s",
          .keys = {of_key(), direction_key()},
          .example = "of: com, direction: z",
          .make = add_final_velocity};
}

TermType distance() {
  return {.name = "distance",
          .meaning = "x of the base, end less start",
          .cost = true,
          .unit = "m",
          .make = add_distance};
}

TermType height() {
  return {.name = "height",
          .meaning = "z of the base at the end",
          .cost = true,
          .unit = "m",
          .make = add_height};
}

TermType time() {
  return {.name = "time", .meaning = "total duration", .cost = true, .unit = "s", .make = add_time};
}

}  // namespace jaculus::transcription::terms
