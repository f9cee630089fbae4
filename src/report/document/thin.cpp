#include "report/document/thin.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace jaculus::report {
namespace {

/// Indices that stay: first, last, and of each stretch the least and the largest value and a gap.
std::vector<std::size_t> kept(const std::vector<double>& y, std::size_t most) {
  std::vector<std::size_t> indices{0, y.size() - 1};
  const std::size_t stretches = std::max<std::size_t>(1, most / 2);
  for (std::size_t s = 0; s < stretches; ++s) {
    const std::size_t begin = s * y.size() / stretches, end = (s + 1) * y.size() / stretches;
    std::size_t least = begin, largest = begin;
    for (std::size_t i = begin; i < end; ++i) {
      if (std::isnan(y[i]) && (i == begin || !std::isnan(y[i - 1]))) indices.push_back(i);
      if (y[i] < y[least] || std::isnan(y[least])) least = i;
      if (y[i] > y[largest] || std::isnan(y[largest])) largest = i;
    }
    if (begin < end) indices.insert(indices.end(), {least, largest});
  }
  std::sort(indices.begin(), indices.end());
  indices.erase(std::unique(indices.begin(), indices.end()), indices.end());
  return indices;
}

void pick(std::vector<double>& values, const std::vector<std::size_t>& indices) {
  if (values.empty()) return;
  std::vector<double> picked;
  for (const std::size_t i : indices) picked.push_back(values[i]);
  values = std::move(picked);
}

}  // namespace

Document thinned(const Document& document, std::size_t most) {
  Document thin = document;
  for (Section& section : thin.sections) {
    for (Chart& chart : section.charts) {
      for (Series& series : chart.series) {
        if (series.y.size() <= most) continue;
        const std::vector<std::size_t> indices = kept(series.y, most);
        for (auto* values : {&series.x, &series.y, &series.low, &series.high})
          pick(*values, indices);
      }
    }
  }
  thin.notices.push_back(
      fmt::format("To keep this file small, series hold at most about {} points each, peaks among "
                  "them; the files "
                  "beside it have all.",
                  most));
  return thin;
}

}  // namespace jaculus::report
