#include "jaculus/solver/ipopt.h"

#include <IpoptConfig.h>
#include <dlfcn.h>
#include <fmt/format.h>

#include <IpIpoptApplication.hpp>
#include <IpSolveStatistics.hpp>
#include <algorithm>
#include <cassert>
#include <charconv>
#include <cstdlib>
#include <mutex>
#include <utility>

#include "jaculus/core/error.h"
#include "jaculus/solver/violations.h"
#include "solver/ipopt_adapter.h"
#include "solver/ipopt_frontal.h"

namespace jaculus::solver {
namespace {

using OptionMap = std::map<std::string, std::string>;

constexpr const char* kOwnLinearSolver = "frontal";

std::string number_text(double value) { return fmt::format("{:.17g}", value); }

/// The options every solve runs with, as Ipopt's own names and values.
OptionMap base_options(const SolverOptions& options, bool warm) {
  const bool own = options.linear_solver == kOwnLinearSolver;
  OptionMap map = {
      {"print_level", "0"},
      {"sb", "yes"},
      {"nlp_scaling_method", "user-scaling"},
      {"linear_solver", own ? "ma57" : options.linear_solver},
      {"hessian_approximation", options.exact_hessian ? "exact" : "limited-memory"},
      {"max_iter", std::to_string(options.max_iterations)},
      {"tol", number_text(options.tolerance)},
      {"acceptable_tol", number_text(std::max(options.acceptable_tolerance, options.tolerance))},
      {"constr_viol_tol", number_text(options.row_tolerance)},
      {"acceptable_constr_viol_tol", number_text(options.row_tolerance)},
      // Optimality is judged on the scaled problem alone: an unscaled gradient has no common unit
      // to judge it by.
      {"dual_inf_tol", "1e10"},
      {"compl_inf_tol", "1e10"},
      {"acceptable_dual_inf_tol", "1e10"},
      {"acceptable_compl_inf_tol", "1e10"},
      {"honor_original_bounds", "yes"},
      // A small first barrier: a large one pushes durations to the middle of their bounds, away
      // from a good guess.
      {"mu_strategy", "monotone"},
      {"mu_init", "1e-2"},
  };

  if (own) {  // it comes in MA57's place
    map["linear_system_scaling"] = "none";
    map["ma57_pivtol"] = "1e-2";
    map["ma57_pivtolmax"] = "0.3";
    map["min_refinement_steps"] = "0";  // residuals are looked at all the same
  }

  if (warm) {
    map["warm_start_init_point"] = "yes";
    map["mu_strategy"] = "monotone";
    map["mu_init"] = "1e-5";
    for (const char* name :
         {"bound_push", "bound_frac", "slack_bound_push", "slack_bound_frac", "mult_bound_push"}) {
      map[std::string("warm_start_") + name] = "1e-8";
    }
  }

  return map;
}

/// JACULUS_IPOPT_OPTIONS: "name value;name value".
OptionMap environment_options() {
  OptionMap map;
  const char* text = std::getenv("JACULUS_IPOPT_OPTIONS");
  std::string rest = text == nullptr ? "" : text;

  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find(';'), rest.size());
    const std::string entry = rest.substr(0, end);
    rest.erase(0, end + 1);

    const std::size_t name = entry.find_first_not_of(' ');
    if (name == std::string::npos) continue;
    const std::size_t gap = entry.find(' ', name);
    const std::size_t value = gap == std::string::npos ? gap : entry.find_first_not_of(' ', gap);
    if (value == std::string::npos) {
      throw InputError("JACULUS_IPOPT_OPTIONS: '" + entry +
                       "'; allowed is \"name value;name value\"");
    }
    map[entry.substr(name, gap - name)] =
        entry.substr(value, entry.find_last_not_of(' ') + 1 - value);
  }

  return map;
}

template <class T>
T parse_number(const std::string& name, const std::string& text) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) {
    throw InputError("solver option '" + name + "': '" + text + "' is not a number of its type");
  }
  return value;
}

void set_option(Ipopt::IpoptApplication& app, const std::string& name, const std::string& value) {
  const Ipopt::SmartPtr<const Ipopt::RegisteredOption> known = app.RegOptions()->GetOption(name);
  if (!IsValid(known))
    throw InputError("solver option '" + name + "': Ipopt " + ipopt_version() +
                     " has no such option");
  bool accepted = false;
  if (known->Type() == Ipopt::OT_Number) {
    accepted = app.Options()->SetNumericValue(name, parse_number<double>(name, value));
  } else if (known->Type() == Ipopt::OT_Integer) {
    accepted = app.Options()->SetIntegerValue(name, parse_number<int>(name, value));
  } else {
    accepted = app.Options()->SetStringValue(name, value);
  }
  if (!accepted)
    throw InputError("solver option '" + name + "': Ipopt does not accept the value '" + value +
                     "'");
}

