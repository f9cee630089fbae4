#include "jaculus/diagnosis/selection.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <set>

#include "diagnosis/posterior.h"

namespace jaculus {
namespace {

constexpr double kGain = 2.0;  // log posterior odds by which a larger model must lead for its successors to be tried
constexpr double kLeastGain = 2.0;  // score of a candidate that is added to others: the prior asks for more than that
constexpr double kReached = 0.5;  // log evidence by which a fit may stay below its screening before it starts elsewhere
constexpr double kLeft =
    -3.0;  // log Bayes factor of structure in what a model leaves, below which no more effects are sought
constexpr double kHopeless =
    0.5;  // share of it that a pair may leave of what its best member left, for triples to be sought
constexpr std::size_t kMostRoots = 2;  // singles that pairs are sought from
constexpr int kMostMates = 6;          // class members fitted beyond those that screening kept
constexpr int kTested = 6;             // models whose remainder is tested for structure

using Members = std::vector<int>;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// All models fitted so far.
class Search {
 public:
  Search(const DiagnosisProblem& problem, const EvidenceSpace& space, const Selection* earlier)
      : problem_(problem), space_(space), earlier_(earlier) {}

  std::vector<ModelFit> models;
  long predictions = 0;

  [[nodiscard]] double value(const ModelFit& model) const {
    return log_weight(model, models.front().fit.log_evidence);  // none is fitted first
  }
  [[nodiscard]] const ModelFit* find(const Members& members) const {
    const auto found =
        std::find_if(models.begin(), models.end(), [&](const ModelFit& m) { return m.candidates == members; });
    return found == models.end() ? nullptr : &*found;
  }
  [[nodiscard]] const ModelFit* best(std::size_t size) const {
    const ModelFit* best = nullptr;
    for (const ModelFit& model : models)
      if (model.candidates.size() == size && model.fit.valid && (best == nullptr || value(model) > value(*best)))
        best = &model;
    return best;
  }
  /// `from` and the others of its size that its form may hide, best first.
  [[nodiscard]] std::vector<ModelFit> close_to(const ModelFit& from, std::size_t count) const {
    const double explained = from.fit.log_evidence - models.front().fit.log_evidence;
    std::vector<ModelFit> close;
    for (const ModelFit& model : models)
      if (model.candidates.size() == from.candidates.size() && value(model) >= value(from) - kFormMember * explained)
        close.push_back(model);
    std::stable_sort(close.begin(), close.end(),
                     [&](const ModelFit& a, const ModelFit& b) { return value(a) > value(b); });
    close.resize(std::min(close.size(), count));
    return close;
  }
  void fit_none() { add({ModelJob{{}, {problem_.hypotheses.nominal()}}}); }

  /// Fits `base` and one more candidate each, of the best `count` probes.
  void extend(const ModelFit& base, const std::vector<Probe>& probes, int count) {
    std::vector<int> order(probes.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(),
                     [&](int a, int b) { return probes[at(a)].score > probes[at(b)].score; });
    std::erase_if(order, [&](int c) {
      return !probes[at(c)].valid || (!base.candidates.empty() && probes[at(c)].score < kLeastGain);
    });
    order.resize(std::min(order.size(), at(count)));
    extend(base, probes, order);
  }
  void extend(const ModelFit& base, const std::vector<Probe>& probes, const std::vector<int>& which) {
    std::vector<ModelJob> jobs;
    for (const int c : which) {
      if (!probes[at(c)].valid) continue;
      ModelJob job;
      job.members = base.candidates;
      job.members.insert(std::upper_bound(job.members.begin(), job.members.end(), c), c);
      if (find(job.members) != nullptr) continue;
      job.starts = fit_starts(problem_, base.fit.p, c, probes[at(c)]);
      if (const Fit* known = base.candidates.empty() ? fitted_earlier(c) : nullptr)
        job.starts.insert(job.starts.begin(), known->p);
      job.enough = base.fit.log_evidence + probes[at(c)].score - kReached;
      jobs.push_back(job);
    }
    add(jobs);
  }

