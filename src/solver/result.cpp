#include "jaculus/solver/result.h"

#include <array>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <type_traits>
#include <utility>

namespace jaculus::solver {
namespace {

constexpr std::array<std::pair<Status, const char*>, 13> kStatusNames{
    {{Status::optimal, "optimal"},
     {Status::acceptable, "acceptable"},
     {Status::infeasible, "infeasible"},
     {Status::contradictory_bounds, "contradictory_bounds"},
     {Status::iteration_limit, "iteration_limit"},
     {Status::time_limit, "time_limit"},
     {Status::interrupted, "interrupted"},
     {Status::stopped, "stopped"},
     {Status::diverged, "diverged"},
     {Status::stalled, "stalled"},
     {Status::evaluation_failed, "evaluation_failed"},
     {Status::no_freedom, "no_freedom"},
     {Status::failed, "failed"}}};

constexpr std::string_view kMagic = "jaculus-result/2";

class Writer {
 public:
  template <class T>
  requires std::is_arithmetic_v<T>
  void put(T value) { bytes_.append(reinterpret_cast<const char*>(&value), sizeof value); }
  void put(std::string_view text) {
    put_count(text.size());
    bytes_.append(text);
  }
  void put(const Vector& v) {
    put_count(v.size());
    bytes_.append(reinterpret_cast<const char*>(v.data()), v.size() * sizeof(double));
  }
  void put_count(std::uint64_t count) { put(count); }
  [[nodiscard]] std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

class Reader {
 public:
  explicit Reader(std::string_view bytes) : bytes_(bytes) {}

  template <class T>
  T get() {
    T value;
    std::memcpy(&value, chunk(sizeof value).data(), sizeof value);
    return value;
  }
  std::string text() {
    const std::size_t size = length(1);
    return std::string(chunk(size));
  }
  Vector vector() {
    const std::size_t size = length(sizeof(double));
    Vector v(size);
    if (size > 0) std::memcpy(v.data(), chunk(size * sizeof(double)).data(), size * sizeof(double));
    return v;
  }
  /// Number of elements to come, checked against what is left so that broken bytes can't ask for a
  /// huge allocation.
  std::size_t length(std::size_t element_size) {
    const auto size = get<std::uint64_t>();
    if (size > bytes_.size() / element_size) throw std::runtime_error("result: truncated bytes");
    return size;
  }
  [[nodiscard]] bool done() const { return bytes_.empty(); }

 private:
  std::string_view chunk(std::size_t size) {
    if (size > bytes_.size()) throw std::runtime_error("result: truncated bytes");
    const std::string_view head = bytes_.substr(0, size);
    bytes_.remove_prefix(size);
    return head;
  }
  std::string_view bytes_;
};

void put_history(Writer& out, const std::vector<IterationInfo>& history) {
  out.put_count(history.size());
  for (const IterationInfo& info : history) {
    out.put(info.iteration);
    out.put(info.objective);
    out.put(info.infeasibility);
    out.put(info.dual_infeasibility);
    out.put(info.barrier);
    const std::uint8_t restoration = info.restoration ? 1 : 0;
    out.put(restoration);
    out.put(info.elapsed_s);
  }
}

std::vector<IterationInfo> get_history(Reader& in) {
  std::vector<IterationInfo> history(in.length(sizeof(int) + 5 * sizeof(double) + 1));
  for (IterationInfo& info : history) {
    info.iteration = in.get<int>();
    info.objective = in.get<double>();
    info.infeasibility = in.get<double>();
    info.dual_infeasibility = in.get<double>();
    info.barrier = in.get<double>();
    info.restoration = in.get<std::uint8_t>() != 0;
    info.elapsed_s = in.get<double>();
  }
  return history;
}

}  // namespace

std::string to_string(Status status) {
  for (const auto& [value, name] : kStatusNames) {
    if (value == status) return name;
  }
  throw std::logic_error("status without a name");
}

Status status_from_string(std::string_view text) {
  for (const auto& [value, name] : kStatusNames) {
    if (text == name) return value;
  }
  throw std::invalid_argument("unknown status '" + std::string(text) + "'");
}

const Vector& NlpResult::x() const {
  if (!converged()) {
    throw std::logic_error("the solve ended '" + to_string(status) +
                           "': it has no solution, only a last_iterate()");
  }
  return x_;
}

std::string serialise(const NlpResult& result) {
  Writer out;
  out.put(kMagic);
  out.put(to_string(result.status));
  out.put(result.message);
  out.put(result.last_iterate());
  out.put(result.row_multipliers);
  out.put(result.lower_multipliers);
  out.put(result.upper_multipliers);

  for (const double v : {result.objective, result.max_violation, result.max_scaled_violation})
    out.put(v);
  const EvaluationCounts& counts = result.evaluations;
  for (const int v : {result.iterations, result.feasibility_iterations, counts.objective,
                      counts.gradient, counts.constraints, counts.jacobian, counts.hessian}) {
    out.put(v);
  }
  const WallSeconds& wall = result.wall_seconds;
  for (const double v : {wall.total, wall.functions, wall.linear_solver}) out.put(v);
  put_history(out, result.history);

  out.put_count(result.conflicts.size());
  for (const BoundConflict& conflict : result.conflicts) {
    out.put(conflict.name);
    out.put(conflict.unit);
    out.put(conflict.lower);
    out.put(conflict.upper);
  }

  return out.take();
}

NlpResult deserialise_result(std::string_view bytes) {
  Reader in(bytes);
  if (in.text() != kMagic) throw std::runtime_error("result: not the bytes of a result");
  NlpResult result;
  result.status = status_from_string(in.text());
  result.message = in.text();
  result.set_iterate(in.vector());
  result.row_multipliers = in.vector();
  result.lower_multipliers = in.vector();
  result.upper_multipliers = in.vector();

  for (double* v : {&result.objective, &result.max_violation, &result.max_scaled_violation})
    *v = in.get<double>();
  EvaluationCounts& counts = result.evaluations;
  for (int* v : {&result.iterations, &result.feasibility_iterations, &counts.objective,
                 &counts.gradient, &counts.constraints, &counts.jacobian, &counts.hessian}) {
    *v = in.get<int>();
  }
  WallSeconds& wall = result.wall_seconds;
  for (double* v : {&wall.total, &wall.functions, &wall.linear_solver}) *v = in.get<double>();
  result.history = get_history(in);

  result.conflicts.resize(in.length(2 * sizeof(double) + 2));
  for (BoundConflict& conflict : result.conflicts) {
    conflict.name = in.text();
    conflict.unit = in.text();
    conflict.lower = in.get<double>();
    conflict.upper = in.get<double>();
  }

  if (!in.done()) throw std::runtime_error("result: bytes left over");
  return result;
}

}  // namespace jaculus::solver