void set_options(Ipopt::IpoptApplication& app, const SolverOptions& options, bool warm) {
  OptionMap map = base_options(options, warm);
  for (const auto& [name, value] : options.ipopt) {
    if (name == "print_level" || name == "sb" || name == "output_file" ||
        name == "file_print_level") {
      throw InputError("solver option '" + name +
                       "': what is printed is not the problem's to say; use --quiet or --json");
    }
    map[name] = value;
  }
  for (const auto& [name, value] : environment_options()) map[name] = value;
  // 3.14
  if (IsValid(app.RegOptions()->GetOption("timing_statistics")))
    map.emplace("timing_statistics", "yes");
  for (const auto& [name, value] : map) set_option(app, name, value);
}

/// Threads of OpenBLAS change the order of sums and fight with --jobs; other BLAS libraries don't
/// have this switch.
void use_one_blas_thread() {
  using SetThreads = void (*)(int);
  if (const auto set =
          reinterpret_cast<SetThreads>(dlsym(RTLD_DEFAULT, "openblas_set_num_threads")))
    set(1);
}

std::pair<Status, std::string> explain(int code, const detail::IpoptAdapter& adapter) {
  const std::string undefined =
      adapter.failed_function.empty()
          ? ""
          : "; last undefined or not finite: the " + adapter.failed_function;

  switch (code) {
    case Ipopt::Solve_Succeeded:
      return {Status::optimal, "optimal to the tolerance"};
    case Ipopt::Feasible_Point_Found:
      return {Status::optimal, "as many equations as free variables; they hold to the tolerance"};
    case Ipopt::Solved_To_Acceptable_Level:
      return {Status::acceptable, "optimal to the acceptable tolerance, no further progress"};
    case Ipopt::Infeasible_Problem_Detected:
      return {Status::infeasible, "no point nearby satisfies all constraints"};
    case Ipopt::Search_Direction_Becomes_Too_Small:
      return {Status::stalled, "steps became too small" + undefined};
    case Ipopt::Restoration_Failed:
      return {Status::stalled, "the search for feasibility found no further step" + undefined};
    case Ipopt::Error_In_Step_Computation:
      return {Status::stalled, "no step could be computed" + undefined};
    case Ipopt::Diverging_Iterates:
      return {Status::diverged, "iterates grow without end; is the problem bounded?"};
    case Ipopt::User_Requested_Stop:
      assert(adapter.stop_reason);
      return {*adapter.stop_reason, "ended before convergence: " + to_string(*adapter.stop_reason)};
    case Ipopt::Maximum_Iterations_Exceeded:
      return {Status::iteration_limit, "not converged within the allowed iterations"};
    case Ipopt::Maximum_CpuTime_Exceeded:
    case -5:  // Maximum_WallTime_Exceeded of 3.14
      return {Status::time_limit, "not converged within the allowed time"};
    case Ipopt::Not_Enough_Degrees_Of_Freedom:
      return {Status::no_freedom, "fewer free variables than equality constraints"};
    case Ipopt::Invalid_Number_Detected:
      return {Status::evaluation_failed,
              "the functions can't be evaluated where they are needed" + undefined};
    default:
      return {Status::failed, fmt::format("Ipopt ended with code {}{}", code, undefined)};
  }
}

/// Fixed variables are constants to Ipopt, so their multipliers come from stationarity:
///   lower - upper = (grad f + J' lambda)_i, the rate of the objective with the fixed value.
void add_fixed_multipliers(transcription::Nlp& nlp, NlpResult& result) {
  const Vector& lower = nlp.variable_lower();
  const Vector& upper = nlp.variable_upper();
  if (!(lower.array() == upper.array()).any()) return;
  const transcription::Sparsity& sparsity = nlp.jacobian_sparsity();
  Vector rate(nlp.variables()), jacobian(sparsity.size());
  if (!nlp.gradient(result.last_iterate(), rate) || !nlp.jacobian(result.last_iterate(), jacobian))
    return;
  for (int k = 0; k < sparsity.size(); ++k) {
    rate[sparsity.columns[k]] += jacobian[k] * result.row_multipliers[sparsity.rows[k]];
  }
  for (int i = 0; i < nlp.variables(); ++i) {
    if (lower[i] != upper[i]) continue;
    result.lower_multipliers[i] = std::max(rate[i], 0.0);
    result.upper_multipliers[i] = std::max(-rate[i], 0.0);
  }
}

void measure_violation(transcription::Nlp& nlp, NlpResult& result) {
  if (!nlp.objective(result.last_iterate(), result.objective)) result.objective = kNaN;
  if (const auto worst = worst_violation(nlp, result.last_iterate())) {
    result.max_violation = worst->absolute;
    result.max_scaled_violation = worst->scaled;
  }
}

