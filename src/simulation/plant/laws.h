#pragma once
// The laws of a plant (law.h) in a run: what they read where the mechanism stands, what they do to
// it, the rates of their states.

#include <array>
#include <vector>

#include "jaculus/simulation/plant.h"
#include "simulation/plant/drive.h"
#include "simulation/plant/fast_part.h"
#include "simulation/plant/inertia.h"
#include "simulation/plant/mechanism.h"

namespace jaculus::simulation::detail {

class Laws {
 public:
  /// InputError where a law names a joint, motor or body that the robot lacks.
  explicit Laws(const Plant& plant);

  [[nodiscard]] bool empty() const { return laws_.empty(); }
  /// States of all laws.
  [[nodiscard]] int states() const { return states_; }
  /// Sets all states to their start, each over its scale.
  void start(double* states) const;

  /// What laws change of motors, battery and ground; `states` as start() left them, integrated.
  const PlantChanges& before_motors(const Mechanism& mechanism, const Inertia& inertia, double t,
                                    const double* q, const double* v, const double* states);
  /// Adds the generalised forces; sets what rates() gives. After before_motors() at the same state.
  void add(const Mechanism& mechanism, const std::vector<MotorState>& motors, double bus,
           const double* q, const double* v, double* force);
  /// Whether a law makes a joint's torque that may follow its own rate.
  [[nodiscard]] bool has_fast_parts() const { return follows_rates_; }
  /// Appends those joints, the torque's slope by a difference and without responses; after add() at
  /// the same state.
  void list_fast_parts(const Mechanism& mechanism, const double* q, const double* v,
                       std::vector<FastPart>& parts);
  /// Rates of all states, each over its scale, as add() left them.
  [[nodiscard]] const std::vector<double>& rates() const { return rates_; }

 private:
  /// A joint by its motor, or by its link where no motor turns it; or a body with a point.
  struct Place {
    int motor = -1, body = -1;
    Vec2 point = Vec2::Zero();  ///< [m]
    int count = 1;              ///< left and right
  };
  /// A joint's rate that a law reads where it makes the same joint's torque.
  struct OwnRate {
    int reading = 0, value = 0;  ///< places among readings and among values of actions
    Place joint;
  };
  struct Own {
    const Law* law;
    LawFunctions functions;
    std::vector<Place> read_at, act_at;
    std::vector<double> readings, actions, states, rates;
    bool before = false;  ///< acts before the motors
    std::vector<OwnRate> own_rates;
  };
  static void pair_rates(Own& own);
  /// d(rate)/dv of a joint: the mechanism's own, or that of `state`, which is set.
  static const Row& row_of(const Place& joint, const Mechanism& mechanism, const double* q,
                           const double* v, JointState& state);
  void read(Own& own, const Mechanism& mechanism, const Inertia& inertia, double t, const double* q,
            const double* v);
  void read_motors(Own& own, const std::vector<MotorState>& motors, double bus);
  void act(const Own& own, const Mechanism& mechanism, const double* q, const double* v,
           double* force) const;

  std::vector<Own> laws_;
  std::vector<double> rates_;
  std::vector<double> limits_;  ///< largest torque at each motor's joint [N m, N]
  int states_ = 0;
  bool follows_rates_ = false;
  std::vector<double> values_beside_, rates_beside_;  ///< of a law at another rate
  PlantChanges changes_;
};

}  // namespace jaculus::simulation::detail
