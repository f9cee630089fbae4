#include "solver/ipopt_frontal.h"

#include <algorithm>
#include <cassert>
#include <memory>

#if __has_include(<HSLLoader.h>)
#include <HSLLoader.h>
#define JACULUS_HSL_LOADER 1
#endif

namespace jaculus::solver::detail {
namespace {

/// What the pattern says of every x and every row.
struct Graph {
  std::vector<std::vector<int>> columns;  ///< of a row
  std::vector<int> rows_of;               ///< number of rows that read a column
  std::vector<char> coupled;              ///< with another column, in the Hessian
};

Graph graph_of(const SymmetricPattern& pattern, const KktSizes& sizes) {
  const int first_row = sizes.x + sizes.s;
  Graph graph;
  graph.columns.resize(static_cast<std::size_t>(pattern.size - first_row));
  graph.rows_of.assign(static_cast<std::size_t>(sizes.x), 0);
  graph.coupled.assign(static_cast<std::size_t>(sizes.x), 0);

  for (std::size_t k = 0; k < pattern.rows.size(); ++k) {
    const int i = std::max(pattern.rows[k], pattern.columns[k]);
    const int j = std::min(pattern.rows[k], pattern.columns[k]);
    if (j >= sizes.x || i == j) continue;
    if (i < sizes.x) graph.coupled[i] = graph.coupled[j] = 1;
    if (i < first_row) continue;
    graph.columns[i - first_row].push_back(j);
    ++graph.rows_of[j];
  }
  return graph;
}

}  // namespace

EliminationOrder order_along_time(const SymmetricPattern& pattern, const KktSizes& sizes) {
  const Graph graph = graph_of(pattern, sizes);
  const auto is_private = [&](int x) { return graph.rows_of[x] == 1 && !graph.coupled[x]; };

  // The first column of a row, the number of columns where it has none.
  const int rows = static_cast<int>(graph.columns.size());
  std::vector<int> first(static_cast<std::size_t>(rows), sizes.x);
  for (int r = 0; r < rows; ++r)
    for (const int x : graph.columns[r])
      if (!is_private(x)) first[r] = std::min(first[r], x);

  std::vector<char> begins(static_cast<std::size_t>(sizes.x) + 1, 0);
  for (int r = 0; r < sizes.y_c; ++r) begins[first[r]] = 1;

  EliminationOrder order;
  order.group.assign(static_cast<std::size_t>(pattern.size), 0);
  std::vector<int> group_of(static_cast<std::size_t>(sizes.x) + 1, 0);
  int group = 0;
  for (int x = 0; x <= sizes.x; ++x) {
    if (x > 0 && begins[x] && !begins[x - 1]) ++group;
    group_of[x] = group;
    if (x < sizes.x) order.group[x] = group;
  }
  order.groups = group + 1;

  for (int r = 0; r < rows; ++r) {
    const int own = group_of[first[r]], y = sizes.x + sizes.s + r;
    order.group[y] = own;
    for (const int x : graph.columns[r])
      if (is_private(x)) order.group[x] = own;
    if (r < sizes.y_c) continue;
    const int s = sizes.x + r - sizes.y_c;
    order.group[s] = own;
    order.slack_rows.push_back({s, y});
  }
  return order;
}

#ifdef JACULUS_HSL_LOADER

namespace {

// Fronts of robots are below 100; beyond this a general ordering does better.
constexpr int kWidest = 300;

/// Of the solve under way: Ipopt's callbacks carry nothing of ours but a number, for one solve at a
/// time runs in a process.
struct Solve {
  int slacks = 0, equalities = 0;
  bool refused = false;
  std::vector<std::unique_ptr<FrontalFactorization>> factorizations;
};
Solve current;

// Places of MA57's INFO, from 0.
enum Info { kFlag = 0, kRealSpace = 8, kIntegerSpace = 9, kNegative = 23, kRank = 24 };
enum Flag { kDone = 0, kRefused = -1, kSingular = 4 };

void ma57_initialise(double*, ipfint*) {}

/// Analysis; KEEP's first entry becomes our number of the factorisation.
void ma57_analyse(ipfint* n, ipfint* entries, const ipfint* rows, const ipfint* columns, ipfint*,
                  ipfint* keep, ipfint*, ipfint*, ipfint* info, double*) {
  std::fill_n(info, 40, 0);
  SymmetricPattern pattern{*n, {rows, rows + *entries}, {columns, columns + *entries}};
  for (int& i : pattern.rows) --i;
  for (int& j : pattern.columns) --j;

  const KktSizes sizes{*n - 2 * current.slacks - current.equalities, current.slacks,
                       current.equalities};
  if (sizes.x >= 0) {
    const EliminationOrder order = order_along_time(pattern, sizes);
    current.factorizations.push_back(
        std::make_unique<FrontalFactorization>(std::move(pattern), order));
  }
  current.refused = sizes.x < 0 || current.factorizations.back()->widest_front() > kWidest;
  if (current.refused) {
    info[kFlag] = kRefused;
    return;
  }
  keep[0] = static_cast<ipfint>(current.factorizations.size()) - 1;
  info[kRealSpace] = info[kIntegerSpace] = 1;
}

void ma57_factorise(ipfint* n, ipfint* entries, double* values, double*, ipfint*,
                    ipfint* own_integers, ipfint*, ipfint*, ipfint* keep, ipfint*, ipfint*,
                    double* control, ipfint* info, double*) {
  const Inertia inertia = current.factorizations[keep[0]]->factorize(
      {values, static_cast<std::size_t>(*entries)}, control[0]);
  own_integers[0] = keep[0];
  info[kFlag] = inertia.zero > 0 ? kSingular : kDone;
  info[kNegative] = inertia.negative;
  info[kRank] = *n - inertia.zero;
}

void ma57_solve(ipfint*, ipfint* n, double*, ipfint*, ipfint* own_integers, ipfint*, ipfint* count,
                double* rhs, ipfint* stride, double*, ipfint*, ipfint*, ipfint*, ipfint* info) {
  for (int k = 0; k < *count; ++k)
    current.factorizations[own_integers[0]]->solve(
        {rhs + static_cast<std::ptrdiff_t>(k) * *stride, static_cast<std::size_t>(*n)});
  info[kFlag] = kDone;
}

/// Asks for more space: never needed.
void ma57_enlarge(ipfint*, ipfint*, ipfint*, double*, ipfint*, double*, ipfint*, ipfint*, ipfint*,
                  ipfint*, ipfint*, ipfint* info) {
  info[kFlag] = kDone;
}

}  // namespace

FrontalInIpopt::FrontalInIpopt(const transcription::Nlp& nlp) {
  current = {};
  for (int r = 0; r < nlp.rows(); ++r)
    ++(nlp.row_lower()[r] == nlp.row_upper()[r] ? current.equalities : current.slacks);
  LSL_setMA57(ma57_analyse, ma57_factorise, ma57_solve, ma57_enlarge, ma57_initialise);
}

FrontalInIpopt::~FrontalInIpopt() {
  LSL_setMA57(nullptr, nullptr, nullptr, nullptr, nullptr);  // the real one may be asked for next
  current = {};
}

bool FrontalInIpopt::available() { return true; }
bool FrontalInIpopt::refused() { return current.refused; }

#else

FrontalInIpopt::FrontalInIpopt(const transcription::Nlp&) {}
FrontalInIpopt::~FrontalInIpopt() = default;
bool FrontalInIpopt::available() { return false; }
bool FrontalInIpopt::refused() { return false; }

#endif

}  // namespace jaculus::solver::detail
