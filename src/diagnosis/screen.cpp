#include "jaculus/diagnosis/screen.h"

#include <tbb/parallel_for.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstddef>

namespace jaculus {
namespace {

constexpr double kInfluence = 0.1;  // norm of a prior scale's signature below which these data can't see a candidate
constexpr double kSmall = 0.15;     // of the probing step
constexpr double kLowest = 0.125, kHighest = 8.0;  // rungs of the ladder, of the probing step
constexpr int kEven = 16;                          // spaces between rungs over a short range
constexpr int kHalvings = 6;                       // of the space in which a threshold lies
constexpr double kHarm = 10.0;             // log evidence by which a rung past a threshold is worse than the one before
constexpr double kBeyondProportion = 4.0;  // times what a proportional effect would change there

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Probing step of a parameter from where the base model has it; inwards where it would leave the bounds.
double probe_step(const FreeParameter& parameter, double value, double share) {
  double step = share * parameter.usual_step();
  if (!parameter.bounds.contains(value + step)) step = -step;
  return step;
}

/// Column per prior scale for moving parameter i of p by `step`; false where a simulation fails.
bool column(const DiagnosisProblem& problem, const EvidenceSpace& space, const Vector& p, const Vector& r_at_p, int i,
            double step, VectorRef out) {
  Vector moved = p;
  moved[i] += step;
  const PredictionSet set = predict_all(problem, moved);
  if (!set.valid) return false;
  out = (r_at_p - space.residual(rows_of(problem, set))) * (problem.hypotheses.parameters[at(i)].scale / step);
  return true;
}

/// Columns at a share of the probing steps; beyond one it is the first parameter's alone.
bool columns(const DiagnosisProblem& problem, const EvidenceSpace& space, const Fit& base, const Candidate& candidate,
             double share, Matrix& out) {
  out.resize(space.rows, static_cast<Eigen::Index>(candidate.parameters.size()));
  Vector p = base.p, r = base.residual;
  for (std::size_t k = 0; k < candidate.parameters.size(); ++k) {
    const int i = candidate.parameters[k];
    const FreeParameter& own = problem.hypotheses.parameters[at(i)];
    const double step = probe_step(own, p[i], k == 0 ? share : std::min(1.0, std::abs(share)));
    auto slope = out.col(static_cast<Eigen::Index>(k));
    if (!column(problem, space, p, r, i, step, slope)) return false;
    if (k > 0) continue;
    // The others may do nothing before the first is switched on.
    p[i] += step;
    r -= slope * (step / own.scale);
  }
  return true;
}

struct Linear {
  double log_evidence = 0.0;
  Vector mean;
};

/// Linear Gaussian model r = G u + noise, u ~ N(0, I).
Linear linear_evidence(const Matrix& G, const Vector& r) {
  if (G.cols() == 0) return {};
  const Matrix A = G.transpose() * G + Matrix::Identity(G.cols(), G.cols());
  const Vector b = G.transpose() * r;
  const Eigen::LLT<Matrix> llt(A);
  Linear result;
  result.mean = llt.solve(b);
  result.log_evidence = 0.5 * b.dot(result.mean) - llt.matrixLLT().diagonal().array().log().sum();
  return result;
}

void score(const DiagnosisProblem& problem, const Fit& base, const Candidate& candidate, const Matrix& own,
           double alone, Probe& probe) {
  Matrix G(own.rows(), own.cols() + base.jacobian.cols());
  G << own, -base.jacobian;
  Linear linear = linear_evidence(G, base.residual);
  for (Eigen::Index k = 0; k < own.cols(); ++k) {
    const FreeParameter& p = problem.hypotheses.parameters[at(candidate.parameters[static_cast<std::size_t>(k)])];
    const double value = base.p[candidate.parameters[static_cast<std::size_t>(k)]];
    const Bounds range{(p.bounds.lower - value) / p.scale, (p.bounds.upper - value) / p.scale};
    if (range.contains(linear.mean[k])) continue;
    linear.mean[k] = std::clamp(linear.mean[k], range.lower, range.upper);
    // On the wrong side of a boundary the first parameter can do nothing for the residual.
    if (k == 0 && linear.mean[k] == 0.0) linear.log_evidence = alone - 1.0;
  }
  if (linear.log_evidence - alone <= probe.score) return;
  probe.score = linear.log_evidence - alone;
  probe.estimate = linear.mean.head(own.cols());
}

/// u of the first parameter's rungs within its bounds.
std::vector<double> ladder(const FreeParameter& parameter, double value) {
  const double step = probe_step(parameter, value, 1.0);
  const double range = parameter.bounds.upper - parameter.bounds.lower;
  std::vector<double> rungs;
  const auto add = [&](double move) {
    if (move != 0.0 && parameter.bounds.contains(value + move)) rungs.push_back(move / parameter.scale);
  };
  if (range < kHighest * std::abs(step)) {
    for (int i = 0; i <= kEven; ++i) add(parameter.bounds.lower + i * range / kEven - value);
    return rungs;
  }
  for (double share = kLowest; share <= kHighest; share *= 2.0) {
    add(share * step);
    add(-share * step);
  }
  return rungs;
}

/// What a step of the first parameter alone, u prior scales, does to the misfit.
class Climb {
 public:
  Climb(const DiagnosisProblem& problem, const EvidenceSpace& space, const Fit& base, int first, double alone)
      : problem_(problem), space_(space), base_(base), first_(first) {
    standing_ = alone - 0.5 * base.residual.squaredNorm();
  }

