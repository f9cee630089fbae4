#include "transcription/redundancy.h"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <map>
#include <memory>

namespace jaculus::transcription {

namespace {

/// All stance rows on one set of columns.
struct Group {
  std::vector<int> columns;
  std::vector<std::size_t> terms;  // indices into node_rows
};

/// A value that the bounds allow.
double within(double lower, double upper) {
  if (std::isfinite(lower) && std::isfinite(upper)) return 0.5 * (lower + upper);
  return std::isfinite(lower) ? lower : std::isfinite(upper) ? upper : 0.0;
}

/// What the user wrote that the rows of a group go with: `initial` at the plan's first node, else
/// the phase that lands there.
const yaml::Node& place(const TermContext& context, const Group& group) {
  const Layout& layout = context.layout;
  if (group.columns.front() == layout.nodes.front().q) return context.problem.initial.node;
  for (std::size_t p = 1; p < layout.phases.size(); ++p) {
    const int before = layout.phases[p - 1].last_node;
    if (layout.nodes[before].q == group.columns.front()) return context.problem.phases[p].node;
  }
  return context.problem.node;
}

struct Rows {
  Vector residual;  // distance from the rows' bounds
  Matrix J;         // free columns only
};

bool evaluate(const TermContext& context, const Group& group, const Vector& y, Rows& out) {
  const int size = count_of(y);
  out.residual.resize(0);
  out.J.resize(0, size);

  for (std::size_t t : group.terms) {
    const NodeTerm& term = context.node_rows[t];
    const int rows = count_of(term.rows), at = count_of(out.residual);
    Vector values(rows);
    Matrix J = Matrix::Zero(rows, size);
    if (!term.evaluate(y, values, &J, nullptr, nullptr)) return false;
    for (int i = 0; i < rows; ++i) values[i] -= term.rows[i].bounds.lower;
    out.residual.conservativeResize(at + rows);
    out.residual.tail(rows) = values;
    out.J.conservativeResize(at + rows, Eigen::NoChange);
    out.J.bottomRows(rows) = J;
  }

  for (int j = 0; j < size; ++j) {
    const int column = group.columns[j];
    if (context.layout.lower[column] == context.layout.upper[column]) out.J.col(j).setZero();
  }

  return true;
}

/// Rows, in order, whose gradients are independent of those before.
std::vector<char> independent_rows(const Matrix& J) {
  std::vector<char> keep(J.rows(), 0);
  Matrix basis(J.cols(), 0);
  for (int i = 0; i < J.rows(); ++i) {
    Vector row = J.row(i).transpose();
    const double size = row.norm();
    for (int pass = 0; pass < 2; ++pass) row -= basis * (basis.transpose() * row);
    if (size == 0.0 || row.norm() < 1e-7 * size) continue;
    keep[i] = 1;
    basis.conservativeResize(Eigen::NoChange, basis.cols() + 1);
    basis.rightCols(1) = row.normalized();
  }
  return keep;
}

/// The same term with some of its rows.
NodeTerm select_rows(const NodeTerm& term, const std::vector<int>& kept) {
  NodeTerm part = term;
  part.rows.clear();
  for (int i : kept) part.rows.push_back(term.rows[i]);
  const int all = count_of(term.rows), count = count_of(kept);

  struct Scratch {
    Vector v, m;
    Matrix J;
  };
  const auto size = std::ssize(term.columns);
  auto s = std::make_shared<Scratch>(
      Scratch{Vector::Zero(all), Vector::Zero(all), Matrix::Zero(all, size)});

  part.evaluate = [whole = term.evaluate, kept, count, s](
                      const ConstVectorRef& y, VectorRef values, Matrix* J,
                      const ConstVectorRef* multipliers, Matrix* H) {
    s->J.setZero();
    for (int i = 0; i < count && multipliers; ++i) s->m[kept[i]] = (*multipliers)[i];
    const ConstVectorRef m(s->m);
    if (!whole(y, s->v, J ? &s->J : nullptr, multipliers ? &m : nullptr, H)) return false;

    for (int i = 0; i < count; ++i) {
      values[i] = s->v[kept[i]];
      if (J) J->row(i) = s->J.row(kept[i]);
    }
    return true;
  };

  return part;
}

/// The state at which the rows are tested for rank: from the middle of the bounds onto the rows
/// (Gauss-Newton).
Vector start_on_rows(const TermContext& context, const Group& group, Rows& rows) {
  Vector y(count_of(group.columns));
  for (int j = 0; j < y.size(); ++j) {
    const int column = group.columns[j];
    y[j] = within(context.layout.lower[column], context.layout.upper[column]);
  }
  for (int iteration = 0; iteration < 50; ++iteration) {
    if (!evaluate(context, group, y, rows)) break;
    const Vector step = rows.J.completeOrthogonalDecomposition().solve(rows.residual);
    if (step.norm() < 1e-13) break;
    y -= step * std::min(1.0, 0.3 / std::max(1e-9, step.cwiseAbs().maxCoeff()));
    for (int j = 0; j < y.size(); ++j) {
      const int column = group.columns[j];
      y[j] = std::clamp(y[j], context.layout.lower[column], context.layout.upper[column]);
    }
  }
  return y;
}

}  // namespace

std::vector<std::string> remove_redundant_rows(TermContext& context) {
  std::vector<Group> groups;
  for (std::size_t t = 0; t < context.node_rows.size(); ++t) {
    if (!context.node_rows[t].stance) continue;
    if (groups.empty() || groups.back().columns != context.node_rows[t].columns)
      groups.push_back({context.node_rows[t].columns, {}});
    groups.back().terms.push_back(t);
  }

  std::vector<std::string> notes;
  std::vector<NodeTerm> result;
  std::map<std::size_t, std::vector<int>> kept;

  for (const Group& group : groups) {
    Rows rows;
    const Vector y = start_on_rows(context, group, rows);
    if (!evaluate(context, group, y, rows))
      throw place(context, group).error("no pose of the feet closes the robot's loops");

    const std::vector<char> keep = independent_rows(rows.J);
    int at = 0;
    for (std::size_t t : group.terms) {
      kept[t];
      for (int i = 0; i < count_of(context.node_rows[t].rows); ++i, ++at) {
        const RowSpec& row = context.node_rows[t].rows[i];
        if (keep[at]) {
          kept[t].push_back(i);
        } else if (std::abs(rows.residual[at]) > 1e-6) {
          throw place(context, group)
              .error(fmt::format(
                  "the values given contradict the contacts: {} would be {:.6g} {} and must be 0",
                  row.name, rows.residual[at], row.unit));
        } else {
          notes.push_back(row.name + ": implied by what is given, left out");
        }
      }
    }
  }

  for (std::size_t t = 0; t < context.node_rows.size(); ++t) {
    const auto it = kept.find(t);
    if (it == kept.end() || it->second.size() == context.node_rows[t].rows.size()) {
      result.push_back(context.node_rows[t]);
    } else if (!it->second.empty()) {
      result.push_back(select_rows(context.node_rows[t], it->second));
    }
  }

  context.node_rows = std::move(result);
  return notes;
}

}  // namespace jaculus::transcription
