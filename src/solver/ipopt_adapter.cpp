#include "solver/ipopt_adapter.h"

#include <IpCompoundVector.hpp>
#include <IpTNLPAdapter.hpp>
#include <algorithm>
#include <cassert>

#include "jaculus/core/interrupt.h"

namespace jaculus::solver::detail {
namespace {

using ConstMap = Eigen::Map<const Vector>;
using Map = Eigen::Map<Vector>;

constexpr double kIpoptInfinity = 2e19;  // beyond Ipopt's default of 1e19 for "no bound"

void copy_bounds(const Vector& from, double* to) {
  for (Eigen::Index i = 0; i < from.size(); ++i)
    to[i] = std::clamp(from[i], -kIpoptInfinity, kIpoptInfinity);
}

void copy(const Vector& from, double* to) { std::copy(from.data(), from.data() + from.size(), to); }

}  // namespace

Vector clamp_into_bounds(const transcription::Nlp& nlp, const Vector& x) {
  return x.cwiseMax(nlp.variable_lower()).cwiseMin(nlp.variable_upper());
}

double linear_seconds(Ipopt::TimingStatistics& timing) {
  return timing.StdAugSystemSolverMultiSolve().TotalWallclockTime();
}

IpoptAdapter::IpoptAdapter(transcription::Nlp& nlp, const Start& start,
                           const SolverOptions& options)
    : nlp_(nlp), start_(start), options_(options), point_(start.x) {
  assert(start.x.size() == nlp.variables());
  assert(nlp.variable_scale().size() == nlp.variables() &&
         (nlp.variable_scale().array() > 0.0).all());
  assert(nlp.row_scale().size() == nlp.rows() && (nlp.row_scale().array() > 0.0).all());
  assert(nlp.objective_scale() > 0.0);
  result.row_multipliers = Vector::Zero(nlp.rows());
  result.lower_multipliers = Vector::Zero(nlp.variables());
  result.upper_multipliers = Vector::Zero(nlp.variables());
  result.set_iterate(clamp_into_bounds(nlp, start.x));
}

double IpoptAdapter::elapsed() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
}

bool IpoptAdapter::get_nlp_info(Index& n, Index& m, Index& nnz_jac_g, Index& nnz_h_lag,
                                IndexStyleEnum& index_style) {
  n = nlp_.variables();
  m = nlp_.rows();
  nnz_jac_g = nlp_.jacobian_sparsity().size();
  nnz_h_lag = nlp_.hessian_sparsity().size();
  index_style = C_STYLE;
  return true;
}

bool IpoptAdapter::get_bounds_info(Index, Number* x_l, Number* x_u, Index, Number* g_l,
                                   Number* g_u) {
  copy_bounds(nlp_.variable_lower(), x_l);
  copy_bounds(nlp_.variable_upper(), x_u);
  copy_bounds(nlp_.row_lower(), g_l);
  copy_bounds(nlp_.row_upper(), g_u);
  return true;
}

bool IpoptAdapter::get_scaling_parameters(Number& obj_scaling, bool& use_x_scaling, Index,
                                          Number* x_scaling, bool& use_g_scaling, Index,
                                          Number* g_scaling) {
  obj_scaling = 1.0 / nlp_.objective_scale();
  use_x_scaling = use_g_scaling = true;
  copy(nlp_.variable_scale().cwiseInverse(), x_scaling);
  copy(nlp_.row_scale().cwiseInverse(), g_scaling);
  return true;
}

bool IpoptAdapter::get_starting_point(Index, bool init_x, Number* x, bool init_z, Number* z_l,
                                      Number* z_u, Index, bool init_lambda, Number* lambda) {
  if (init_x) copy(clamp_into_bounds(nlp_, start_.x), x);
  if ((init_z || init_lambda) && !start_.duals) return false;
  if (init_z) {
    copy(start_.duals->lower, z_l);
    copy(start_.duals->upper, z_u);
  }
  if (init_lambda) copy(start_.duals->rows, lambda);
  return true;
}

template <class Evaluate>
bool IpoptAdapter::evaluate(const char* name, int& count, const Number* values, int size,
                            Evaluate&& run) {
  const double before = elapsed();
  ++count;
  const bool defined = run() && ConstMap(values, size).allFinite();
  result.wall_seconds.functions += elapsed() - before;
  if (!defined) failed_function = name;
  return defined;
}

bool IpoptAdapter::eval_f(Index n, const Number* x, bool, Number& obj_value) {
  return evaluate("objective", result.evaluations.objective, &obj_value, 1,
                  [&] { return nlp_.objective(ConstMap(x, n), obj_value); });
}

bool IpoptAdapter::eval_grad_f(Index n, const Number* x, bool, Number* grad_f) {
  return evaluate("objective gradient", result.evaluations.gradient, grad_f, n,
                  [&] { return nlp_.gradient(ConstMap(x, n), Map(grad_f, n)); });
}

bool IpoptAdapter::eval_g(Index n, const Number* x, bool, Index m, Number* g) {
  const bool defined = evaluate("constraints", result.evaluations.constraints, g, m,
                                [&] { return nlp_.constraints(ConstMap(x, n), Map(g, m)); });
  if (defined) {
    row_point_ = ConstMap(x, n);
    row_values_ = ConstMap(g, m);
  }
  return defined;
}