  struct Rung {
    double u = 0.0;
    double score = -kInfinity;     ///< log evidence gained, width of the valley by its slope
    double influence = kInfinity;  ///< norm of what the step changes; infinite where the simulation fails
  };

  Rung at_step(double u) {
    ++predictions;
    Vector p = base_.p;
    p[first_] += u * problem_.hypotheses.parameters[at(first_)].scale;
    const PredictionSet set = predict_all(problem_, p);
    if (!set.valid) return {u};
    const Vector r = space_.residual(rows_of(problem_, set));
    const double there = linear_evidence(-base_.jacobian, r).log_evidence - 0.5 * r.squaredNorm() - 0.5 * u * u;
    const double influence = (r - base_.residual).norm();
    return {u, there - standing_ - 0.5 * std::log1p(influence * influence / (u * u)), influence};
  }

  long predictions = 0;

 private:
  const DiagnosisProblem& problem_;
  const EvidenceSpace& space_;
  const Fit& base_;
  int first_;
  double standing_ = 0.0;
};

/// Whether an effect sets in between two steps: what it changes grows far beyond proportion, and does harm.
bool sets_in(const Climb::Rung& near, const Climb::Rung& far) {
  return near.u != 0.0 && far.score < near.score - kHarm &&
         far.influence * std::abs(near.u) > kBeyondProportion * near.influence * std::abs(far.u);
}

/// Effects with a threshold (a foot that slips, a limit that is met) do next to nothing up to a strength and soon too much: their valley
/// lies just past the threshold. Halves the space around it until a step helps.
void find_threshold(Climb& climb, Climb::Rung near, Climb::Rung far, Climb::Rung& best) {
  for (int i = 0; i < kHalvings && best.u == 0.0 && sets_in(near, far); ++i) {
    const Climb::Rung middle = climb.at_step(0.5 * (near.u + far.u));
    if (middle.score > 0.0)
      best = middle;
    else
      (middle.score < near.score - kHarm ? far : near) = middle;
  }
}

/// Walks the ladder; a rung that beats the linear score takes its place.
void climb_ladder(const DiagnosisProblem& problem, const EvidenceSpace& space, const Fit& base, int first, double alone,
                  Probe& probe) {
  Climb climb(problem, space, base, first, alone);
  std::vector<Climb::Rung> rungs{{0.0, 0.0, 0.0}};
  for (const double u : ladder(problem.hypotheses.parameters[at(first)], base.p[first]))
    rungs.push_back(climb.at_step(u));
  Climb::Rung best =
      *std::max_element(rungs.begin(), rungs.end(),
                        [](const Climb::Rung& one, const Climb::Rung& other) { return one.score < other.score; });
  std::sort(rungs.begin(), rungs.end(),
            [](const Climb::Rung& one, const Climb::Rung& other) { return one.u < other.u; });
  for (std::size_t i = 0; i + 1 < rungs.size(); ++i) {
    const bool below = rungs[i + 1].u <= 0.0;
    const Climb::Rung &near = rungs[below ? i + 1 : i], &far = rungs[below ? i : i + 1];
    find_threshold(climb, near, far, best);
  }
  probe.predictions += climb.predictions;
  if (best.u != 0.0) probe.rung = best.u;
  probe.score = std::max(probe.score, best.score);
}

}  // namespace

Probe probe_candidate(const DiagnosisProblem& problem, const EvidenceSpace& space, const Fit& base, int c,
                      Screening how) {
  const Candidate& candidate = problem.hypotheses.candidates[at(c)];
  Probe probe;
  if (std::find(base.free.begin(), base.free.end(), candidate.parameters.front()) != base.free.end()) return probe;
  const double alone = linear_evidence(-base.jacobian, base.residual).log_evidence;
  const auto parameters = static_cast<long>(candidate.parameters.size());
  probe.predictions = 2 * parameters;
  if (columns(problem, space, base, candidate, 1.0, probe.full) && probe.full.norm() > kInfluence) {
    score(problem, base, candidate, probe.full, alone, probe);
    probe.valid = true;
  }
  if (columns(problem, space, base, candidate, kSmall, probe.small) && probe.small.norm() > kInfluence) {
    score(problem, base, candidate, probe.small, alone, probe);
    if (!probe.valid) probe.full = probe.small;
    probe.valid = true;
  } else if (probe.valid) {
    probe.small = probe.full;
  }
  if (how != Screening::ladder) return probe;
  climb_ladder(problem, space, base, candidate.parameters.front(), alone, probe);
  if (probe.valid || std::isnan(probe.rung)) return probe;
  // Without influence up to its threshold: its columns are those of the rung that helps.
  const FreeParameter& first = problem.hypotheses.parameters[at(candidate.parameters.front())];
  probe.valid = columns(problem, space, base, candidate, probe.rung * first.scale / first.usual_step(), probe.full);
  probe.small = probe.full;
  probe.predictions += parameters;
  return probe;
}

std::vector<Probe> screen(const DiagnosisProblem& problem, const EvidenceSpace& space, const Fit& base, Screening how) {
  std::vector<Probe> probes(problem.hypotheses.candidates.size());
  tbb::parallel_for(std::size_t{0}, probes.size(), [&](std::size_t c) {
    probes[c] = probe_candidate(problem, space, base, static_cast<int>(c), how);
  });
  return probes;
}

std::vector<Vector> fit_starts(const DiagnosisProblem& problem, const Vector& base, int c, const Probe& probe) {
  const auto& parameters = problem.hypotheses.candidates[at(c)].parameters;
  Vector estimated = base, probed = base;
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    const FreeParameter& p = problem.hypotheses.parameters[at(parameters[k])];
    const double step = p.usual_step();
    const double u = probe.estimate.size() > 0 ? probe.estimate[static_cast<Eigen::Index>(k)] : 0.0;
    estimated[parameters[k]] = std::clamp(base[parameters[k]] + u * p.scale, p.bounds.lower, p.bounds.upper);
    // A start at nominal can be a point without slope.
    if (k == 0 && std::abs(u * p.scale) < 0.02 * std::abs(step))
      estimated[parameters[k]] = base[parameters[k]] + 0.1 * step;
    const double side = k == 0 && u < 0.0 && !p.one_sided() ? -std::abs(step) : (p.one_sided() ? step : std::abs(step));
    probed[parameters[k]] = std::clamp(base[parameters[k]] + side, p.bounds.lower, p.bounds.upper);
  }
  if (std::isnan(probe.rung)) return {estimated, probed};
  Vector climbed = base;
  const int first = parameters.front();
  climbed[first] += probe.rung * problem.hypotheses.parameters[at(first)].scale;
  return {estimated, climbed, probed};
}

double unexplained_energy(const Vector& signature, const Matrix& own) {
  if (own.cols() == 0) return signature.squaredNorm();
  const Matrix A = own.transpose() * own + 1e-6 * Matrix::Identity(own.cols(), own.cols());
  const Vector u = A.llt().solve(own.transpose() * signature);
  return (signature - own * u).squaredNorm();
}

}  // namespace jaculus