  /// log Bayes factor of smooth structure in what a model leaves.
  [[nodiscard]] double left(const ModelFit& model) const { return structure_evidence(problem_, space_, model.fit); }

  std::vector<Probe> probe(const ModelFit& base) {
    const Screening how = base.candidates.empty() ? Screening::ladder : Screening::steps;
    std::vector<Probe> probes = screen(problem_, space_, base.fit, how);
    for (const Probe& probe : probes) predictions += probe.predictions;
    return probes;
  }

 private:
  struct ModelJob {
    Members members;
    std::vector<Vector> starts;
    double enough = kInfinity;  ///< log evidence that screening promised
  };

  [[nodiscard]] const Fit* fitted_earlier(int c) const {
    if (earlier_ == nullptr) return nullptr;
    const auto found = std::find_if(earlier_->models.begin(), earlier_->models.end(),
                                    [&](const ModelFit& m) { return m.fit.valid && m.candidates == Members{c}; });
    return found == earlier_->models.end() ? nullptr : &found->fit;
  }

  void add(const std::vector<ModelJob>& jobs) {
    std::vector<ModelFit> fits(jobs.size());
    tbb::parallel_for(std::size_t{0}, jobs.size(), [&](std::size_t i) {
      ModelFit& model = fits[i];
      model.candidates = jobs[i].members;
      model.log_prior = log_prior(model.candidates.size(), problem_.hypotheses.candidates.size());
      FitOptions fitting;
      fitting.enough = jobs[i].enough;
      model.fit = fit_model(problem_, space_, problem_.hypotheses.freed_by(model.candidates), jobs[i].starts, fitting);
      if (model.candidates.size() == 1) model.fit = fit_around(problem_, space_, model.fit, fitting);
    });
    for (ModelFit& fit : fits) {
      predictions += fit.fit.predictions;
      models.push_back(std::move(fit));
    }
  }

