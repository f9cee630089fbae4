#include "diagnosis/selection/residual.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <numeric>
#include <utility>

#include "diagnosis/forward/sensitivities.h"
#include "diagnosis/selection/strong_directions.h"

namespace jaculus::diagnosis {
namespace {

/// Times settings.slope_renewed under a logged input: what a slope that is off by a tenth leaves
/// there, forces take that are granted to every model.
constexpr double kForcesTake = 10.0;

/// A step of what follows below which a secant says nothing [prior scales].
constexpr double kLeastSecant = 1e-6;

/// Slopes of rows as whitened ones are told anew along directions, a column each.
void turn(const std::vector<Eigen::Index>& columns, const Matrix& along,
          const std::vector<std::vector<Vector>>& told, RowSlopes& slopes) {
  const auto known = [&](Eigen::Index i) { return !slopes.columns[i].empty(); };
  if (!std::all_of(columns.begin(), columns.end(), known)) return;
  for (std::size_t d = 0; d < told.front().size(); ++d) {
    Matrix T(told.front()[d].size(), columns.size()), D(T.rows(), told.size());
    for (int i = 0; i < count_of(columns); ++i) T.col(i) = slopes.columns[columns[i]][d];
    for (int k = 0; k < count_of(told); ++k) D.col(k) = told[k][d];
    T = told_along(T, along, D);
    for (int i = 0; i < count_of(columns); ++i) slopes.columns[columns[i]][d] = T.col(i);
  }
}

/// `slope_of` 0 to `count` - 1, in parallel; nothing where one is nothing: its simulation failed.
template <class SlopeOf>
std::optional<std::vector<std::vector<Vector>>> slopes_in_parallel(int count,
                                                                   const SlopeOf& slope_of) {
  std::vector<std::vector<Vector>> slopes(count);
  tbb::parallel_for(0, count, [&](int k) {
    if (auto own = slope_of(k)) slopes[k] = std::move(*own);
  });
  if (std::any_of(slopes.begin(), slopes.end(), [](const auto& own) { return own.empty(); }))
    return {};
  return slopes;
}

/// A difference's rows over its step, times `unit`.
std::optional<std::vector<Vector>> slope_by(std::optional<Difference> moved, double unit) {
  if (!moved) return {};
  for (Vector& rows : moved->rows) rows *= unit / moved->step;
  return std::move(moved->rows);
}

/// How many of some free parameters come before the first of those listed.
Eigen::Index count_before(const std::vector<int>& listed, const std::vector<int>& free) {
  const auto is_listed = [&](int i) { return index_of(listed, i) >= 0; };
  return std::find_if(free.begin(), free.end(), is_listed) - free.begin();
}

}  // namespace

Residual::Residual(const Problem& problem, const Whitening& whitening, std::vector<int> free,
                   Vector fixed, const Matrix& known, const Matrix& effects)
    : problem_(problem),
      whitening_(whitening),
      free_(std::move(free)),
      nuisances_(count_before(problem.hypotheses.nuisances(), free_)),
      tolerances_(count_before(problem.hypotheses.tolerances, free_)),
      first_followed_(nuisances_),
      fixed_(std::move(fixed)),
      steps_(Vector::Constant(count_of(free_), problem.settings.first_step)) {
  const bool all = effects.cols() > 0 && effects.cols() == nuisances_;
  if (known.cols() != size() - nuisances_ || (known.cols() == 0 && !all)) return;
  slopes_ = Matrix::Zero(whitening.rows, size());
  if (known.cols() > 0) slopes_.rightCols(known.cols()) = known;
  if (!all) return;
  slopes_.leftCols(nuisances_) = effects;
  follow_effects();
}

Residual::Residual(const Problem& problem, const Whitening& whitening, std::vector<int> free,
                   Vector fixed, const LinearNuisances& linear, const Matrix& effects)
    : Residual(problem, whitening, std::move(free), std::move(fixed), linear.slopes, effects) {
  if (slopes_.size() > 0 && tolerances_ < size()) linear_ = &linear;
}

Vector Residual::simulated(const Vector& u) const {
  Vector p = full(u);
  if (linear_ == nullptr) return p;
  for (Eigen::Index i = tolerances_; i < size(); ++i) p[free_[i]] = linear_->p[free_[i]];
  return p;
}

Bounds Residual::range(Eigen::Index i) const {
  return problem_.hypotheses.parameters[free_[i]].scaled_bounds();
}

void Residual::keep_rows(const RowSlopes& nuisances) {
  row_slopes_.columns.resize(free_.size());
  std::copy(nuisances.columns.begin(), nuisances.columns.end(),
            row_slopes_.columns.begin() + nuisances_);
}

RowSlopes Residual::nuisance_rows() const {
  if (row_slopes_.columns.empty()) return {};
  RowSlopes rows{{row_slopes_.columns.begin() + nuisances_, row_slopes_.columns.end()}};
  const bool known = std::all_of(rows.columns.begin(), rows.columns.end(),
                                 [](const auto& own) { return !own.empty(); });
  return known ? rows : RowSlopes{};
}

bool Residual::value(const Vector& u, Vector& r) {
  if (u.size() == at_.size() && u == at_ && residual_.size() > 0) {
    r = residual_;
    return true;
  }
  const Vector p = simulated(u);
  if (p.size() != simulated_.size() || p != simulated_) {
    ++predictions_;
    simulated_.resize(0);
    const PredictionSet set = predict_all(problem_, p);
    if (!set.valid) {
      message_ = set.message;
      return false;
    }
    rows_ = rows_of(problem_, whitening_.alignments, set);
    simulated_ = p;
  }
  r = whitening_.residual(rows_);
  const Eigen::Index n = size() - tolerances_;
  if (linear_ != nullptr)
    r += linear_->slopes.rightCols(n) * (u.tail(n) - reduced(linear_->p).tail(n));
  at_ = u;
  residual_ = r;
  return true;
}

/// Some columns of dr/du; nothing where a simulation fails.
std::optional<Matrix> Residual::differenced(const Vector& u,
                                            const std::vector<Eigen::Index>& columns) {
  const Vector p = simulated(u);
  auto slopes = slopes_in_parallel(count_of(columns), [&](int k) {
    const Eigen::Index i = columns[k];
    const double scale = problem_.hypotheses.parameters[free_[i]].scale;
    return slope_by(
        difference(problem_, whitening_.alignments, p, rows_, free_[i], steps_[i] * scale), scale);
  });
  predictions_ += count_of(columns);
  if (!slopes) return {};

  const Matrix J = -whitening_.columns(*slopes);
  for (int k = 0; k < count_of(columns); ++k) {
    steps_[columns[k]] = difference_step(J.col(k).norm(), problem_.settings);
    if (!row_slopes_.columns.empty()) row_slopes_.columns[columns[k]] = std::move((*slopes)[k]);
  }
  return J;
}

/// Along the strong directions of the slopes of some tolerances; nothing where a simulation fails.
std::optional<Residual::Turned> Residual::turned(const Vector& u, const Matrix& slopes,
                                                 const std::vector<Eigen::Index>& columns,
                                                 double least) {
  const StrongDirections strong = strong_directions(slopes, least, problem_.settings.slope_changed);
  Turned out{strong.along, Matrix(whitening_.rows, strong.along.cols()), {}};
  const auto count = static_cast<int>(strong.along.cols());
  if (count == 0) return out;
  const Vector p = simulated(u);
  auto rows = slopes_in_parallel(count, [&](int k) {
    const double step = difference_step(strong.sizes[k], problem_.settings);
    Vector move = Vector::Zero(p.size());
    for (int i = 0; i < count_of(columns); ++i) {
      const int own = free_[columns[i]];
      move[own] = step * strong.along(i, k) * problem_.hypotheses.parameters[own].scale;
    }
    return slope_by(difference_along(problem_, whitening_.alignments, p, rows_, move), 1.0 / step);
  });
  predictions_ += count;
  if (!rows) return {};
  out.rows = std::move(*rows);
  out.white = -whitening_.columns(out.rows);
  return out;
}

/// The first `end` slopes, those of nuisances less what secants by effects' moves made of them: in
/// prior scales these are the ones that move, and what effects bend lands on weak ones too.
Matrix Residual::unbent(Eigen::Index end) const {
  Matrix slopes = slopes_.leftCols(end);
  const Eigen::Index n = end - nuisances_;
  for (const Secant& secant : secants_)
    if (secant.by_effects)
      slopes.rightCols(n) -= secant.missed * secant.along.segment(nuisances_, n).transpose();
  return slopes;
}

/// One more secant, of the step to u: with the effects' slopes there, before these are taken, or of
/// all that follows.
void Residual::add_secant(const Vector& u, const Matrix* effects) {
  const Eigen::Index n = first_followed_;
  const Vector du = u - slopes_at_;
  Vector along = du.head(n + followed());
  if (effects != nullptr) along.head(n).setZero();
  if (along.size() == 0 || along.norm() < kLeastSecant) return;
  Vector missed = residual_ - slopes_residual_ - expected_over(du);
  if (effects != nullptr) missed -= 0.5 * (*effects - slopes_.leftCols(n)) * du.head(n);
  const bool by_effects = !along.head(nuisances_).isZero(0.0);
  secants_.push_back({std::move(missed), along / along.squaredNorm(), by_effects});
}

/// What secants that wait say of effects.
void Residual::add_to_effects() {
  for (std::size_t k = added_; k < secants_.size(); ++k) {
    auto own = secants_[k].along.head(first_followed_);
    if (!own.isZero(0.0)) slopes_.leftCols(first_followed_) += secants_[k].missed * own.transpose();
    own.setZero();
  }
}

/// A secant is a pass over all slopes, so that it waits until they are asked for as a whole.
void Residual::add_secants() {
  for (; added_ < secants_.size(); ++added_) {
    const Secant& own = secants_[added_];
    slopes_.leftCols(own.along.size()).noalias() += own.missed * own.along.transpose();
  }
}

/// By what the slopes say the residual moves over a step.
Vector Residual::expected_over(const Vector& du) const {
  Vector expected = slopes_ * du;
  for (std::size_t k = added_; k < secants_.size(); ++k) {
    const Secant& own = secants_[k];
    expected += own.missed * own.along.dot(du.head(own.along.size()));
  }
  return expected;
}

void Residual::keep(const Vector& u, bool effects, bool all) {
  slopes_at_ = u;
  slopes_residual_ = residual_;
  effects_told_ = effects;
  new_ = all;
}

bool Residual::tell(const Vector& u) {
  if (slopes_.size() == 0) return renewed_slopes(u) != nullptr;
  if (stand_at(u) && effects_told_at(u)) return true;
  std::vector<Eigen::Index> effects(first_followed_);
  std::iota(effects.begin(), effects.end(), Eigen::Index{0});
  const std::optional<Matrix> told = differenced(u, effects);
  if (!told) return false;

  add_to_effects();
  if (slopes_at_.size() == u.size()) add_secant(u, &*told);
  slopes_.leftCols(first_followed_) = *told;
  keep(u, true, false);
  return true;
}

bool Residual::follow(const Vector& u) {
  if (slopes_at_.size() != u.size()) return tell(u);
  if (stand_at(u)) return true;
  add_secant(u, nullptr);
  keep(u, false, false);
  return true;
}

const Matrix* Residual::slopes(const Vector& u) { return tell(u) ? &told() : nullptr; }

const Matrix* Residual::renewed_slopes(const Vector& u) {
  const bool anew = slopes_.size() == 0;
  if (!anew && (followed() == 0 || told_at(u))) return slopes(u);
  add_secants();

  const double least = problem_.settings.slope_renewed * (in_windows(problem_) ? kForcesTake : 1.0);
  // Together move those that may go both ways: friction at none goes one.
  std::vector<Eigen::Index> columns, together;
  const Eigen::Index end = anew ? size() : first_followed_ + followed();
  for (Eigen::Index i = 0; i < end; ++i) {
    const bool tolerance = !anew && i >= tolerances_;
    if (tolerance && !problem_.hypotheses.parameters[free_[i]].one_sided())
      together.push_back(i);
    else if (!tolerance || slopes_.col(i).norm() > least)
      // Effects' anew too: their steps are told by now.
      columns.push_back(i);
  }
  Matrix slopes = anew ? Matrix(whitening_.rows, end) : unbent(end);
  const Matrix T = slopes(Eigen::all, together);
  const std::optional<Matrix> told = differenced(u, columns);
  const std::optional<Turned> along = told ? turned(u, T, together, least) : std::nullopt;
  if (!along) return nullptr;

  slopes(Eigen::all, columns) = *told;
  if (!together.empty()) slopes(Eigen::all, together) = told_along(T, along->along, along->white);
  if (anew) slopes_.resize(whitening_.rows, end);
  slopes_.leftCols(end) = slopes;
  if (!row_slopes_.columns.empty() && !along->rows.empty())
    turn(together, along->along, along->rows, row_slopes_);
  keep(u, true, true);
  secants_.clear();
  added_ = 0;
  ++times_renewed_;
  return &slopes_;
}

LinearNuisances linear_nuisances(const Problem& problem, const Whitening& whitening, Vector p,
                                 const RowSlopes& near) {
  LinearNuisances out{.p = std::move(p)};
  const std::vector<int> nuisances = problem.hypotheses.nuisances();
  if (nuisances.empty()) return out;
  const bool known = !near.columns.empty();
  Residual residual(problem, whitening, nuisances, out.p,
                    known ? whitening.slopes(near) : Matrix());
  // Under a plan other spaces follow from them.
  if (!in_windows(problem)) residual.keep_rows(near);
  const Vector u = residual.reduced(out.p);
  Vector r;
  const Matrix* slopes = residual.value(u, r) ? residual.renewed_slopes(u) : nullptr;
  if (slopes == nullptr) return out;
  out.slopes = *slopes;
  out.rows = residual.nuisance_rows();
  out.predictions = residual.predictions();
  return out;
}

}  // namespace jaculus::diagnosis
