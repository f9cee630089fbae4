#include "diagnosis/selection/minimise.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "diagnosis/noise/random_weights.h"
#include "diagnosis/selection/box_step.h"

namespace jaculus::diagnosis {
namespace {

// Of a method, not of a diagnosis: they say how a fit gets to its end, not where that is. All are
// shares, without a unit.
//
// Nocedal and Wright (2006, algorithm 4.1): of the promised fall, from which a step is taken, below
// which less is trusted and from which more is; times a good step that is trusted then.
constexpr double kWorthIt = 1e-3, kPoor = 0.25, kGood = 0.75, kWider = 2.0;
// Dennis and Schnabel (1983, A6.3.1): of a step that failed, where a parabola says to try next.
constexpr double kLeastShare = 0.1, kMostShare = 0.5;
// MINPACK: failures one after the other until slopes are doubted.
constexpr int kFailures = 2;
// Slopes that foretell a fall within this share of it are good enough to go on by a secant: what a
// step that is trusted more has at least.
constexpr double kForetold = 1.0 - kGood;
// Of what is trusted; what is closer is at its end, but for rounding. Chosen.
constexpr double kWithin = 0.99;

/// Rows that a misfit weighs alike: spans of first and count.
using Part = std::vector<std::pair<int, int>>;

/// W = M J of a residual's slopes on the way, and W^T W of every part of the rows. Where slopes
/// follow secants, J + d s^T with s zero but for those that follow, so do both: W + w s^T with
/// w = M d, and with v = W^T w of a part
///   W^T W + v s^T + s v^T + w^T w s s^T.
/// W itself stays as it was, W_0, with the w s^T beside it,
///   W^T x = W_0^T x + sum s (w^T x),
/// so that a secant is one pass over W_0, which is larger than what a processor keeps at hand.
/// Misfits that follow change the parts' shares in H alone.
class WeighedSlopes {
 public:
  WeighedSlopes(const RandomWeights& weights, std::vector<Part> parts)
      : weights_(weights), parts_(std::move(parts)), grams_(parts_.size()) {}

  /// `told`: whether the effects' slopes, which come first, were told anew.
  void follow(Residual& residual, bool told) {
    const Eigen::Index before = residual.first_followed();
    const std::vector<Residual::Secant>& secants = residual.secants();
    if (W_.size() == 0 || renewed_ != residual.times_renewed()) {
      W_ = weights_.stacked(residual.told());
      added_.clear();
      for (std::size_t k = 0; k < parts_.size(); ++k) grams_[k] = gram_of(parts_[k]);
    } else {
      for (; followed_ < secants.size(); ++followed_) add(secants[followed_]);
      if (before > 0 && told) renew(residual.told_before());
    }
    renewed_ = residual.times_renewed();
    followed_ = secants.size();
  }

  /// W^T W and W^T x, a share of each part's rows.
  [[nodiscard]] Matrix gram(const Vector& shares) const {
    Matrix sum = Matrix::Zero(W_.cols(), W_.cols());
    for (std::size_t k = 0; k < parts_.size(); ++k)
      sum += shares[static_cast<Eigen::Index>(k)] * grams_[k];
    return sum;
  }
  [[nodiscard]] Vector along(const Vector& shares, const Vector& x) const {
    Vector sum = Vector::Zero(W_.cols());
    for (std::size_t k = 0; k < parts_.size(); ++k)
      sum += shares[static_cast<Eigen::Index>(k)] * along_part(parts_[k], x);
    return sum;
  }

 private:
  /// A secant as W has it; `along` of all columns.
  struct Added {
    Vector w, along;
  };

  [[nodiscard]] Matrix gram_of(const Part& part) const {
    Matrix gram = Matrix::Zero(W_.cols(), W_.cols());
    for (const auto& [first, count] : part)
      gram.selfadjointView<Eigen::Lower>().rankUpdate(W_.middleRows(first, count).transpose());
    gram.triangularView<Eigen::StrictlyUpper>() = gram.transpose();
    return gram;
  }

  /// W^T X by the rows of a part.
  template <class Columns>
  [[nodiscard]] Matrix along_part(const Part& part, const Columns& X) const {
    Matrix sum = Matrix::Zero(W_.cols(), X.cols());
    for (const auto& [first, count] : part) {
      const auto own = X.middleRows(first, count);
      sum.noalias() += W_.middleRows(first, count).transpose() * own;
      for (const Added& added : added_)
        sum.noalias() += added.along * (added.w.segment(first, count).transpose() * own);
    }
    return sum;
  }

