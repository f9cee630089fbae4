#include "diagnosis/localise/departure.h"

#include <Eigen/QR>
#include <algorithm>
#include <boost/math/special_functions/erf.hpp>
#include <cassert>
#include <cmath>

#include "diagnosis/noise/quantiles.h"

namespace jaculus::diagnosis {
namespace {

struct Sample {
  double time = 0.0;
  int channel = 0;
  double z = 0.0;
};

std::vector<Sample> standardised(const std::vector<DepartureChannel>& channels, double until) {
  std::vector<Sample> samples;
  for (int c = 0; c < count_of(channels); ++c) {
    for (Eigen::Index k = 0; k < channels[c].time.size(); ++k) {
      if (channels[c].time[k] > until || !std::isfinite(channels[c].mean[k])) continue;
      samples.push_back({channels[c].time[k], c, channels[c].mean[k] / channels[c].error[k]});
    }
  }
  std::stable_sort(samples.begin(), samples.end(),
                   [](const Sample& a, const Sample& b) { return a.time < b.time; });
  return samples;
}

/// Whether any channel's latest sample is out, at each sample.
std::vector<char> any_out(const std::vector<Sample>& samples, int channels, double band) {
  std::vector<char> out(channels, 0), any;
  any.reserve(samples.size());
  int count = 0;
  for (const Sample& s : samples) {
    char& mine = out[s.channel];
    const char now = std::abs(s.z) > band ? 1 : 0;
    count += now - mine;
    mine = now;
    any.push_back(count > 0 ? 1 : 0);
  }
  return any;
}

/// Index of the first sample from which on the band is left for good; -1 where there is none.
int crossing(const std::vector<Sample>& samples, const std::vector<char>& any,
             const Settings& settings) {
  const int n = count_of(samples);
  std::vector<int> after(n + 1, 0);
  for (int i = n - 1; i >= 0; --i) after[i] = after[i + 1] + any[i];
  for (int i = 0; i < n; ++i) {
    if (any[i] == 0 || after[i] < settings.departure_stays * (n - i) ||
        n - i < settings.departure_fewest)
      continue;
    bool at_once = true;
    const double until = samples[i].time + settings.departure_unbroken;
    for (int j = i; j < n && samples[j].time <= until; ++j) at_once &= any[j] != 0;
    if (at_once) return i;
  }
  return -1;
}

/// chi2 of the hinge model with its onset at t0, over all channels up to `end`.
double hinge_chi2(const std::vector<DepartureChannel>& channels, double t0, double end) {
  double chi2 = 0.0;
  for (const DepartureChannel& c : channels) {
    double energy = 0.0;
    std::vector<double> y, s, weight;
    for (Eigen::Index k = 0; k < c.time.size() && c.time[k] <= end; ++k) {
      if (!std::isfinite(c.mean[k])) continue;
      if (c.time[k] > t0) {
        s.push_back((c.time[k] - t0) / (end - t0));
        y.push_back(c.mean[k] / c.error[k]);
        weight.push_back(1.0 / c.error[k]);
      } else {
        energy += std::pow(c.mean[k] / c.error[k], 2);
      }
    }
    const auto n = count_of(y);
    if (n > 0) {
      const Eigen::Map<const Vector> tau(s.data(), n);
      const Eigen::Map<const Vector> value(y.data(), n);
      const Vector square = tau.cwiseAbs2();
      Matrix basis(n, n > 1 ? 2 : 1);
      basis.col(0) = c.rate ? tau : square;
      if (n > 1) basis.col(1) = c.rate ? square : Vector(square.cwiseProduct(tau));
      basis = Eigen::Map<const Vector>(weight.data(), n).asDiagonal() * basis;
      energy += (value - basis * basis.colPivHouseholderQr().solve(value)).squaredNorm();
    }
    chi2 += energy / c.inflation;
  }

  return chi2;
}

/// How long after the crossing the hinge is fitted: some samples of every channel that is out.
double fit_end(const std::vector<DepartureChannel>& channels, double crossing, double until,
               const Settings& settings) {
  double longest = settings.onset_shortest;
  for (const DepartureChannel& c : channels) {
    if (c.time.size() < 2) continue;
    const double period =
        (c.time[c.time.size() - 1] - c.time[0]) / static_cast<double>(c.time.size() - 1);
    longest = std::max(longest, std::min(settings.onset_samples * period, settings.onset_longest));
  }
  return std::min(until, crossing + longest);
}

void fit_onset(const std::vector<DepartureChannel>& channels, double begin, double until,
               const Settings& settings, Departure& d) {
  const double end = fit_end(channels, d.crossing, until, settings);
  double rows = 0.0;
  for (const DepartureChannel& c : channels)
    rows += static_cast<double>((c.time.array() <= end).count()) / c.inflation;
  std::vector<double> onset, chi2;
  for (double t0 = begin; t0 < d.crossing; t0 += settings.onset_step) {
    onset.push_back(t0);
    chi2.push_back(hinge_chi2(channels, t0, end));
  }

  if (onset.empty()) {
    d.time = d.crossing;
    d.ci95 = {begin, d.crossing};
    return;
  }

  const std::size_t best = std::min_element(chi2.begin(), chi2.end()) - chi2.begin();
  d.time = onset[best];
  const double scale = std::max(1.0, chi2[best] / std::max(1.0, rows));
  d.ci95 = {d.time, d.time};
  for (std::size_t i = 0; i < onset.size(); ++i) {
    if ((chi2[i] - chi2[best]) / scale > quantiles::kChi2Of95) continue;
    d.ci95.lower = std::min(d.ci95.lower, onset[i]);
    d.ci95.upper = std::max(d.ci95.upper, onset[i]);
  }
}

/// Names of the channels that are out within `reach` of the crossing, farthest first.
std::vector<std::string> channels_out(const std::vector<DepartureChannel>& channels,
                                      const std::vector<Sample>& samples, const Departure& d,
                                      double reach) {
  std::vector<std::pair<double, int>> out;
  for (int c = 0; c < count_of(channels); ++c) {
    double z = 0.0;
    for (const Sample& s : samples)
      if (s.channel == c && std::abs(s.time - d.crossing) <= reach) z = std::max(z, std::abs(s.z));
    if (z > d.band) out.emplace_back(-z, c);
  }
  std::sort(out.begin(), out.end());

  std::vector<std::string> names;
  for (const auto& [z, c] : out) names.push_back(channels[c].name);
  return names;
}

}  // namespace

Departure first_departure(const std::vector<DepartureChannel>& channels, const Settings& settings,
                          double until) {
  Departure d;
  const std::vector<Sample> samples = standardised(channels, until);
  double tests = 0.0;
  for (const DepartureChannel& c : channels) {
    assert(c.error.size() == c.time.size() && c.mean.size() == c.time.size() && c.inflation >= 1.0);
    tests += static_cast<double>((c.time.array() <= until).count()) / c.inflation;
  }
  if (samples.empty()) return d;

  tests = std::max(tests, static_cast<double>(channels.size()));
  d.band = std::sqrt(2.0) * boost::math::erfc_inv(settings.departure_level / tests);
  double farthest = 0.0;
  for (const Sample& s : samples) farthest = std::max(farthest, std::abs(s.z));
  d.false_alarm = std::min(1.0, tests * std::erfc(farthest / std::sqrt(2.0)));
  const std::vector<char> any = any_out(samples, count_of(channels), d.band);
  const int first = crossing(samples, any, settings);
  if (first < 0) return d;

  d.found = true;
  d.crossing = samples[first].time;
  d.channels = channels_out(channels, samples, d, 2.0 * settings.departure_unbroken);
  fit_onset(channels, samples.front().time, until, settings, d);
  return d;
}

}  // namespace jaculus::diagnosis
