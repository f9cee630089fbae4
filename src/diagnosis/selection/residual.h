#pragma once
// The white residual of a fit as a function of its free parameters, and its slopes.
//
//   r(u) = T (y - A m - f(p)) (noise/whitening.h),  u = (p - nominal)/scale of the free parameters
// A slope by differences is a simulation of everything. Effects have a few parameters, but every
// model also fits nuisances, unknown gains and a robot's some eighty tolerances; so on the way the
// nuisances' slopes N follow by secants,
//   N += (dr - E du_e - N dn) dn^T/|dn|^2,
// E the mean of the effects' slopes at both ends (Broyden 1965). A step on the way may follow by a
// secant altogether, effects too,
//   J += (dr - J du) du^T/|du|^2,
// until they are told by differences again. Where nuisances are renewed it is
// those of the gains and of what is strong in the tolerances: what changes a slope by a tenth
// (settings.slope_changed) moves the others' rows by less than noise. Many tolerances do the same
// to a motion, so that where fifty to eighty are strong each by itself some thirty to fifty
// directions are (strong_directions.h): with their slopes T, V those directions and D the
// differences along them,
//   T += (D - T V) V^T.
// While models are sought, tolerances go by their slopes at one
// point,
//   r(u) = r(u_e, u_g, t_0) + N_t (t - t_0),
// t of u the tolerances: effects and gains u_g are a few parameters again. Beside a model that is
// fitted already the effects' slopes are known as well, those of what is added from screening: then
// E follows by the same secants until it is renewed.

#include <optional>

#include "diagnosis/noise/whitening.h"

namespace jaculus::diagnosis {

/// Nuisances by their slopes at one point: what tolerances go by, and gains set out with.
struct LinearNuisances {
  Vector p;              ///< all parameters, there
  Matrix slopes{};       ///< white rows x (unknown gains, then tolerances)
  RowSlopes rows{};      ///< the same before whitening; under a plan
  long predictions = 0;  ///< that it took
};

/// Counts its simulations. `problem` and `whitening` have to outlive it.
class Residual {
 public:
  /// `fixed`: all parameters, the free ones of no account. `known`: slopes of the nuisances among
  /// the free ones to set out with, white rows x nuisances; else they are differenced at the
  /// start. `effects`: the same of the effects, white rows x their parameters, which then follow by
  /// secants too; else they are differenced.
  Residual(const Problem& problem, const Whitening& whitening, std::vector<int> free, Vector fixed,
           const Matrix& known = {}, const Matrix& effects = {});
  /// The same with tolerances by their slopes. `linear` has to outlive it.
  Residual(const Problem& problem, const Whitening& whitening, std::vector<int> free, Vector fixed,
           const LinearNuisances& linear, const Matrix& effects = {});

  /// Lets the effects' slopes follow by secants too, from where they are differenced first.
  void follow_effects() {
    add_secants();
    first_followed_ = 0;
    secants_.clear();  // of fewer parameters; the slopes have them already
    added_ = 0;
  }

  /// By what the slopes were moved: J += missed along^T, the first columns of it.
  struct Secant {
    Vector missed;            ///< white rows
    Vector along;             ///< du/|du|^2, zero for effects that were told there
    bool by_effects = false;  ///< whether it was made of their moves too
  };
  /// Since they were renewed last.
  [[nodiscard]] const std::vector<Secant>& secants() const { return secants_; }
  /// Whether slopes at u were told there, but for what is weak in those of tolerances.
  [[nodiscard]] bool told_at(const Vector& u) const {
    return effects_told_at(u) && (followed() == 0 || (new_ && stand_at(u)));
  }
  /// Whether those of effects were, where these don't follow.
  [[nodiscard]] bool effects_told_at(const Vector& u) const {
    return first_followed_ == 0 || (effects_told_ && stand_at(u));
  }
  /// How often they were.
  [[nodiscard]] int times_renewed() const { return times_renewed_; }
  /// Place of the first free parameter whose slopes follow by secants: the first nuisance's, or the
  /// first of all.
  [[nodiscard]] Eigen::Index first_followed() const { return first_followed_; }
  /// How many do, from there on: all, or but tolerances where these go by their slopes.
  [[nodiscard]] Eigen::Index followed() const {
    return (linear_ == nullptr ? size() : tolerances_) - first_followed_;
  }

  /// Place of the first that moves the residual in proportion: the first tolerance where these go
  /// by their slopes, else past the last.
  [[nodiscard]] Eigen::Index first_linear() const {
    return linear_ == nullptr ? size() : tolerances_;
  }

