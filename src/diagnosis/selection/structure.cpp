#include "diagnosis/selection/structure.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <cmath>
#include <vector>

namespace jaculus::diagnosis {
namespace {

constexpr double kRankThreshold = 1e-6;

/// Modes at the rows of a span: of the command's time, or of a window's own.
Matrix modes_of(const ObservedDataset& observed, const RowSpan& span, int modes) {
  const Segment& segment = observed.segments[span.segment];
  const Channel& channel = observed.channels[span.channel];
  const Vector& time = segment.time[span.channel];
  if (!observed.measured_input) return fault_modes(observed, channel, time, modes);
  return fault_modes(time.array() - segment.start, segment.end() - segment.start,
                     channel.zero_order_hold, modes);
}

/// Orthonormal basis of T D of one motion, on its own rows.
struct MotionBasis {
  int first = 0;  ///< row among those that take part
  Matrix Q;       ///< rows of the motion x directions
};

MotionBasis basis_of(int first, const Matrix& columns) {
  Eigen::ColPivHouseholderQR<Matrix> qr(columns);
  qr.setThreshold(kRankThreshold);
  return {first, qr.householderQ() * Matrix::Identity(columns.rows(), qr.rank())};
}

/// Segments that a command drove are one motion.
MotionBasis shared_motion(const ObservedDataset& observed, const DatasetNoise& noise,
                          const DatasetWhitening& whitening, int first, int modes) {
  Matrix raw = Matrix::Zero(observed.rows(), count_of(observed.channels) * modes);
  for (const RowSpan& span : whitening.spans)
    raw.block(span.first, span.channel * modes, span.count, modes) =
        noise.channels[span.channel].noise_floor * modes_of(observed, span, modes);

  Matrix columns(whitening.rows, raw.cols());
  for (Eigen::Index k = 0; k < raw.cols(); ++k) columns.col(k) = whitening.apply(raw.col(k));
  return basis_of(first, columns);
}

/// A window under a logged input is a motion of its own.
MotionBasis window_motion(const ObservedDataset& observed, const DatasetNoise& noise,
                          const DatasetWhitening& whitening, int block, int first, int modes) {
  const SegmentBlock& own = whitening.blocks[block];
  const int origin = noise.nuisances[own.segment].first;
  Matrix raw = Matrix::Zero(own.count, count_of(observed.channels) * modes);
  for (const RowSpan& span : whitening.spans)
    if (span.segment == own.segment)
      raw.block(span.first - origin, span.channel * modes, span.count, modes) =
          noise.channels[span.channel].noise_floor * modes_of(observed, span, modes);

  Matrix columns = whitening.whiten_block(block, raw);
  for (Eigen::Index k = 0; k < columns.cols(); ++k) own.nuisances.apply(columns.col(k));
  return basis_of(first + own.first, columns);
}

std::vector<MotionBasis> motions_of(const Problem& problem, const NoiseModel& noise,
                                    const Whitening& whitening) {
  const int modes = problem.settings.structure_modes;
  std::vector<MotionBasis> motions;
  int first = 0;
  for (int d = 0; d < count_of(whitening.datasets); ++d) {
    const ObservedDataset& observed = problem.observations.datasets[d];
    const DatasetWhitening& own = whitening.datasets[d];
    if (!observed.measured_input) {
      motions.push_back(shared_motion(observed, noise.datasets[d], own, first, modes));
    } else {
      for (int b = 0; b < count_of(own.blocks); ++b)
        motions.push_back(window_motion(observed, noise.datasets[d], own, b, first, modes));
    }
    first += own.rows;
  }
  return motions;
}

/// Variances of the structure over the noise's: 1, 3, 10, 30 and so on over some decades.
std::vector<double> variances_over(int decades) {
  std::vector<double> variances;
  double decade = 1.0;
  for (int i = 0; i < decades; ++i, decade *= 10.0) {
    variances.push_back(decade);
    variances.push_back(3.0 * decade);
  }
  variances.push_back(decade);
  return variances;
}

/// log of the mean over the unknown size a^2 of the structure.
double log_bayes_factor(double energy, double directions, const std::vector<double>& variances) {
  std::vector<double> logs;
  double largest = -kInfinity, sum = 0.0;
  for (const double a : variances) {
    logs.push_back(-0.5 * directions * std::log(1.0 + a) + 0.5 * energy * a / (1.0 + a));
    largest = std::max(largest, logs.back());
  }
  for (const double value : logs) sum += std::exp(value - largest);
  return largest + std::log(sum / static_cast<double>(variances.size()));
}

}  // namespace

double structure_evidence(const Problem& problem, const NoiseModel& noise,
                          const Whitening& whitening, const Fit& fit) {
  const std::vector<MotionBasis> motions = motions_of(problem, noise, whitening);
  Matrix A(whitening.rows, 0);  // orthonormal basis of the model's own sensitivities
  if (!fit.free.empty()) A = basis_of(0, fit.jacobian).Q;
  const Vector r = fit.residual - A * (A.transpose() * fit.residual);

  // With B = Q^T A, w = Q^T r: the projection of r on what of Q lies outside of A has the energy
  // w^T (I - B B^T)^-1 w = |w|^2 + w^T B (I - B^T B)^-1 B^T w. Directions of Q within A drop out.
  double energy = 0.0, directions = 0.0;
  Matrix BtB = Matrix::Zero(A.cols(), A.cols());
  Vector Btw = Vector::Zero(A.cols());
  for (const MotionBasis& motion : motions) {
    const Matrix& Q = motion.Q;
    const Vector w = Q.transpose() * r.segment(motion.first, Q.rows());
    const Matrix B = Q.transpose() * A.middleRows(motion.first, Q.rows());
    energy += w.squaredNorm();
    directions += static_cast<double>(Q.cols());
    BtB += B.transpose() * B;
    Btw += B.transpose() * w;
  }
  if (A.cols() > 0) {
    const Eigen::SelfAdjointEigenSolver<Matrix> solver(BtB);
    const Vector along = solver.eigenvectors().transpose() * Btw;
    for (Eigen::Index i = 0; i < along.size(); ++i) {
      const double outside = 1.0 - solver.eigenvalues()[i];
      if (outside > kRankThreshold * kRankThreshold)
        energy += along[i] * along[i] / outside;
      else
        directions -= 1.0;
    }
  }
  return log_bayes_factor(energy, directions, variances_over(problem.settings.structure_decades));
}

}  // namespace jaculus::diagnosis
