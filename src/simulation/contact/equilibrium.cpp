#include "simulation/contact/equilibrium.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace jaculus::simulation::detail {

namespace {

/// Hinges that no rigid contact loads; height and pitch where the floor gives way. Motors act on
/// none of these rows.
std::vector<int> loose_coordinates(const PlantEquations& equations,
                                   const std::vector<ContactState>& contacts,
                                   const std::vector<Touch>& modes) {
  std::vector<int> rows;
  const bool gives_way = equations.compliant(0);
  for (const Hinge& hinge : equations.hinges()) {
    const int i = hinge.coordinate;
    const bool loaded = std::any_of(contacts.begin(), contacts.end(), [i](const ContactState& c) {
      return c.normal[i] != 0.0 || c.tangential[i] != 0.0;
    });
    if (!loaded || gives_way) rows.push_back(i);
  }

  bool stands = false;
  for (int i = 0; i < count_of(modes); ++i)
    stands = stands || (equations.compliant(i) && modes[i] != Touch::open);
  for (const char* name : {"z", "pitch"})
    if (const int i = equations.plant().model.coordinate_index(name); stands && i >= 0)
      rows.push_back(i);
  return rows;
}

/// Q - h of some coordinates; false where the equations are singular.
bool unbalanced(PlantEquations& equations, double t, const State& y,
                const std::vector<Touch>& modes, const std::vector<int>& rows, Vector& out) {
  const double* balance = equations.balance(t, y, modes);
  if (balance == nullptr) return false;
  out.resize(count_of(rows));
  for (int k = 0; k < count_of(rows); ++k) out[k] = balance[rows[k]];
  return out.allFinite();
}

constexpr double kBalanced = 1e-9;  // of the weight

/// Hinges within their play to the flank that their load rests on, for within it nothing tells how
/// far that is.
bool lean_on_flanks(PlantEquations& equations, double t, const std::vector<Touch>& modes,
                    const std::vector<int>& rows, State& y) {
  Vector force;
  for (const Hinge& hinge : equations.hinges()) {
    const int row = index_of(rows, hinge.coordinate);
    double& angle = y[hinge.coordinate];
    if (row < 0 || std::abs(angle) >= hinge.half_play) continue;
    if (!unbalanced(equations, t, y, modes, rows, force)) return false;
    if (std::abs(force[row]) > kBalanced * equations.force_scale())
      angle = std::copysign(hinge.half_play, force[row]);
  }
  return true;
}

}  // namespace

bool settle_loose_parts(PlantEquations& equations, double t, const std::vector<Touch>& modes,
                        State& y) {
  const std::vector<ContactState>* contacts = equations.contacts(y);
  if (contacts == nullptr) return false;
  const std::vector<int> rows = loose_coordinates(equations, *contacts, modes);
  const auto v = y.begin() + equations.size();
  const bool moves = std::any_of(v, v + equations.size(), [](double rate) { return rate != 0.0; });
  if (rows.empty() || moves) return true;

  constexpr double kStep = 1e-9;  // of differences; springs are stiff [rad, m]
  const auto forces = [&](Vector& out) { return unbalanced(equations, t, y, modes, rows, out); };
  Vector force, moved;
  if (!lean_on_flanks(equations, t, modes, rows, y) || !forces(force)) return false;

  const int size = count_of(rows);
  const double scale = equations.force_scale();
  for (int pass = 0; pass < 60 && force.norm() > kBalanced * scale; ++pass) {
    Matrix jacobian(size, size);
    for (int k = 0; k < size; ++k) {
      double& own = y[rows[k]];
      const double was = own;
      own += kStep;
      const bool ok = forces(moved);
      own = was;
      if (!ok) return false;
      jacobian.col(k) = (moved - force) / kStep;
    }
    const Vector step = jacobian.colPivHouseholderQr().solve(-force);

    // the flanks of a play begin softly, so that a whole step may overshoot
    for (double share = 1.0;; share *= 0.5) {
      for (int k = 0; k < size; ++k) y[rows[k]] += share * step[k];
      if (forces(moved) && moved.norm() < force.norm()) break;
      for (int k = 0; k < size; ++k) y[rows[k]] -= share * step[k];
      if (share < 1e-6) return force.norm() < 1e-4 * scale;
    }
    force = moved;
  }
  return true;
}

bool hold_by_torques(PlantEquations& equations, double t, const State& y,
                     const std::vector<Touch>& modes) {
  const int motors = count_of(equations.motors()), n = equations.size();
  std::vector<double> torques(motors, 0.0);
  State dydt(equations.states());
  const auto acceleration = [&](Vector& a) {
    equations.hold(torques);
    const bool ok = equations.evaluate(t, y, modes, dydt) != nullptr;
    a = Eigen::Map<const Vector>(dydt.data() + n, n);
    return ok;
  };

  Vector free, with;
  if (!acceleration(free)) return false;
  // a is affine in the torques, so the step is large for the sake of rounding [N m]
  constexpr double kProbe = 0.1;
  Matrix response(n, motors);
  for (int m = 0; m < motors; ++m) {
    torques[m] = kProbe;
    if (!acceleration(with)) return false;
    response.col(m) = (with - free) / kProbe;
    torques[m] = 0.0;
  }

  Eigen::CompleteOrthogonalDecomposition<Matrix> solver(response.rows(), response.cols());
  // Feet that stand leave one combination of torques without effect: none of it is asked for. The
  // rank is settled as it is factorised.
  solver.setThreshold(1e-7);
  solver.compute(response);
  const Vector torque = solver.solve(-free);
  for (int m = 0; m < motors; ++m) torques[m] = torque[m];
  equations.hold(torques);
  return true;
}

}  // namespace jaculus::simulation::detail
