#pragma once
// What effects would do to the data of an experiment that nobody has done yet.
//
// The experiment is simulated as stated, sensors and their noise included, and becomes the problem,
// the noise model and the whitening by which a diagnosis would judge the real data: clocks, start
// offsets and forces that the plant may lack are counted at their price. Tolerances of the robot
// and unknown gains, with white slopes N, are marginalised by one more linear map,
//   M^-1/2 = I - U diag(1 - 1/sqrt(1 + s^2)) U^T,   N = U diag(s) V^T,
// so that data of a robot within its tolerances are independent standard normal numbers again. A
// signature is what an effect adds to these,
//   g(u) = M^-1/2 T (f(p(u)) - f(p0)),   u = (p - nominal)/scale.
// Valid near the nominal robot: T and N are those about it.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "diagnosis/forward/problem.h"
#include "diagnosis/noise/whitening.h"
#include "jaculus/diagnosis/options.h"
#include "jaculus/simulation/experiment.h"

namespace jaculus::diagnosis {

/// The misfit that a diagnosis grants every model under a plan in a coordinate
/// (noise/random_effects.h): n of its N rows.
/// Of a model that misses L = |g_A - g_B|^2 there, on data of the mean energy L + N, at the most
/// likely variance v = 1 + m, max(1 + L/n, that of the least misfit v_0),
///   -2 log density = c(L) + what all models share,
///   c = (L + n)/v + n log v - (n/v_0 + n log v_0),
/// so that differences count by n values and not by rows. n = 0: c(L) = L.
struct MisfitShape {
  Misfit of{};         ///< n, N and its rows
  double least = 0.0;  ///< least misfit [noise floors]

  [[nodiscard]] double variance(double missed) const;
  [[nodiscard]] double cost(double missed) const;
};

/// Those of all coordinates; rows of none hold noise alone.
struct MisfitShapes {
  std::vector<MisfitShape> own;

  /// Sum of c, rows of none as they are.
  [[nodiscard]] double cost(const Vector& r) const;
  /// v of every row.
  [[nodiscard]] Vector variances(const Vector& r) const;
};

struct SignatureSpace {
  std::shared_ptr<const Problem> problem;
  Whitening whitening;
  std::vector<Vector> rows;  ///< predicted for the nominal robot, a dataset each [unit]
  Shrinkage tolerances;      ///< of white rows
  RandomEffects random;      ///< on rows without tolerances, one block; no groups: not asked for
  MisfitShapes misfits;
  std::vector<int> channel;  ///< of every row of the datasets, counted through all
  int channels = 0;
};

/// A space, or why there is none.
struct PlannedSpace {
  std::optional<SignatureSpace> space;
  std::vector<std::string> reasons;  ///< why the data could not answer; empty where they could
  std::vector<std::string> notes;    ///< what would be left out
};

/// Whether forces that the plant may lack are granted; each takes simulations of its own.
enum class MissingForces { granted, left_out };

/// The space of several experiments that are diagnosed together, over options.effects.
PlannedSpace space_of(const std::vector<simulation::Experiment>& experiments,
                      const DiagnoseOptions& options, MissingForces forces);

/// The same of datasets that are there.
PlannedSpace space_of_data(const std::vector<trajectory::Dataset>& datasets,
                           const DiagnoseOptions& options, MissingForces forces);

/// Raw rows at p less those of the nominal robot, a dataset each; nothing where the plant is lost.
std::optional<std::vector<Vector>> change_of_rows(const SignatureSpace& space, const Vector& p);
/// g of such a change.
Vector signature_of(const SignatureSpace& space, const std::vector<Vector>& change);

struct CurvePoint {
  double share = 0.0;  ///< of the departure, signed
  Vector u;            ///< of the free parameters
  Vector signature;    ///< g
  Matrix slopes;       ///< dg/du, rows x free
};

/// Signatures of a set of effects along its departure from nominal, both ways where bounds allow
/// it.
struct SignatureCurve {
  std::vector<int> free;           ///< indices of the effects' parameters
  std::vector<Bounds> bounds;      ///< of u
  std::vector<CurvePoint> points;  ///< empty: no point could be simulated
  Matrix plain;                    ///< T df/du at the least share, tolerances not marginalised
  MisfitShapes misfits{};          ///< of the space

  /// The point at the departure itself; null where it could not be simulated.
  [[nodiscard]] const CurvePoint* stated() const;
};

/// The point of some free parameters at p, with T df/du into `plain` where that is given; nothing
/// where the plant is lost.
std::optional<CurvePoint> curve_point(const SignatureSpace& space, const std::vector<int>& free,
                                      const Vector& p, Matrix* plain = nullptr);

/// Of some candidates at p(share) = nominal + share (p - nominal). Without candidates: one point
/// that changes nothing.
SignatureCurve signature_curve(const SignatureSpace& space, const std::vector<int>& candidates,
                               const Vector& p, const std::vector<double>& shares);

/// p of one candidate: its first parameter at `size` probing steps from nominal, cut at the bounds.
/// A probing step is a prior scale unless the effect states another.
Vector stated_departure(const Problem& problem, int candidate, double size);

}  // namespace jaculus::diagnosis
