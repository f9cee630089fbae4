#include "jaculus/solver/elastic.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

namespace jaculus::solver {
namespace {

/// The row's distance beyond the bound it passes.
double beyond(double value, double lower, double upper) {
  if (value > upper) return value - upper;
  return value < lower ? value - lower : 0.0;
}

std::vector<Relaxation> relaxed_rows(transcription::Nlp& nlp, const Vector& excess, const Vector& x,
                                     double tolerance) {
  Vector values(nlp.rows());
  std::vector<Relaxation> relaxed;
  if (!nlp.constraints(x, values)) return relaxed;
  for (int i = 0; i < nlp.rows(); ++i) {
    // Slacks end a little above zero; what counts is by how much the row itself is missed.
    const double amount = beyond(values[i], nlp.row_lower()[i], nlp.row_upper()[i]);
    const double scaled = std::abs(amount) / nlp.row_scale()[i];
    if (excess[i] == 0.0 || scaled <= tolerance) continue;
    relaxed.push_back({i, nlp.row_name(i), nlp.row_unit(i), amount, scaled});
  }
  std::stable_sort(relaxed.begin(), relaxed.end(),
                   [](const auto& a, const auto& b) { return a.scaled > b.scaled; });
  return relaxed;
}

/// Limits that change the sum of slacks.
std::vector<LimitSensitivity> all_limits(const ElasticNlp& elastic, int variables,
                                         const NlpResult& result) {
  std::vector<LimitSensitivity> limits =
      limit_sensitivities(elastic, result, {.threshold = 1e-3, .equalities = true});
  std::erase_if(limits, [&](const LimitSensitivity& limit) {
    return !limit.is_row && limit.index >= variables;  // bounds of the slacks
  });
  return limits;
}

/// Those without the relaxed rows themselves.
std::vector<LimitSensitivity> opposing_limits(std::vector<LimitSensitivity> limits,
                                              const std::vector<Relaxation>& relaxed,
                                              std::size_t most) {
  std::erase_if(limits, [&](const LimitSensitivity& limit) {
    return limit.is_row && std::any_of(relaxed.begin(), relaxed.end(),
                                       [&](const auto& r) { return r.row == limit.index; });
  });
  if (limits.size() > most) limits.resize(most);
  return limits;
}

}  // namespace

ElasticNlp::ElasticNlp(transcription::Nlp& nlp, Vector reference,
                       const std::function<bool(int row)>& may_relax, double proximity)
    : nlp_(nlp),
      n_(nlp.variables()),
      reference_(std::move(reference)),
      jacobian_(nlp.jacobian_sparsity()) {
  assert(reference_.size() == n_);
  for (int i = 0; i < nlp.rows(); ++i) {
    if (may_relax && !may_relax(i)) continue;
    if (nlp.row_upper()[i] < kInfinity) slacks_.push_back({i, -1.0});
    if (nlp.row_lower()[i] > -kInfinity) slacks_.push_back({i, 1.0});
  }

  const auto count = std::ssize(slacks_);
  pull_ = proximity * nlp.variable_scale().array().square().inverse();
  lower_.resize(n_ + count);
  lower_ << nlp.variable_lower(), Vector::Zero(count);
  upper_.resize(n_ + count);
  upper_ << nlp.variable_upper(), Vector::Constant(count, kInfinity);
  scale_.resize(n_ + count);
  scale_.head(n_) = nlp.variable_scale();
  for (int k = 0; k < count; ++k) {
    const int row = slacks_[k].row;
    scale_[n_ + k] = nlp.row_scale()[row];
    jacobian_.rows.push_back(row);
    jacobian_.columns.push_back(n_ + k);
  }

  hessian_ = nlp.hessian_sparsity();
  for (int i = 0; i < n_; ++i) {
    hessian_.rows.push_back(i);
    hessian_.columns.push_back(i);
  }
}

Vector ElasticNlp::start() {
  Vector point = Vector::Zero(variables());
  point.head(n_) = reference_.cwiseMax(nlp_.variable_lower()).cwiseMin(nlp_.variable_upper());
  Vector values(rows());
  if (!nlp_.constraints(point.head(n_), values)) return point;
  for (int k = 0; k < count_of(slacks_); ++k) {
    const int i = slacks_[k].row;
    const double amount = -slacks_[k].sign * beyond(values[i], row_lower()[i], row_upper()[i]);
    point[n_ + k] = std::max(amount, 0.0);
  }
  return point;
}

Vector ElasticNlp::excess(const Vector& point) const {
  Vector sum = Vector::Zero(rows());
  for (int k = 0; k < count_of(slacks_); ++k) {
    sum[slacks_[k].row] -= slacks_[k].sign * point[n_ + k];
  }
  return sum;
}

std::string ElasticNlp::variable_name(int column) const {
  if (column < n_) return nlp_.variable_name(column);
  const Slack& slack = slacks_[column - n_];
  return nlp_.row_name(slack.row) +
         (slack.sign > 0.0 ? ", short of its lower bound" : ", over its upper bound");
}

std::string ElasticNlp::variable_unit(int column) const {
  return column < n_ ? nlp_.variable_unit(column) : nlp_.row_unit(slacks_[column - n_].row);
}

bool ElasticNlp::objective(const ConstVectorRef& x, double& value) {
  const auto count = std::ssize(slacks_);
  value = x.tail(count).cwiseQuotient(scale_.tail(count)).sum() +
          0.5 * (x.head(n_) - reference_).cwiseAbs2().dot(pull_);
  return true;
}

bool ElasticNlp::gradient(const ConstVectorRef& x, VectorRef gradient) {
  const auto count = std::ssize(slacks_);
  gradient.head(n_) = pull_.cwiseProduct(x.head(n_) - reference_);
  gradient.tail(count) = scale_.tail(count).cwiseInverse();
  return true;
}

bool ElasticNlp::constraints(const ConstVectorRef& x, VectorRef values) {
  if (!nlp_.constraints(x.head(n_), values)) return false;
  for (int k = 0; k < count_of(slacks_); ++k) {
    values[slacks_[k].row] += slacks_[k].sign * x[n_ + k];
  }
  return true;
}

bool ElasticNlp::jacobian(const ConstVectorRef& x, VectorRef values) {
  const Eigen::Index own = nlp_.jacobian_sparsity().size();
  for (int k = 0; k < count_of(slacks_); ++k) values[own + k] = slacks_[k].sign;
  return nlp_.jacobian(x.head(n_), values.head(own));
}

bool ElasticNlp::hessian(const ConstVectorRef& x, double sigma, const ConstVectorRef& lambda,
                         VectorRef values) {
  values.tail(n_) = sigma * pull_;
  return nlp_.hessian(x.head(n_), 0.0, lambda, values.head(nlp_.hessian_sparsity().size()));
}

Conflict find_conflict(transcription::Nlp& nlp, const Vector& x, const ElasticOptions& options) {
  ElasticNlp elastic(nlp, x, options.may_relax, options.proximity);
  const NlpResult result = solve_nlp(elastic, {elastic.start(), {}}, options.solver);
  Conflict conflict;
  conflict.status = result.status;
  conflict.iterations = result.iterations;
  conflict.wall_seconds = result.wall_seconds;
  if (result.last_iterate().size() == 0) return conflict;  // contradictory bounds: nothing ran
  conflict.x = result.last_iterate().head(nlp.variables());
  conflict.relaxed =
      relaxed_rows(nlp, elastic.excess(result.last_iterate()), conflict.x, options.tolerance);
  conflict.feasible = result.converged() && conflict.relaxed.empty();
  if (result.converged() && !conflict.feasible) {
    conflict.limits = all_limits(elastic, nlp.variables(), result);
    conflict.against =
        opposing_limits(conflict.limits, conflict.relaxed, std::max(options.most, 0));
  }
  return conflict;
}

}  // namespace jaculus::solver
