#include "diagnosis/localise/components.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <optional>
#include <random>

#include "diagnosis/noise/quantiles.h"
#include "diagnosis/selection/screen.h"
#include "diagnosis/validation/shapley.h"
#include "jaculus/effects/effect.h"

namespace jaculus::diagnosis {
namespace {

using effects::Component;
using effects::Effect;
using effects::kComponentCount;

constexpr int kDraws = 4000;

/// One effect of a model in one component.
struct Player {
  int member = 0;  ///< index in the model's candidates
  Component component = Component::body;
  Effect effect;  ///< restricted to the component
  Vector theta;
};

/// Energies of a model's players, and what their signatures are.
struct Attribution {
  double weight = 0.0;  ///< posterior probability
  std::vector<Player> players;
  Vector energy;      ///< Shapley value of each, at the fit
  double left = 0.0;  ///< energy beyond noise that the model leaves
  Matrix signatures;  ///< rows x players, of each alone
  Matrix gram;        ///< of the signatures
  Vector pull;        ///< signatures times the residual without any
  Matrix
      /// L of the members' first parameters' relative covariance, members x members
      deviation_root;
};

/// Parts that none of the robots has are no players: a robot on one foot has no front legs.
std::vector<Player> players_of(const Problem& problem, const ModelFit& model) {
  const std::vector<ObservedDataset>& datasets = problem.observations.datasets;
  std::vector<Player> players;
  for (int m = 0; m < count_of(model.candidates); ++m) {
    const Candidate& candidate = problem.hypotheses.candidates[model.candidates[m]];
    if (candidate.effect == nullptr) return {};
    for (const Effect* part : effects::in_parts(*candidate.effect)) {
      const auto applies = [&](const ObservedDataset& d) { return part->applies(d.model); };
      if (std::none_of(datasets.begin(), datasets.end(), applies)) continue;
      players.push_back({m, part->where.front(), *part, candidate.theta(model.fit.p)});
    }
  }
  return players;
}

/// The problem in which every player is a hypothesis of its own, and p with some of them at work.
struct PlayersProblem {
  Problem problem;
  Vector p;  ///< nominal players, everything else as fitted

