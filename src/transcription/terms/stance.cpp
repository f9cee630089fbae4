// What every problem has: feet that stand where the plan begins, and impacts where feet land. Along
// a phase the feet stay by the acceleration constraint of the equations of motion, so position and
// velocity are imposed once, not at every node.

#include <fmt/format.h>

#include "transcription/terms/common.h"

namespace jaculus::transcription::terms {

namespace {

/// Rows of one foot at a node: its height and, where asked for, its velocity.
NodeTerm standing_foot(const TermContext& context, int node, int foot, bool with_velocity) {
  const std::string& name = context.model().feet[foot].name;
  NodeTerm term;
  term.name = name + " on the ground";
  term.columns = node_columns(context, node);
  term.stance = true;

  const NodeBlock& block = context.layout.nodes[node];
  const std::string where =
      fmt::format("{}, node {}: {}", context.layout.phases[block.phase].name, block.number, name);
  term.rows.push_back({where + " height", "m", {0.0, 0.0}, 0.1});
  if (with_velocity) {
    term.rows.push_back({where + " x velocity", "m/s", {0.0, 0.0}, 1.0});
    term.rows.push_back({where + " z velocity", "m/s", {0.0, 0.0}, 1.0});
  }

  const dynamics::AbsoluteTree& tree = context.equations.tree();
  auto f = std::make_shared<PointFunction>(tree, dynamics::foot_point(tree, foot));
  term.evaluate = [f, &tree, with_velocity](const ConstVectorRef& y, VectorRef values, Matrix* J,
                                            const ConstVectorRef* multipliers, Matrix* H) {
    const int n = tree.n;
    if (!dynamics::set_configuration(tree, y.head(n), f->motion)) return false;
    dynamics::set_rates(tree, y.tail(n), f->motion);
    dynamics::set_rate_sensitivity(tree, f->motion);

    values[0] = dynamics::point_position(f->point, f->motion).y();
    if (with_velocity) values.segment<2>(1) = dynamics::point_velocity(f->point, f->motion);
    const Vec2 weights[3][2] = {{{0, 1}, {0, 0}}, {{0, 0}, {1, 0}}, {{0, 0}, {0, 1}}};
    for (int i = 0; i < values.size(); ++i) {
      if (J) {
        f->gradient.setZero();
        dynamics::add_point_gradient(tree, f->motion, f->point, weights[i][0], weights[i][1],
                                     f->gradient, f->scratch);
        J->row(i) = f->gradient.transpose();
      }
      if (H) {
        const double m = (*multipliers)[i];
        dynamics::add_point_hessian(tree, f->motion, f->point, m * weights[i][0], m * weights[i][1],
                                    *H, f->scratch);
      }
    }
    return true;
  };

  return term;
}

struct ImpactScratch {
  ImpactScratch(const components::Equations& equations, const std::vector<int>& feet)
      : point(equations, feet),
        mu(Vector::Zero(point.Z.rows())),
        full(Matrix::Zero(point.Z.cols(), point.Z.cols())) {}
  components::EquationsPoint point;
  Vector mu;
  Matrix full;
};

/// Rows of an impact: q stays, v jumps, normal impulses.
std::vector<RowSpec> impact_rows(const TermContext& context, const PhaseBlock& block,
                                 const std::string& name) {
  const int n = context.layout.n;
  std::vector<RowSpec> rows;
  for (int i = 0; i < 2 * n; ++i) {
    const model::Coordinate& c = context.model().coordinates[i % n];
    rows.push_back(
        {fmt::format("{}: {} of {}", name, i < n ? "continuity" : "jump of the rate", c.name),
         std::string(c.angular ? "rad" : "m") + (i < n ? "" : "/s"),
         {0.0, 0.0},
         context.layout.scale[context.layout.nodes.front().q + i]});
  }

  for (int foot : block.feet) {
    rows.push_back({fmt::format("{}: {} normal impulse", name, context.model().feet[foot].name),
                    "N s",
                    {0.0, kInfinity},
                    0.1 * weight_scale(context)});
  }
  return rows;
}

/// Columns: q and v before, q and v after. Rows: q stays (n), v jumps by the impact (n), normal
/// impulses (one a foot).
NodeTerm impact(const TermContext& context, int phase) {
  const PhaseBlock& block = context.layout.phases[phase];
  const int n = context.layout.n, before = context.layout.phases[phase - 1].last_node;
  NodeTerm term;
  term.name = "impact at the start of " + block.name;
  term.columns = node_columns(context, before);
  for (int column : node_columns(context, block.first_node)) term.columns.push_back(column);
  term.rows = impact_rows(context, block, term.name);

  const components::Equations& equations = context.equations;
  auto s = std::make_shared<ImpactScratch>(equations, block.feet);
  const int feet = count_of(block.feet);
  term.evaluate = [s, &equations, n, feet](const ConstVectorRef& y, VectorRef values, Matrix* J,
                                           const ConstVectorRef* multipliers, Matrix* H) {
    components::EquationsPoint* const p = &s->point;
    if (!equations.evaluate_impact(y.head(n), y.segment(n, n), *p)) return false;

    values.head(n) = y.segment(2 * n, n) - y.head(n);
    values.segment(n, n) = y.tail(n) - y.segment(n, n) - p->a;
    for (int k = 0; k < feet; ++k) values[2 * n + k] = p->force[2 * k + 1];

    if (!J) return true;
    equations.differentiate(*p);
    for (int i = 0; i < 2 * n; ++i) {
      (*J)(i, i) = -1.0;
      (*J)(i, 2 * n + i) = 1.0;
    }
    J->block(n, 0, n, 2 * n) -= p->Z.topLeftCorner(n, 2 * n);
    for (int k = 0; k < feet; ++k)
      J->row(2 * n + k).head(2 * n) = p->Z.row(n + 2 * k + 1).head(2 * n);
    if (!H) return true;

    Vector& mu = s->mu;
    Matrix& full = s->full;
    mu.setZero();
    full.setZero();
    mu.head(n) = -multipliers->segment(n, n);
    for (int k = 0; k < feet; ++k) mu[n + 2 * k + 1] = (*multipliers)[2 * n + k];
    equations.add_hessian(mu, *p, full);
    H->topLeftCorner(2 * n, 2 * n) += full.topLeftCorner(2 * n, 2 * n);
    return true;
  };

  return term;
}

}  // namespace

void add_stance(TermContext& context) {
  for (int foot : context.layout.phases.front().feet)
    context.node_rows.push_back(standing_foot(context, 0, foot, true));
}

void add_impacts(TermContext& context) {
  for (int p = 1; p < count_of(context.layout.phases); ++p) {
    const PhaseBlock& phase = context.layout.phases[p];
    if (phase.landing.empty()) continue;
    const int before = context.layout.phases[p - 1].last_node;
    for (int foot : phase.landing)
      context.node_rows.push_back(standing_foot(context, before, foot, false));
    context.node_rows.push_back(impact(context, p));
  }
}

}  // namespace jaculus::transcription::terms
