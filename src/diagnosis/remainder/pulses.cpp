#include "diagnosis/remainder/pulses.h"

#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <boost/math/special_functions/erf.hpp>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>
#include <optional>
#include <utility>

#include "diagnosis/data/scatter.h"

namespace jaculus::diagnosis {
namespace {

constexpr double kMedianOfNormal = 0.6745;  ///< median of |x| of a normal number
constexpr double kFreedom = 4.0;            ///< degrees of freedom of Student's t
constexpr int kRounds = 60;                 ///< of the fit, beyond which nothing moves by 1e-3
constexpr double kLeast = std::numeric_limits<double>::min();
constexpr Eigen::Index kFewestBoxes = 40;
constexpr std::array kLengths = {2, 3, 4, 6, 8, 10, 12};  ///< of pulses, in boxes
constexpr int kLeeway = 2;          ///< boxes that the middle of the likeliest pulse may lie aside
constexpr double kRepeats = 0.5;    ///< share of a pulse that other trials have as well
constexpr double kSameTime = 0.25;  ///< of a box

double usual_size(std::vector<double> values) {
  for (double& value : values) value = std::abs(value);
  return median(std::move(values)) / kMedianOfNormal;
}

/// A pulse's share of its peak in each of `count` boxes.
Vector half_sine(int count) {
  Vector shape(count);
  for (int k = 0; k < count; ++k)
    shape[k] = std::sin(std::numbers::pi * (k + 0.5) / static_cast<double>(count));
  return shape;
}

/// Amplitude of a pulse, that over its standard deviation as if boxes were independent, and this
/// over its usual size.
struct Matched {
  double amplitude = 0.0, alone = 0.0, deviations = 0.0;
};

Matched match(const UsualForce& usual, int first, const Vector& shape) {
  const Eigen::Index count = shape.size();
  const Eigen::ArrayXd weight = shape.array() / usual.variance.segment(first, count).array();
  const double own = (weight * usual.residual.segment(first, count).array()).sum();
  const double information = (weight * shape.array()).sum();
  return {own / information, own / std::sqrt(information), kNaN};
}

/// Matched filters by first box and count, over runs of boxes without a gap.
struct Filters {
  std::map<std::pair<int, int>, Matched> all;
  std::map<int, double> usually;  ///< size of `alone`, by count

