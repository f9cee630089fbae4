#include "solver/prolong.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "jaculus/transcription/guess.h"

namespace jaculus::solver::detail {
namespace {

using transcription::Interval;
using transcription::IntervalBlock;
using transcription::Layout;
using transcription::NonlinearProgram;
using transcription::PathRows;
using transcription::PhaseBlock;

/// Entries of a vector of multipliers that are of one quantity along time.
struct Samples {
  std::vector<double> at;                ///< when, rising; in durations of a phase
  std::vector<std::vector<int>> places;  ///< the entries of that instant

  void add(double when, int place) {
    constexpr double kSame = 1e-9;
    if (at.empty() || when > at.back() + kSame) {
      at.push_back(when);
      places.emplace_back();
    }
    places.back().push_back(place);
  }

  /// The share of the duration that each instant stands for: half way to its neighbours.
  [[nodiscard]] std::vector<double> shares() const {
    std::vector<double> share(at.size(), 1.0);
    const int last = count_of(at) - 1;
    for (int i = 0; i <= last && last > 0; ++i)
      share[i] = 0.5 * (at[std::min(i + 1, last)] - at[std::max(i - 1, 0)]);
    return share;
  }
};

/// Linear between instants, constant beyond them.
double interpolate(const std::vector<double>& at, const std::vector<double>& values, double when) {
  const auto above = std::upper_bound(at.begin(), at.end(), when);
  if (above == at.begin()) return values.front();
  if (above == at.end()) return values.back();
  const auto k = above - at.begin();
  const double f = (when - at[k - 1]) / (at[k] - at[k - 1]);
  return (1.0 - f) * values[k - 1] + f * values[k];
}

enum class Kind { value, density };

/// Carries the entries of one quantity over to another mesh.
void carry(const Samples& coarse, const Vector& from, const Samples& fine, Kind kind, Vector& to) {
  if (coarse.at.empty()) return;
  std::vector<double> values(coarse.at.size(), 0.0);
  const std::vector<double> coarse_share = coarse.shares(), fine_share = fine.shares();
  for (std::size_t i = 0; i < values.size(); ++i) {
    for (const int place : coarse.places[i]) values[i] += from[place];
    values[i] /= kind == Kind::density ? coarse_share[i] : count_of(coarse.places[i]);
  }

  for (std::size_t i = 0; i < fine.at.size(); ++i) {
    const double value = interpolate(coarse.at, values, fine.at[i]);
    const double each =
        kind == Kind::density ? value * fine_share[i] / count_of(fine.places[i]) : value;
    for (const int place : fine.places[i]) to[place] = each;
  }
}

Samples defects(const NonlinearProgram& program, const PhaseBlock& phase, int component) {
  Samples samples;
  for (int k = phase.first_interval; k <= phase.last_interval; ++k) {
    const IntervalBlock& block = program.layout().intervals[k];
    samples.add(block.begin + 0.5 * block.fraction, program.intervals()[k].defect_row + component);
  }
  return samples;
}

Samples path_rows(const NonlinearProgram& program, int phase, int term, int row) {
  const PhaseBlock& block = program.layout().phases[phase];
  const transcription::PathTerm* wanted = &program.path_terms()[phase][term];
  std::vector<std::pair<double, int>> found;
  for (int k = block.first_interval; k <= block.last_interval; ++k) {
    const IntervalBlock& interval = program.layout().intervals[k];
    for (const PathRows& rows : program.intervals()[k].path)
      if (rows.term == wanted)
        found.emplace_back(interval.begin + 0.5 * rows.point * interval.fraction, rows.row + row);
  }

  Samples samples;
  for (const auto& [when, place] : found) samples.add(when, place);
  return samples;
}

Samples inputs(const Layout& layout, const PhaseBlock& phase, int input) {
  Samples samples;
  for (int k = phase.first_interval; k <= phase.last_interval; ++k) {
    const IntervalBlock& block = layout.intervals[k];
    const double first = layout.held ? 0.5 : 0.0;
    samples.add(block.begin + first * block.fraction, block.u_first + input);
    if (!layout.held && k == phase.last_interval)
      samples.add(block.begin + block.fraction, block.u_last + input);
  }
  return samples;
}

/// A state at all nodes but the first and last of the plan; phase p lasts from p to p + 1.
Samples inner_states(const Layout& layout, int state) {
  Samples samples;
  for (std::size_t k = 1; k < layout.intervals.size(); ++k) {
    const IntervalBlock& block = layout.intervals[k];
    const transcription::NodeBlock& node = layout.nodes[block.first];
    samples.add(block.phase + block.begin, node.q + state);
  }
  return samples;
}

/// Number of the last variables, which are of no time: durations and extra variables.
int timeless(const NonlinearProgram& program) {
  return program.variables() - program.layout().phases.front().duration;
}

void carry_bounds(const NonlinearProgram& coarse_program, const Vector& from,
                  const NonlinearProgram& fine_program, Vector& to) {
  const Layout &coarse = coarse_program.layout(), &fine = fine_program.layout();
  for (std::size_t p = 0; p < coarse.phases.size(); ++p)
    for (int i = 0; i < coarse.n_u; ++i)
      carry(inputs(coarse, coarse.phases[p], i), from, inputs(fine, fine.phases[p], i),
            Kind::density, to);
  for (int i = 0; i < 2 * coarse.n; ++i) {
    carry(inner_states(coarse, i), from, inner_states(fine, i), Kind::density, to);
    to[fine.nodes.front().q + i] = from[coarse.nodes.front().q + i];
    to[fine.nodes.back().q + i] = from[coarse.nodes.back().q + i];
  }
  to.tail(timeless(coarse_program)) = from.tail(timeless(coarse_program));
}

void carry_rows(const NonlinearProgram& coarse, const Vector& from, const NonlinearProgram& fine,
                Vector& to) {
  for (int p = 0; p < count_of(coarse.layout().phases); ++p) {
    for (int i = 0; i < 2 * coarse.layout().n; ++i)
      carry(defects(coarse, coarse.layout().phases[p], i), from,
            defects(fine, fine.layout().phases[p], i), Kind::value, to);
    for (int t = 0; t < count_of(coarse.path_terms()[p]); ++t)
      for (int i = 0; i < count_of(coarse.path_terms()[p][t].rows); ++i)
        carry(path_rows(coarse, p, t, i), from, path_rows(fine, p, t, i), Kind::density, to);
  }

  const auto coarse_rows = coarse.node_rows(), fine_rows = fine.node_rows();
  for (std::size_t t = 0; t < std::min(coarse_rows.size(), fine_rows.size()); ++t) {
    const int rows = count_of(fine_rows[t].term->rows);
    if (rows == count_of(coarse_rows[t].term->rows))
      to.segment(fine_rows[t].row, rows) = from.segment(coarse_rows[t].row, rows);
  }
}

/// Calls use(i, slack to the lower bound, slack to the upper one) for every inequality.
template <class Use>
void each_inequality(const ConstVectorRef& value, const Vector& lower, const Vector& upper,
                     Use&& use) {
  for (int i = 0; i < value.size(); ++i)
    if (lower[i] < upper[i]) use(i, value[i] - lower[i], upper[i] - value[i]);
}

}  // namespace

Start prolong(NonlinearProgram& coarse, const NlpResult& result, NonlinearProgram& fine) {
  const Vector& x = result.last_iterate();
  const trajectory::Trajectory plan = transcription::to_trajectory(coarse, x);
  transcription::GuessSpec spec = fine.problem().guess;
  spec.kind = "file";
  Start start{transcription::initial_guess(fine, spec, 0, &plan),
              Duals{Vector::Zero(fine.rows()), Vector::Zero(fine.variables()),
                    Vector::Zero(fine.variables())}};

  start.x.tail(timeless(coarse)) = x.tail(timeless(coarse));
  carry_rows(coarse, result.row_multipliers, fine, start.duals->rows);
  carry_bounds(coarse, result.lower_multipliers, fine, start.duals->lower);
  carry_bounds(coarse, result.upper_multipliers, fine, start.duals->upper);
  return start;
}

double mean_complementarity(NonlinearProgram& program, const Start& start) {
  Vector g(program.rows());
  if (!program.constraints(start.x, g)) return 0.0;
  double sum = 0.0;
  int count = 0;
  const auto add = [&](double slack, double multiplier) {
    if (!std::isfinite(slack)) return;
    sum += std::max(slack, 0.0) * std::max(multiplier, 0.0);
    ++count;
  };
  each_inequality(g, program.row_lower(), program.row_upper(), [&](int i, double low, double up) {
    add(low, -start.duals->rows[i]);
    add(up, start.duals->rows[i]);
  });
  each_inequality(start.x, program.variable_lower(), program.variable_upper(),
                  [&](int i, double low, double up) {
                    add(low, start.duals->lower[i]);
                    add(up, start.duals->upper[i]);
                  });
  return count > 0 ? sum / count : 0.0;
}

SolverOptions prolonged_options(SolverOptions options, double barrier) {
  // Smaller ones are below what the tolerance asks for, larger ones forget the start.
  constexpr double kLeastBarrier = 1e-7, kMostBarrier = 1e-2;
  options.ipopt["mu_init"] =
      fmt::format("{:.17g}", std::clamp(barrier, kLeastBarrier, kMostBarrier));
  for (const char* name : {"bound_push", "bound_frac", "slack_bound_push", "slack_bound_frac"})
    options.ipopt[std::string("warm_start_") + name] = "1e-5";
  return options;
}

}  // namespace jaculus::solver::detail