  /// Of one free parameter.
  [[nodiscard]] Bounds range(Eigen::Index i) const;
  [[nodiscard]] Vector full(const Vector& u) const {
    return problem_.hypotheses.unscaled(free_, u, fixed_);
  }
  /// What is simulated for u: full(u), or tolerances where their slopes are.
  [[nodiscard]] Vector simulated(const Vector& u) const;
  [[nodiscard]] Vector reduced(const Vector& p) const {
    return problem_.hypotheses.scaled(free_, p);
  }

  /// Keeps slopes of rows from here on; the nuisances' may be known already.
  void keep_rows(const RowSlopes& nuisances = {});
  /// Those of the nuisances as they were differenced last; none where one is not known.
  [[nodiscard]] RowSlopes nuisance_rows() const;

  /// False where the simulation fails. What was asked for last is kept: a minimiser and the rounds
  /// about it ask for the same point again.
  bool value(const Vector& u, Vector& r);
  /// Tells slopes at the point of the last `value`: those before first_followed() by differences,
  /// one more of secants(). False where a simulation fails.
  bool tell(const Vector& u);
  /// Moves slopes to that point by a secant, those of effects too; tells them where none are known.
  bool follow(const Vector& u);
  /// dr/du as told last, what follows by secants so; and of what comes before first_followed().
  [[nodiscard]] const Matrix& told() {
    add_secants();
    return slopes_;
  }
  [[nodiscard]] auto told_before() const { return slopes_.leftCols(first_followed_); }
  /// dr/du at the point of the last `value`, what follows by secants so. Null where a simulation
  /// fails; else valid until slopes are asked for again.
  const Matrix* slopes(const Vector& u);
  /// The same with those of effects, gains and what is strong in tolerances by differences; the
  /// others less what secants by effects' moves made of them.
  const Matrix* renewed_slopes(const Vector& u);

  [[nodiscard]] const Settings& settings() const { return problem_.settings; }
  [[nodiscard]] long predictions() const { return predictions_; }
  [[nodiscard]] const std::string& message() const { return message_; }
  [[nodiscard]] const std::vector<Vector>& predicted() const { return rows_; }
  [[nodiscard]] Eigen::Index size() const { return count_of(free_); }

 private:
  [[nodiscard]] std::optional<Matrix> differenced(const Vector& u,
                                                  const std::vector<Eigen::Index>& columns);
  /// Differences of some tolerances along directions, and of their rows.
  struct Turned {
    Matrix along;  ///< the directions, columns x directions
    Matrix white;  ///< a direction each
    std::vector<std::vector<Vector>> rows;
  };
  [[nodiscard]] std::optional<Turned> turned(const Vector& u, const Matrix& slopes,
                                             const std::vector<Eigen::Index>& columns,
                                             double least);
  [[nodiscard]] Matrix unbent(Eigen::Index end) const;
  [[nodiscard]] bool stand_at(const Vector& u) const {
    return slopes_at_.size() == u.size() && slopes_at_ == u;
  }
  void add_secant(const Vector& u, const Matrix* effects);
  void add_secants();
  void add_to_effects();
  [[nodiscard]] Vector expected_over(const Vector& du) const;
  void keep(const Vector& u, bool effects, bool all);

  const Problem& problem_;
  const Whitening& whitening_;
  std::vector<int> free_;
  Eigen::Index nuisances_ = 0;               ///< place of the first: gains, then tolerances
  Eigen::Index tolerances_ = 0;              ///< place of the first of them, which come last
  Eigen::Index first_followed_ = 0;          ///< place of the first that follows by secants
  const LinearNuisances* linear_ = nullptr;  ///< null: tolerances are simulated
  Vector fixed_, steps_;
  std::vector<Vector> rows_;  ///< predicted at `simulated_`
  Vector simulated_;          ///< all parameters
  Vector at_, residual_;      ///< of the last `value`
  Vector slopes_at_, slopes_residual_;
  RowSlopes row_slopes_;  ///< of every free parameter, as differenced last; empty: not kept
  Matrix slopes_;         ///< there, with the first `added_` secants; empty: not known anywhere
  bool effects_told_ = false;  ///< whether those of effects were differenced there
  bool new_ = false;           ///< whether all but weak ones of tolerances were
  std::vector<Secant> secants_;
  std::size_t added_ = 0;  ///< of them, to `slopes_`
  int times_renewed_ = 0;
  long predictions_ = 0;
  std::string message_;
};

/// At p. `near`: the same of rows at a point nearby, of which what is strong is told anew; empty:
/// all is told. No columns where there are none, or where a simulation fails.
LinearNuisances linear_nuisances(const Problem& problem, const Whitening& whitening, Vector p,
                                 const RowSlopes& near = {});

}  // namespace jaculus::diagnosis
