#include "studies/search.h"

#include <boost/math/tools/minima.hpp>
#include <cassert>
#include <cmath>
#include <limits>

namespace jaculus::studies {
namespace {

constexpr int kScanPoints = 64;

void consider(double argument, double value, SearchResult& best) {
  ++best.evaluations;
  if (value > best.value) {
    best.value = value;
    best.argument = argument;
  }
}

}  // namespace

SearchResult maximise(const SearchSpace& space, const std::function<double(double)>& value) {
  assert(space.lower <= space.upper);
  SearchResult best;

  const double first = space.integer ? std::ceil(space.lower) : space.lower;
  const double last = space.integer ? std::floor(space.upper) : space.upper;
  assert(first <= last);
  const double step = space.integer ? 1.0 : (last - first) / (kScanPoints - 1);
  const int count = step > 0.0 ? static_cast<int>(std::lround((last - first) / step)) + 1 : 1;

  for (int i = 0; i < count; ++i) {
    const double x = i + 1 == count ? last : first + i * step;
    consider(x, value(x), best);
  }

  if (!space.integer && std::isfinite(best.value) && step > 0.0) {
    const auto negative = [&](double x) {
      const double v = value(x);
      return std::isfinite(v) ? -v : std::numeric_limits<double>::max();
    };
    const auto [x, v] = boost::math::tools::brent_find_minima(
        negative, std::max(first, best.argument - step), std::min(last, best.argument + step), 26);
    consider(x, -v, best);
  }

  if (!std::isfinite(best.value)) return best;
  const double near = space.integer ? 0.0 : 1e-6 * (last - first);
  if (best.argument <= first + near) best.bound = "lower";
  if (best.argument >= last - near)
    best.bound = count > 1 || best.bound.empty() ? "upper" : best.bound;

  return best;
}

}  // namespace jaculus::studies