/// With every variable fixed there is nothing to search: the constraints hold or they don't.
NlpResult judge_fixed_point(transcription::Nlp& nlp, const Start& start, double row_tolerance) {
  NlpResult result;
  result.set_iterate(detail::clamp_into_bounds(nlp, start.x));
  result.row_multipliers = Vector::Zero(nlp.rows());
  result.lower_multipliers = result.upper_multipliers = Vector::Zero(nlp.variables());
  measure_violation(nlp, result);
  add_fixed_multipliers(nlp, result);
  result.status = result.max_violation <= row_tolerance ? Status::optimal : Status::infeasible;
  if (!std::isfinite(result.objective + result.max_violation))
    result.status = Status::evaluation_failed;
  result.message = "every variable is fixed; nothing to optimise";
  return result;
}

NlpResult refuse(std::vector<BoundConflict> conflicts) {
  NlpResult result;
  result.status = Status::contradictory_bounds;
  result.message = "contradictory bounds:";
  for (const BoundConflict& c : conflicts) {
    result.message += fmt::format(" {} in [{:g}, {:g}] {};", c.name, c.lower, c.upper, c.unit);
  }
  result.message.pop_back();
  result.conflicts = std::move(conflicts);
  return result;
}

NlpResult run_ipopt_with(transcription::Nlp& nlp, const Start& start,
                         const SolverOptions& options) {
  use_one_blas_thread();
  Ipopt::SmartPtr<Ipopt::IpoptApplication> app = new Ipopt::IpoptApplication(false);
  app->RethrowNonIpoptException(true);
  set_options(*app, options, start.duals.has_value());
  Ipopt::SmartPtr<detail::IpoptAdapter> adapter = new detail::IpoptAdapter(nlp, start, options);

  // An empty file name: no ipopt.opt of the working folder has a say.
  if (app->Initialize("") != Ipopt::Solve_Succeeded) throw InputError("Ipopt refuses its options");

  const auto begin = std::chrono::steady_clock::now();
  const int code = app->OptimizeTNLP(GetRawPtr(adapter));
  NlpResult result = std::move(adapter->result);
  result.wall_seconds.total =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();

  if (code == Ipopt::Invalid_Option || code == Ipopt::Invalid_Problem_Definition) {
    throw InputError("Ipopt refuses its options: is the linear solver '" + options.linear_solver +
                     "' installed?");
  }
  std::tie(result.status, result.message) = explain(code, *adapter);

  if (!result.history.empty()) result.iterations = result.history.back().iteration;
  if (IsValid(app->IpoptDataObject())) {
    result.wall_seconds.linear_solver =
        adapter->restoration_linear_seconds() +
        detail::linear_seconds(app->IpoptDataObject()->TimingStats());
  }

  add_fixed_multipliers(nlp, result);
  measure_violation(nlp, result);
  return result;
}

/// The frontal solver where it can be had, MUMPS for all that it refuses.
NlpResult run_ipopt(transcription::Nlp& nlp, const Start& start, const SolverOptions& options) {
  if (options.linear_solver != kOwnLinearSolver) return run_ipopt_with(nlp, start, options);
  if (options.exact_hessian && detail::FrontalInIpopt::available()) {
    const detail::FrontalInIpopt frontal(nlp);
    NlpResult result = run_ipopt_with(nlp, start, options);
    if (!detail::FrontalInIpopt::refused()) return result;
  }
  SolverOptions with_mumps = options;
  with_mumps.linear_solver = "mumps";
  return run_ipopt_with(nlp, start, with_mumps);
}

}  // namespace

Start warm_start(const NlpResult& result) {
  return {result.last_iterate(),
          Duals{result.row_multipliers, result.lower_multipliers, result.upper_multipliers}};
}

std::vector<BoundConflict> bound_conflicts(const transcription::Nlp& nlp) {
  std::vector<BoundConflict> conflicts;
  const auto impossible = [](double lower, double upper) {  // written so that NaN is caught
    return !(lower <= upper) || lower == kInfinity || upper == -kInfinity;
  };
  for (int i = 0; i < nlp.variables(); ++i) {
    const double lower = nlp.variable_lower()[i], upper = nlp.variable_upper()[i];
    if (impossible(lower, upper))
      conflicts.push_back({nlp.variable_name(i), nlp.variable_unit(i), lower, upper});
  }
  for (int i = 0; i < nlp.rows(); ++i) {
    const double lower = nlp.row_lower()[i], upper = nlp.row_upper()[i];
    if (impossible(lower, upper))
      conflicts.push_back({nlp.row_name(i), nlp.row_unit(i), lower, upper});
  }
  return conflicts;
}

NlpResult solve_nlp(transcription::Nlp& nlp, const Start& start, const SolverOptions& options) {
  assert(start.x.size() == nlp.variables());
  static std::mutex one_at_a_time;  // MUMPS keeps state of its own
  const std::lock_guard lock(one_at_a_time);
  std::vector<BoundConflict> conflicts = bound_conflicts(nlp);
  if (!conflicts.empty()) return refuse(std::move(conflicts));
  if (nlp.variable_lower() == nlp.variable_upper())
    return judge_fixed_point(nlp, start, options.row_tolerance);
  return run_ipopt(nlp, start, options);
}

std::string ipopt_version() { return IPOPT_VERSION; }

}  // namespace jaculus::solver
