// Rows of a dataset and their order. Selection and cutting are in observe.cpp.

#include "diagnosis/data/observations.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace jaculus::diagnosis {
namespace {

/// Which of `own` windows `kept` are: one of each equal part, at places that spread evenly over the
/// parts (golden ratio sequence: Schretter, Kobbelt and Dehaye 2012). At one place of each they
/// would all be of one moment of the motion where a trial has as many windows as a part.
std::vector<int> spread_over(int own, int kept) {
  std::vector<int> chosen;
  for (int k = 0; k < kept; ++k) {
    const int from = k * own / kept, to = (k + 1) * own / kept;
    const double turns = (k + 0.5) * std::numbers::phi;
    chosen.push_back(from + static_cast<int>((turns - std::floor(turns)) * (to - from)));
  }
  return chosen;
}

}  // namespace

double Segment::end() const {
  double last = start;
  for (const Vector& t : time)
    if (t.size() > 0) last = std::max(last, t[t.size() - 1]);
  return last;
}

int ObservedDataset::rows() const {
  int count = 0;
  for (const Segment& segment : segments)
    for (const Vector& time : segment.time) count += count_of(time);
  return count;
}

std::string ObservedDataset::name() const { return dataset.folder.filename().string(); }

int ObservedDataset::stream_index(const std::string& stream) const {
  return index_of(streams, stream);
}

int ObservedDataset::stream_of(int channel) const { return stream_index(channels[channel].stream); }

bool motion_alone(const ObservedDataset& observed) {
  return std::all_of(observed.channels.begin(), observed.channels.end(), [](const Channel& c) {
    using trajectory::Quantity;
    const Quantity quantity = trajectory::parse_channel(c.name).quantity;
    return quantity == Quantity::position || quantity == Quantity::velocity;
  });
}

bool tracked_alone(const ObservedDataset& observed) {
  return std::all_of(observed.channels.begin(), observed.channels.end(), [](const Channel& c) {
    return c.name == "x" || c.name == "z" || c.name == "pitch";
  });
}

ObservedDataset without_channel(ObservedDataset observed, int channel) {
  const auto drop = [channel](auto& list) { list.erase(list.begin() + channel); };

  drop(observed.channels);
  for (Segment& segment : observed.segments) {
    drop(segment.time);
    drop(segment.value);
    drop(segment.block);
    drop(segment.spacing);
  }

  return observed;
}

Observations without_channels(Observations observations, const std::vector<ChannelPlace>& dropped) {
  std::vector<ChannelPlace> last_first = dropped;
  std::sort(last_first.begin(), last_first.end(),
            [](const ChannelPlace& a, const ChannelPlace& b) { return a.channel > b.channel; });

  for (const ChannelPlace& place : last_first) {
    ObservedDataset& observed = observations.datasets[place.dataset];
    observed = without_channel(std::move(observed), place.channel);
  }
  std::erase_if(observations.datasets, [](const ObservedDataset& d) { return d.rows() == 0; });

  return observations;
}

Observations without_tails(Observations observations, const std::vector<SegmentTail>& dropped) {
  for (const SegmentTail& tail : dropped) {
    Segment& segment = observations.datasets[tail.dataset].segments[tail.segment];
    for (std::size_t c = 0; c < segment.time.size(); ++c) {
      const Vector& time = segment.time[c];
      const auto kept = std::lower_bound(time.begin(), time.end(), tail.from) - time.begin();
      segment.time[c].conservativeResize(kept);
      segment.value[c].conservativeResize(kept);
    }
  }

  return observations;
}

int windows_of(const Observations& observations) {
  int all = 0;
  for (const ObservedDataset& observed : observations.datasets)
    if (observed.measured_input) all += count_of(observed.segments);
  return all;
}

Observations with_windows(Observations observations, int most) {
  const int all = windows_of(observations);
  if (all <= most) return observations;

  for (ObservedDataset& observed : observations.datasets) {
    const int own = count_of(observed.segments);
    const int kept = std::min(own, std::max(2, own * most / all));
    if (!observed.measured_input || kept == own) continue;
    std::vector<Segment> spread;
    for (const int s : spread_over(own, kept)) spread.push_back(observed.segments[s]);
    observed.segments = std::move(spread);
  }
  return observations;
}

std::vector<RowSpan> row_spans(const ObservedDataset& observed) {
  std::vector<RowSpan> spans;
  int first = 0;
  for (int s = 0; s < count_of(observed.segments); ++s) {
    for (int c = 0; c < count_of(observed.channels); ++c) {
      const int count = count_of(observed.segments[s].time[c]);
      if (count > 0) spans.push_back({s, c, first, count});
      first += count;
    }
  }
  return spans;
}

}  // namespace jaculus::diagnosis
