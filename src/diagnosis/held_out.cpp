#include "jaculus/diagnosis/held_out.h"

#include <tbb/parallel_for.h>

#include <Eigen/Cholesky>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <cstddef>

namespace jaculus {
namespace {

constexpr int kIterations = 5;
constexpr int kMostFolds = 8;
constexpr double kLeastGap = 1.5;  // below it a shrink would divide noise by noise

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Squares and counts of judged errors by condition and channel.
struct Errors {
  std::vector<Vector> squares, counts;
  double train_runs = 1.0;
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
    return Vector(space.whiten(all).segment(n.first, n.count).cwiseProduct(prefix));
  };
  Matrix A(n.count, n.columns.cols());
  for (Eigen::Index k = 0; k < A.cols(); ++k) A.col(k) = white(n.scale[k] * n.columns.col(k));
  const Vector r_white = white(raw - n.columns * n.mean);
  const Matrix H = A.transpose() * A + Matrix::Identity(A.cols(), A.cols());
  const Vector found = n.mean + n.scale.cwiseProduct(H.llt().solve(A.transpose() * r_white));
  raw -= n.columns * found;
  for (const RowSpan& span : row_spans(condition)) {
    if (span.run != r) continue;
    const double sigma = condition.channels[at(span.channel)].noise_floor;
    for (int i = 0; i < span.count; ++i) {
      const int row = span.first - n.first + i;
      if (prefix[row] > 0.0) continue;
      errors.squares[at(c)][span.channel] += std::pow(raw[row] / sigma, 2) / (1.0 + 1.0 / errors.train_runs);
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

struct FoldResult {
  bool valid = false;
  Errors before, after;
};

FoldResult run_fold(const DiagnosisProblem& problem, const Linearisation& about, const EvidenceSpace& whole,
                    const RunMask& mask, const Fit& none, const Fit& model) {
  FoldResult result{false, no_errors(problem), no_errors(problem)};
  const EvidenceSpace space = evidence_space(problem, about, mask);
  if (space.rows == 0) return result;
  const Fit nominal = fit_model(problem, space, none.free, {none.p}, {kIterations});
  const Fit fitted = fit_model(problem, space, model.free, {model.p}, {kIterations});
  if (!nominal.valid || !fitted.valid) return result;
  for (const auto& [p, errors] : {std::pair(&nominal.p, &result.before), std::pair(&fitted.p, &result.after)}) {
    const PredictionSet set = predict_all(problem, *p);
    if (!set.valid) return result;
    const std::vector<Vector> predicted = rows_of(problem, set);
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
  std::vector<FoldResult> folds(masks.size());
  tbb::parallel_for(std::size_t{0}, masks.size(),
                    [&](std::size_t f) { folds[f] = run_fold(problem, about, whole, masks[f], none, model); });
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