  [[nodiscard]] const Matched& at(int first, int count) const { return all.at({first, count}); }
  [[nodiscard]] bool has(int first, int count) const { return all.contains({first, count}); }
};

bool follow_one_another(const ForceBoxes& boxes, int first, int count) {
  const int last = first + count - 1;
  if (first < 0 || last >= boxes.time.size() || boxes.trial[first] != boxes.trial[last])
    return false;
  const double apart = boxes.time[last] - boxes.time[first];
  return std::abs(apart - (count - 1) * boxes.length) < kSameTime * boxes.length;
}

/// `least`: usual sizes are no less than these.
Filters matched_filters(const ForceBoxes& boxes, const UsualForce& usual,
                        const std::function<Vector(int)>& shape, const Filters* least) {
  Filters filters;
  for (int count = kLengths.front(); count <= kLengths.back() + 2; ++count) {
    std::vector<double> sizes;
    for (int first = 0; first < boxes.time.size(); ++first) {
      if (!follow_one_another(boxes, first, count)) continue;
      const Matched matched = match(usual, first, shape(count));
      filters.all[{first, count}] = matched;
      sizes.push_back(matched.alone);
    }
    if (sizes.empty()) continue;
    double usually = usual_size(std::move(sizes));
    if (least != nullptr && least->usually.contains(count))
      usually = std::max(usually, least->usually.at(count));
    filters.usually[count] = usually;
    for (auto& [place, matched] : filters.all)
      if (place.second == count) matched.deviations = matched.alone / usually;
  }
  return filters;
}

/// z of a pulse, or of the mean force over its boxes or these and one more at either side, where
/// that is nearer to zero.
double steady_deviations(const Filters& pulses, const Filters& means, int first, int count) {
  const double own = pulses.at(first, count).deviations;
  double least = own;
  for (const auto& [before, more] :
       {std::pair(0, 0), std::pair(1, 1), std::pair(0, 1), std::pair(1, 2)}) {
    if (!means.has(first - before, count + more)) continue;
    const double mean = means.at(first - before, count + more).deviations;
    if (mean * own <= 0.0) return 0.0;
    if (std::abs(mean) < std::abs(least)) least = mean;
  }
  return least;
}

/// The likeliest pulse of the same sign about the middle of one that was found.
std::pair<int, int> likeliest(const Filters& filters, const ForceBoxes& boxes, int first,
                              int count) {
  const double middle = first + 0.5 * (count - 1), sign = filters.at(first, count).amplitude;
  std::pair<int, int> best{first, count};
  double most = 0.0;
  for (const int length : kLengths) {
    for (int from = std::max(0, first - length); from <= first + count; ++from) {
      if (!filters.has(from, length) || boxes.trial[from] != boxes.trial[first]) continue;
      const Matched& found = filters.at(from, length);
      const bool near = std::abs(from + 0.5 * (length - 1) - middle) <= kLeeway;
      if (!near || found.amplitude * sign <= 0.0) continue;
      if (std::abs(found.alone) <= most) continue;
      most = std::abs(found.alone);
      best = {from, length};
    }
  }
  return best;
}

/// The same boxes of time in another trial; none where it hasn't all of them.
std::optional<int> same_time(const ForceBoxes& boxes, int trial, int first, int count) {
  for (int i = 0; i < boxes.time.size(); ++i)
    if (boxes.trial[i] == trial &&
        std::abs(boxes.time[i] - boxes.time[first]) < kSameTime * boxes.length)
      return follow_one_another(boxes, i, count) ? std::optional(i) : std::nullopt;
  return std::nullopt;
}

/// Of trials that have a pulse's boxes at the same time, how many, how many have a good part of it,
/// and the first such one's first box. `but`: not asked.
struct Alike {
  int trials = 0, alike = 0, first = -1;
  [[nodiscard]] bool most() const { return trials > 0 && 2 * alike > trials; }
};
Alike alike_at(const ForceBoxes& boxes, const UsualForce& usual, int first, int count,
               double amplitude, int but) {
  Alike found;
  for (int trial = 0; trial <= *std::max_element(boxes.trial.begin(), boxes.trial.end()); ++trial) {
    if (trial == but) continue;
    const std::optional<int> there = same_time(boxes, trial, first, count);
    if (!there) continue;
    ++found.trials;
    if (match(usual, *there, half_sine(count)).amplitude / amplitude < kRepeats) continue;
    if (found.alike++ == 0) found.first = *there;
  }
  return found;
}

/// Whether two pulses are one: overlap in a trial, or in time where one is in every trial.
bool same_pulse(const ForceBoxes& boxes, const Pulse& a, const Pulse& b) {
  const bool one_trial = boxes.trial[a.first] == boxes.trial[b.first];
  if (one_trial) return a.first <= b.last + 1 && b.first <= a.last + 1;
  const bool together = boxes.time[a.first] <= boxes.time[b.last] + boxes.length &&
                        boxes.time[b.first] <= boxes.time[a.last] + boxes.length;
  return (a.every_trial || b.every_trial) && together && a.peak * b.peak > 0.0;
}

/// A series of boxes with how it is usually wrong and what pulses are in it.
struct Series {
  const ForceBoxes& boxes;
  const UsualForce& usual;
  Filters pulses, means;
};
Series series_of(const ForceBoxes& boxes, const UsualForce& usual, const Series* least) {
  const auto level = [](int count) -> Vector { return Vector::Ones(count); };
  return {boxes, usual,
          matched_filters(boxes, usual, half_sine, least == nullptr ? nullptr : &least->pulses),
          matched_filters(boxes, usual, level, least == nullptr ? nullptr : &least->means)};
}

/// The mean over trials at the same time, as a trial of its own.
struct OverTrials {
  ForceBoxes boxes;
  UsualForce usual;
  std::vector<int> box;  ///< one of those that each is the mean of
};

/// Of boxes that more than half of the trials have at the same time; none where trials don't share
/// their times.
OverTrials over_trials(const ForceBoxes& all, const UsualForce& usual) {
  const int trials = *std::max_element(all.trial.begin(), all.trial.end()) + 1;
  std::vector<int> order(all.trial.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return all.time[a] < all.time[b]; });

  OverTrials mean;
  std::vector<double> time, residual, variance;
  for (auto from = order.begin(), to = from; from != order.end(); from = to) {
    double told = 0.0, sum = 0.0;
    for (; to != order.end() && all.time[*to] - all.time[*from] < kSameTime * all.length; ++to) {
      told += 1.0 / usual.variance[*to];
      sum += usual.residual[*to] / usual.variance[*to];
    }
    const auto alike = to - from;
    if (alike < 2 || 2 * alike <= trials) continue;
    mean.box.push_back(*from);
    time.push_back(all.time[*from]);
    residual.push_back(sum / told);
    variance.push_back(1.0 / told);
  }

