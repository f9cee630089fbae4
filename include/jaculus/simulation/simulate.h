#pragma once
// Forward simulation of a plant with hybrid contact: feet stick, slip (Coulomb), lift and land
// (plastic impact), joints meet their stops; all found as events and never stepped over.

#include <string>
#include <vector>

#include "jaculus/simulation/controller.h"
#include "jaculus/simulation/plant.h"

namespace jaculus::simulation {

enum class ContactMode { open, stick, slip };
enum class EventKind { lift, land, slip, stick, stop, release, limit };

struct Event {
  double time = 0.0;  ///< [s]
  EventKind kind = EventKind::lift;
  std::string what;  ///< foot, point or joint
};

enum class SimulationStatus { done, diverged, event_cluster, singular, contact_unresolved };
const char* status_name(SimulationStatus status);

/// State at the start. Contacts follow from it: a point within `contact_tolerance` of the floor and
/// not moving up is closed.
struct StartState {
  Vector q;  ///< coordinates of plant.model [rad or m]
  Vector v;  ///< rates
};

/// What samples hold beside the motion; what they don't is NaN. Each sample of contact forces
/// evaluates the equations once more; motors need their own law alone.
enum class Sampled { motion, motors, all };

/// When a simulation ends, and where it is sampled.
struct SimulationOptions {
  double duration = 0.0;             ///< [s]
  Vector sample_times;               ///< rising, within [0, duration]; where the results stand [s]
  double relative_tolerance = 1e-6;  ///< of a step's error beside a state's size [-]
  double absolute_tolerance = 1e-8;  ///< of coordinates; rates have 100/s times as much [rad, m]
  double contact_tolerance = 1e-6;   ///< [m]
  int max_events = 2000;
  bool stop_at_lift_off = false;  ///< ends when no point touches the floor any more
  Sampled sampled = Sampled::all;
};

/// Samples are columns. Coordinates are those of plant.model; hinges stand apart.
struct Simulation {
  SimulationStatus status = SimulationStatus::done;
  double end_time = 0.0;  ///< where it ended, or failed [s]
  std::string message;    ///< for users, where not done
  Vector time;            ///< [s]
  Matrix q, v;            ///< n x samples
  /// motors x samples: joint angle on the motor's side, what an encoder sees [rad]
  Matrix motor_position;
  Matrix motor_velocity;  ///< [rad/s]
  Matrix torque;          ///< motors x samples, one motor's at the joint [N m]
  Matrix current;         ///< [A]
  Matrix voltage;         ///< at the terminals [V]
  Vector bus_voltage;     ///< [V]
  Matrix force;           ///< 2 a foot x samples: x, z [N]
  std::vector<Event> events;
  long evaluations = 0;  ///< of the equations
};

/// Simulates. Bad input is an InputError (a reference for another robot); everything numerical is a
/// status.
Simulation simulate(const Plant& plant, const Controller& controller, const StartState& start,
                    const SimulationOptions& options);

/// Turns and lifts the base of a robot that stands on two feet until both touch; one whose feet are
/// 10 mm or more apart in height, or above one another, stays as it is.
void level_feet(const Plant& plant, Vector& q);

/// The start of a reference: its initial coordinates, as the plant's encoders show them, at rest,
/// lowered or raised so that the lowest feet touch the floor. A motor's joint that encoders would
/// show beyond its stop rests against it. A start whose feet are more than 50 mm above the floor is
/// a drop, and stays there. `off`: by how much a trial's coordinates are off the initial ones, by
/// index [m, rad]; empty: by nothing.
StartState reference_start(const Plant& plant, const Reference& reference, const Vector& off = {});

}  // namespace jaculus::simulation