bool IpoptAdapter::eval_jac_g(Index n, const Number* x, bool, Index, Index nele_jac, Index* rows,
                              Index* columns, Number* values) {
  if (values == nullptr) {
    const transcription::Sparsity& sparsity = nlp_.jacobian_sparsity();
    std::copy(sparsity.rows.begin(), sparsity.rows.end(), rows);
    std::copy(sparsity.columns.begin(), sparsity.columns.end(), columns);
    return true;
  }
  return evaluate("constraint Jacobian", result.evaluations.jacobian, values, nele_jac,
                  [&] { return nlp_.jacobian(ConstMap(x, n), Map(values, nele_jac)); });
}

bool IpoptAdapter::eval_h(Index n, const Number* x, bool, Number obj_factor, Index m,
                          const Number* lambda, bool, Index nele_hess, Index* rows, Index* columns,
                          Number* values) {
  if (values == nullptr) {
    const transcription::Sparsity& sparsity = nlp_.hessian_sparsity();
    std::copy(sparsity.rows.begin(), sparsity.rows.end(), rows);
    std::copy(sparsity.columns.begin(), sparsity.columns.end(), columns);
    return true;
  }
  return evaluate("Hessian of the Lagrangian", result.evaluations.hessian, values, nele_hess, [&] {
    return nlp_.hessian(ConstMap(x, n), obj_factor, ConstMap(lambda, m), Map(values, nele_hess));
  });
}

bool IpoptAdapter::current_point(const Ipopt::IpoptData* data,
                                 Ipopt::IpoptCalculatedQuantities* quantities) {
  if (data == nullptr || quantities == nullptr) return false;
  // iteration 0 belongs to the problem itself, later ones may be the restoration's
  if (original_ == nullptr) {
    original_ = dynamic_cast<Ipopt::OrigIpoptNLP*>(GetRawPtr(quantities->GetIpoptNLP()));
    if (original_ == nullptr) return false;
  }
  Ipopt::SmartPtr<const Ipopt::Vector> x = data->curr()->x();
  if (const auto* compound = dynamic_cast<const Ipopt::CompoundVector*>(GetRawPtr(x))) {
    x = compound->GetComp(0);  // restoration stacks its slacks below the variables
  }
  auto* adapter = dynamic_cast<Ipopt::TNLPAdapter*>(GetRawPtr(original_->nlp()));
  if (adapter == nullptr) return false;
  adapter->ResortX(*original_->NLP_scaling()->unapply_vector_scaling_x(x), point_.data());
  return true;
}

double IpoptAdapter::row_violation() {
  if (row_point_.size() != point_.size() || row_point_ != point_) {
    row_point_ = point_;
    row_values_.resize(nlp_.rows());
    if (!nlp_.constraints(point_, row_values_)) {
      row_point_.resize(0);
      return kNaN;
    }
  }
  if (nlp_.rows() == 0) return 0.0;
  return std::max({0.0, (nlp_.row_lower() - row_values_).maxCoeff(),
                   (row_values_ - nlp_.row_upper()).maxCoeff()});
}

bool IpoptAdapter::intermediate_callback(Ipopt::AlgorithmMode mode, Index iter, Number obj_value,
                                         Number inf_pr, Number inf_du, Number mu, Number, Number,
                                         Number, Number, Index, const Ipopt::IpoptData* ip_data,
                                         Ipopt::IpoptCalculatedQuantities* ip_cq) {
  IterationInfo info;
  info.iteration = iter;
  info.objective = obj_value;
  info.infeasibility = inf_pr;
  info.restoration = mode == Ipopt::RestorationPhaseMode;

  if (current_point(ip_data, ip_cq)) {
    info.infeasibility = row_violation();
    // The restoration reports an objective of its own.
    if (info.restoration && !nlp_.objective(point_, info.objective)) info.objective = kNaN;
  }

  if (info.restoration && ip_data != nullptr) {
    // no const access
    const double spent = linear_seconds(const_cast<Ipopt::IpoptData*>(ip_data)->TimingStats());
    if (spent < restoration_s_) restorations_s_ += restoration_s_;
    restoration_s_ = spent;
  }

  info.dual_infeasibility = inf_du;
  info.barrier = mu;
  info.elapsed_s = elapsed();
  result.history.push_back(info);

  if (options_.progress && !options_.progress(info)) stop_reason = Status::stopped;
  if (info.elapsed_s > options_.time_limit_s) stop_reason = Status::time_limit;
  if (options_.stop_on_interrupt && interrupt_requested()) stop_reason = Status::interrupted;
  return !stop_reason;
}

void IpoptAdapter::finalize_solution(Ipopt::SolverReturn, Index n, const Number* x,
                                     const Number* z_l, const Number* z_u, Index m, const Number*,
                                     const Number* lambda, Number, const Ipopt::IpoptData*,
                                     Ipopt::IpoptCalculatedQuantities*) {
  result.set_iterate(ConstMap(x, n));
  result.lower_multipliers = ConstMap(z_l, n);
  result.upper_multipliers = ConstMap(z_u, n);
  result.row_multipliers = ConstMap(lambda, m);
}

}  // namespace jaculus::solver::detail
