// Selects the channels that count as evidence and cuts them to what the plan, the script or the
// logged input covers.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <optional>
#include <set>
#include <utility>

#include "diagnosis/data/evidence_channels.h"
#include "diagnosis/data/observations.h"
#include "diagnosis/data/partings.h"
#include "diagnosis/data/scatter.h"
#include "jaculus/simulation/experiment.h"
#include "jaculus/trajectory/log_checks.h"

namespace jaculus::diagnosis {
namespace {

using model::PlanarModel;
using trajectory::Dataset;
using trajectory::Stream;
using trajectory::Trial;

struct Samples {
  Vector time, value;
  int block = 1;
  double spacing = 0.0;
};

/// Samples of one channel within [from, to], gaps left out, averaged in blocks so that at most
/// `most` remain. A block never spans a gap: an average over one would stand at no instant.
Samples cut(const Stream& stream, int channel, double from, double to, int most, int fewest) {
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 0; i < stream.time.size(); ++i) {
    if (stream.time[i] < from || stream.time[i] > to || !std::isfinite(stream.values(channel, i)))
      continue;
    kept.push_back(i);
  }

  // Blocks by which at most `most` are left, and not fewer than `fewest`.
  const std::size_t wanted = (kept.size() + most - 1) / static_cast<std::size_t>(most);
  const std::size_t block =
      std::max<std::size_t>(1, std::min(wanted, kept.size() / static_cast<std::size_t>(fewest)));
  std::vector<double> times, values;
  for (std::size_t i = 0; i + block <= kept.size(); i += block) {
    if (kept[i + block - 1] - kept[i] != static_cast<Eigen::Index>(block) - 1) continue;
    const auto n = static_cast<Eigen::Index>(block);
    times.push_back(stream.time.segment(kept[i], n).mean());
    values.push_back(stream.values.row(channel).segment(kept[i], n).mean());
  }