  /// The first columns by new slopes.
  void renew(ConstMatrixRef J) {
    const Eigen::Index before = J.cols();
    const Matrix first = weights_.stacked(J);
    W_.leftCols(before) = first;
    for (Added& added : added_) added.along.head(before).setZero();
    for (std::size_t k = 0; k < parts_.size(); ++k) {
      grams_[k].leftCols(before) = along_part(parts_[k], first);
      grams_[k].topRows(before) = grams_[k].leftCols(before).transpose();
    }
  }

  void add(const Residual::Secant& secant) {
    const Vector w = weights_.stacked(secant.missed);
    Vector s = Vector::Zero(W_.cols());
    s.head(secant.along.size()) = secant.along;
    for (std::size_t k = 0; k < parts_.size(); ++k) {
      const Vector v = along_part(parts_[k], w);
      double square = 0.0;
      for (const auto& [first, count] : parts_[k]) square += w.segment(first, count).squaredNorm();
      grams_[k] += v * s.transpose() + s * v.transpose() + square * (s * s.transpose());
    }
    added_.push_back({w, std::move(s)});
  }

  const RandomWeights& weights_;
  std::vector<Part> parts_;
  std::vector<Matrix> grams_;  ///< a part each
  Matrix W_;                   ///< W_0, but for the columns that are made anew
  std::vector<Added> added_;
  int renewed_ = 0;
  std::size_t followed_ = 0;
};

/// Rows of the misfits that follow, then the other rows of M J.
std::vector<Part> parts_of(const RandomEffects& random, bool follow, const RandomWeights& weights,
                           Eigen::Index rows) {
  const auto all = static_cast<int>(rows + weights.more_rows());
  if (!follow) return {{{0, all}}};
  std::vector<Part> parts;
  for (const Misfit& misfit : random.misfits) parts.push_back(misfit.spans);
  parts.emplace_back();
  for (const RandomBlock& block : random.blocks)
    parts.back().emplace_back(block.first, block.count);
  parts.back().insert(parts.back().end(), random.plain.begin(), random.plain.end());
  if (weights.more_rows() > 0) parts.back().emplace_back(rows, all - static_cast<int>(rows));
  return parts;
}

/// The cost about a residual, and its quadratic model.
class Cost {
 public:
  Cost(Residual& residual, const RandomEffects& random, const Vector& scales, Misfits misfits)
      : residual_(residual),
        random_(random),
        scales_(scales),
        follow_(misfits == Misfits::follow && !random.misfits.empty()),
        weights_(random, follow_ ? without_misfits(random, scales) : scales) {}

  /// Infinite where the simulation fails.
  double at(const Vector& u) {
    if (!residual_.value(u, r_)) return kInfinity;
    own_ = follow_ ? misfits_of(random_, r_, scales_) : scales_;
    root_ = weights_.stacked(r_);
    const double log_det = follow_ ? misfits_log_det(random_, own_) : 0.0;
    return 0.5 * (weighed_square(root_) + u.squaredNorm() + log_det);
  }

  /// Of the residual.
  [[nodiscard]] Eigen::Index rows() const { return r_.size(); }

  /// g and H at the point of the last `at`, by slopes that are told there or moved there by a
  /// secant. False where a simulation fails.
  bool model(const Vector& u, bool told, Vector& g, Matrix& H) {
    if (!(told ? residual_.tell(u) : residual_.follow(u))) return false;
    if (!slopes_) slopes_.emplace(weights_, parts_of(random_, follow_, weights_, r_.size()));
    slopes_->follow(residual_, residual_.effects_told_at(u));
    const Vector shares = shares_now();
    H = slopes_->gram(shares);
    H.diagonal().array() += 1.0;
    g = slopes_->along(shares, root_) + u;
    return true;
  }

 private:
  /// |x|^2 of rows of M r, each part's by the root of its variance.
  [[nodiscard]] double weighed_square(Vector x) const {
    if (!follow_) return x.squaredNorm();
    for (const Misfit& own : random_.misfits)
      for (const auto& [first, count] : own.spans)
        x.segment(first, count) *= 1.0 / std::sqrt(own.variance(own_[own.group]));
    return x.squaredNorm();
  }

  /// Of each part of the rows, what its misfit leaves of their weight.
  [[nodiscard]] Vector shares_now() const {
    if (!follow_) return Vector::Ones(1);
    Vector shares = Vector::Ones(count_of(random_.misfits) + 1);
    for (int c = 0; c < count_of(random_.misfits); ++c) {
      const Misfit& own = random_.misfits[c];
      shares[c] = 1.0 / own.variance(own_[own.group]);
    }
    return shares;
  }

