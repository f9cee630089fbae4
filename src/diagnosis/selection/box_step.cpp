#include "diagnosis/selection/box_step.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cassert>
#include <vector>

namespace jaculus::diagnosis {
namespace {

// Without fewer faults, as Kim and Park (2011) have it for non-negative least squares.
constexpr int kBlockTries = 3;
// Of the largest slope, that is no fault. Derivation: a factor of some hundred columns leaves 1e-14
// of it times the root of H's condition, up to 1e4.
constexpr double kRounding = 1e-10;

enum class Place { free, lower, upper };

struct Model {
  const Matrix& H;
  const Vector &g, &lower, &upper;

  [[nodiscard]] double bound(Eigen::Index i, Place place) const {
    return place == Place::lower ? lower[i] : upper[i];
  }

  /// The best values of the free ones, the others at their bounds.
  [[nodiscard]] Vector best(const std::vector<Place>& places) const {
    Vector d = Vector::Zero(g.size());
    std::vector<Eigen::Index> free;
    for (Eigen::Index i = 0; i < g.size(); ++i) {
      if (places[i] == Place::free)
        free.push_back(i);
      else
        d[i] = bound(i, places[i]);
    }
    const Vector slope = g + H * d;
    d(free) = -Matrix(H(free, free)).llt().solve(Vector(slope(free)));
    return d;
  }

  /// By how much the model falls when a held parameter moves inwards; none where it can't.
  [[nodiscard]] double falls_inwards(Eigen::Index i, Place place, const Vector& slope) const {
    if (lower[i] == upper[i] || place == Place::free) return 0.0;
    return place == Place::lower ? -slope[i] : slope[i];
  }
};

/// Exchanges all faults at once; whether none is left.
bool pivot_in_blocks(const Model& model, double rounding, std::vector<Place>& places, Vector& d) {
  const Eigen::Index n = model.g.size();
  Eigen::Index fewest = n + 1;
  for (int tries = kBlockTries; tries > 0;) {
    d = model.best(places);
    const Vector slope = model.g + model.H * d;
    Eigen::Index faults = 0;
    for (Eigen::Index i = 0; i < n; ++i) {
      const Place before = places[i];
      if (before != Place::free && model.falls_inwards(i, before, slope) > rounding)
        places[i] = Place::free;
      else if (before == Place::free && d[i] < model.lower[i])
        places[i] = Place::lower;
      else if (before == Place::free && d[i] > model.upper[i])
        places[i] = Place::upper;
      faults += places[i] != before;
    }
    if (faults == 0) return true;
    if (faults >= fewest) --tries;
    fewest = std::min(fewest, faults);
  }
  return false;
}

/// Moves d as far towards `target` as bounds let it, and holds what met its bound first.
bool reach(const Model& model, const Vector& target, std::vector<Place>& places, Vector& d) {
  double share = 1.0;
  Eigen::Index first = -1;
  for (Eigen::Index i = 0; i < d.size(); ++i) {
    const double move = target[i] - d[i];
    if (places[i] != Place::free || move == 0.0) continue;
    const double room = (move < 0.0 ? model.lower[i] : model.upper[i]) - d[i];
    if (room / move >= share) continue;
    share = room / move;
    first = i;
  }

  d += share * (target - d);
  if (first < 0) return true;
  places[first] = target[first] < d[first] ? Place::lower : Place::upper;
  d[first] = model.bound(first, places[first]);
  return false;
}

/// From d within bounds on.
void by_active_set(const Model& model, double rounding, std::vector<Place>& places, Vector& d) {
  const Eigen::Index most_freed =
      100 * d.size();  // never met, but rounding must not go on for ever
  for (Eigen::Index count = 0; count < most_freed; ++count) {
    while (!reach(model, model.best(places), places, d)) {
    }
    const Vector slope = model.g + model.H * d;
    double most = rounding;
    Eigen::Index freed = -1;
    for (Eigen::Index i = 0; i < d.size(); ++i) {
      const double falls = model.falls_inwards(i, places[i], slope);
      if (falls <= most) continue;
      most = falls;
      freed = i;
    }
    if (freed < 0) return;
    places[freed] = Place::free;
  }
}

}  // namespace

Bounds room_within(const Bounds& range, double u) {
  return {std::min(0.0, range.lower - u), std::max(0.0, range.upper - u)};
}

Vector box_step(const Matrix& H, const Vector& g, const Vector& lower, const Vector& upper) {
  assert((lower.array() <= 0.0).all() && (upper.array() >= 0.0).all());
  const Model model{H, g, lower, upper};
  const double rounding = kRounding * g.lpNorm<Eigen::Infinity>();
  std::vector<Place> places(g.size(), Place::free);
  Vector d;
  if (pivot_in_blocks(model, rounding, places, d)) return d;

  // From what the blocks left, within bounds, those that are at one held.
  d = d.cwiseMax(lower).cwiseMin(upper);
  for (Eigen::Index i = 0; i < d.size(); ++i) {
    places[i] = Place::free;
    if (d[i] >= upper[i]) places[i] = Place::upper;
    if (d[i] <= lower[i]) places[i] = Place::lower;
  }
  by_active_set(model, rounding, places, d);
  return d;
}

}  // namespace jaculus::diagnosis
