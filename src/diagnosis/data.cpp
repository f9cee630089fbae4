// Rows of a condition and their order. Selection and cutting are in observe.cpp.

#include "jaculus/diagnosis/data.h"

#include <cstddef>

namespace jaculus {

int Condition::rows() const {
  int count = 0;
  for (const Run& run : runs)
    for (const Vector& time : run.time) count += static_cast<int>(time.size());
  return count;
}

int Condition::stream_index(const std::string& name) const {
  for (std::size_t i = 0; i < streams.size(); ++i)
    if (streams[i] == name) return static_cast<int>(i);
  return -1;
}

std::vector<RowSpan> row_spans(const Condition& condition) {
  std::vector<RowSpan> spans;
  int first = 0;
  for (std::size_t r = 0; r < condition.runs.size(); ++r) {
    for (std::size_t c = 0; c < condition.channels.size(); ++c) {
      const int count = static_cast<int>(condition.runs[r].time[c].size());
      if (count > 0) spans.push_back({static_cast<int>(r), static_cast<int>(c), first, count});
      first += count;
    }
  }
  return spans;
}

Vector measured_rows(const Condition& condition) {
  Vector rows(condition.rows());
  for (const RowSpan& span : row_spans(condition)) {
    rows.segment(span.first, span.count) =
        condition.runs[static_cast<std::size_t>(span.run)].value[static_cast<std::size_t>(span.channel)];
  }
  return rows;
}

void drop_channel(Condition& condition, std::size_t channel) {
  const auto drop = [&](auto& list) {
    if (channel < list.size()) list.erase(list.begin() + static_cast<std::ptrdiff_t>(channel));
  };
  drop(condition.channels);
  for (Run& run : condition.runs) {
    drop(run.time);
    drop(run.value);
    drop(run.recorded);
    drop(run.block);
    drop(run.spacing);
  }
}

}  // namespace jaculus
