#include "diagnosis/localise_shares.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <random>

namespace jaculus {
namespace {

constexpr std::array<double, 4> kSizePrior{0.5, 0.35, 0.1, 0.05};
constexpr double kStructuredDirections = 20.0;

/// A subset of the candidates with what the data say about it.
struct Subset {
  std::vector<int> members;  ///< indices of candidates
  std::vector<int> columns;
  std::vector<int> sides;
  double log_prior = 0.0;
  double log_weight = 0.0;
  double chi2 = 0.0;  ///< of the residual at the posterior mean
  Vector mean;
  Matrix root;  ///< L of A = L L^T
};

double normal_cdf(double z) { return 0.5 * std::erfc(-z / std::sqrt(2.0)); }

Matrix pick(const Matrix& G, const std::vector<int>& columns) { return G(columns, columns); }

/// Posterior and evidence of one subset at noise `kappa`.
void weigh(const ShareSystem& system, double kappa, Subset& s) {
  const auto k = static_cast<Eigen::Index>(s.columns.size());
  s.log_weight = s.log_prior;
  s.chi2 = system.rr;
  if (k == 0) return;
  const Matrix G = pick(system.G, s.columns);
  const Vector b = system.b(s.columns);
  const Eigen::LLT<Matrix> A(Matrix::Identity(k, k) + G / kappa);
  s.root = A.matrixL();
  s.mean = A.solve(b) / kappa;
  s.log_weight += 0.5 * b.dot(s.mean) / kappa - s.root.diagonal().array().log().sum();
  const Matrix covariance = A.solve(Matrix::Identity(k, k));
  for (Eigen::Index i = 0; i < k; ++i) {
    const int side = s.sides[static_cast<size_t>(i)];
    if (side == 0) continue;
    const double inside = normal_cdf(side * s.mean[i] / std::sqrt(covariance(i, i)));
    s.log_weight += std::log(std::max(inside, 1e-300) / 0.5);
  }
  s.chi2 = system.rr - 2.0 * b.dot(s.mean) + s.mean.dot(G * s.mean);
}

/// Whether the posterior mean lies on the allowed sides, up to its own uncertainty.
bool within_sides(const Subset& s) {
  for (size_t i = 0; i < s.sides.size(); ++i)
    if (s.sides[i] * s.mean[static_cast<Eigen::Index>(i)] < 0.0) return false;
  return true;
}

Subset make_subset(const std::vector<ShareCandidate>& candidates, const std::vector<double>& weight,
                   const std::vector<int>& members) {
  Subset s;
  s.members = members;
  for (const int m : members) {
    const ShareCandidate& c = candidates[static_cast<size_t>(m)];
    s.columns.insert(s.columns.end(), c.columns.begin(), c.columns.end());
    s.sides.insert(s.sides.end(), c.sides.begin(), c.sides.end());
    s.log_prior += std::log(weight[static_cast<size_t>(m)]);
  }
  return s;
}

/// All subsets up to `largest`, with their prior.
std::vector<Subset> all_subsets(const std::vector<ShareCandidate>& candidates, int largest) {
  std::array<double, kComponentCount> entries{};
  for (const ShareCandidate& c : candidates)
    for (const SharePart& part : c.parts)
      entries[static_cast<size_t>(part.component)] += 1.0 / static_cast<double>(c.parts.size());
  std::vector<double> weight;
  for (const ShareCandidate& c : candidates) {
    weight.push_back(0.0);
    for (const SharePart& part : c.parts)
      weight.back() += 1.0 / (entries[static_cast<size_t>(part.component)] * static_cast<double>(c.parts.size()));
  }
  std::vector<Subset> subsets;
  std::vector<std::vector<int>> of_size{{}};
  for (int size = 0; size <= std::min<int>(largest, static_cast<int>(kSizePrior.size()) - 1); ++size) {
    const size_t begin = subsets.size();
    double total = 0.0;
    for (const auto& members : of_size) {
      subsets.push_back(make_subset(candidates, weight, members));
      total += std::exp(subsets.back().log_prior);
    }
    for (size_t i = begin; i < subsets.size(); ++i)
      subsets[i].log_prior += std::log(kSizePrior[static_cast<size_t>(size)] / total);
    std::vector<std::vector<int>> larger;
    for (const auto& members : of_size) {
      for (int e = members.empty() ? 0 : members.back() + 1; e < static_cast<int>(candidates.size()); ++e) {
        larger.push_back(members);
        larger.back().push_back(e);
      }
    }
    of_size = std::move(larger);
    if (of_size.empty()) break;
  }
  return subsets;
}

/// Energy of chi2 beyond what noise makes in 95 of 100 cases.
double beyond_noise(double chi2, double rows, double floor_error) {
  const double deviation = rows * std::sqrt(2.0 / std::max(rows, 1.0) + floor_error * floor_error);
  return std::max(0.0, chi2 - rows - 1.645 * deviation);
}

/// A draw from the posterior of a subset, on the allowed sides.
Vector draw(const Subset& s, std::mt19937_64& generator) {
  std::normal_distribution<double> normal;
  Vector theta = s.mean;
  for (int attempt = 0; attempt < 50; ++attempt) {
    Vector z(theta.size());
    for (double& v : z) v = normal(generator);
    theta = s.mean + s.root.transpose().triangularView<Eigen::Upper>().solve(z);
    bool inside = true;
    for (size_t i = 0; i < s.sides.size(); ++i)
      inside = inside && s.sides[i] * theta[static_cast<Eigen::Index>(i)] >= 0;
    if (inside) return theta;
  }
  // The posterior lies almost wholly on the forbidden side: its nearest allowed point.
  for (size_t i = 0; i < s.sides.size(); ++i)
    if (s.sides[i] * theta[static_cast<Eigen::Index>(i)] < 0.0) theta[static_cast<Eigen::Index>(i)] = 0.0;
  return theta;
}

/// Shapley values of the components in the energy that a subset explains at theta.
Vector shapley(const ShareSystem& system, const std::vector<ShareCandidate>& candidates, const Subset& s,
               const Vector& theta) {
  Vector energy = Vector::Zero(kComponentCount);
  const Vector pull = system.G(Eigen::all, s.columns) * theta;
  Eigen::Index row = 0;
  for (const int m : s.members) {
    const ShareCandidate& c = candidates[static_cast<size_t>(m)];
    for (const SharePart& part : c.parts)
      for (size_t i = 0; i < part.columns.size(); ++i)
        energy[static_cast<Eigen::Index>(part.component)] +=
            theta[row + static_cast<Eigen::Index>(i)] * pull[part.columns[i]];
    row += static_cast<Eigen::Index>(c.columns.size());
  }
  return energy.cwiseMax(0.0);
}

double quantile(std::vector<double>& values, double p) {
  std::sort(values.begin(), values.end());
  return values[static_cast<size_t>(std::lround(p * static_cast<double>(values.size() - 1)))];
}

/// What one candidate alone leaves of the energy of a field with G-products `b`, prior included.
double left_by(const ShareSystem& system, const ShareCandidate& c, const Vector& b, double energy, double kappa) {
  Subset alone;
  alone.columns = c.columns;
  alone.sides = c.sides;
  ShareSystem field = system;
  field.b = b;
  field.rr = energy;
  weigh(field, kappa, alone);
  return within_sides(alone) ? energy - alone.mean.dot(b(c.columns)) : energy;
}

/// Components whose best single explanation of the measured gap another component's could pass for.
void find_alike(const ShareSystem& system, const std::vector<ShareCandidate>& candidates, double kappa,
                std::vector<ComponentShare>& shares) {
  const double gap = system.rr - system.rows;
  if (gap <= 0.0) return;
  for (ComponentShare& share : shares) {
    Subset best;
    best.log_weight = -kInfinity;
    for (const ShareCandidate& c : candidates) {
      if (!c.acts_in(share.component) || c.parts.size() > 1) continue;
      Subset alone;
      alone.columns = c.columns;
      alone.sides = c.sides;
      weigh(system, kappa, alone);
      if (alone.log_weight > best.log_weight) best = alone;
    }
    if (best.columns.empty()) continue;
    Vector theta = Vector::Zero(system.G.rows());
    theta(best.columns) = best.mean;
    const double energy = theta.dot(system.G * theta);
    if (!(energy > 0.0) || !within_sides(best)) continue;
    theta *= std::sqrt(gap / energy);
    const Vector b = system.G * theta;
    for (const ShareCandidate& c : candidates) {
      if (c.acts_in(share.component) || c.parts.size() > 1) continue;
      const Component other = c.parts.front().component;
      const bool passes = left_by(system, c, b, gap, kappa) / kappa < 6.0;  // a factor of 20 in likelihood
      if (passes && std::find(share.like.begin(), share.like.end(), other) == share.like.end())
        share.like.push_back(other);
    }
    std::sort(share.like.begin(), share.like.end());
  }
}

/// Draws from the average over subsets: rows of `energy` are shares of the components, last the unexplained.
Matrix sample_shares(const ShareSystem& system, const std::vector<ShareCandidate>& candidates,
                     const std::vector<Subset>& subsets, const std::vector<double>& weight,
                     const ShareOptions& options) {
  std::mt19937_64 generator(options.seed);
  std::discrete_distribution<size_t> choose(weight.begin(), weight.end());
  Matrix shares = Matrix::Zero(options.samples, kComponentCount + 1);
  for (int i = 0; i < options.samples; ++i) {
    const Subset& s = subsets[choose(generator)];
    Vector energy = Vector::Zero(kComponentCount + 1);
    if (!s.columns.empty()) energy.head(kComponentCount) = shapley(system, candidates, s, draw(s, generator));
    energy[kComponentCount] = beyond_noise(s.chi2, system.rows, options.floor_error);
    const double total = energy.sum();
    if (total > 0.0) shares.row(i) = energy.transpose() / total;
  }
  return shares;
}

}  // namespace

void ShareSystem::add(const Matrix& S, const Vector& r, const Matrix& N, const Vector& precision, double effective) {
  assert(S.rows() == r.size() && S.cols() == b.size() && N.cols() == precision.size());
  Matrix PS = S;
  Vector Pr = r;
  double lost = 0.0;
  if (N.cols() > 0) {
    const Matrix NN = N.transpose() * N;
    // A nuisance that nothing sees (no column) stays where its prior has it.
    const double tiny = 1e-12 * std::max(1.0, NN.diagonal().maxCoeff());
    const Eigen::LDLT<Matrix> inner(NN + Matrix(precision.array().max(tiny).matrix().asDiagonal()));
    PS -= N * inner.solve(N.transpose() * S);
    Pr -= N * inner.solve(N.transpose() * r);
    lost = inner.solve(NN).trace();
  }
  G += S.transpose() * PS;
  b += S.transpose() * Pr;
  rr += r.dot(Pr);
  rows += std::max(0.0, effective - lost);
}

void ShareSystem::project_out(const std::vector<int>& columns) {
  if (columns.empty()) return;
  const auto m = static_cast<Eigen::Index>(columns.size());
  const Matrix NN = pick(G, columns);
  const Eigen::LLT<Matrix> inner(Matrix::Identity(m, m) + NN);
  const Matrix across = G(Eigen::all, columns);
  const Vector along = b(columns);
  const Vector mean = inner.solve(along);
  rows = std::max(0.0, rows - inner.solve(NN).trace());
  rr -= along.dot(mean);
  b -= across * mean;
  G -= across * inner.solve(across.transpose());
  for (const int c : columns) {
    G.row(c).setZero();
    G.col(c).setZero();
    b[c] = 0.0;
  }
}

bool ShareCandidate::acts_in(Component component) const {
  return std::any_of(parts.begin(), parts.end(), [&](const SharePart& part) { return part.component == component; });
}

ShareAnswer component_shares(const ShareSystem& system, const std::vector<ShareCandidate>& candidates,
                             const ShareOptions& options) {
  std::vector<Subset> subsets = all_subsets(candidates, options.largest);
  ShareAnswer answer;
  double best_chi2 = system.rr;
  for (Subset& s : subsets) {
    weigh(system, 1.0, s);
    if (within_sides(s)) best_chi2 = std::min(best_chi2, s.chi2);
  }
  answer.kappa = 1.0 + beyond_noise(best_chi2, system.rows, options.floor_error) / kStructuredDirections;
  double top = -kInfinity;
  for (Subset& s : subsets) {
    weigh(system, answer.kappa, s);
    s.log_weight -= 0.5 * system.rr / answer.kappa;
    top = std::max(top, s.log_weight);
  }
  std::vector<double> weight;
  double total = 0.0;
  for (const Subset& s : subsets) total += weight.emplace_back(std::exp(s.log_weight - top));
  for (double& w : weight) w /= total;

  Vector involved = Vector::Zero(kComponentCount);
  for (size_t i = 0; i < subsets.size(); ++i) {
    if (subsets[i].members.empty()) answer.nothing = weight[i];
    std::array<bool, kComponentCount> counted{};
    for (const int m : subsets[i].members)
      for (const SharePart& part : candidates[static_cast<size_t>(m)].parts)
        counted[static_cast<size_t>(part.component)] = true;
    for (int c = 0; c < kComponentCount; ++c) involved[c] += counted[static_cast<size_t>(c)] ? weight[i] : 0.0;
  }
  const Matrix shares = sample_shares(system, candidates, subsets, weight, options);
  for (int c = 0; c < kComponentCount; ++c) {
    ComponentShare share;
    share.component = static_cast<Component>(c);
    std::vector<double> values(shares.col(c).begin(), shares.col(c).end());
    share.share = shares.col(c).mean();
    share.ci95 = {quantile(values, 0.025), quantile(values, 0.975)};
    share.involved = involved[c];
    for (const ShareCandidate& candidate : candidates)
      for (const SharePart& part : candidate.parts)
        for (const int column : part.columns)
          share.visible = share.visible || (part.component == share.component && system.G(column, column) >= 9.0);
    answer.components.push_back(share);
  }
  answer.unexplained = shares.col(kComponentCount).mean();
  find_alike(system, candidates, answer.kappa, answer.components);
  return answer;
}

}  // namespace jaculus