  const double spacing = kept.size() > 1 ? (stream.time[kept.back()] - stream.time[kept.front()]) /
                                               static_cast<double>(kept.back() - kept.front())
                                         : 0.0;
  return {Eigen::Map<Vector>(times.data(), count_of(times)),
          Eigen::Map<Vector>(values.data(), count_of(values)), static_cast<int>(block), spacing};
}

/// Latest time at which any stream of the data has a sample.
double data_end(const Dataset& dataset) {
  double end = 0.0;
  for (const Trial& trial : dataset.trials)
    for (const Stream& stream : trial.streams)
      if (stream.time.size() > 0) end = std::max(end, stream.time[stream.time.size() - 1]);
  return end;
}

void set_window(ObservedDataset& observed, const Settings& settings) {
  const Dataset& dataset = observed.dataset;
  double end = data_end(dataset);
  if (dataset.plan) {
    const int column = dataset.plan->column("time");
    if (column >= 0 && dataset.plan->values.rows() > 0)
      end = std::min(end, dataset.plan->values.col(column).maxCoeff());
  }
  observed.window_start = -settings.rest_used;
  observed.window_end = end;
}

/// Rows of a channel in a segment at most: under a logged input no more than missing forces can
/// express.
int most_rows(const ObservedDataset& observed, double duration, const Settings& settings) {
  if (!observed.measured_input) return settings.samples;
  const double rows = std::ceil(settings.rows_of_box * duration / settings.force_box);
  return std::clamp(static_cast<int>(rows), settings.fewest_samples, settings.samples);
}

/// Adds the samples of every channel within [from, to].
void add_channels(const ObservedDataset& observed, const Trial& trial, double from, double to,
                  const Settings& settings, Segment& segment) {
  const int rows = most_rows(observed, to - from, settings);
  for (const Channel& channel : observed.channels) {
    const Stream* stream = trial.stream(channel.stream);
    const int index = stream != nullptr ? stream->channel(channel.name) : -1;
    Samples samples;
    const double begin = channel.zero_order_hold && !observed.measured_input
                             ? std::max(from, settings.command_settles)
                             : from;
    if (index >= 0) samples = cut(*stream, index, begin, to, rows, settings.fewest_samples);
    if (samples.time.size() < settings.fewest_samples) samples = {};
    segment.time.push_back(samples.time);
    segment.value.push_back(samples.value);
    segment.block.push_back(samples.block);
    segment.spacing.push_back(samples.spacing);
  }

  const double first = observed.measured_input ? segment.start : 0.0;
  const double last = observed.measured_input ? segment.end() : to;
  segment.prefix_end = first + settings.prefix_share * (last - first);
}

/// Least-squares parabola through samples about t: value and slope there; NaN where fewer than
/// settings.window_start_samples are near.
Vec2 local_fit(const Stream& stream, int channel, double t, const Settings& settings) {
  const double half_width = settings.window_start_half_width;
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  int count = 0;
  for (Eigen::Index i = 0; i < stream.time.size(); ++i) {
    const double dt = stream.time[i] - t;
    if (std::abs(dt) > half_width || !std::isfinite(stream.values(channel, i))) continue;
    const Eigen::Vector3d row(1.0, dt / half_width, dt * dt / (half_width * half_width));
    normal += row * row.transpose();
    right += row * stream.values(channel, i);
    ++count;
  }
  if (count < settings.window_start_samples) return Vec2::Constant(kNaN);
  const Eigen::Vector3d fit = normal.ldlt().solve(right);
  return {fit[0], fit[1] / half_width};
}

/// Initial coordinates of a window from the joints' own channels; false where one is missing.
bool measured_start(const ObservedDataset& observed, const Trial& trial, double t,
                    const Settings& settings, Segment& segment) {
  const int n = observed.model.size();
  segment.start_q = Vector::Zero(n);
  segment.start_v = Vector::Zero(n);

  for (int i = 0; i < n; ++i) {
    bool found = false;
    for (const Stream& stream : trial.streams) {
      const int channel = stream.channel(observed.model.coordinates[i].name);
      if (channel < 0) continue;
      const Vec2 fit = local_fit(stream, channel, t, settings);
      if (!fit.allFinite()) continue;
      segment.start_q[i] = fit[0];
      segment.start_v[i] = fit[1];
      found = true;
    }
    if (!found) return false;
  }

  return true;
}

/// The first time about which a parabola has samples on both sides. At the end of a log its slope
/// is told with 16 times the variance of its middle (3 and 48 sigma^2 a sample and half width), and
/// a robot that a dry friction holds does not answer a wrong rate in proportion.
double start_known(const ObservedDataset& observed, const Trial& trial, const Settings& settings) {
  double first = -kInfinity;
  for (const model::Coordinate& coordinate : observed.model.coordinates) {
    double own = kInfinity;
    for (const Stream& stream : trial.streams)
      if (stream.channel(coordinate.name) >= 0 && stream.time.size() > 0)
        own = std::min(own, stream.time[0]);
    if (std::isfinite(own)) first = std::max(first, own);
  }
  return first + settings.window_start_half_width;
}

/// The end of what a model of the plane can be held to within [from, to] of a trial.
double together_until(const std::vector<Sides>& sides, double from, double to,
                      std::vector<Parting>& partings) {
  const std::optional<Parting> found = first_parting(sides, from, to);
  if (!found) return to;
  partings.push_back(*found);
  return found->from;
}

void add(std::vector<Segment> more, std::vector<Segment>& segments) {
  std::move(more.begin(), more.end(), std::back_inserter(segments));
}

/// Where windows may begin, one after the other, beside what is left out of a trial; where that
/// leaves no room for one, as if nothing were [s].
std::vector<double> window_starts(double end, double length,
                                  const std::vector<TrialSpan>& left_out) {
  std::vector<double> starts;
  for (double from = 0.0; !left_out.empty() && from + length <= end;) {
    const auto taken = std::find_if(left_out.begin(), left_out.end(), [&](const TrialSpan& s) {
      return s.from < from + length && from < s.to;
    });
    if (taken == left_out.end()) starts.push_back(from);
    from = taken == left_out.end() ? from + length : taken->to;
  }

  const int possible = std::max(1, static_cast<int>(std::floor(end / length)));
  if (starts.empty())
    for (int k = 0; k < possible; ++k) starts.push_back(k * length);
  return starts;
}

/// Windows of a trial beside what is left out of it.
std::vector<Segment> cut_windows(const ObservedDataset& observed, int trial_index,
                                 const Settings& settings, const std::vector<TrialSpan>& left_out,
                                 std::vector<Parting>& partings) {
  const Trial& trial = observed.dataset.trials[trial_index];
  const double known = start_known(observed, trial, settings);
  const std::vector<Sides> sides = sides_of(observed, trial, settings);
  std::vector<Parting> of_windows;
  double end = 0.0;
  for (const Stream& stream : trial.streams)
    if (stream.time.size() > 0) end = std::max(end, stream.time[stream.time.size() - 1]);

  std::vector<Segment> windows;
  const std::vector<double> starts = window_starts(end, settings.window_length, left_out);
  const int free = count_of(starts), count = std::min(free, settings.windows);
  for (int w = 0; w < count; ++w) {
    const double grid =
        starts[static_cast<std::size_t>(std::floor(static_cast<double>(w) * free / count))];
    const double from = std::max(grid, known), to = std::min(end, grid + settings.window_length);
    if (from >= to) continue;
    Segment segment;
    segment.trial = trial_index;
    segment.start = from;
    if (!measured_start(observed, trial, from, settings, segment)) continue;
    add_channels(observed, trial, from, together_until(sides, from, to, of_windows), settings,
                 segment);
    windows.push_back(std::move(segment));
  }
  if (const auto one = as_one(of_windows)) partings.push_back(*one);
  return windows;
}

/// Trials that a plan or a script drove, whole until their sides part.
void cut_trials(ObservedDataset& observed, const Settings& settings,
                std::vector<Parting>& partings) {
  double latest = 0.0;
  for (int t = 0; t < count_of(observed.dataset.trials); ++t) {
    const Trial& trial = observed.dataset.trials[t];
    const double to =
        together_until(sides_of(observed, trial, settings), 0.0, observed.window_end, partings);
    Segment segment;
    segment.trial = t;
    add_channels(observed, trial, observed.window_start, to, settings, segment);
    observed.segments.push_back(std::move(segment));
    latest = std::max(latest, to);
  }
  observed.window_end = latest;
}

bool has_data(const Segment& segment) {
  return std::any_of(segment.time.begin(), segment.time.end(),
                     [](const Vector& t) { return t.size() > 0; });
}

/// Drops channels without samples, and constant ones: a dead sensor agrees with nothing and proves
/// nothing.
void drop_dead_channels(ObservedDataset& observed, const std::string& label,
                        std::vector<std::string>& notes) {
  for (std::size_t c = observed.channels.size(); c-- > 0;) {
    double least = kInfinity, most = -kInfinity;
    for (const Segment& segment : observed.segments) {
      if (segment.value[c].size() == 0) continue;
      least = std::min(least, segment.value[c].minCoeff());
      most = std::max(most, segment.value[c].maxCoeff());
    }
    if (most > least) continue;
    const std::string& name = observed.channels[c].name;
    notes.push_back(
        most < least
            ? fmt::format("{}: {} has too few samples in the window, or none but NaN: left out",
                          label, name)
            : fmt::format("{}: {} is constant (a dead sensor?): left out", label, name));
    observed = without_channel(std::move(observed), static_cast<int>(c));
  }
}

void find_copies(const ObservedDataset& observed, const std::string& label,
                 std::vector<std::string>& reasons) {
  if (observed.measured_input) return;
  for (std::size_t a = 0; a < observed.segments.size(); ++a) {
    for (std::size_t b = a + 1; b < observed.segments.size(); ++b) {
      bool same = has_data(observed.segments[a]);
      for (std::size_t c = 0; c < observed.channels.size() && same; ++c) {
        const Vector& u = observed.segments[a].value[c];
        const Vector& v = observed.segments[b].value[c];
        same = u.size() == v.size() && (u.size() == 0 || u == v);
      }
      if (!same) continue;
      const auto& trials = observed.dataset.trials;
      reasons.push_back(fmt::format(
          "{}: {} and {} are copies of one another, so nothing tells the noise", label,
          trials[observed.segments[a].trial].name, trials[observed.segments[b].trial].name));
      return;
    }
  }
}

void set_spacing(ObservedDataset& observed) {
  for (std::size_t c = 0; c < observed.channels.size(); ++c) {
    std::vector<double> gaps;
    for (const Segment& segment : observed.segments)
      for (Eigen::Index i = 1; i < segment.time[c].size(); ++i)
        gaps.push_back(segment.time[c][i] - segment.time[c][i - 1]);
    if (!gaps.empty()) observed.channels[c].spacing = median(std::move(gaps));
  }
}

ObservedDataset cut_dataset(const Dataset& dataset, const PlanarModel& model,
                            const Settings& settings, Observations& out) {
  ObservedDataset observed;
  observed.dataset = dataset;
  simulation::put_gains_at_motors(model, observed.dataset.controller);
  observed.model = model;
  observed.measured_input = dataset.controller.kind == trajectory::ControllerKind::measured;
  const std::string label = observed.name();
  simulation::require_units(dataset, model);
  select_channels(observed, label, out.notes);
  set_window(observed, settings);

  std::vector<Parting> partings;
  if (!observed.measured_input) cut_trials(observed, settings, partings);
  for (int t = 0; observed.measured_input && t < count_of(dataset.trials); ++t)
    add(cut_windows(observed, t, settings, {}, partings), observed.segments);
  const std::string plane =
      out_of_plane(dataset, label, observed.window_start, observed.window_end);
  if (!plane.empty()) out.notes.push_back(plane);
  if (!partings.empty()) out.notes.push_back(note_of(partings, count_of(observed.dataset.trials)));
  out.partings.insert(out.partings.end(), partings.begin(), partings.end());

  std::erase_if(observed.segments, [](const Segment& segment) { return !has_data(segment); });
  drop_dead_channels(observed, label, out.notes);
  std::erase_if(observed.segments, [](const Segment& segment) { return !has_data(segment); });
  set_spacing(observed);
  std::set<int> trials;
  for (const Segment& segment : observed.segments) trials.insert(segment.trial);
  observed.trials = count_of(trials);
  if (observed.segments.empty()) {
    out.insufficient.push_back(fmt::format(
        "{}: no channel has {} or more samples between {:.3g} s and {:.3g} s that the plant "
        "predicts",
        label, settings.fewest_samples, observed.window_start, observed.window_end));
  }

  find_copies(observed, label, out.insufficient);
  for (const trajectory::RateContradiction& found : trajectory::rate_contradictions(dataset))
    if (model.body_of_joint(found.channel) >= 0 || model.coordinate_index(found.channel) >= 0)
      out.insufficient.push_back(
          fmt::format("{}: {}; mend the log's units or signs first", label, to_text(found)));
  return observed;
}

}  // namespace