  const auto vector = [](const std::vector<double>& of) -> Vector {
    return Eigen::Map<const Vector>(of.data(), std::ssize(of));
  };
  mean.boxes = {all.length, std::vector<int>(time.size(), 0), vector(time), vector(residual), {},
                {}};
  mean.usual = {vector(residual), vector(variance)};
  return mean;
}

/// A place of a pulse in a series, and how unusual it is there.
struct Tried {
  int first, count;
  double deviations;
  bool over_trials;
};
void add_tried(const Series& series, bool over_trials, std::vector<Tried>& tried) {
  for (const int count : kLengths)
    for (int first = 0; first < series.boxes.time.size(); ++first)
      if (series.pulses.has(first, count))
        tried.push_back({first, count,
                         std::abs(steady_deviations(series.pulses, series.means, first, count)),
                         over_trials});
}

}  // namespace

UsualForce usual_force(const ForceBoxes& boxes) {
  const Vector& f = boxes.force;
  const Eigen::RowVectorXd mean = boxes.spreads.colwise().mean();
  const Matrix spreads = boxes.spreads * mean.cwiseMax(kLeast).cwiseInverse().asDiagonal();
  const double size = usual_size({f.begin(), f.end()});
  UsualForce usual{f, Vector::Constant(f.size(), size * size)};
  Vector c = Vector::Constant(spreads.cols(), size * size / static_cast<double>(spreads.cols()));
  Vector weight = Vector::Ones(f.size());

  for (int round = 0; round < kRounds; ++round) {
    const Vector root = (weight.array() / usual.variance.array()).sqrt();
    const Matrix weighted = root.asDiagonal() * boxes.follows;
    const Vector b =
        weighted.completeOrthogonalDecomposition().solve((root.array() * f.array()).matrix());
    usual.residual = f - boxes.follows * b;

    const Eigen::ArrayXd square = usual.residual.array().square();
    weight = (kFreedom + 1.0) / (kFreedom + square / usual.variance.array());
    const Vector raised = weight.array() * square / usual.variance.array().square();
    const Vector told = usual.variance.cwiseInverse();
    c.array() *=
        ((spreads.transpose() * raised).array() / (spreads.transpose() * told).array()).sqrt();
    usual.variance = spreads * c;
  }
  return usual;
}

std::vector<Pulse> unusual_pulses(const ForceBoxes& boxes, double level) {
  if (boxes.time.size() < kFewestBoxes || usual_size({boxes.force.begin(), boxes.force.end()}) <= 0)
    return {};
  const UsualForce usual = usual_force(boxes);
  const Series alone = series_of(boxes, usual, nullptr);
  const OverTrials mean = over_trials(boxes, usual);
  const Series together = series_of(mean.boxes, mean.usual, &alone);
  std::vector<Tried> tried;
  add_tried(alone, false, tried);
  add_tried(together, true, tried);
  if (tried.empty()) return {};

  const auto number = static_cast<double>(tried.size());
  const double bound = std::numbers::sqrt2 * boost::math::erfc_inv(level / number);
  std::erase_if(tried, [&](const Tried& own) { return !(own.deviations > bound); });
  std::stable_sort(tried.begin(), tried.end(),
                   [](const Tried& a, const Tried& b) { return a.deviations > b.deviations; });

  std::vector<Pulse> found;
  for (const Tried& own : tried) {
    const Series& series = own.over_trials ? together : alone;
    const auto [first, count] = likeliest(series.pulses, series.boxes, own.first, own.count);
    const double peak = series.pulses.at(first, count).amplitude;
    const double chance = number * std::erfc(own.deviations / std::numbers::sqrt2);
    const int place = own.over_trials ? mean.box[first] : first;
    const int found_in = own.over_trials ? -1 : boxes.trial[first];
    const Alike alike = alike_at(boxes, usual, place, count, peak, found_in);
    if (own.over_trials && !alike.most()) continue;  // of one trial, and found there

    const int begin = own.over_trials ? alike.first : first;
    const Pulse pulse{begin, begin + count - 1, peak, 1.0 - std::min(1.0, chance), alike.most()};
    const Pulse as_tried =
        own.over_trials ? pulse : Pulse{own.first, own.first + own.count - 1, peak, 0.0, false};
    if (std::none_of(found.begin(), found.end(), [&](const Pulse& known) {
          return same_pulse(boxes, known, pulse) || same_pulse(boxes, known, as_tried);
        }))
      found.push_back(pulse);
  }
  return found;
}

}  // namespace jaculus::diagnosis
