#include "diagnosis/selection/residual.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <numeric>
#include <utility>

#include "diagnosis/forward/sensitivities.h"

namespace jaculus::diagnosis {
namespace {

/// Times settings.slope_renewed under a logged input: what a slope that is off by a tenth leaves
/// there, forces take that are granted to every model.
constexpr double kForcesTake = 10.0;

/// A step of what follows below which a secant says nothing [prior scales].
constexpr double kLeastSecant = 1e-6;

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
  std::vector<std::vector<Vector>> slopes(columns.size());
  tbb::parallel_for(0, count_of(columns), [&](int k) {
    const Eigen::Index i = columns[k];
    const double scale = problem_.hypotheses.parameters[free_[i]].scale;
    auto moved = difference(problem_, whitening_.alignments, p, rows_, free_[i], steps_[i] * scale);
    if (!moved) return;
    for (Vector& rows : moved->rows) rows *= scale / moved->step;
    slopes[k] = std::move(moved->rows);
  });
  predictions_ += count_of(columns);
  if (std::any_of(slopes.begin(), slopes.end(), [](const auto& own) { return own.empty(); }))
    return {};

  const Matrix J = -whitening_.columns(slopes);
  for (int k = 0; k < count_of(columns); ++k) {
    steps_[columns[k]] = difference_step(J.col(k).norm(), problem_.settings);
    if (!row_slopes_.columns.empty()) row_slopes_.columns[columns[k]] = std::move(slopes[k]);
  }
  return J;
}

/// One more secant, of the step to u at which the effects' slopes are `effects`; before these are
/// taken.
void Residual::follow(const Vector& u, const Matrix& effects) {
  const Eigen::Index n = first_followed_;
  const Vector du = u - slopes_at_, dn = du.segment(n, followed());
  if (dn.size() == 0 || dn.norm() < kLeastSecant) return;
  Vector missed = residual_ - slopes_residual_ - expected_over(du);
  missed -= 0.5 * (effects - slopes_.leftCols(n)) * du.head(n);
  secants_.push_back({std::move(missed), dn / dn.squaredNorm()});
}

/// A secant is a pass over all slopes, so that it waits until they are asked for as a whole.
void Residual::add_secants() {
  for (; added_ < secants_.size(); ++added_) {
    const Secant& own = secants_[added_];
    slopes_.middleCols(first_followed_, own.along.size()).noalias() +=
        own.missed * own.along.transpose();
  }
}

/// By what the slopes say the residual moves over a step.
Vector Residual::expected_over(const Vector& du) const {
  Vector expected = slopes_ * du;
  for (std::size_t k = added_; k < secants_.size(); ++k) {
    const Secant& own = secants_[k];
    expected += own.missed * own.along.dot(du.segment(first_followed_, own.along.size()));
  }
  return expected;
}

void Residual::keep(const Vector& u, bool told) {
  slopes_at_ = u;
  slopes_residual_ = residual_;
  new_ = told;
}

bool Residual::tell(const Vector& u) {
  if (slopes_.size() == 0) return renewed_slopes(u) != nullptr;
  if (slopes_at_.size() == u.size() && slopes_at_ == u) return true;
  std::vector<Eigen::Index> effects(first_followed_);
  std::iota(effects.begin(), effects.end(), Eigen::Index{0});
  const std::optional<Matrix> told = differenced(u, effects);
  if (!told) return false;

  if (slopes_at_.size() == u.size()) follow(u, *told);
  slopes_.leftCols(first_followed_) = *told;
  keep(u, false);
  return true;
}

const Matrix* Residual::slopes(const Vector& u) { return tell(u) ? &told() : nullptr; }

const Matrix* Residual::renewed_slopes(const Vector& u) {
  const bool anew = slopes_.size() == 0;
  if (!anew && (followed() == 0 || told_at(u))) return slopes(u);
  add_secants();

  const double least = problem_.settings.slope_renewed * (in_windows(problem_) ? kForcesTake : 1.0);
  std::vector<Eigen::Index> columns;
  for (Eigen::Index i = 0; i < (anew ? size() : first_followed_ + followed()); ++i) {
    // Effects' anew too: their steps are told by now.
    const bool strong = anew || i < tolerances_ || slopes_.col(i).norm() > least;
    if (strong) columns.push_back(i);
  }
  const std::optional<Matrix> told = differenced(u, columns);
  if (!told) return nullptr;

  if (anew) slopes_.resize(whitening_.rows, size());
  // What effects bend by secants lands on weak nuisances too, in prior scales the ones that move.
  if (first_followed_ < nuisances_ && !anew)
    for (Eigen::Index i = nuisances_; i < first_followed_ + followed(); ++i)
      for (const Secant& secant : secants_)
        slopes_.col(i) -= secant.missed * secant.along[i - first_followed_];
  slopes_(Eigen::all, columns) = *told;
  keep(u, true);
  secants_.clear();
  added_ = 0;
  ++times_renewed_;
  return &slopes_;
}

LinearNuisances linear_nuisances(const Problem& problem, const Whitening& whitening, Vector p) {
  LinearNuisances out{std::move(p), {}};
  const std::vector<int> nuisances = problem.hypotheses.nuisances();
  if (nuisances.empty()) return out;
  Residual residual(problem, whitening, nuisances, out.p);
  // Under a plan other spaces follow from them.
  if (!in_windows(problem)) residual.keep_rows();
  const Vector u = residual.reduced(out.p);
  Vector r;
  const Matrix* slopes = residual.value(u, r) ? residual.slopes(u) : nullptr;
  if (slopes == nullptr) return out;
  out.slopes = *slopes;
  out.rows = residual.nuisance_rows();
  return out;
}

}  // namespace jaculus::diagnosis
