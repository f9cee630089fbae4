#include "diagnosis/selection/minimise.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/noise/random_weights.h"
#include "diagnosis/selection/box_step.h"
#include "diagnosis/selection/weighed_slopes.h"

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

/// Rows of the misfits that follow, then the other rows of M J.
std::vector<WeighedSlopes::Part> parts_of(const RandomEffects& random, bool follow,
                                          const RandomWeights& weights, Eigen::Index rows) {
  const auto all = static_cast<int>(rows + weights.more_rows());
  if (!follow) return {{{0, all}}};
  std::vector<WeighedSlopes::Part> parts;
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

/// A step to where the quadratic model is least within a box.
struct Step {
  Vector d;
  double slope = 0.0;     ///< g^T d
  double promised = 0.0;  ///< by how much the model's cost falls
  double size = 0.0;      ///< largest |d_i| sqrt(H_ii) of what trust limits
  bool free = false;      ///< whether no limit of trust holds it
  bool last = false;      ///< whether it promises too little to be taken
};

/// The minimisation: where it stands, by which slopes, and what is trusted.
class Descent {
 public:
  Descent(Residual& residual, const RandomEffects& random, const Vector& scales, Misfits misfits,
          const Ending& ending)
      : residual_(residual), cost_(residual, random, scales, misfits), ending_(ending) {}

  /// From u on, which is left at the best point met.
  std::optional<Minimised> from(Vector& u) {
    if (!begin(u)) return {};
    for (int steps = 0; steps < ending_.iterations; ++steps) {
      // Slopes of effects that were followed are told before anything is made of them, in a turn
      // that is no step.
      Step step = step_from(u);
      bool taken = !step.last && take(step, u);
      if (!taken && !residual_.effects_told_at(u)) {
        if (!tell(u)) return go_back(u);
        step = step_from(u);
        taken = !step.last && take(step, u);
      }
      if (taken) continue;

      const bool told = residual_.told_at(u);
      if (step.last) return ended(step.free || told);
      if (!trust_less(step, told)) return ended(told);
    }
    return ended(false);
  }

 private:
  /// False where nothing can be evaluated.
  bool begin(Vector& u) {
    for (Eigen::Index i = 0; i < u.size(); ++i)
      u[i] = std::clamp(u[i], residual_.range(i).lower, residual_.range(i).upper);
    first_ = now_ = cost_.at(u);
    if (!std::isfinite(now_) || !cost_.model(u, true, g_, H_)) return false;
    // Noise alone leaves half a nat a row; where much more is left, no more of it counts.
    least_fall_ =
        settings().fit_cost_tolerance * std::min(std::abs(now_), static_cast<double>(cost_.rows()));
    sizes_ = H_.diagonal().cwiseSqrt();
    keep_told(u);
    return true;
  }

  [[nodiscard]] Step step_from(const Vector& u) const {
    const Box box = box_about(residual_, u, sizes_, trusted_);
    Step step{box_step(H_, g_, box.lower, box.upper)};
    step.slope = g_.dot(step.d);
    step.promised = -step.slope - 0.5 * step.d.dot(H_ * step.d);
    step.size =
        step.d.cwiseProduct(sizes_).head(residual_.first_linear()).lpNorm<Eigen::Infinity>();
    step.free = step.size < kWithin * trusted_;
    const bool still = step.d.norm() <= settings().fit_parameter_tolerance * (1.0 + u.norm());
    const double least = step.free ? std::max(least_fall_, ending_.least_fall) : least_fall_;
    step.last = still || step.promised <= least;
    return step;
  }

  /// Whether the cost falls by a part of what was promised; slopes then follow by a secant where
  /// they foretold it well, else they are told there.
  bool take(const Step& step, Vector& u) {
    tried_ = cost_.at(u + step.d);
    const double kept = (now_ - tried_) / step.promised;
    const bool foretold = std::abs(kept - 1.0) < kForetold;
    if (!(kept > kWorthIt && cost_.model(u + step.d, !foretold, g_, H_))) return false;
    failed_ = 0;
    u += step.d;
    now_ = tried_;
    if (!foretold) keep_told(u);
    if (kept < kPoor) trusted_ = kMostShare * step.size;
    if (kept > kGood) trusted_ = std::max(trusted_, kWider * step.size);
    return true;
  }

  /// Tells the effects' slopes; false where a simulation fails.
  bool tell(const Vector& u) {
    if (!std::isfinite(cost_.at(u)) || !cost_.model(u, true, g_, H_)) return false;
    keep_told(u);
    return true;
  }

  /// After a step that failed; false where nothing could be trusted less, or it is no use to: by
  /// slopes from elsewhere, or for little.
  bool trust_less(const Step& step, bool told) {
    ++failed_;
    const bool useless =
        failed_ >= kFailures && (!told || step.promised < settings().scales_settled);
    if (step.size == 0.0 || useless) return false;
    trusted_ = share_by_parabola(step.slope, tried_ - now_) * step.size;
    return true;
  }

  void keep_told(const Vector& u) {
    told_point_ = u;
    told_cost_ = now_;
  }

  /// To where slopes of effects were told last: without them a fit is none.
  Minimised go_back(Vector& u) {
    u = told_point_;
    now_ = told_cost_;
    return ended(false);
  }

  [[nodiscard]] Minimised ended(bool settled) const { return {first_ - now_, settled}; }
  [[nodiscard]] const Settings& settings() const { return residual_.settings(); }

  Residual& residual_;
  Cost cost_;
  Ending ending_;
  Vector g_, sizes_;  ///< gradient; roots of H's diagonal where it began
  Matrix H_;
  double first_ = 0.0, now_ = 0.0, tried_ = 0.0;  ///< costs: where it began, stands, last tried
  double least_fall_ = 0.0;                       ///< of a step that is worth taking
  double trusted_ = kInfinity;
  int failed_ = 0;     ///< steps, one after the other
  Vector told_point_;  ///< where slopes of effects were told last
  double told_cost_ = 0.0;
};

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
  Descent descent(residual, random, scales, misfits, ending);
  return descent.from(u);
}

}  // namespace jaculus::diagnosis
