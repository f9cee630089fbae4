// Five-bars: where the pin of two chains from one hip is, which URDF can't say.
//
// Both chains end at the pin where the file draws them so, all joints at zero. Else the pin is
// taken to be as far from one knee as from the other, where the shorter of the lower links ends;
// what the longer one has beyond it is a foot.
//
// Such a leg has coordinates of its own: with phi the pitch of the upper links a and b,
//     extension = +-(phi_a - phi_b)/2,  angle = (phi_a + phi_b)/2,
// up to what the joints' zeros add. By the extension alone the knees come apart where both motors
// sit on one axle, so that its range keeps the lower links from folding onto one another and from
// stretching into a line, beyond which no position of the motors closes the loop. A range of each
// motor can't. With r_a and r_b the lower links and D the knees' distance, the angle g at the pin
// is
//     cos g = (r_a^2 + r_b^2 - D^2)/(2 r_a r_b).

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "jaculus/model/tolerances.h"
#include "model/propose/draft.h"

namespace jaculus::model {
namespace {

/// Ends nearer than a builder can place them are one.
double same_place() { return Tolerances{}.com; }

/// Least angle of the lower links at the pin, and to a straight line [rad]: links of the simulated
/// robot meet at half of it (simulation/plant/passive_forces.h).
constexpr double kOpen = 0.2;
/// How far such a leg swings either way of rest, where the file has no range [rad].
constexpr double kSwing = 0.5 * M_PI;

Vec2 origin_of(const Draft& draft, int body, const std::map<std::string, double>& joints) {
  return pose_of(draft.reduction, body, joints).head<2>();
}

/// Whether the lower links are neither folded nor stretched.
bool is_open(const Draft& draft, const DraftLoop& loop,
             const std::map<std::string, double>& joints) {
  const double a = loop.a.point.norm();
  const double b = loop.b.point.norm();
  const Vec2 apart = origin_of(draft, loop.b.body, joints) - origin_of(draft, loop.a.body, joints);
  return std::abs(a * a + b * b - apart.squaredNorm()) < 2.0 * a * b * std::cos(kOpen);
}

/// A leg as its coordinates are looked for.
struct Swung {
  const Draft& draft;
  const DraftLoop& loop;
  std::array<int, 2> hips;  ///< bodies of the upper links
  LegCoordinates leg;

  /// The pose at rest, stretched and swung by so much [rad].
  [[nodiscard]] std::map<std::string, double> posed(double stretch, double swing) const {
    std::map<std::string, double> joints = draft.rest;
    for (std::size_t i = 0; i < 2; ++i)
      joints[leg.joints[i]] += 2.0 * (leg.stretch[i] * stretch + leg.swing[i] * swing);
    return joints;
  }

  /// How far the middle of the knees then is from the middle of the hips [m].
  [[nodiscard]] double reach(double stretch) const {
    const std::map<std::string, double> joints = posed(stretch, 0.0);
    const Vec2 knees =
        origin_of(draft, loop.a.body, joints) + origin_of(draft, loop.b.body, joints);
    const Vec2 axles = origin_of(draft, hips[0], joints) + origin_of(draft, hips[1], joints);
    return 0.5 * (knees - axles).norm();
  }

  /// How far it can be stretched and stays open however it swings, or shortened (way: -1) [rad].
  [[nodiscard]] double open_for(double way) const {
    constexpr double kStep = 1e-3;  // [rad]
    constexpr int kSwings = 4;      // either way: of hips that lie apart each swing has its own
    double least = M_PI;
    for (int k = -kSwings; k <= kSwings; ++k) {
      double far = 0.0;
      while (far < least && is_open(draft, loop, posed(way * far, kSwing * k / kSwings)))
        far += kStep;
      least = std::min(least, far - kStep);
    }
    return least;
  }
};

}  // namespace

std::optional<LegCoordinates> leg_coordinates(const Draft& draft, const DraftLoop& loop) {
  const std::vector<PlanarBody>& bodies = draft.reduction.bodies;
  Swung swung{draft, loop, {bodies[loop.a.body].parent, bodies[loop.b.body].parent}, {}};
  LegCoordinates& leg = swung.leg;
  for (std::size_t i = 0; i < 2; ++i) {
    const Bounds& range = draft.reduction.ranges[swung.hips[i]];
    if (std::isfinite(range.lower) || std::isfinite(range.upper)) return {};
    leg.joints[i] = bodies[swung.hips[i]].joint;
    leg.swing[i] = 0.5 * bodies[swung.hips[i]].sign;
  }

  constexpr double kLittle = 1e-3;  // [rad]: enough to tell which way is longer
  leg.stretch = {leg.swing[0], -leg.swing[1]};
  if (swung.reach(kLittle) < swung.reach(0.0)) leg.stretch = {-leg.swing[0], leg.swing[1]};

  const double shorter = swung.open_for(-1.0);
  const double longer = swung.open_for(1.0);
  if (!(shorter > 0.0) || !(longer > 0.0)) return {};

  double extension = 0.0;
  double angle = 0.0;
  for (std::size_t i = 0; i < 2; ++i) {
    extension += leg.stretch[i] * draft.rest.at(leg.joints[i]);
    angle += leg.swing[i] * draft.rest.at(leg.joints[i]);
  }
  leg.extension = {extension - shorter, extension + longer};
  leg.angle = {angle - kSwing, angle + kSwing};
  return leg;
}

Vec2 point_at(const Draft& draft, int body, const Vec2& point,
              const std::map<std::string, double>& joints) {
  const Eigen::Vector3d pose = pose_of(draft.reduction, body, joints);
  const double c = std::cos(pose[2]);
  const double s = std::sin(pose[2]);
  return {pose[0] + c * point.x() + s * point.y(), pose[1] - s * point.x() + c * point.y()};
}

DraftLoop pinned(const Draft& draft, const std::string& leg, const DraftFoot& a,
                 const DraftFoot& b) {
  const double apart = (point_at(draft, a.body, a.point) - point_at(draft, b.body, b.point)).norm();
  const double beyond = std::abs(a.point.norm() - b.point.norm());
  const bool b_is_longer = beyond > same_place() && b.point.norm() > a.point.norm();

  DraftLoop loop;
  loop.name = leg + "_leg";
  loop.ends = {a, b};
  loop.foot = b_is_longer ? b : a;
  loop.foot.name = leg + "_foot";
  loop.a = a;
  loop.b = b;
  loop.a.cap = loop.b.cap = 0.0;  // a pin goes through the middle
  if (apart < same_place()) {
    loop.source = "both lower links end there with all joints at zero";
  } else {
    const double reach = std::min(a.point.norm(), b.point.norm());
    loop.a.point *= reach / a.point.norm();
    loop.b.point *= reach / b.point.norm();
    loop.source = fmt::format(
        "{:.4g} m from both knees, where {} ends, is a guess: with all joints at zero the ends lie "
        "{:.2g} m apart",
        reach, beyond > same_place() ? "the shorter lower link" : "a lower link", apart);
  }
  if (beyond <= same_place()) loop.foot.point = loop.a.point;
  return loop;
}

void add_five_bar(Draft& draft, const std::string& leg, const DraftFoot& a, const DraftFoot& b) {
  const DraftLoop loop = pinned(draft, leg, a, b);
  draft.loops.push_back(loop);
  draft.feet.push_back(loop.foot);

  if (loop.foot.guessed)
    draft.missing.push_back(fmt::format("feet.{}.point: {}", loop.foot.name, loop.foot.source));
}

}  // namespace jaculus::model