  Residual& residual_;
  const RandomEffects& random_;
  const Vector& scales_;
  bool follow_;
  RandomWeights weights_;  ///< without misfits where these follow
  std::optional<WeighedSlopes> slopes_;
  Vector r_, root_, own_;  ///< of the last `at`: residual, M r, scales
};

/// The bounds of a step from u: a box of the parameters' ranges and of what is trusted, |d_i| times
/// the root of H_ii, by how much a parameter alone moves the weighed residual. What moves it in
/// proportion is trusted without end.
struct Box {
  Vector lower, upper;
};

Box box_about(const Residual& residual, const Vector& u, const Vector& sizes, double trusted) {
  Box box{Vector(u.size()), Vector(u.size())};
  for (Eigen::Index i = 0; i < u.size(); ++i) {
    const Bounds room = room_within(residual.range(i), u[i]);
    const double far = i < residual.first_linear() ? trusted / sizes[i] : kInfinity;
    box.lower[i] = std::max(room.lower, -far);
    box.upper[i] = std::min(room.upper, far);
  }
  return box;
}

/// The share of a step at which a parabola through the cost at its start, with its slope there, and
/// at its end is least.
double share_by_parabola(double slope, double rise) {
  if (!std::isfinite(rise)) return kLeastShare;
  return std::clamp(-0.5 * slope / (rise - slope), kLeastShare, kMostShare);
}

}  // namespace

double cost_of(const RandomEffects& random, const Vector& scales, Misfits misfits, const Vector& r,
               const Vector& u) {
  const bool follow = misfits == Misfits::follow;
  const Vector own = follow ? misfits_of(random, r, scales) : scales;
  const RandomWeights weights(random, own);
  const double log_det = follow ? misfits_log_det(random, own) : 0.0;
  return 0.5 * (weights.stacked(r).squaredNorm() + u.squaredNorm() + log_det);
}

std::optional<Minimised> minimise(Residual& residual, const RandomEffects& random,
                                  const Vector& scales, Misfits misfits, const Ending& ending,
                                  Vector& u) {
  const Settings& settings = residual.settings();
  for (Eigen::Index i = 0; i < u.size(); ++i)
    u[i] = std::clamp(u[i], residual.range(i).lower, residual.range(i).upper);

  Cost cost(residual, random, scales, misfits);
  double now = cost.at(u);
  const double first = now;
  Vector g;
  Matrix H;
  if (!std::isfinite(first) || !cost.model(u, true, g, H)) return {};
  // Noise alone leaves half a nat a row; where much more is left, no more of it counts.
  const double least_fall =
      settings.fit_cost_tolerance * std::min(std::abs(now), static_cast<double>(cost.rows()));
  const Vector sizes = H.diagonal().cwiseSqrt();
  double trusted = kInfinity;
  int failed = 0;  // one after the other
  // Where effects' slopes were told last: without them a fit is none.
  Vector told_point = u;
  double told_cost = now;
  for (int step = 0; step < ending.iterations; ++step) {
    const Box box = box_about(residual, u, sizes, trusted);
    const Vector d = box_step(H, g, box.lower, box.upper);
    const double slope = g.dot(d), promised = -slope - 0.5 * d.dot(H * d);
    const double size =
        d.cwiseProduct(sizes).head(residual.first_linear()).lpNorm<Eigen::Infinity>();
    const bool still = d.norm() <= settings.fit_parameter_tolerance * (1.0 + u.norm());
    const bool free = size < kWithin * trusted;  // of what is trusted
    const bool ends =
        still || promised <= (free ? std::max(least_fall, ending.least_fall) : least_fall);
    const bool told_here = residual.effects_told_at(u);
    if (ends && told_here) return Minimised{first - now, free || residual.told_at(u)};

    const double next = ends ? kInfinity : cost.at(u + d);
    const double kept = ends ? -kInfinity : (now - next) / promised;
    const bool foretold = std::abs(kept - 1.0) < kForetold;
    if (!(kept > kWorthIt && cost.model(u + d, !foretold, g, H))) {
      // Slopes of effects that were followed are told before anything is made of them, in a turn
      // that is no step.
      if (!told_here) {
        if (!std::isfinite(cost.at(u)) || !cost.model(u, true, g, H)) {
          u = told_point;
          return Minimised{first - told_cost, false};
        }
        told_point = u;
        told_cost = now;
        --step;
        continue;
      }
      ++failed;
      const bool told = residual.told_at(u);
      // Nothing could be trusted less, or it is no use to: by slopes from elsewhere, or for little.
      const bool useless = failed >= kFailures && (!told || promised < settings.scales_settled);
      if (size == 0.0 || useless) return Minimised{first - now, told};
      trusted = share_by_parabola(slope, next - now) * size;
      continue;
    }
    failed = 0;
    u += d;
    now = next;
    if (!foretold) {
      told_point = u;
      told_cost = now;
    }
    if (kept < kPoor) trusted = kMostShare * size;
    if (kept > kGood) trusted = std::max(trusted, kWider * size);
  }
  return Minimised{first - now, false};
}

}  // namespace jaculus::diagnosis
