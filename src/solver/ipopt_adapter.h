#pragma once
// What Ipopt sees of an Nlp. Private to solver/ipopt.cpp.

#include <IpIpoptCalculatedQuantities.hpp>
#include <IpIpoptData.hpp>
#include <IpOrigIpoptNLP.hpp>
#include <IpTNLP.hpp>
#include <IpTimingStatistics.hpp>
#include <chrono>
#include <optional>
#include <string>

#include "jaculus/solver/ipopt.h"

namespace jaculus::solver::detail {

class IpoptAdapter : public Ipopt::TNLP {
 public:
  using Index = Ipopt::Index;
  using Number = Ipopt::Number;

  /// All of them must outlive the adapter.
  IpoptAdapter(transcription::Nlp& nlp, const Start& start, const SolverOptions& options);

  bool get_nlp_info(Index& n, Index& m, Index& nnz_jac_g, Index& nnz_h_lag,
                    IndexStyleEnum& index_style) override;
  bool get_bounds_info(Index n, Number* x_l, Number* x_u, Index m, Number* g_l,
                       Number* g_u) override;
  bool get_scaling_parameters(Number& obj_scaling, bool& use_x_scaling, Index n, Number* x_scaling,
                              bool& use_g_scaling, Index m, Number* g_scaling) override;
  bool get_starting_point(Index n, bool init_x, Number* x, bool init_z, Number* z_l, Number* z_u,
                          Index m, bool init_lambda, Number* lambda) override;
  bool eval_f(Index n, const Number* x, bool new_x, Number& obj_value) override;
  bool eval_grad_f(Index n, const Number* x, bool new_x, Number* grad_f) override;
  bool eval_g(Index n, const Number* x, bool new_x, Index m, Number* g) override;
  bool eval_jac_g(Index n, const Number* x, bool new_x, Index m, Index nele_jac, Index* rows,
                  Index* columns, Number* values) override;
  bool eval_h(Index n, const Number* x, bool new_x, Number obj_factor, Index m,
              const Number* lambda, bool new_lambda, Index nele_hess, Index* rows, Index* columns,
              Number* values) override;
  bool intermediate_callback(Ipopt::AlgorithmMode mode, Index iter, Number obj_value, Number inf_pr,
                             Number inf_du, Number mu, Number d_norm, Number regularization_size,
                             Number alpha_du, Number alpha_pr, Index ls_trials,
                             const Ipopt::IpoptData* ip_data,
                             Ipopt::IpoptCalculatedQuantities* ip_cq) override;
  void finalize_solution(Ipopt::SolverReturn status, Index n, const Number* x, const Number* z_l,
                         const Number* z_u, Index m, const Number* g, const Number* lambda,
                         Number obj_value, const Ipopt::IpoptData* ip_data,
                         Ipopt::IpoptCalculatedQuantities* ip_cq) override;

  /// Wall time the restoration has spent on linear systems [s].
  [[nodiscard]] double restoration_linear_seconds() const {
    return restorations_s_ + restoration_s_;
  }

  NlpResult result;  ///< filled as the solve goes on; status and message are the caller's
  std::optional<Status> stop_reason;  ///< why the callback ended the solve
  std::string failed_function;        ///< the function that last was undefined or not finite

 private:
  /// Runs one evaluation under the clock; false, noted by name, where it fails or `values` are not
  /// finite.
  template <class Evaluate>
  bool evaluate(const char* name, int& count, const Number* values, int size, Evaluate&& run);
  /// The unscaled point of an iteration, in restoration too; false where Ipopt hides it.
  bool current_point(const Ipopt::IpoptData* data, Ipopt::IpoptCalculatedQuantities* quantities);
  /// Largest row violation at point_.
  double row_violation();
  [[nodiscard]] double elapsed() const;

  transcription::Nlp& nlp_;
  const Start& start_;
  const SolverOptions& options_;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  /// Knows how to undo scaling and the removal of fixed variables. Not counted: it holds this
  /// adapter in turn.
  Ipopt::OrigIpoptNLP* original_ = nullptr;
  double restorations_s_ = 0.0;  ///< on linear systems, in restorations that are over [s]
  /// in the present or last one; Ipopt keeps its clock apart and resets it [s]
  double restoration_s_ = 0.0;
  Vector point_;                   ///< [n] the iterate of the callback
  Vector row_point_, row_values_;  ///< where the rows were last evaluated, and what they were
};

/// Wall time spent on linear systems, from building to back-solve [s]. (Ipopt 3.11 does not time
/// MUMPS' factorisation alone.)
double linear_seconds(Ipopt::TimingStatistics& timing);

/// Brings each entry of x into its bounds.
Vector clamp_into_bounds(const transcription::Nlp& nlp, const Vector& x);

}  // namespace jaculus::solver::detail
