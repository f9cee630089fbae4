// Five-bars: where the pin of two chains from one hip is, which URDF can't say.
//
// Both chains end at the pin where the file draws them so, all joints at zero. Else the pin is
// taken to be as far from one knee as from the other, where the shorter of the lower links ends;
// what the longer one has beyond it is a foot.

#include <fmt/format.h>

#include <cmath>

#include "jaculus/model/tolerances.h"
#include "model/propose/draft.h"

namespace jaculus::model {
namespace {

/// Ends nearer than a builder can place them are one.
double same_place() { return Tolerances{}.com; }

}  // namespace

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
