#pragma once
// What happens to contacts where a run begins and at its events: impacts, and the change of modes
// where forces ask for it. Each function takes a run's state and leaves it in line with Coulomb's
// law, or says why it can't.

#include <optional>
#include <string>
#include <vector>

#include "jaculus/simulation/simulate.h"
#include "simulation/contact/plant_equations.h"

namespace jaculus::simulation::detail {

/// A rate that counts as zero; above what is left of one that a contact holds at zero [m/s, rad/s].
inline constexpr double kStill = 2e-7;

/// Why a run ends before its time; nothing where it goes on.
struct Fault {
  SimulationStatus status;
  std::string message;  ///< for users
};
using Outcome = std::optional<Fault>;

/// A run at an instant: all that its future depends on, but for the inputs under way, which the
/// equations hold.
struct RunState {
  double t = 0.0;             ///< [s]
  State y;                    ///< as in plant_equations.h
  State dydt;                 ///< its rates
  std::vector<Touch> modes;   ///< one a unilateral
  bool touched = false;       ///< whether a point has been in contact so far
  int transitions = 0;        ///< events of contacts so far
  int crowded = 0;            ///< the last so many of them followed one another at once
  double last_event = -1.0;   ///< [s]
  std::vector<Event> events;  ///< so far
};

/// Changes a mode, as an event of the run.
void set_mode(const PlantEquations& equations, int contact, Touch mode, RunState& state);

/// Whether a foot or point is on the floor.
bool touches_floor(const PlantEquations& equations, const RunState& state);

/// At the start: points that stand in compliant ground are in contact. A fault where one starts
/// beyond a rigid contact by more than `tolerance` [m].
Outcome initialise_contacts(PlantEquations& equations, double tolerance, RunState& state);

/// At the start, from rest: hinges hang and a compliant floor carries what neither a motor nor a
/// rigid contact holds.
Outcome find_static_equilibrium(PlantEquations& equations, RunState& state);

/// Until the first command: the torques that come nearest to keeping the pose, with everything that
/// touches sticking; whether it does so is for the forces to say.
Outcome hold_pose(PlantEquations& equations, double tolerance, RunState& state);

/// Rates jump where touching contacts approach; then modes by the forces.
Outcome resolve_impact(PlantEquations& equations, double tolerance, RunState& state);

/// A mode that a contact had, and which its forces contradict.
struct ExcludedMode {
  int contact;
  Touch mode;
};
/// Modes by the forces: stick, slip or open for everything that touches; the excluded one only
/// where there is no other.
Outcome resolve_modes(PlantEquations& equations, double tolerance,
                      const std::optional<ExcludedMode>& excluded, RunState& state);

}  // namespace jaculus::simulation::detail
