#include "diagnosis/pattern_scan.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/forward/sensitivities.h"
#include "diagnosis/remainder/pattern_file.h"
#include "diagnosis/selection/line_search.h"
#include "diagnosis/selection/residual.h"
#include "jaculus/effects/user_effect.h"

namespace jaculus::diagnosis {
namespace {

/// Positions q and rates v, one a row.
UsualMotions motions_of(const Matrix& q, const Matrix& v) {
  return {q.leftCols<1>(), (v.rowwise().squaredNorm() / static_cast<double>(v.cols())).cwiseSqrt(),
          q.rowwise().maxCoeff() - q.rowwise().minCoeff()};
}

/// In the first segment; nothing moves where it can't be simulated.
UsualMotion usual_motion(const KnownModel& about) {
  const BuiltProblem alone = builder_of(about.problem->hypotheses.effects_of(about.candidates),
                                        about.problem->settings)(about.problem->observations);
  const model::PlanarModel& robot = alone.problem->observations.datasets.front().model;
  const SimulationSetup setup =
      alone.forward->setup(0, 0, carried_over(about, alone.problem->hypotheses));
  const simulation::Simulation run =
      simulate(setup.plant, setup.controller, setup.start, setup.options);
  if (run.time.size() > 0 && run.v.allFinite() && run.motor_velocity.allFinite())
    return {motions_of(run.q, run.v), motions_of(run.motor_position, run.motor_velocity),
            run.time[run.time.size() - 1] - run.time[0]};
  const Matrix none = Matrix::Zero(count_of(robot.motors), 1);
  return {motions_of(setup.start.q, Matrix::Zero(robot.size(), 1)), motions_of(none, none)};
}

std::vector<double> scales_of(const PlacePattern& pattern) {
  std::vector<double> scales;
  for (const PatternParameter& own : pattern.parameters) scales.push_back(own.scale);
  return scales;
}

effects::Effect effect_of(const PlacePattern& pattern, bool free_shape) {
  return effects::parse_user_effect(pattern_file(pattern, scales_of(pattern), free_shape),
                                    pattern.name)
      .effect;
}

/// A model's effects and the patterns, as candidates.
std::vector<effects::Effect> effects_and_patterns(const KnownModel& about,
                                                  const std::vector<PlacePattern>& patterns) {
  std::vector<effects::Effect> all = about.problem->hypotheses.effects_of(about.candidates);
  for (const PlacePattern& pattern : patterns) {
    const bool present = std::any_of(all.begin(), all.end(), [&](const effects::Effect& effect) {
      return effect.name == pattern.name;
    });
    if (!present) all.push_back(effect_of(pattern, false));
  }
  return all;
}

/// Y_k of a pattern, a column a parameter; none where it changes nothing or is lost.
Matrix pattern_columns(const PatternProblem& own, int candidate) {
  const Problem& problem = *own.built.problem;
  const Whitening& whitening = own.comparison.whitening;
  const std::vector<int>& parameters = problem.hypotheses.candidates[candidate].parameters;
  Matrix columns(whitening.rows, count_of(parameters));
  for (int k = 0; k < count_of(parameters); ++k) {
    const double scale = problem.hypotheses.parameters[parameters[k]].scale;
    const auto moved = difference(problem, whitening.alignments, own.p, own.rows, parameters[k],
                                  problem.settings.pattern_step * scale);
    if (!moved) return {};
    columns.col(k) = whitening.apply(moved->rows) * (scale / moved->step);
  }
  return columns;
}

/// Whether two patterns are of one kind at one place, so that the better one stands for both.
bool alike(const PlacePattern& a, const PlacePattern& b) {
  return a.at == b.at && a.regressor == b.regressor && a.form == b.form;
}

}  // namespace

Vector carried_over(const KnownModel& model, const Hypotheses& hypotheses) {
  const std::vector<FreeParameter>& known = model.problem->hypotheses.parameters;
  Vector p = hypotheses.nominal();
  for (int i = 0; i < count_of(hypotheses.parameters); ++i) {
    const FreeParameter& own = hypotheses.parameters[i];
    for (int k = 0; k < count_of(known); ++k)
      if (own.owner != "force" && known[k].owner == own.owner && known[k].name == own.name)
        p[i] = model.p[k];
  }
  return p;
}

std::optional<PatternProblem> pattern_problem(const KnownModel& about,
                                              const std::vector<Alignment>& alignments) {
  const Observations& observations = about.problem->observations;
  const Settings& settings = about.problem->settings;
  PatternProblem out;
  out.patterns = place_patterns(observations.datasets.front().model, usual_motion(about),
                                {settings.pattern_prior, settings.lever, settings.rest_speed});
  out.built = builder_of(effects_and_patterns(about, out.patterns), settings)(observations);
  const Problem& problem = *out.built.problem;
  out.p = carried_over(about, problem.hypotheses);
  NoiseModel noise = estimate_noise(problem, out.p, alignments);
  if (!noise.valid()) return {};
  out.comparison = comparison_about(problem, with_random_effects(problem, std::move(noise)));
  out.rows = rows_of(problem, out.comparison.noise, out.comparison.noise.at_p);
  return out;
}

LinearPatterns without_patterns(const PatternProblem& own) {
  const Problem& problem = *own.built.problem;
  const Whitening& whitening = own.comparison.whitening;
  const std::vector<int> nuisances = problem.hypotheses.nuisances();
  const Matrix J = linear_nuisances(problem, whitening, own.p).slopes;
  LinearPatterns out;
  out.residual = whitening.residual(own.rows);
  if (J.cols() > 0) out.residual -= J * problem.hypotheses.scaled(nuisances, own.p);
  Matrix X(out.residual.size(), 1 + J.cols());
  X << out.residual, -J;
  out.model = columns_of(whitening.random, X);
  if (whitening.random.blocks.empty())
    for (Eigen::Index k = 1; k < X.cols(); ++k) out.model.products.shared.push_back(k - 1);

  out.nuisances = shrinkage(J);
  out.nuisances.apply(out.residual);
  return out;
}

void add_columns(const PatternProblem& own, LinearPatterns& linear) {
  linear.columns.resize(own.patterns.size());
  linear.acting.resize(own.patterns.size());
  tbb::parallel_for(0, count_of(own.patterns), [&](int k) {
    const int c = own.built.problem->hypotheses.candidate(own.patterns[k].name);
    if (c < 0) return;
    const Matrix acting = pattern_columns(own, c);
    Matrix left = acting;
    linear.nuisances.apply(left);
    if (!(left.squaredNorm() > 1.0)) return;
    linear.acting[k] = columns_of(own.comparison.whitening.random, acting);
    linear.columns[k] = std::move(left);
  });
  for (const Matrix& columns : linear.columns) linear.tried += columns.cols() > 0 ? 1 : 0;
}

Matrix columns_of(const LinearPatterns& linear, const std::vector<int>& members) {
  Matrix all(linear.residual.size(), 0);
  for (const int k : members) {
    const Eigen::Index before = all.cols();
    all.conservativeResize(all.rows(), before + linear.columns[k].cols());
    all.rightCols(linear.columns[k].cols()) = linear.columns[k];
  }
  return all;
}

double log_evidence(const PatternProblem& own, const LinearPatterns& linear,
                    const std::vector<int>& members) {
  const RandomEffects& random = own.comparison.whitening.random;
  const Problem& problem = *own.built.problem;
  Columns more;
  for (const int k : members)
    more = more.X.cols() == 0 ? linear.acting[k] : side_by_side(random, more, linear.acting[k]);
  Products all = linear.model.products;
  if (!members.empty())
    all = side_by_side(all, products_between(random, linear.model.X, more.X), more.products);
  return followed_by(problem, random, all, first_scales(random), problem.settings.scale_steps)
      .evidence();
}

PatternScan likely_patterns(const KnownModel& about, const std::vector<Alignment>& alignments) {
  const std::optional<PatternProblem> own = pattern_problem(about, alignments);
  if (!own || own->comparison.whitening.random.size() == 0) return {};
  LinearPatterns linear = without_patterns(*own);
  add_columns(*own, linear);
  const double without = log_evidence(*own, linear, {});
  std::vector<double> gains(own->patterns.size(), -kInfinity);
  tbb::parallel_for(0, count_of(own->patterns), [&](int k) {
    const bool known = about.problem->hypotheses.candidate(own->patterns[k].name) >= 0;
    if (own->patterns[k].listed || known || linear.columns[k].cols() == 0) return;
    gains[k] = log_evidence(*own, linear, {k}) - without;
  });

  const Settings& settings = about.problem->settings;
  // About no force and of a grid's shape a gain ranks; what a form explains, its fit tells.
  std::vector<LikelyPattern> all;
  for (std::size_t k = 0; k < gains.size(); ++k)
    if (gains[k] > 0.0) all.push_back({own->patterns[k], gains[k]});
  std::stable_sort(all.begin(), all.end(),
                   [](const LikelyPattern& a, const LikelyPattern& b) { return a.gain > b.gain; });

  PatternScan scan{{}, linear.tried};
  for (const LikelyPattern& next : all) {
    const bool known = std::any_of(
        scan.likely.begin(), scan.likely.end(),
        [&](const LikelyPattern& better) { return alike(better.pattern, next.pattern); });
    if (!known && count_of(scan.likely) < settings.patterns_tried) scan.likely.push_back(next);
  }
  return scan;
}

effects::Effect pattern_effect(const PlacePattern& pattern) {
  effects::Effect effect = effect_of(pattern, true);
  effect.pattern = true;
  if (effect.sized)  // what it is on a robot is one as well
    effect.sized = [made_for = effect.sized](const model::PlanarModel& robot,
                                             const effects::JointRates& rates) {
      std::vector<effects::Effect> all = made_for(robot, rates);
      for (effects::Effect& own : all) own.pattern = true;
      return all;
    };
  return effect;
}

}  // namespace jaculus::diagnosis
