#include "testbed/joint_laws.h"

#include <algorithm>
#include <cmath>

namespace jaculus::testbed {
namespace {

constexpr double kSpotWidth = 0.1;    ///< of a tight spot and of a catch [rad]
constexpr double kCableReach = 0.3;   ///< beyond taut, where a cable pulls with its share [rad]
constexpr double kStopDamping = 0.5;  ///< of a soft stop, over speed [s/rad]
constexpr double kStopDepth = 0.1;    ///< at which it yields [rad]
constexpr double kTailShare = 0.05;   ///< of a tail motor's torque, that laws take theirs of [-]
constexpr double kDragRate = 10.0;    ///< at which square drag takes its share [rad/s]

double bristle_at(const JointDisturbances& o, const JointMemory& memory, double u) {
  const double by = u - memory.last;
  if (by == 0.0) return memory.bristle;
  const double end = by > 0.0 ? 1.0 : -1.0;
  return end + (memory.bristle - end) * std::exp(-std::abs(by) / o.hysteresis_width);
}

/// What pulls back beyond a place on one side [-]; `share` is signed by the side.
double cable_pull(const JointDisturbances& o, double u) {
  const double side = o.cable > 0.0 ? 1.0 : -1.0;
  const double beyond = std::clamp((side * u - o.cable_slack) / kCableReach, 0.0, 1.0);
  return -o.cable * beyond * beyond;
}

double stop_push(const JointDisturbances& o, double u, double rate) {
  const double side = o.stop > 0.0 ? 1.0 : -1.0;
  const double into = std::clamp(side * u - o.stop_place, 0.0, kStopDepth);
  return -o.stop * into * std::max(0.0, 1.0 + kStopDamping * side * rate);
}

double detent_pull(const JointDisturbances& o, double u) {
  const double x = (u - o.detent_place) / kSpotWidth;
  return -o.detent * x * std::exp(0.5 * (1.0 - x * x));
}

double torque_measure(const JointSize& size, const Drive& drive) {
  return drive.limb == Limb::tail ? kTailShare * size.torque : size.torque;
}

/// By which the motor's torque arrives otherwise [N m or N].
double lost_on_the_way(const JointDisturbances& o, const JointSize& size, const Drive& drive,
                       const JointMotion& now) {
  double torque = now.torque;
  const double share = torque / size.torque;
  if (o.saturation != 0.0) torque /= 1.0 + o.saturation * share * share;
  if (o.gear_runout != 0.0) {
    const double turned = drive.motor.gear * now.angle / size.radian;
    torque *= 1.0 + o.gear_runout * std::sin(turned + o.gear_phase);
  }
  return torque - now.torque;
}

}  // namespace

double torque_of_laws(const JointDisturbances& o, const JointSize& size, const Drive& drive,
                      const JointMemory& memory, const JointMotion& now) {
  const double u = (now.angle - memory.start) / size.radian, rate = now.rate / size.radian;
  double share = 0.0;
  if (o.hysteresis != 0.0) share -= o.hysteresis * bristle_at(o, memory, u);
  if (o.cable != 0.0) share += cable_pull(o, u);
  if (o.stop != 0.0) share += stop_push(o, u, rate);
  if (o.detent != 0.0) share += detent_pull(o, u);

  if (o.square_drag != 0.0 && drive.limb != Limb::tail) {
    const double speed = rate / kDragRate;
    share -= o.square_drag * std::abs(speed) * speed;
  }
  return share * torque_measure(size, drive) + lost_on_the_way(o, size, drive, now);
}

double friction_of_laws(const JointDisturbances& o, const JointSize& size, const Drive& drive,
                        const JointMemory& memory) {
  double share = 0.0;
  if (o.tight_spot != 0.0) {
    const double x = (memory.last - o.tight_spot_place) / kSpotWidth;
    share += o.tight_spot * std::exp(-0.5 * x * x);
  }
  if (o.grease != 0.0) share += o.grease * std::exp(-memory.travel / o.grease_travel);
  return share * torque_measure(size, drive);
}

JointMemory moved(const JointDisturbances& o, const JointSize& size, JointMemory memory,
                  double angle) {
  const double u = (angle - memory.start) / size.radian;
  memory.bristle = bristle_at(o, memory, u);
  memory.travel += std::abs(u - memory.last);
  memory.last = u;
  return memory;
}

double misreading(const JointDisturbances& o, const JointSize& size, double angle) {
  if (o.encoder_runout == 0.0) return 0.0;
  const double turned = std::sin(angle / size.radian + o.encoder_phase);
  return size.radian * o.encoder_runout * (turned - std::sin(o.encoder_phase));
}

double misreading_rate(const JointDisturbances& o, const JointSize& size, double angle) {
  if (o.encoder_runout == 0.0) return 0.0;
  return o.encoder_runout * std::cos(angle / size.radian + o.encoder_phase);
}

}  // namespace jaculus::testbed
