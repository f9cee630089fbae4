#include "diagnosis/validation/fold_interval.h"

#include <boost/math/distributions/students_t.hpp>
#include <cmath>

namespace jaculus::diagnosis {

Bounds fold_interval(const std::vector<double>& by_fold, double value) {
  double n = 0.0, sum = 0.0, squares = 0.0;
  for (const double v : by_fold) {
    if (!std::isfinite(v)) continue;
    n += 1.0;
    sum += v;
  }
  if (n < 2.0) return {kNaN, kNaN};

  for (const double v : by_fold)
    if (std::isfinite(v)) squares += (v - sum / n) * (v - sum / n);
  const double t = boost::math::quantile(boost::math::students_t(n - 1.0), 0.975);
  const double half = t * std::sqrt(squares / (n - 1.0) / n);
  return {value - half, value + half};
}

}  // namespace jaculus::diagnosis
