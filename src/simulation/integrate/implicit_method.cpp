#include "simulation/integrate/implicit_method.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace jaculus::simulation::detail {

namespace {

constexpr double kGamma = 0.4358665215084590;
/// Share of the smoothed sign's width within which the rate is told to come to rest. Newton's step
/// to there, a/r, ends at a root where it is at most 1/(2 L) (Kantorovich), L = 2/width the most
/// that a smoothed sign's slope changes beside itself.
constexpr double kRests = 0.25;

/// As published, k_i = h f(y + sum alpha_ij k_j) + h J sum gamma_ij k_j, and with u = Gamma k,
/// which needs no product by J.
struct Coefficients {
  Eigen::Matrix4d a, c;           ///< below their diagonals
  Eigen::RowVector4d m, e, time;  ///< weights, those of the error, places of the stages

  Coefficients() {
    Eigen::Matrix4d alpha = Eigen::Matrix4d::Zero(), gamma = kGamma * Eigen::Matrix4d::Identity();
    alpha(1, 0) = 0.87173304301691801;
    alpha(2, 0) = 0.84457060015369423;
    alpha(2, 1) = -0.11299064236484185;
    alpha(3, 2) = 1.0;
    gamma(1, 0) = -0.87173304301691801;
    gamma(2, 0) = -0.90338057013044082;
    gamma(2, 1) = 0.054180672388095326;
    gamma(3, 0) = 0.24212380706095346;
    gamma(3, 1) = -1.2232505839045147;
    gamma(3, 2) = 0.54526025533510214;
    const Eigen::RowVector4d b{0.24212380706095346, -1.2232505839045147, 1.5452602553351020,
                               kGamma};
    const Eigen::RowVector4d less{0.37810903145819369, -0.096042292212423178, 0.5,
                                  0.21793326075422950};  // of order 2

    const Eigen::Matrix4d inverse = gamma.inverse();
    a = alpha * inverse;
    c = Eigen::Matrix4d::Identity() / kGamma - inverse;
    m = b * inverse;
    e = (b - less) * inverse;
    time = alpha.rowwise().sum().transpose();
  }
};

const Coefficients& coefficients() {
  static const Coefficients all;
  return all;
}

void add(double share, const State& x, State& sum) {
  for (std::size_t i = 0; i < x.size(); ++i) sum[i] += share * x[i];
}

}  // namespace

/// `inverse`: gamma h.
void ImplicitMethod::factorise(const FastParts& fast, double inverse) {
  SmallMatrix rates = SmallMatrix::Identity(size_, size_) / inverse;
  for (const FastPart& part : fast.parts) {
    const double slope = part.damping + inverse * part.stiffness;
    for (int j = 0; j < size_; ++j)
      for (int i = 0; i < size_; ++i) rates(i, j) += slope * part.response[i] * part.row[j];
  }
  factors_.compute(rates);
}

/// (I/(gamma h) - J) x = what x holds.
void ImplicitMethod::solve(const FastParts& fast, double inverse, State& x) const {
  double* v = x.data() + size_;
  for (std::size_t i = 0; i < x.size(); ++i)
    if (i < static_cast<std::size_t>(size_) || i >= 2 * static_cast<std::size_t>(size_))
      x[i] *= inverse;
  for (const FastPart& part : fast.parts) {
    if (part.stiffness == 0.0) continue;
    const double force = part.stiffness * dot(part.row, x.data(), size_);
    for (int i = 0; i < size_; ++i) v[i] -= force * part.response[i];
  }
  Eigen::Map<Vector> rates(v, size_);
  rates = factors_.solve(rates);
  for (int i = 0; i < size_; ++i) x[i] += inverse * v[i];
}

void ImplicitMethod::take(const RightHandSide& f, const FastParts& fast, const FastSlopes& slopes,
                          Step& step, State& error) {
  const Coefficients& k = coefficients();
  const double h = step.length, inverse = kGamma * h;
  size_ = fast.size;
  factorise(fast, inverse);

  rate_ = step.dydt;
  for (int i = 0; i < 4; ++i) {
    if (i > 0) {
      at_ = step.y;
      for (int j = 0; j < i; ++j) add(k.a(i, j), u_[j], at_);
      f(step.t + k.time[i] * h, at_, rate_);
    }
    u_[i] = rate_;
    for (int j = 0; j < i; ++j) add(k.c(i, j) / h, u_[j], u_[i]);
    solve(fast, inverse, u_[i]);
  }

  step.y_end = step.y;
  std::fill(error.begin(), error.end(), 0.0);
  for (int i = 0; i < 4; ++i) {
    add(k.m[i], u_[i], step.y_end);
    add(k.e[i], u_[i], error);
  }
  if (!f(step.t + h, step.y_end, step.dydt_end)) return;
  slopes(step.y_end, at_end_);
  if (!fast.last(at_end_, inverse)) return;
  for (double& x : error) x /= inverse;
  solve(fast, inverse, error);
  forget(fast, step.dydt_end.data() + size_, error.data() + size_);
}

/// By parts as they are at the step's end, with the responses of its start.
void ImplicitMethod::forget(const FastParts& fast, const double* accelerations, double* rates) {
  const auto rate_of = [&](int k) { return at_end_[k].damping * fast.parts[k].mobility(size_); };
  settling_.clear();
  for (int k = 0; k < count_of(fast.parts); ++k) {
    const FastPart& part = fast.parts[k];
    if (!(rate_of(k) > kGrantedRate)) continue;
    const double way = std::abs(dot(part.row, accelerations, size_)) / rate_of(k);
    if (part.width == 0.0 || way <= kRests * part.width) settling_.push_back(k);
  }
  // More than coordinates: no joint's friction comes so often; the error counts whole.
  const int n = count_of(settling_);
  if (n == 0 || n > kMaxSize) return;

  // Parts pull on one another through the bodies between them.
  SmallMatrix mobility(n, n);
  SmallVector speed(n);
  for (int i = 0; i < n; ++i) {
    const Row& row = fast.parts[settling_[i]].row;
    speed[i] = dot(row, rates, size_);
    for (int k = 0; k < n; ++k)
      mobility(i, k) = dot(row, fast.parts[settling_[k]].response.data(), size_);
  }
  const SmallVector impulse = mobility.completeOrthogonalDecomposition().solve(speed);
  for (int k = 0; k < n; ++k) {
    const double forgotten = (1.0 - kGrantedRate / rate_of(settling_[k])) * impulse[k];
    for (int i = 0; i < size_; ++i) rates[i] -= forgotten * fast.parts[settling_[k]].response[i];
  }
}

void ImplicitMethod::dense(const Step& step, double t, State& out) const {
  const double h = step.length, s = (t - step.t) / h, rest = 1.0 - s;
  const double to = s * s * (3.0 - 2.0 * s);
  for (std::size_t i = 0; i < step.y.size(); ++i) {
    const double way = step.y_end[i] - step.y[i], slope = h * step.dydt_end[i];
    out[i] = i < static_cast<std::size_t>(size_)
                 ? step.y[i] + to * way + s * rest * (rest * h * step.dydt[i] - s * slope)
                 : step.y_end[i] - rest * slope + rest * rest * (slope - way);
  }
}

}  // namespace jaculus::simulation::detail