  [[nodiscard]] Vector with(const std::vector<Player>& players, unsigned subset) const {
    Vector changed = p;
    for (int k = 0; k < count_of(players); ++k)
      if ((subset >> k & 1U) != 0U)
        changed(problem.hypotheses.candidates[k].parameters) = players[k].theta;
    return changed;
  }
};

PlayersProblem players_problem(const Problem& problem, const ModelFit& model,
                               const std::vector<Player>& players) {
  std::vector<const Effect*> list;
  for (const Player& player : players) list.push_back(&player.effect);
  const PlantForward forward = plant_forward(problem.observations, list, problem.settings);
  assert(forward.hypotheses.candidates.size() == players.size());

  PlayersProblem own{{problem.observations, forward.hypotheses, forward.predict, problem.settings},
                     forward.hypotheses.nominal()};
  const std::vector<int> from = problem.hypotheses.nuisances(),
                         to = own.problem.hypotheses.nuisances();
  for (std::size_t i = 0; i < from.size(); ++i) own.p[to[i]] = model.fit.p[from[i]];
  return own;
}

/// Whitened residual with some players at work; nothing where the simulation fails.
std::optional<Vector> residual_with(const PlayersProblem& own, const Whitening& whitening,
                                    const std::vector<Player>& players, unsigned subset) {
  const PredictionSet set = predict_all(own.problem, own.with(players, subset));
  if (!set.valid) return {};
  return whitening.residual(rows_of(own.problem, whitening.alignments, set));
}

/// Energy of a residual beyond what noise makes in 95 of 100 cases.
double beyond_noise(double chi2, double rows, double floor_error) {
  const double deviation = rows * std::sqrt(2.0 / std::max(rows, 1.0) + floor_error * floor_error);
  return std::max(0.0, chi2 - rows - quantiles::kOneSided95 * deviation);
}

/// L of the relative covariance of the members' first parameters (of their departure from nominal).
Matrix relative_root(const Problem& problem, const ModelFit& model) {
  const Eigen::Index n = count_of(model.candidates);
  Matrix covariance(n, n);
  const Vector u = problem.hypotheses.scaled(model.fit.free, model.fit.p);
  std::vector<Eigen::Index> place;
  Eigen::Index at = 0;
  for (const int c : model.candidates) {
    place.push_back(at);
    at += count_of(problem.hypotheses.candidates[c].parameters);
  }
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j)
      covariance(i, j) = model.fit.covariance(place[i], place[j]) /
                         std::max(1e-12, std::abs(u[place[i]] * u[place[j]]));
  covariance.diagonal().array() += 1e-12;
  return covariance.llt().matrixL();
}

/// Nothing where a subset can't be simulated.
std::optional<Attribution> attribute(const Problem& problem, const Whitening& whitening,
                                     const ModelFit& model) {
  Attribution out;
  out.weight = model.probability();
  out.players = players_of(problem, model);
  out.left =
      beyond_noise(model.fit.chi2, whitening.rows - whitening.apart, problem.settings.floor_error);
  const int n = count_of(out.players);
  out.energy = Vector::Zero(n);
  out.signatures.resize(whitening.rows, n);
  if (model.candidates.empty() || n == 0) return out;

  const PlayersProblem own = players_problem(problem, model, out.players);
  Vector nothing;
  std::vector<double> value(std::size_t{1} << n);
  for (unsigned subset = 0; subset < value.size(); ++subset) {
    const auto r = residual_with(own, whitening, out.players, subset);
    if (!r) return {};
    if (subset == 0) nothing = *r;
    value[subset] = nothing.squaredNorm() - r->squaredNorm();
    for (int k = 0; k < n; ++k)
      if (subset == 1U << k) out.signatures.col(k) = nothing - *r;
  }
  out.energy = shapley_values(value, n);
  out.gram = out.signatures.transpose() * out.signatures;
  out.pull = out.signatures.transpose() * nothing;
  out.deviation_root = relative_root(problem, model);
  return out;
}

/// Share of each component, then of what is left, for the players' energies.
Vector shares_of(const Attribution& a, const Vector& energy) {
  Vector shares = Vector::Zero(kComponentCount + 1);
  for (int k = 0; k < energy.size(); ++k)
    shares[static_cast<int>(a.players[k].component)] += std::max(0.0, energy[k]);
  shares[kComponentCount] = a.left;
  const double all = shares.sum();
  return all > 0.0 ? Vector(shares / all) : shares;
}

/// Energies with the members' signatures scaled: those of a quadratic v.
Vector scaled_energy(const Attribution& a, const Vector& scale) {
  Vector own(a.energy.size());
  for (int k = 0; k < own.size(); ++k) own[k] = scale[a.players[k].member];
  return own.cwiseProduct(2.0 * a.pull - a.gram * own);
}

/// Draws of the shares: a model by its probability, its parameters by their covariance.
std::array<std::vector<double>, kComponentCount> draw_shares(
    const std::vector<Attribution>& models) {
  std::mt19937_64 generator(1);
  std::normal_distribution<double> normal;
  std::vector<double> weights;
  for (const Attribution& a : models) weights.push_back(a.weight);
  std::discrete_distribution<int> model(weights.begin(), weights.end());

  std::array<std::vector<double>, kComponentCount> draws;
  for (int d = 0; d < kDraws; ++d) {
    const Attribution& a = models[model(generator)];
    Vector scale = Vector::Ones(a.deviation_root.rows());
    Vector z(scale.size());
    for (double& v : z) v = normal(generator);
    if (z.size() > 0) scale += a.deviation_root * z;
    const Vector shares = shares_of(a, z.size() > 0 ? scaled_energy(a, scale) : a.energy);
    for (int c = 0; c < kComponentCount; ++c) draws[c].push_back(shares[c]);
  }
  for (std::vector<double>& own : draws) std::sort(own.begin(), own.end());
  return draws;
}

/// Components of effects that the data can't tell from a model's: those of indistinguishable
/// effects, and parts of one effect whose signatures reproduce one another.
void add_indistinguishable(const Problem& problem, const Whitening& whitening,
                           const Posterior& posterior, const Attribution& a, const ModelFit& model,
                           const Matrix& nuisances, std::vector<ComponentShare>& components) {
  const auto add = [&](Component from, Component other) {
    std::vector<Component>& list = components[static_cast<int>(from)].indistinguishable;
    if (from != other && std::find(list.begin(), list.end(), other) == list.end())
      list.push_back(other);
  };
  for (const Player& player : a.players) {
    const int candidate = model.candidates[player.member];
    for (const int other : posterior.indistinguishable[candidate])
      if (!problem.hypotheses.candidates[candidate].effect->acts_in(
              problem.hypotheses.candidates[other].where))
        add(player.component, problem.hypotheses.candidates[other].where);
  }

  for (int i = 0; i < count_of(a.players); ++i) {
    for (int j = 0; j < count_of(a.players); ++j) {
      const auto si = a.signatures.col(i), sj = a.signatures.col(j);
      if (i == j || a.players[i].member != a.players[j].member) continue;
      if (sj.norm() < problem.settings.component_compared * si.norm()) continue;
      Matrix other(sj.size(), 1 + nuisances.cols());
      other << nuisances, sj;
      const double energy =
          unexplained_energy(whitening.random, model.fit.scales, si, other, nuisances.cols());
      if (0.5 * energy < problem.settings.indistinguishable_below)
        add(a.players[i].component, a.players[j].component);
    }
  }
}

}  // namespace

