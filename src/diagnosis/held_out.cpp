#include "jaculus/diagnosis/held_out.h"

#include <tbb/parallel_for.h>

#include <Eigen/Cholesky>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <cstddef>

namespace jaculus {
namespace {

constexpr int kSteps = 2;  // of a refit
constexpr int kMostFolds = 8;
constexpr double kLeastGap = 1.5;  // below it a shrink would divide noise by noise

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Squares and counts of judged errors by condition and channel.
struct Errors {
  std::vector<Vector> squares, counts;
  double train_runs = 1.0;
  double log_density = 0.0;  ///< of all judged rows together, less what does not depend on the model
};

Errors no_errors(const DiagnosisProblem& problem) {
  Errors errors;
  for (const Condition& c : problem.observations.conditions) {
    errors.squares.push_back(Vector::Zero(static_cast<Eigen::Index>(c.channels.size())));
    errors.counts.push_back(errors.squares.back());
  }
  return errors;
}

double prefix_end(const Condition& condition, const Run& run) {
  if (!condition.measured_input) return condition.prefix_end;
  double end = run.start;
  for (const Vector& t : run.time)
    if (t.size() > 0) end = std::max(end, t[t.size() - 1]);
  return run.start + 0.25 * (end - run.start);
}

/// -r^T (I + B B^T)^-1 r/2 of the white rows that are judged, B: what the prefix leaves open of the nuisances, C L^-T.
double log_density(const Vector& white, const Vector& judged, const Matrix& columns, const Eigen::LLT<Matrix>& prefix) {
  const Vector r = white.cwiseProduct(judged);
  const Matrix B = judged.asDiagonal() * prefix.matrixL().solve(columns.transpose()).transpose();
  const Vector along = B.transpose() * r;
  const Matrix inner = B.transpose() * B + Matrix::Identity(B.cols(), B.cols());
  return -0.5 * (r.squaredNorm() - along.dot(inner.llt().solve(along)));
}

/// Errors of one held-out run after its nuisances were estimated from the prefix.
void judge_run(const Condition& condition, int c, int r, const Vector& residual, const RunNuisances& n,
               const ConditionSpace& space, Errors& errors) {
  const double end = prefix_end(condition, condition.runs[at(r)]);
  Vector prefix = Vector::Zero(n.count), raw = residual.segment(n.first, n.count);
  for (const RowSpan& span : row_spans(condition)) {
    if (span.run != r) continue;
    const Vector& time = condition.runs[at(r)].time[at(span.channel)];
    for (int i = 0; i < span.count; ++i)
      if (time[i] < end) prefix[span.first - n.first + i] = 1.0;
  }
  // Neighbours' correlation is used as everywhere; a row whose predecessor is in the prefix is in it by time order.
  const auto white = [&](const Vector& part) {
    Vector all = Vector::Zero(condition.rows());
    all.segment(n.first, n.count) = part;
    return Vector(space.whiten(all).segment(n.first, n.count));
  };
  Matrix columns(n.count, n.columns.cols());
  for (Eigen::Index k = 0; k < columns.cols(); ++k) columns.col(k) = white(n.scale[k] * n.columns.col(k));
  const Matrix A = prefix.asDiagonal() * columns;
  const Vector r_white = white(raw - n.columns * n.mean).cwiseProduct(prefix);
  const Matrix H = A.transpose() * A + Matrix::Identity(A.cols(), A.cols());
  const Eigen::LLT<Matrix> llt(H);
  raw -= n.columns * (n.mean + n.scale.cwiseProduct(llt.solve(A.transpose() * r_white)));
  // What the prefix leaves open of the nuisances: rows of n.columns S L^-T, of which each row's square sum is a variance.
  const Matrix open = llt.matrixL().solve((n.columns * n.scale.asDiagonal()).transpose()).transpose();
  errors.log_density += log_density(white(raw), (1.0 - prefix.array()).matrix(), columns, llt);
  for (const RowSpan& span : row_spans(condition)) {
    if (span.run != r) continue;
    for (int i = 0; i < span.count; ++i) {
      const int row = span.first - n.first + i;
      if (prefix[row] > 0.0) continue;
      const double variance = std::pow(space.sigma[span.first + i], 2) * (1.0 + 1.0 / errors.train_runs);
      errors.squares[at(c)][span.channel] += raw[row] * raw[row] / (variance + open.row(row).squaredNorm());
      errors.counts[at(c)][span.channel] += 1.0;
    }
  }
}

/// Folds as masks of training runs.
std::vector<RunMask> folds_of(const DiagnosisProblem& problem, std::string& over) {
  const auto& conditions = problem.observations.conditions;
  RunMask all;
  std::vector<std::pair<int, int>> groups;  // condition, trial
  int trials = 0;
  for (std::size_t c = 0; c < conditions.size(); ++c) {
    all.emplace_back(conditions[c].runs.size(), true);
    trials += conditions[c].trials;
  }
  over = conditions.size() > 1 ? "conditions" : (trials > 1 ? "trials" : "time");
  std::vector<RunMask> folds;
  const auto hold = [&](auto&& out) {
    RunMask mask = all;
    for (std::size_t c = 0; c < conditions.size(); ++c)
      for (std::size_t r = 0; r < conditions[c].runs.size(); ++r)
        if (out(static_cast<int>(c), static_cast<int>(r))) mask[c][r] = false;
    folds.push_back(mask);
  };
  if (over == "conditions") {
    for (int c = 0; c < static_cast<int>(conditions.size()); ++c) hold([&](int k, int) { return k == c; });
  } else if (over == "trials") {
    const int count = std::min(kMostFolds, trials);
    std::vector<int> names;
    for (const Run& run : conditions[0].runs)
      if (names.empty() || names.back() != run.trial) names.push_back(run.trial);
    for (int f = 0; f < count; ++f)
      hold([&](int, int r) {
        const auto place = std::find(names.begin(), names.end(), conditions[0].runs[at(r)].trial) - names.begin();
        return static_cast<int>(place) % count == f;
      });
  } else if (conditions.size() == 1 && conditions[0].runs.size() > 1) {
    for (int f = 0; f < 3; ++f) hold([&](int, int r) { return r % 3 == f; });
  }
  return folds;
}

/// A fitted model with its rows' slopes: what all folds share.
struct Tangent {
  bool valid = false;
  std::vector<int> free;
  Vector p;
  std::vector<Vector> rows;                 ///< predicted, a condition each
  std::vector<std::vector<Vector>> slopes;  ///< d(rows)/du, a free parameter and a condition each
};

bool rows_at(const DiagnosisProblem& problem, const Vector& p, std::vector<Vector>& rows) {
  const PredictionSet set = predict_all(problem, p);
  if (set.valid) rows = rows_of(problem, set);
  return set.valid;
}

Tangent tangent_of(const DiagnosisProblem& problem, const Fit& fit) {
  Tangent tangent{false, fit.free, fit.p, {}, {}};
  if (!rows_at(problem, fit.p, tangent.rows)) return tangent;
  for (std::size_t i = 0; i < fit.free.size(); ++i) {
    const FreeParameter& own = problem.hypotheses.parameters[at(fit.free[i])];
    double step = difference_step(fit.jacobian.col(static_cast<Eigen::Index>(i)).norm());
    if (!own.bounds.contains(fit.p[fit.free[i]] + step * own.scale)) step = -step;
    const auto moved = [&] {
      Vector p = fit.p;
      p[fit.free[i]] += step * own.scale;
      return p;
    };
    std::vector<Vector> there;
    if (!rows_at(problem, moved(), there)) {
      step = -step;
      if (!own.bounds.contains(fit.p[fit.free[i]] + step * own.scale) || !rows_at(problem, moved(), there))
        return tangent;
    }
    for (std::size_t c = 0; c < there.size(); ++c) there[c] = (there[c] - tangent.rows[c]) / step;
    tangent.slopes.push_back(std::move(there));
  }
  tangent.valid = true;
  return tangent;
}

/// Gauss-Newton on the rows of a fold with the slopes of the whole, from where the whole was fitted: folds differ little. Returns the
/// predicted rows at the best point reached.
std::vector<Vector> refitted_rows(const DiagnosisProblem& problem, const EvidenceSpace& space, const Tangent& tangent) {
  const auto size = static_cast<Eigen::Index>(tangent.free.size());
  std::vector<Vector> best = tangent.rows, rows = best;
  if (size == 0) return best;
  Matrix J(space.rows, size);
  for (Eigen::Index i = 0; i < size; ++i) J.col(i) = -space.apply(tangent.slopes[static_cast<std::size_t>(i)]);
  const Eigen::LLT<Matrix> curvature(J.transpose() * J + Matrix::Identity(size, size));
  Vector p = tangent.p;
  double least = kInfinity;
  for (int step = 0;; ++step) {
    Vector u = problem.hypotheses.scaled(tangent.free, p);
    const Vector r = space.residual(rows);
    const double cost = r.squaredNorm() + u.squaredNorm();
    if (cost < least) best = rows;
    if (cost >= least || step == kSteps) return best;
    least = cost;
    u -= curvature.solve(J.transpose() * r + u);
    p = problem.hypotheses.unscaled(tangent.free, u, p);
    if (!rows_at(problem, p, rows)) return best;
  }
}

struct FoldResult {
  bool valid = false;
  Errors before, after;
};

FoldResult run_fold(const DiagnosisProblem& problem, const Linearisation& about, const EvidenceSpace& whole,
                    const RunMask& mask, const Tangent& none, const Tangent& model) {
  FoldResult result{false, no_errors(problem), no_errors(problem)};
  const EvidenceSpace space = evidence_space(problem, about, mask);
  if (space.rows == 0) return result;
  for (const auto& [tangent, errors] : {std::pair(&none, &result.before), std::pair(&model, &result.after)}) {
    const std::vector<Vector> predicted = refitted_rows(problem, space, *tangent);
    for (std::size_t c = 0; c < mask.size(); ++c) {
      const Condition& condition = problem.observations.conditions[c];
      const auto trained = static_cast<double>(std::count(mask[c].begin(), mask[c].end(), true));
      errors->train_runs = condition.measured_input || trained == 0.0 ? kInfinity : trained;
      const Vector residual = measured_rows(condition) - predicted[c];
      for (std::size_t r = 0; r < mask[c].size(); ++r) {
        if (mask[c][r]) continue;
        judge_run(condition, static_cast<int>(c), static_cast<int>(r), residual, about.nuisances[c][r],
                  whole.conditions[c], *errors);
      }
    }
  }
  result.valid = true;
  return result;
}

/// Root of the mean over channels of their mean squares.
double overall(const Errors& errors) {
  double sum = 0.0, channels = 0.0;
  for (std::size_t c = 0; c < errors.squares.size(); ++c) {
    for (Eigen::Index k = 0; k < errors.squares[c].size(); ++k) {
      if (errors.counts[c][k] == 0.0) continue;
      sum += errors.squares[c][k] / errors.counts[c][k];
      channels += 1.0;
    }
  }
  return channels > 0.0 ? std::sqrt(sum / channels) : kNaN;
}

void add(Errors& sum, const Errors& one) {
  sum.log_density += one.log_density;
  for (std::size_t c = 0; c < sum.squares.size(); ++c) {
    sum.squares[c] += one.squares[c];
    sum.counts[c] += one.counts[c];
  }
}

double shrink_of(double before, double after) { return 1.0 - (after - 1.0) / (before - 1.0); }

void set_interval(const std::vector<FoldResult>& folds, HeldOut& out) {
  std::vector<double> shrinks;
  for (const FoldResult& fold : folds) {
    const double before = overall(fold.before), after = overall(fold.after);
    if (fold.valid && before > 1.1 && std::isfinite(after)) shrinks.push_back(shrink_of(before, after));
  }
  const auto n = static_cast<double>(shrinks.size());
  if (n < 2.0 || !out.shrink) return;
  double mean = 0.0, squares = 0.0;
  for (const double s : shrinks) mean += s / n;
  for (const double s : shrinks) squares += (s - mean) * (s - mean);
  const double t = boost::math::quantile(boost::math::students_t(n - 1.0), 0.975);
  const double half = t * std::sqrt(squares / (n - 1.0) / n);
  out.ci95 = {*out.shrink - half, *out.shrink + half};
}

}  // namespace

HeldOut held_out(const DiagnosisProblem& problem, const Linearisation& about, const Fit& none, const Fit& model) {
  HeldOut out;
  const std::vector<RunMask> masks = folds_of(problem, out.over);
  if (masks.empty()) return out;
  const EvidenceSpace whole = evidence_space(problem, about);
  const Tangent of_none = tangent_of(problem, none), of_model = tangent_of(problem, model);
  if (!of_none.valid || !of_model.valid) return out;
  std::vector<FoldResult> folds(masks.size());
  tbb::parallel_for(std::size_t{0}, masks.size(),
                    [&](std::size_t f) { folds[f] = run_fold(problem, about, whole, masks[f], of_none, of_model); });
  Errors before = no_errors(problem), after = before;
  for (const FoldResult& fold : folds) {
    if (!fold.valid) continue;
    ++out.folds;
    add(before, fold.before);
    add(after, fold.after);
  }
  if (out.folds == 0) return out;
  out.valid = true;
  out.before = overall(before);
  out.after = overall(after);
  out.log_gain = after.log_density - before.log_density;
  if (out.before >= kLeastGap) out.shrink = shrink_of(out.before, out.after);
  set_interval(folds, out);
  for (std::size_t c = 0; c < before.squares.size(); ++c) {
    const Condition& condition = problem.observations.conditions[c];
    const std::string prefix = before.squares.size() > 1 ? condition.dataset.folder.filename().string() + "." : "";
    for (std::size_t k = 0; k < condition.channels.size(); ++k) {
      const auto i = static_cast<Eigen::Index>(k);
      if (before.counts[c][i] == 0.0) continue;
      out.channels[prefix + condition.channels[k].stream + "." + condition.channels[k].name] = {
          std::sqrt(before.squares[c][i] / before.counts[c][i]), std::sqrt(after.squares[c][i] / after.counts[c][i])};
    }
  }
  return out;
}

}  // namespace jaculus
