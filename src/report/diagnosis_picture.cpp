#include "report/diagnosis_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "diagnosis/forward/problem.h"
#include "jaculus/diagnosis/summary.h"
#include "report/render/motion_channels.h"
#include "report/render/stick_figure.h"

namespace jaculus::report {
namespace {

using diagnosis::Posture;
using model::PlanarModel;

constexpr double kLineWidth = 0.012;                   // of the picture's height or width
constexpr double kLongestArrow = 0.3;                  // likewise
constexpr double kArc = 0.09;                          // radius of a torque's arrow, likewise
constexpr double kWidestArc = 1.5 * std::numbers::pi;  // of the largest torque [rad]
constexpr double kSmallest = 0.1;  // of the largest force of its kind, below which none is drawn
constexpr double kTold = 2.0;      // standard deviations below which a force is not drawn

using Lines = std::vector<std::vector<Vec2>>;

/// Half the extent of the lines of all postures, each about its measured base.
double extent_of(const std::vector<Lines>& all) {
  double left = kInfinity, right = -kInfinity, low = kInfinity, high = -kInfinity;
  for (const Lines& lines : all) {
    for (const auto& line : lines) {
      for (const Vec2& p : line) {
        left = std::min(left, p.x());
        right = std::max(right, p.x());
        low = std::min(low, p.y());
        high = std::max(high, p.y());
      }
    }
  }
  return left <= right ? std::max({right - left, high - low, 1e-3}) : 1.0;
}

void shift(Lines& lines, double x) {
  for (auto& line : lines)
    for (Vec2& p : line) p.x() += x;
}

/// The largest absolute force of a kind over all postures.
struct LargestForces {
  double linear = 0.0, angular = 0.0;
};

LargestForces largest_forces(const PlanarModel& model, const std::vector<Posture>& postures) {
  LargestForces most;
  for (const Posture& posture : postures) {
    for (Eigen::Index i = 0; i < posture.force.size(); ++i) {
      double& own = model.coordinates[i].angular ? most.angular : most.linear;
      own = std::max(own, std::abs(posture.force[i]));
    }
  }
  return most;
}

/// The first body that a coordinate moves; the base where no joint goes with it.
int body_of(const PlanarModel& model, int coordinate) {
  for (int b = 1; b < count_of(model.bodies); ++b)
    if (model.joint_map(b, coordinate) != 0.0) return b;
  return 0;
}

/// How a coordinate that slides moves its body's root [1].
Vec2 direction_of(const PlanarModel& model, const Vector& q, int coordinate, int body) {
  constexpr double kStep = 1e-4;  // [m]
  Vector there = q;
  there[coordinate] += kStep;
  const Lines a = stick_lines(model, q), b = stick_lines(model, there);
  if (a.empty() || b.empty()) return Vec2::Zero();
  const Vec2 moved = b[body].front() - a[body].front();
  return moved.norm() > 0.0 ? Vec2(moved / moved.norm()) : Vec2(Vec2::Zero());
}

/// A line with a head at its end.
std::vector<Vec2> with_head(std::vector<Vec2> line, double size) {
  const Vec2 tip = line.back();
  const Vec2 back = line[line.size() - 2] - tip;
  if (!(back.norm() > 0.0)) return line;
  const Vec2 along = size * back / back.norm(), across(-along.y(), along.x());
  line.push_back(tip + along + 0.6 * across);
  line.push_back(tip);
  line.push_back(tip + along - 0.6 * across);
  return line;
}

/// A torque about +y (from +z towards +x) as an arc about a joint.
std::vector<Vec2> arc(const Vec2& centre, double radius, double angle) {
  constexpr int kPoints = 24;
  std::vector<Vec2> line;
  for (int k = 0; k <= kPoints; ++k) {
    const double phi = angle * k / kPoints;
    line.push_back(centre + radius * Vec2(std::sin(phi), std::cos(phi)));
  }
  return line;
}

std::string force_text(const PlanarModel& model, const Posture& posture, int i) {
  return fmt::format("{:.2g} \u00B1 {:.1g} {} along {}", posture.force[i],
                     posture.force_deviation[i], model.coordinates[i].angular ? "N m" : "N",
                     diagnosis::in_words(model.coordinates[i].name));
}

/// Arrows of the forces that the data tell from zero.
void add_forces(const PlanarModel& model, const Posture& posture, double offset, double extent,
                const LargestForces& most, Drawing& drawing) {
  const Lines lines = stick_lines(model, posture.measured);
  std::string told;
  for (int i = 0; i < count_of(model.coordinates) && posture.force.size() > 0; ++i) {
    const double force = posture.force[i];
    const double largest = model.coordinates[i].angular ? most.angular : most.linear;
    if (std::abs(force) < kSmallest * largest) continue;
    if (lines.empty() || !(std::abs(force) > kTold * posture.force_deviation[i])) continue;
    const int body = body_of(model, i);
    Vec2 at = body > 0 ? lines[body].front() : Vec2(0.5 * (lines[0].front() + lines[0].back()));
    at.x() += offset;

    const double width = kLineWidth * extent;
    std::vector<Vec2> line;
    if (model.coordinates[i].angular) {
      line = arc(at, kArc * extent, kWidestArc * force / largest);
    } else {
      const Vec2 along = direction_of(model, posture.measured, i, body);
      line = {at, at + kLongestArrow * extent * force / largest * along};
    }
    const std::string text = force_text(model, posture, i);
    drawing.parts.push_back({model.coordinates[i].name, with_head(line, 3.0 * width), 0.6 * width,
                             kNaN, "the model lacks " + text, "force"});
    told += (told.empty() ? "" : ", ") + text;
  }
  if (!told.empty()) drawing.caption = "The model as believed lacks " + told + ".";
}

/// Lines of one posture in one style; measured ones that nothing measured in another.
void add_robot(const PlanarModel& model, const Vector& q, double offset, double width,
               const std::string& style, const std::vector<bool>& known, Drawing& drawing) {
  if (q.size() == 0) return;
  Lines lines = stick_lines(model, q);
  shift(lines, offset);
  for (int b = 0; b < count_of(lines); ++b) {
    const bool assumed = style == "measured" && !known[b];
    const std::string& name = model.bodies[b].name;
    drawing.parts.push_back({name, lines[b], b == 0 ? 1.6 * width : width, kNaN,
                             name + (assumed ? ", from the model" : ", " + style),
                             assumed ? "assumed" : style});
  }
}

/// The floor under the robot.
void add_floor(const PlanarModel& model, double extent, Drawing& drawing) {
  if (model.feet.empty()) return;
  drawing.parts.push_back({"floor",
                           {Vec2(-0.5 * extent, 0.0), Vec2(0.5 * extent, 0.0)},
                           0.3 * kLineWidth * extent,
                           kNaN,
                           "floor"});
}

bool any_style(const Picture& picture, const std::string& style) {
  for (const Drawing& panel : picture.panels)
    for (const Drawing::Part& part : panel.parts)
      if (part.style == style) return true;
  return false;
}

void add_legend(Picture& picture) {
  const std::pair<const char*, const char*> meanings[] = {
      {"measured", "measured"},
      {"assumed", "not measured, as the model has it"},
      {"nominal", "model as believed"},
      {"augmented", "model with what was found"},
      {"force", "force or torque that the model as believed lacks"}};
  for (const auto& [style, meaning] : meanings)
    if (any_style(picture, style)) picture.legend.emplace_back(style, meaning);
}

}  // namespace

Picture telling_picture(const diagnosis::Diagnosis& d) {
  Picture picture{"telling", "The robot at telling times", {}, {}, ""};
  if (!d.where || d.where->postures.empty() || !d.problem) return picture;
  const std::vector<Posture>& postures = d.where->postures;
  const diagnosis::ObservedDataset& observed =
      d.problem->observations.datasets[postures.front().dataset];
  const PlanarModel& model = observed.model;

  const int x = model.coordinate_index("x");
  std::vector<Lines> all;
  std::vector<double> offsets;
  for (const Posture& posture : postures) {
    offsets.push_back(x >= 0 && model.base_free[0] ? -posture.measured[x] : 0.0);
    for (const Vector* q : {&posture.measured, &posture.nominal}) {
      all.push_back(stick_lines(model, *q));
      shift(all.back(), offsets.back());
    }
  }
  const double extent = extent_of(all), width = kLineWidth * extent;
  const LargestForces most = largest_forces(model, postures);

  for (std::size_t i = 0; i < postures.size(); ++i) {
    const Posture& posture = postures[i];
    Drawing panel{fmt::format("telling_{}", i + 1),
                  fmt::format("{:.3g} s: {}", posture.time, posture.why),
                  {},
                  ""};
    add_floor(model, extent, panel);
    add_robot(model, posture.nominal, offsets[i], width, "nominal", {}, panel);
    if (!d.model.candidates.empty())
      add_robot(model, posture.augmented, offsets[i], width, "augmented", {}, panel);
    add_robot(model, posture.measured, offsets[i], 0.6 * width, "measured",
              known_bodies(model, posture.known), panel);
    add_forces(model, posture, offsets[i], extent, most, panel);
    picture.panels.push_back(std::move(panel));
  }

  add_legend(picture);
  const diagnosis::Segment& segment = observed.segments[postures.front().segment];
  picture.caption = fmt::format(
      "{}, {}{}; times count from its start. A trial's own clock, start and offsets are taken out.",
      observed.name(), observed.dataset.trials[segment.trial].name,
      observed.measured_input ? fmt::format(" from {:.3g} s on", segment.start) : "");
  return picture;
}

}  // namespace jaculus::report
