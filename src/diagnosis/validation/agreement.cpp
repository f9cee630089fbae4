#include "diagnosis/validation/agreement.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "diagnosis/forward/unknown_gains.h"
#include "diagnosis/noise/alignment.h"
#include "diagnosis/noise/quantiles.h"
#include "diagnosis/validation/fit_to_others.h"

namespace jaculus::diagnosis {
namespace {

constexpr double kMilli = 1e3;  // ms a second

/// Sums over the segments in one bin of time.
struct Bin {
  double sum = 0.0;
  int count = 0;
  void add(double value) {
    sum += value;
    ++count;
  }
  [[nodiscard]] double mean() const { return sum / count; }
};

/// Root mean square of each channel of a dataset about rest, by predictions with clocks of their
/// own [unit]; NaN where a channel has no row after the command.
Vector channel_gaps(const Problem& problem, int dataset,
                    const std::vector<const Prediction*>& predictions, const Alignment& from) {
  const ObservedDataset& observed = problem.observations.datasets[dataset];
  const Alignment alignment = align(observed, predictions, from, problem.settings);
  const Vector residual =
      measured_rows(observed, alignment) - predicted_rows(observed, alignment, predictions);

  const int channels = count_of(observed.channels);
  std::vector<std::map<long, Bin>> bins(channels);
  std::vector<Bin> rest(channels);
  for (const RowSpan& span : row_spans(observed)) {
    const Segment& segment = observed.segments[span.segment];
    const double origin = alignment.origin(observed, span.segment, span.channel);
    for (int i = 0; i < span.count; ++i) {
      const double t = segment.time[span.channel][i] - origin;
      Bin& bin = t < 0.0 ? rest[span.channel]
                         : bins[span.channel][std::lround(t / segment.spacing[span.channel])];
      bin.add(residual[span.first + i]);
    }
  }

  Vector gaps(channels);
  for (int c = 0; c < channels; ++c) {
    const double offset = rest[c].count > 0 ? rest[c].mean() : 0.0;
    double squares = 0.0;
    for (const auto& [index, bin] : bins[c]) squares += std::pow(bin.mean() - offset, 2);
    gaps[c] = std::sqrt(squares / static_cast<double>(bins[c].size()));
  }
  return gaps;
}

/// The gaps of every dataset at p; empty where the simulation fails.
std::vector<Vector> gaps_at(const Problem& problem, const Comparison& comparison, const Vector& p) {
  const PredictionSet set = predict_all(problem, p);
  if (!set.valid) return {};
  std::vector<Vector> gaps;
  for (int d = 0; d < count_of(problem.observations.datasets); ++d)
    gaps.push_back(channel_gaps(problem, d, set.segments(problem.observations.datasets[d], d),
                                comparison.noise.alignments[d]));
  return gaps;
}

/// A dataset's gap, root of the mean over channels [noise floors].
double overall(const Comparison& comparison, int dataset, const Vector& gaps) {
  double sum = 0.0, count = 0.0;
  for (Eigen::Index c = 0; c < gaps.size(); ++c) {
    if (std::isnan(gaps[c])) continue;
    const double floor = comparison.noise.datasets[dataset].channels[c].noise_floor;
    sum += std::pow(gaps[c] / floor, 2);
    count += 1.0;
  }
  return std::sqrt(sum / count);
}

Fit fit_from(const Problem& problem, const Whitening& whitening, const std::vector<int>& free,
             const Vector& p, const Vector& scales) {
  FitOptions options;
  options.scales = scales;
  options.hold_scales = scales.size() == whitening.random.size() && scales.size() > 0;
  return fit_model(problem, whitening, free, {p}, options);
}

/// Gaps of each dataset where the model is fitted to the others. Empty vectors where it fails.
std::vector<Vector> held_out_gaps(const Problem& problem, const Comparison& comparison,
                                  const Fit& model) {
  const int count = count_of(problem.observations.datasets);
  std::vector<Vector> gaps(count);
  tbb::parallel_for(0, count, [&](int d) {
    SegmentMask mask;
    for (int own = 0; own < count; ++own)
      mask.emplace_back(problem.observations.datasets[own].segments.size(), own != d);
    const Whitening others = whitening_of(problem, comparison.noise, mask);
    const auto p = fit_to_others(problem, comparison.whitening, others, mask, model);
    if (!p) return;
    const std::vector<Vector> all = gaps_at(problem, comparison, *p);
    if (!all.empty()) gaps[d] = all[d];
  });
  return gaps;
}

std::vector<FittedUnknown> unknowns_of(const Problem& problem, const Fit& fit) {
  std::vector<FittedUnknown> unknowns;
  for (const int i : problem.hypotheses.gains) {
    const FreeParameter& own = problem.hypotheses.parameters[i];
    const int place = index_of(fit.free, i);
    const double half =
        quantiles::kTwoSided95Rounded * own.scale * std::sqrt(fit.covariance(place, place));
    const bool log = own.name.starts_with("log_"), clock = own.name.starts_with("clock");
    const auto shown = [&](double value) {
      return clock ? kMilli * value : log ? std::exp(value) : share_of_range(value);
    };
    unknowns.push_back({clock ? own.name : own.name.substr(own.name.find('_') + 1),
                        clock ? "ms later than its stamps"
                        : log ? "factor"
                              : "share of its stated range",
                        shown(fit.p[i]),
                        {shown(std::max(own.bounds.lower, fit.p[i] - half)),
                         shown(std::min(own.bounds.upper, fit.p[i] + half))},
                        fit.p[i] == own.bounds.lower || fit.p[i] == own.bounds.upper});
  }
  return unknowns;
}

/// Effects that the unknown gains of `none` can pass for.
std::vector<std::string> hidden_by_unknowns(const Problem& problem, const Comparison& comparison,
                                            const Fit& none, const std::vector<Probe>& probes) {
  std::vector<std::string> hidden;
  std::vector<Eigen::Index> gains;
  for (const int i : problem.hypotheses.gains) gains.push_back(index_of(none.free, i));
  if (gains.empty()) return hidden;

  const Matrix columns = none.jacobian(Eigen::all, gains);
  const double told = 2.0 * problem.settings.indistinguishable_below;
  for (int c = 0; c < count_of(probes); ++c) {
    if (!probes[c].valid) continue;
    const Vector signature = probes[c].full.col(0);
    const auto energy = [&](const Matrix& own) {
      return unexplained_energy(comparison.whitening.random, none.scales, signature, own, 0);
    };
    if (energy(Matrix(signature.size(), 0)) >= told && energy(columns) < told)
      hidden.push_back(problem.hypotheses.candidates[c].name);
  }
  return hidden;
}

/// Names every set that a member of the model harms.
void add_harm(const Problem& problem, const Comparison& comparison,
              const std::vector<int>& candidates, const Fit& model,
              const std::vector<Vector>& account, Agreement& agreement) {
  const double least = problem.settings.least_improvement;
  for (const int c : candidates) {
    std::vector<int> less = candidates;
    std::erase(less, c);
    Vector p = model.p;
    for (const int i : problem.hypotheses.candidates[c].parameters)
      p[i] = problem.hypotheses.parameters[i].nominal;
    const Fit without =
        fit_from(problem, comparison.whitening, problem.hypotheses.freed_by(less), p, model.scales);
    const std::vector<Vector> gaps =
        without.valid ? gaps_at(problem, comparison, without.p) : std::vector<Vector>();
    for (int d = 0; d < count_of(gaps); ++d)
      if (overall(comparison, d, gaps[d]) < (1.0 - least) * overall(comparison, d, account[d]))
        agreement.sets[d].harmed_by.push_back(problem.hypotheses.candidates[c].name);
  }
}

}  // namespace

std::vector<std::string> Agreement::channels() const {
  std::vector<std::string> names;
  for (const SetAgreement& set : sets)
    for (const ChannelAgreement& c : set.channels)
      if (std::find(names.begin(), names.end(), c.channel) == names.end())
        names.push_back(c.channel);
  return names;
}

double Agreement::explained(const std::string& channel, double ChannelAgreement::*after) const {
  double before = 0.0, left = 0.0;
  for (const SetAgreement& set : sets) {
    for (const ChannelAgreement& own : set.channels) {
      if (own.channel != channel) continue;
      before += own.stated * own.stated;
      left += std::pow(own.*after, 2);
    }
  }

  return before > 0.0 ? 1.0 - left / before : kNaN;
}

Agreement agreement_of(const Problem& problem, const Comparison& comparison, const Fit& none,
                       const std::vector<Probe>& probes, const std::vector<int>& candidates,
                       const Vector& p) {
  const std::vector<ObservedDataset>& datasets = problem.observations.datasets;
  Agreement agreement;
  if (datasets.size() < 2 && problem.hypotheses.gains.empty()) return agreement;
  const Fit model = candidates.empty() ? none
                                       : fit_from(problem, comparison.whitening,
                                                  problem.hypotheses.freed_by(candidates), p, {});
  if (!model.valid) return agreement;
  agreement.unknowns = unknowns_of(problem, model);
  agreement.hidden = hidden_by_unknowns(problem, comparison, none, probes);
  if (datasets.size() < 2) return agreement;

  const std::vector<Vector> account = gaps_at(problem, comparison, model.p);
  if (account.empty()) return agreement;
  const std::vector<Vector> stated = gaps_at(problem, comparison, problem.hypotheses.nominal());
  const std::vector<Vector> unknowns = gaps_at(problem, comparison, none.p);
  const std::vector<Vector> held_out = held_out_gaps(problem, comparison, model);

  for (int d = 0; d < count_of(datasets); ++d) {
    SetAgreement set{datasets[d].name(), {}, {}, false};
    for (int c = 0; c < count_of(datasets[d].channels); ++c) {
      const Channel& channel = datasets[d].channels[c];
      const double floor = comparison.noise.datasets[d].channels[c].noise_floor;
      set.channels.push_back({channel.stream, channel.name, channel.unit,
                              stated.empty() ? kNaN : stated[d][c],
                              unknowns.empty() ? kNaN : unknowns[d][c], account[d][c],
                              held_out[d].size() == 0 ? kNaN : held_out[d][c], floor});
    }
    agreement.sets.push_back(std::move(set));
  }

  add_harm(problem, comparison, candidates, model, account, agreement);
  const double least = problem.settings.least_improvement;
  for (int d = 0; d < count_of(datasets); ++d) {
    SetAgreement& set = agreement.sets[d];
    // A model as stated that can't be simulated is worse than any that can.
    const bool better = held_out[d].size() > 0 &&
                        (stated.empty() || overall(comparison, d, held_out[d]) <
                                               (1.0 - least) * overall(comparison, d, stated[d]));
    set.agrees = better && set.harmed_by.empty();
  }
  return agreement;
}

}  // namespace jaculus::diagnosis