ComponentShares component_shares(const Problem& problem, const Selection& selection,
                                 const Posterior& posterior) {
  ComponentShares out;
  for (int c = 0; c < kComponentCount; ++c) {
    out.components.emplace_back();
    out.components.back().component = static_cast<Component>(c);
  }
  for (int c = 0; c < count_of(problem.hypotheses.candidates); ++c) {
    const Candidate& candidate = problem.hypotheses.candidates[c];
    if (candidate.effect == nullptr) continue;
    const bool shows = selection.search.probes[c].valid;
    for (ComponentShare& share : out.components) {
      const bool acts = candidate.effect->acts_in(share.component);
      share.present = share.present || acts;
      share.visible = share.visible || (acts && shows);
    }
  }

  const Whitening& whitening = selection.comparison.whitening;
  const ModelFit* none = posterior.find({});
  const Matrix nuisances = none != nullptr ? none->fit.jacobian : Matrix(whitening.rows, 0);
  std::vector<Attribution> models;
  double counted = 0.0;
  for (const ModelFit& model : posterior.models) {
    if (!model.fit.valid || model.probability() < problem.settings.model_counted) continue;
    auto attribution = attribute(problem, whitening, model);
    if (!attribution) continue;
    add_indistinguishable(problem, whitening, posterior, *attribution, model, nuisances,
                          out.components);
    counted += attribution->weight;
    models.push_back(std::move(*attribution));
  }
  if (models.empty()) return out;

  for (const Attribution& a : models) {
    const Vector shares = shares_of(a, a.energy);
    std::array<bool, kComponentCount> acts{};
    for (const Player& player : a.players) acts[static_cast<int>(player.component)] = true;
    for (int c = 0; c < kComponentCount; ++c) {
      out.components[c].share += a.weight / counted * shares[c];
      if (acts[c]) out.components[c].inclusion += a.weight / counted;
    }
    out.unexplained += a.weight / counted * shares[kComponentCount];
  }
  const auto draws = draw_shares(models);
  for (int c = 0; c < kComponentCount; ++c)
    out.components[c].ci95 = {draws[c][kDraws / 40], draws[c][kDraws - 1 - kDraws / 40]};
  return out;
}

}  // namespace jaculus::diagnosis
