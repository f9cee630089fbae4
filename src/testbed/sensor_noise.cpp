#include "testbed/sensor_noise.h"

#include <cassert>
#include <cmath>

namespace jaculus::testbed {
namespace {

/// Deviates of unit variance.
class White {
 public:
  explicit White(double tails)
      : tails_(tails),
        heavy_(tails > 0.0 ? tails : 1.0),
        scale_(tails > 0.0 ? std::sqrt((tails - 2.0) / tails) : 1.0) {}

  double operator()(std::mt19937_64& random) {
    return tails_ > 0.0 ? scale_ * heavy_(random) : normal_(random);
  }

 private:
  double tails_;
  std::normal_distribution<double> normal_;
  std::student_t_distribution<double> heavy_;
  double scale_;
};

}  // namespace

void add_noise(Vector& values, double sd, double dt, const NoiseShape& shape,
               std::mt19937_64& random) {
  assert(shape.tails == 0.0 || shape.tails > 2.0);
  if (!(sd > 0.0)) return;

  White white(shape.tails);
  std::normal_distribution<double> normal;
  const double keep = shape.coloured > 0.0 ? std::exp(-dt / shape.correlation_time) : 0.0;
  const double renew = std::sqrt(1.0 - keep * keep);
  double slow = shape.coloured > 0.0 ? normal(random) : 0.0;

  for (double& value : values) {
    value += sd * std::sqrt(1.0 - shape.coloured) * white(random);
    if (shape.coloured == 0.0) continue;
    value += sd * std::sqrt(shape.coloured) * slow;
    slow = keep * slow + renew * normal(random);
  }
}

void quantise(Vector& values, double step) {
  if (!(step > 0.0)) return;
  for (double& value : values) value = step * std::round(value / step);
}

void low_pass(Vector& values, double time, double dt) {
  if (!(time > 0.0) || values.size() == 0) return;
  const double keep = std::exp(-dt / time);
  double state = values[0];
  for (double& value : values) value = state = keep * state + (1.0 - keep) * value;
}

}  // namespace jaculus::testbed
