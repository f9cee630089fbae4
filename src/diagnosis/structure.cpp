// Smooth shapes in what a model leaves.

#include <Eigen/QR>
#include <array>
#include <cmath>
#include <cstddef>

#include "jaculus/diagnosis/selection.h"

namespace jaculus {
namespace {

constexpr int kModes = 10;  // a channel
constexpr std::array<double, 11> kVariances = {1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1e3, 3e3, 1e4, 3e4, 1e5};

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// T D of one condition: modes of every channel, in windows of a measured input each run its own time.
Matrix structure_columns(const Condition& condition, const ConditionSpace& space) {
  const auto channels = static_cast<int>(condition.channels.size());
  Matrix raw = Matrix::Zero(condition.rows(), channels * kModes);
  for (const RowSpan& span : space.spans) {
    const Channel& channel = condition.channels[at(span.channel)];
    const Run& run = condition.runs[at(span.run)];
    raw.block(span.first, span.channel * kModes, span.count, kModes) =
        channel.noise_floor * fault_modes(condition, channel, run.time[at(span.channel)], kModes);
  }
  Matrix columns(space.rows, raw.cols());
  for (Eigen::Index k = 0; k < raw.cols(); ++k) columns.col(k) = space.apply(raw.col(k));
  return columns;
}

}  // namespace

double structure_evidence(const DiagnosisProblem& problem, const EvidenceSpace& space, const Fit& fit) {
  Eigen::Index width = 0;
  for (const Condition& c : problem.observations.conditions)
    width += static_cast<Eigen::Index>(c.channels.size()) * kModes;
  Matrix columns = Matrix::Zero(space.rows, width);
  Eigen::Index row = 0, column = 0;
  for (std::size_t c = 0; c < space.conditions.size(); ++c) {
    const Matrix own = structure_columns(problem.observations.conditions[c], space.conditions[c]);
    columns.block(row, column, own.rows(), own.cols()) = own;
    row += own.rows();
    column += own.cols();
  }
  Vector r = fit.residual;
  if (!fit.free.empty()) {
    const Eigen::ColPivHouseholderQR<Matrix> model(fit.jacobian);
    columns -= fit.jacobian * model.solve(columns);
    r -= fit.jacobian * model.solve(r);
  }
  Eigen::ColPivHouseholderQR<Matrix> qr(columns);
  qr.setThreshold(1e-6);
  const auto k = qr.rank();
  const Vector z = (qr.householderQ().transpose() * r).head(k);
  const double energy = z.squaredNorm();
  double largest = -kInfinity, sum = 0.0;
  std::array<double, kVariances.size()> logs{};
  for (std::size_t i = 0; i < kVariances.size(); ++i) {
    const double a = kVariances[i];
    logs[i] = -0.5 * static_cast<double>(k) * std::log(1.0 + a) + 0.5 * energy * a / (1.0 + a);
    largest = std::max(largest, logs[i]);
  }
  for (const double value : logs) sum += std::exp(value - largest);
  return largest + std::log(sum / static_cast<double>(kVariances.size()));
}

}  // namespace jaculus