  const DiagnosisProblem& problem_;
  const EvidenceSpace& space_;
  const Selection* earlier_;
};

/// Candidates whose columns, at either strength, reproduce the signature of a fitted model.
Members mates(const EvidenceSpace& space, const Vector& signature, const Matrix& nuisances,
              const std::vector<Probe>& probes, double equivalence) {
  Members found;
  for (std::size_t c = 0; c < probes.size(); ++c) {
    if (!probes[c].valid) continue;
    double energy = kInfinity;
    for (const Matrix* own : {&probes[c].small, &probes[c].full}) {
      Matrix all(space.rows, own->cols() + nuisances.cols());
      all << *own, nuisances;
      energy = std::min(energy, unexplained_energy(signature, all));
    }
    if (0.5 * energy < equivalence) found.push_back(static_cast<int>(c));
  }
  return found;
}

/// Equivalence classes of the fitted singles, by signature.
void add_classes(const EvidenceSpace& space, const ModelFit& none, const Search& search, double equivalence,
                 Selection& out) {
  out.equivalent.assign(out.probes.size(), {});
  for (const ModelFit& model : search.models) {
    if (model.candidates.size() != 1 || !model.fit.valid) continue;
    const int own = model.candidates.front();
    const Vector signature = none.fit.residual - model.fit.residual;
    Members others = mates(space, signature, none.fit.jacobian, out.probes, equivalence);
    std::erase(others, own);
    others.insert(others.begin(), own);
    out.equivalent[at(own)] = others;
  }
}

/// Backwards from the best set, and one for one: each member dropped, what is left fitted, and extended anew where it was not.
void exchange(Search& search, const ModelFit& best, const std::set<Members>& extended, int kept) {
  for (const int dropped : best.candidates) {
    Members rest = best.candidates;
    std::erase(rest, dropped);
    if (search.find(rest) == nullptr) {
      Members rest_of_rest = rest;
      const int again = rest_of_rest.back();
      rest_of_rest.pop_back();
      const ModelFit* root = search.find(rest_of_rest);
      if (root == nullptr) continue;
      const ModelFit copy = *root;
      search.extend(copy, search.probe(copy), std::vector<int>{again});
    }
    const ModelFit* smaller = search.find(rest);
    if (smaller == nullptr || !smaller->fit.valid || extended.contains(rest)) continue;
    const ModelFit copy = *smaller;
    search.extend(copy, search.probe(copy), kept);
  }
}

void search_larger(Search& search, const SelectionOptions& options) {
  for (std::size_t size = 2; size <= at(options.largest); ++size) {
    const ModelFit* base = search.best(size - 1);
    const ModelFit* before = search.best(size - 2);
    if (base == nullptr || before == nullptr || search.value(*base) < search.value(*before) + (size > 2 ? kGain : 0.0))
      return;
    const ModelFit from = *base;
    const double left = search.left(from);
    // A set that takes little off what its best member leaves is not on the way to an explanation.
    if (left < kLeft || (size > 2 && left > kHopeless * search.left(*before))) return;
    if (options.progress) options.progress(size == 2 ? "pairs of effects" : "triples of effects");
    // What the form of an effect may hide, a second effect may tell apart.
    std::set<Members> extended;
    for (const ModelFit& root : search.close_to(from, size == 2 ? kMostRoots : 1)) {
      search.extend(root, search.probe(root), options.kept_pairs);
      extended.insert(root.candidates);
    }
    const ModelFit* reached = search.best(size);
    if (reached == nullptr || search.value(*reached) < search.value(from)) return;
    const ModelFit best = *reached;
    exchange(search, best, extended, options.kept_pairs);
  }
}

/// Structure in what `none` leaves, and the models that lead with or without the form of effects counted.
void test_structure(const DiagnosisProblem& problem, const EvidenceSpace& space, std::vector<ModelFit>& models) {
  const double none = models.front().fit.log_evidence;
  std::vector<std::size_t> order(models.size()), tested;
  std::iota(order.begin(), order.end(), std::size_t{0});
  for (const double form : {kFormMember, 0.0}) {
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return log_weight(models[a], none, form) > log_weight(models[b], none, form);
    });
    for (std::size_t i = 0; i < order.size(); ++i)
      if (i < at(kTested) || models[order[i]].candidates.empty()) tested.push_back(order[i]);
  }
  std::sort(tested.begin(), tested.end());
  tested.erase(std::unique(tested.begin(), tested.end()), tested.end());
  tbb::parallel_for(std::size_t{0}, tested.size(), [&](std::size_t i) {
    ModelFit& model = models[tested[i]];
    if (model.fit.valid) model.structure = structure_evidence(problem, space, model.fit);
  });
}

}  // namespace

Selection select_models(const DiagnosisProblem& problem, const EvidenceSpace& space, const SelectionOptions& options,
                        const Selection* earlier) {
  Selection out;
  Search search(problem, space, earlier);
  search.fit_none();
  if (!search.models.front().fit.valid) return out;
  const ModelFit none = search.models.front();
  if (options.progress) options.progress("screening");
  out.probes = search.probe(none);
  if (options.progress) options.progress("single effects");
  search.extend(none, out.probes, options.kept);
  if (const ModelFit* best = search.best(1)) {
    Members class_mates =
        mates(space, none.fit.residual - best->fit.residual, none.fit.jacobian, out.probes, options.equivalence);
    std::stable_sort(class_mates.begin(), class_mates.end(),
                     [&](int a, int b) { return out.probes[at(a)].score > out.probes[at(b)].score; });
    std::erase_if(class_mates, [&](int c) { return search.find({c}) != nullptr; });
    class_mates.resize(std::min(class_mates.size(), at(kMostMates)));
    search.extend(none, out.probes, class_mates);
  }
  search_larger(search, options);
  add_classes(space, none, search, options.equivalence, out);
  out.models = std::move(search.models);
  out.predictions = search.predictions;
  test_structure(problem, space, out.models);
  weigh(out);
  return out;
}

}  // namespace jaculus