Observations observe(const std::vector<Dataset>& datasets, const std::vector<PlanarModel>& models,
                     const Settings& settings) {
  Observations out;
  for (std::size_t i = 0; i < datasets.size(); ++i) {
    ObservedDataset observed = cut_dataset(datasets[i], models[i], settings, out);
    if (!observed.segments.empty()) out.datasets.push_back(std::move(observed));
  }
  return out;
}

Observations with_windows_beside(Observations observations, const std::vector<TrialSpan>& left_out,
                                 const Settings& settings) {
  for (int d = 0; d < count_of(observations.datasets); ++d) {
    ObservedDataset& observed = observations.datasets[d];
    if (!observed.measured_input) continue;
    std::vector<Segment> windows;
    for (int t = 0; t < count_of(observed.dataset.trials); ++t) {
      std::vector<TrialSpan> of_trial;
      for (const TrialSpan& span : left_out)
        if (span.dataset == d && span.trial == t) of_trial.push_back(span);
      std::vector<Parting> known;  // told when all windows were cut
      std::vector<Segment> anew = cut_windows(observed, t, settings, of_trial, known);
      std::erase_if(anew, [](const Segment& segment) { return !has_data(segment); });
      if (anew.empty())
        std::copy_if(observed.segments.begin(), observed.segments.end(), std::back_inserter(anew),
                     [&](const Segment& segment) { return segment.trial == t; });
      add(std::move(anew), windows);
    }
    observed.segments = std::move(windows);
    set_spacing(observed);
  }
  return observations;
}

}  // namespace jaculus::diagnosis
