#include "diagnosis/preflight/signatures.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/build_problem.h"
#include "diagnosis/forward/sensitivities.h"
#include "diagnosis/preflight/simulated_data.h"

namespace jaculus::diagnosis {
namespace {

/// Random effects as one block of all rows, tolerances taken off.
RandomEffects without_tolerances(const RandomEffects& random, const Shrinkage& tolerances,
                                 int rows) {
  RandomEffects out;
  out.groups = random.groups;
  out.misfits = random.misfits;
  out.plain = random.plain;
  Eigen::Index columns = 0;
  for (const RandomBlock& block : random.blocks) columns += block.columns.cols();
  if (columns == 0) return out;

  RandomBlock all{0, rows, Matrix::Zero(rows, columns), {}, {}};
  Eigen::Index next = 0;
  for (const RandomBlock& block : random.blocks) {
    all.columns.block(block.first, next, block.count, block.columns.cols()) = block.columns;
    all.group.insert(all.group.end(), block.group.begin(), block.group.end());
    next += block.columns.cols();
  }
  tolerances.apply(all.columns);
  all.gram = all.columns.transpose() * all.columns;
  out.blocks.push_back(std::move(all));
  return out;
}

/// The channel of every white row.
void number_channels(SignatureSpace& space) {
  for (std::size_t d = 0; d < space.whitening.datasets.size(); ++d) {
    for (const RowSpan& span : space.whitening.datasets[d].spans)
      space.channel.insert(space.channel.end(), span.count, space.channels + span.channel);
    space.channels += count_of(space.problem->observations.datasets[d].channels);
  }
}

/// Slopes of rows at p, a prior scale each, as raw rows a dataset each; nothing where a simulation
/// fails. `sensitivity`: norm of the white change by a prior scale, which tells the step.
std::optional<std::vector<std::vector<Vector>>> raw_slopes(const SignatureSpace& space,
                                                           const Vector& p,
                                                           const std::vector<Vector>& rows_at_p,
                                                           const std::vector<int>& free,
                                                           double sensitivity) {
  std::vector<std::vector<Vector>> slopes;
  for (const int i : free) {
    const double scale = space.problem->hypotheses.parameters[i].scale;
    const double step = scale * difference_step(sensitivity, space.problem->settings);
    auto moved = difference(*space.problem, space.whitening.alignments, p, rows_at_p, i, step);
    if (!moved) return {};
    for (Vector& rows : moved->rows) rows *= scale / moved->step;
    slopes.push_back(std::move(moved->rows));
  }
  return slopes;
}

}  // namespace

double MisfitShape::variance(double missed) const {
  if (of.values <= 0.0) return 1.0;
  return std::max(of.variance(least), 1.0 + missed / of.values);
}

double MisfitShape::cost(double missed) const {
  const double n = of.values;
  if (n <= 0.0) return missed;
  const auto own = [n](double energy, double v) { return (energy + n) / v + n * std::log(v); };
  return own(missed, variance(missed)) - own(0.0, variance(0.0));
}

double MisfitShapes::cost(const Vector& r) const {
  double sum = r.squaredNorm();
  for (const MisfitShape& misfit : own) {
    const double missed = misfit.of.energy(r);
    sum += misfit.cost(missed) - missed;
  }
  return sum;
}

Vector MisfitShapes::variances(const Vector& r) const {
  Vector out = Vector::Ones(r.size());
  for (const MisfitShape& misfit : own) {
    const double variance = misfit.variance(misfit.of.energy(r));
    for (const auto& [first, count] : misfit.of.spans)
      out.segment(first, count).setConstant(variance);
  }
  return out;
}

PlannedSpace space_of_data(const std::vector<trajectory::Dataset>& datasets,
                           const DiagnoseOptions& options, MissingForces forces) {
  PlannedSpace out;
  BuiltProblem built = build_problem(datasets, options);
  out.reasons = built.problem->observations.insufficient;
  out.notes = built.problem->observations.notes;
  if (!built.forward) return out;
  const Prepared prepared = prepare(std::move(built), builder_of(options));
  out.reasons = prepared.reasons;
  out.notes.insert(out.notes.end(), prepared.notes.begin(), prepared.notes.end());
  if (!out.reasons.empty()) return out;

  const Problem& problem = *prepared.built.problem;
  const auto plain = [&] {  // misfits need no simulation
    return in_windows(problem) ? prepared.noise : with_random_effects(problem, prepared.noise);
  };
  const Comparison comparison = forces == MissingForces::granted
                                    ? first_comparison(problem, prepared.noise)
                                    : comparison_about(problem, plain());
  SignatureSpace space;
  space.problem = prepared.built.problem;
  space.whitening = comparison.whitening;
  space.rows = rows_of(problem, comparison.noise, comparison.noise.at_p);
  const LinearNuisances linear = linear_nuisances(problem, space.whitening, comparison.noise.p);
  space.tolerances = shrinkage(linear.slopes);
  if (forces == MissingForces::granted)
    space.random =
        without_tolerances(space.whitening.random, space.tolerances, space.whitening.rows);
  for (const Misfit& misfit : space.whitening.random.misfits)
    space.misfits.own.push_back({misfit, problem.settings.least_misfit});
  number_channels(space);
  out.space = std::move(space);
  return out;
}

PlannedSpace space_of(const std::vector<simulation::Experiment>& experiments,
                      const DiagnoseOptions& options, MissingForces forces) {
  std::vector<trajectory::Dataset> datasets;
  for (const simulation::Experiment& experiment : experiments) {
    auto data = simulated_data(experiment, {});
    if (!data)
      return {{}, {experiment.name + ": the nominal robot can't be simulated to the end"}, {}};
    datasets.push_back(std::move(*data));
  }
  return space_of_data(datasets, options, forces);
}

std::optional<std::vector<Vector>> change_of_rows(const SignatureSpace& space, const Vector& p) {
  const PredictionSet there = predict_all(*space.problem, p);
  if (!there.valid) return {};
  std::vector<Vector> rows = rows_of(*space.problem, space.whitening.alignments, there);
  for (std::size_t d = 0; d < rows.size(); ++d) rows[d] -= space.rows[d];
  return rows;
}

Vector signature_of(const SignatureSpace& space, const std::vector<Vector>& change) {
  Vector white = space.whitening.apply(change);
  space.tolerances.apply(white);
  return white;
}

const CurvePoint* SignatureCurve::stated() const {
  for (const CurvePoint& point : points)
    if (point.share == 1.0) return &point;
  return nullptr;
}

std::optional<CurvePoint> curve_point(const SignatureSpace& space, const std::vector<int>& free,
                                      const Vector& p, Matrix* plain) {
  const auto change = change_of_rows(space, p);
  if (!change) return {};
  CurvePoint point{
      1.0, space.problem->hypotheses.scaled(free, p), signature_of(space, *change), {}};
  std::vector<Vector> rows = space.rows;
  for (std::size_t d = 0; d < rows.size(); ++d) rows[d] += (*change)[d];
  const double departed = point.u.norm();
  const double sensitivity = departed > 0.0 ? point.signature.norm() / departed : 0.0;
  const auto slopes = raw_slopes(space, p, rows, free, sensitivity);
  if (!slopes) return {};

  point.slopes = space.whitening.columns(*slopes);
  if (plain != nullptr) *plain = point.slopes;
  space.tolerances.apply(point.slopes);
  return point;
}

SignatureCurve signature_curve(const SignatureSpace& space, const std::vector<int>& candidates,
                               const Vector& p, const std::vector<double>& shares) {
  const Hypotheses& hypotheses = space.problem->hypotheses;
  const Vector nominal = hypotheses.nominal();
  SignatureCurve curve;
  curve.free = hypotheses.parameters_of(candidates);
  curve.misfits = space.misfits;
  for (const int i : curve.free) curve.bounds.push_back(hypotheses.parameters[i].scaled_bounds());
  if (curve.free.empty()) {
    curve.points.push_back(
        {1.0, {}, Vector::Zero(space.whitening.rows), Matrix(space.whitening.rows, 0)});
    return curve;
  }

  double least = kInfinity;
  for (const double share : shares) {
    const Vector there = nominal + share * (p - nominal);
    const bool within = std::all_of(curve.free.begin(), curve.free.end(), [&](int i) {
      return hypotheses.parameters[i].bounds.contains(there[i]);
    });
    if (!within) continue;
    const bool nearest = std::abs(share) < least;
    auto point = curve_point(space, curve.free, there, nearest ? &curve.plain : nullptr);
    if (!point) continue;
    point->share = share;
    least = std::min(least, std::abs(share));
    curve.points.push_back(std::move(*point));
  }
  return curve;
}

Vector stated_departure(const Problem& problem, int candidate, double size) {
  Vector p = problem.hypotheses.nominal();
  const int first = problem.hypotheses.candidates[candidate].parameters.front();
  const FreeParameter& own = problem.hypotheses.parameters[first];
  p[first] = std::clamp(own.nominal + size * own.usual_step(), own.bounds.lower, own.bounds.upper);
  return p;
}

}  // namespace jaculus::diagnosis
