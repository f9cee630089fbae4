#include "simulation/plant/laws.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>

#include "jaculus/components/motor.h"
#include "jaculus/core/error.h"

namespace jaculus::simulation {

bool is_of_motor(ReadingKind kind) {
  return kind == ReadingKind::motor_torque || kind == ReadingKind::motor_current ||
         kind == ReadingKind::motor_voltage || kind == ReadingKind::motor_limit;
}

}  // namespace jaculus::simulation

namespace jaculus::simulation::detail {

namespace {

bool of_joint(ReadingKind kind) {
  return is_of_motor(kind) || kind == ReadingKind::joint_position ||
         kind == ReadingKind::joint_rate || kind == ReadingKind::joint_load;
}

bool of_joint(ActionKind kind) {
  return kind == ActionKind::joint_torque || kind == ActionKind::torque_scale;
}

/// Of a joint's rate, by which the slope of its torque is told; more where it turns faster. A sign
/// that is smoothed is so over far more; one that isn't has a slope that ends there [rad/s, m/s].
constexpr double kRateStep = 1e-6;

/// Generalised force less the motors' that a joint feels, by its row: -row.h/(row.row).
double load_at(const Row& row, const Inertia& inertia) {
  double along = 0.0, square = 0.0;
  for (int i = 0; i < inertia.size(); ++i) {
    along -= row[i] * inertia.bias(i);
    square += row[i] * row[i];
  }
  return square > 0.0 ? along / square : 0.0;
}

int body_named(const model::PlanarModel& model, const std::string& name) {
  for (int b = 0; b < count_of(model.bodies); ++b)
    if (model.bodies[b].name == name) return b;
  return -1;
}

}  // namespace

Laws::Laws(const Plant& plant) {
  const model::PlanarModel& model = plant.model;

  for (const Law& law : plant.laws) {
    const auto joint = [&](const std::string& name, bool needs_motor) {
      Place place;
      place.motor = model.motor_index(name);
      place.body = model.body_of_joint(name);
      if (place.body < 0)
        throw InputError(fmt::format("{}: the robot has no joint '{}'", law.name, name));
      if (needs_motor && place.motor < 0)
        throw InputError(fmt::format("{}: no motor turns joint '{}'", law.name, name));
      place.count =
          place.motor < 0 ? model.bodies[place.body].count : model.motors[place.motor].count;
      return place;
    };
    const auto body = [&](const std::string& name, const Vec2& point) {
      Place place{-1, body_named(model, name), point, 1};
      if (place.body < 0)
        throw InputError(fmt::format("{}: the robot has no body '{}'", law.name, name));
      place.count = model.bodies[place.body].count;
      return place;
    };

    Own own{&law, law.functions(), {}, {}, {}, {}, {}, {}, {}, {}};
    for (const Reading& r : law.readings) {
      const bool whole = r.kind == ReadingKind::time || r.kind == ReadingKind::bus_voltage;
      own.read_at.push_back(whole              ? Place{}
                            : of_joint(r.kind) ? joint(r.of, is_of_motor(r.kind))
                                               : body(r.of, r.point));
    }
    int values = 0;
    for (const Action& a : law.actions) {
      own.act_at.push_back(a.kind == ActionKind::bus_drop || a.kind == ActionKind::friction_scale
                               ? Place{}
                           : of_joint(a.kind) ? joint(a.of, a.kind == ActionKind::torque_scale)
                                              : body(a.of, a.point));
      own.before = own.before || a.before_motors();
      values += a.values();
    }

    own.readings.assign(law.readings.size(), 0.0);
    own.actions.assign(values, 0.0);
    own.states.assign(law.states.size(), 0.0);
    own.rates.assign(law.states.size(), 0.0);
    states_ += count_of(law.states);
    pair_rates(own);
    follows_rates_ = follows_rates_ || !own.own_rates.empty();
    laws_.push_back(std::move(own));
  }

  for (const model::PlanarMotor& motor : model.motors)
    limits_.push_back(components::largest_joint_torque(motor).value);
  rates_.assign(states_, 0.0);
  changes_.torque_scale.assign(model.motors.size(), 1.0);
}

void Laws::pair_rates(Own& own) {
  int value = 0;
  for (std::size_t a = 0; a < own.act_at.size(); ++a) {
    for (std::size_t i = 0; i < own.read_at.size(); ++i)
      if (own.law->actions[a].kind == ActionKind::joint_torque &&
          own.law->readings[i].kind == ReadingKind::joint_rate &&
          own.read_at[i].body == own.act_at[a].body)
        own.own_rates.push_back({static_cast<int>(i), value, own.act_at[a]});
    value += own.law->actions[a].values();
  }
}

void Laws::start(double* states) const {
  for (const Own& own : laws_)
    for (const LawState& state : own.law->states) *states++ = state.initial / state.scale;
}

/// All but motors and battery.
void Laws::read(Own& own, const Mechanism& mechanism, const Inertia& inertia, double t,
                const double* q, const double* v) {
  PointState point{};
  const Place* pointed = nullptr;  // whose point is in `point`
  for (std::size_t i = 0; i < own.readings.size(); ++i) {
    const Place& place = own.read_at[i];
    const ReadingKind kind = own.law->readings[i].kind;
    double& value = own.readings[i];
    const bool at_point = kind >= ReadingKind::point_x && kind <= ReadingKind::point_rate_z;
    if (at_point &&
        (pointed == nullptr || pointed->body != place.body || pointed->point != place.point)) {
      mechanism.point(place.body, place.point, point);
      pointed = &place;
    }
    if (of_joint(kind) && !is_of_motor(kind)) {
      JointState joint;
      if (place.motor >= 0) {
        joint = {mechanism.motor_angle(place.motor, q), mechanism.motor_rate(place.motor, v), 0.0,
                 mechanism.motor_row[place.motor]};
      } else {
        mechanism.joint(place.body, q, v, joint);
      }
      value = kind == ReadingKind::joint_position ? joint.value : joint.rate;
      if (kind == ReadingKind::joint_load) value = load_at(joint.row, inertia) / place.count;
      continue;
    }
    if (kind == ReadingKind::time) value = t;
    if (kind == ReadingKind::point_x) value = point.px;
    if (kind == ReadingKind::point_z) value = point.pz;
    if (kind == ReadingKind::point_rate_x) value = point.vx;
    if (kind == ReadingKind::point_rate_z) value = point.vz;
    if (kind == ReadingKind::body_rate) value = mechanism.frame(place.body).omega;
    if (kind == ReadingKind::body_angle)
      value = std::atan2(mechanism.frame(place.body).s, mechanism.frame(place.body).c);
    if (is_of_motor(kind) || kind == ReadingKind::bus_voltage) value = 0.0;
  }
}

void Laws::read_motors(Own& own, const std::vector<MotorState>& motors, double bus) {
  for (std::size_t i = 0; i < own.readings.size(); ++i) {
    const int motor = own.read_at[i].motor;
    const ReadingKind kind = own.law->readings[i].kind;
    if (kind == ReadingKind::motor_torque) own.readings[i] = motors[motor].torque;
    if (kind == ReadingKind::motor_current) own.readings[i] = motors[motor].current;
    if (kind == ReadingKind::motor_voltage) own.readings[i] = motors[motor].voltage;
    if (kind == ReadingKind::motor_limit) own.readings[i] = limits_[motor];
    if (kind == ReadingKind::bus_voltage) own.readings[i] = bus;
  }
}

const PlantChanges& Laws::before_motors(const Mechanism& mechanism, const Inertia& inertia,
                                        double t, const double* q, const double* v,
                                        const double* states) {
  std::fill(changes_.torque_scale.begin(), changes_.torque_scale.end(), 1.0);
  changes_.bus_drop = 0.0;
  changes_.friction_scale = 1.0;
  for (Own& own : laws_) {
    read(own, mechanism, inertia, t, q, v);
    for (std::size_t k = 0; k < own.states.size(); ++k)
      own.states[k] = *states++ * own.law->states[k].scale;
    if (!own.before) continue;

    assert(own.functions.before && "an action before the motors has its function");
    own.functions.before(own.readings.data(), own.states.data(), own.actions.data());
    const double* value = own.actions.data();
    for (std::size_t a = 0; a < own.act_at.size(); ++a) {
      const Action& action = own.law->actions[a];
      if (action.kind == ActionKind::torque_scale)
        changes_.torque_scale[own.act_at[a].motor] *= *value;
      if (action.kind == ActionKind::bus_drop) changes_.bus_drop += *value;
      if (action.kind == ActionKind::friction_scale)
        changes_.friction_scale *= std::max(0.0, *value);
      value += action.values();
    }
  }
  return changes_;
}

const Row& Laws::row_of(const Place& joint, const Mechanism& mechanism, const double* q,
                        const double* v, JointState& state) {
  if (joint.motor >= 0) return mechanism.motor_row[joint.motor];
  mechanism.joint(joint.body, q, v, state);
  return state.row;
}

void Laws::act(const Own& own, const Mechanism& mechanism, const double* q, const double* v,
               double* force) const {
  const double* value = own.actions.data();
  for (std::size_t a = 0; a < own.act_at.size(); ++a) {
    const Action& action = own.law->actions[a];
    const Place& place = own.act_at[a];
    if (action.kind == ActionKind::joint_torque) {
      JointState joint;
      const Row& row = row_of(place, mechanism, q, v, joint);
      for (int i = 0; i < mechanism.n; ++i) force[i] += place.count * value[0] * row[i];
    } else if (action.kind == ActionKind::point_force) {
      PointState point;
      mechanism.point(place.body, place.point, point);
      for (int i = 0; i < mechanism.n; ++i)
        force[i] += place.count * (value[0] * point.jx[i] + value[1] * point.jz[i]);
    } else if (action.kind == ActionKind::body_moment) {
      const Frame& frame = mechanism.frame(place.body);
      for (int i = 0; i < mechanism.n; ++i) force[i] += place.count * value[0] * frame.w[i];
    }
    value += action.values();
  }
}

void Laws::add(const Mechanism& mechanism, const std::vector<MotorState>& motors, double bus,
               const double* q, const double* v, double* force) {
  double* rate = rates_.data();
  for (Own& own : laws_) {
    read_motors(own, motors, bus);
    own.functions.act(own.readings.data(), own.states.data(), own.actions.data(), own.rates.data());
    act(own, mechanism, q, v, force);
    for (std::size_t k = 0; k < own.rates.size(); ++k)
      *rate++ = own.rates[k] / own.law->states[k].scale;
  }
}

void Laws::list_fast_parts(const Mechanism& mechanism, const double* q, const double* v,
                           std::vector<FastPart>& parts) {
  for (Own& own : laws_) {
    values_beside_.resize(own.actions.size());
    rates_beside_.resize(own.rates.size());
    for (const OwnRate& pair : own.own_rates) {
      double& rate = own.readings[pair.reading];
      const double here = rate;
      rate += kRateStep * std::max(1.0, std::abs(here));
      const double step = rate - here;
      own.functions.act(own.readings.data(), own.states.data(), values_beside_.data(),
                        rates_beside_.data());
      rate = here;

      JointState joint;
      const double rise = values_beside_[pair.value] - own.actions[pair.value];
      parts.push_back({.row = row_of(pair.joint, mechanism, q, v, joint),
                       .damping = std::max(0.0, -pair.joint.count * rise / step)});
    }
  }
}

}  // namespace jaculus::simulation::detail
