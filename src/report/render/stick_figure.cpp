#include "report/render/stick_figure.h"

#include <algorithm>
#include <cmath>

#include "jaculus/components/tail_drag.h"
#include "jaculus/dynamics/loop_closure.h"
#include "jaculus/dynamics/rigid_body.h"

namespace jaculus::report {
namespace {

constexpr int kDragArrows = 5;

/// A body's line in its own frame: joints, pins, feet and the ends of a scoop, from its root
/// outwards (the base: from rear to front).
std::vector<Vec2> body_points(const model::PlanarModel& model, int body) {
  std::vector<Vec2> points;
  const auto add = [&points](const Vec2& p) {
    const auto near = [&p](const Vec2& other) { return (p - other).norm() < 1e-9; };
    if (std::none_of(points.begin(), points.end(), near)) points.push_back(p);
  };

  if (body > 0) add(Vec2::Zero());
  for (const model::PlanarBody& child : model.bodies)
    if (child.parent == body) add(child.origin);
  for (const model::PlanarLoop& loop : model.loops) {
    if (loop.body_a == body) add(loop.point_a);
    if (loop.body_b == body) add(loop.point_b);
  }

  for (const model::PlanarPoint& foot : model.feet)
    if (foot.body == body) add(foot.position);
  for (const model::PlanarDrag& drag : model.drags)
    if (drag.body == body) add(drag.end * drag.direction);
  if (points.size() < 2) {
    for (const model::PlanarPoint& point : model.points)
      if (point.body == body) add(point.position);
  }

  const model::PlanarBody& link = model.bodies[body];
  if (points.size() < 2) add(link.com);
  // a cart, a lone base
  if (points.size() < 2) points = {link.com - Vec2(0.05, 0.0), link.com + Vec2(0.05, 0.0)};
  if (body == 0) {
    std::sort(points.begin(), points.end(),
              [](const Vec2& a, const Vec2& b) { return a.x() < b.x(); });
  } else {
    std::sort(points.begin(), points.end(),
              [](const Vec2& a, const Vec2& b) { return a.norm() < b.norm(); });
  }
  return points;
}

/// A line of a figure: paths to its points, and the part of the viewer's figure that they fill.
struct Line {
  int body = 0;
  std::vector<dynamics::Path> points;
  ActorBody out;
};

std::vector<Line> make_lines(const model::PlanarModel& model, const dynamics::AbsoluteTree& tree) {
  std::vector<Line> lines;
  const auto add = [&](int body, const std::string& name, BodyKind kind,
                       const std::vector<Vec2>& points) {
    Line line{body, {}, {name, kind, count_of(points), {}}};
    for (const Vec2& p : points) line.points.push_back(tree.path_to(model, body, p));
    lines.push_back(std::move(line));
  };
  for (int b = 0; b < count_of(model.bodies); ++b)
    add(b, model.bodies[b].name, body_kind(model, b), body_points(model, b));
  for (const model::PlanarDrag& drag : model.drags)
    add(drag.body, drag.name + " scoop", BodyKind::scoop,
        {drag.start * drag.direction, drag.end * drag.direction});
  return lines;
}

void append(std::vector<double>& values, const Vec2& p) {
  values.push_back(p.x());
  values.push_back(p.y());
}

/// Arrows of one frame's loads.
class Loads {
 public:
  Loads(const model::PlanarModel& model, const dynamics::AbsoluteTree& tree,
        const MotionChannels& channels, Actor& actor)
      : model_(model), tree_(tree), channels_(channels), actor_(actor) {
    for (std::size_t f = 0; f < model.feet.size(); ++f) {
      const std::string& foot = model.feet[f].name;
      if (!channels.contains(foot + "_force_x") || !channels.contains(foot + "_force_z")) continue;
      feet_.push_back(f);
      actor.feet.push_back(foot);
      actor.arrows.push_back({foot, ArrowKind::force, {}, {}});
    }

    for (const model::PlanarDrag& drag : model.drags) {
      if (drag.kind == model::DragKind::none || drag.coefficient == 0.0) continue;
      const int count = drag.kind == model::DragKind::point ? 1 : kDragArrows;
      for (int k = 0; k < count; ++k) {
        const double share = (k + 0.5) / count;
        const double distance = drag.kind == model::DragKind::point
                                    ? drag.point_distance
                                    : drag.start + share * (drag.end - drag.start);
        drags_.push_back(
            {&drag, distance, tree.path_to(model, drag.body, distance * drag.direction)});
        actor.arrows.push_back({drag.name + " drag", ArrowKind::drag, {}, {}});
      }
    }
  }

  void frame(const dynamics::Motion& motion, double t, const std::vector<bool>& known) {
    std::size_t a = 0;
    for (const std::size_t f : feet_) {
      const std::string& foot = model_.feet[f].name;
      append(actor_.arrows[a].from, position(tree_.feet[f], motion.pose));
      append(actor_.arrows[a++].force, {channel_at(channels_.at(foot + "_force_x"), t),
                                        channel_at(channels_.at(foot + "_force_z"), t)});
    }
    for (const DragPlace& place : drags_) {
      const bool there = known[place.drag->body];
      append(actor_.arrows[a].from, position(place.path, motion.pose));
      append(actor_.arrows[a++].force, there ? drag(place, motion) : Vec2(kNaN, kNaN));
    }
  }

  void nothing() {
    for (ActorArrow& arrow : actor_.arrows) {
      append(arrow.from, Vec2(kNaN, kNaN));
      append(arrow.force, Vec2(kNaN, kNaN));
    }
  }

 private:
  struct DragPlace {
    const model::PlanarDrag* drag;
    double distance;
    dynamics::Path path;
  };

  /// Force there, a unit of length [N/m]; of a point force the whole [N].
  static Vec2 drag(const DragPlace& place, const dynamics::Motion& motion) {
    const model::PlanarDrag& d = *place.drag;
    const double phi = motion.pose.Y[dynamics::AbsoluteTree::angle_index(d.body)];
    dynamics::PointColumns J;
    dynamics::jacobian_columns(place.path, motion.pose, J);
    const Vec2 n = components::drag_normal(d, phi);
    const double u = n.dot(J.times(motion.V) - d.wind_W);
    const double size = d.kind == model::DragKind::point ? d.point_area : d.width;
    return -0.5 * d.density * d.coefficient * size * u * std::abs(u) * n;
  }

  const model::PlanarModel& model_;
  const dynamics::AbsoluteTree& tree_;
  const MotionChannels& channels_;
  Actor& actor_;
  std::vector<std::size_t> feet_;
  std::vector<DragPlace> drags_;
};

/// Lifts or lowers the base so that the lowest foot is at z = 0.
void stand_on_floor(const model::PlanarModel& model, const dynamics::AbsoluteTree& tree, Vector& q,
                    dynamics::Motion& motion) {
  const int z = model.coordinate_index("z");
  if (z < 0 || model.feet.empty()) return;
  double lowest = kInfinity;
  for (const dynamics::Path& foot : tree.feet)
    lowest = std::min(lowest, position(foot, motion.pose).y());
  q[z] -= lowest;
  static_cast<void>(dynamics::set_configuration(tree, q, motion));
}

}  // namespace

BodyKind body_kind(const model::PlanarModel& model, int body) {
  if (body == 0) return BodyKind::base;
  for (const model::PlanarDrag& drag : model.drags)
    if (drag.body == body) return BodyKind::tail;
  for (const model::PlanarPoint& foot : model.feet)
    for (int b = foot.body; b > 0; b = model.bodies[b].parent)
      if (b == body) return BodyKind::leg;
  for (const model::PlanarLoop& loop : model.loops)
    for (const int end : {loop.body_a, loop.body_b})
      if (end == body || model.bodies[end].parent == body) return BodyKind::leg;
  return BodyKind::link;
}

std::vector<ActorPhase> motion_phases(const trajectory::Table& plan) {
  std::vector<ActorPhase> phases;
  const auto time = plan.values.col(plan.column("time"));
  for (int k = 0; k < count_of(plan.phase); ++k) {
    const double t = time[k];
    if (phases.empty() || phases.back().name != plan.phase[k])
      phases.push_back({plan.phase[k], t, t});
    phases.back().to = t;
  }
  return phases;
}

Actor stick_figure(const model::PlanarModel& model, const MotionChannels& channels,
                   const StickFigureOptions& options) {
  const dynamics::AbsoluteTree tree(model);
  const CoordinateFrames frames = coordinate_frames(model, channels, options.most_frames);
  const std::vector<bool> known = known_bodies(model, frames.known);
  std::vector<Line> lines = make_lines(model, tree);
  Actor actor;
  actor.name = options.name;
  actor.style = options.style;
  actor.colour = options.colour;
  actor.phases = options.phases;
  actor.friction = options.friction;
  actor.time = frames.time;
  Actor unloaded;  // where loads are not wanted
  Loads loads(model, tree, channels, options.loads ? actor : unloaded);
  const bool whole = std::all_of(known.begin(), known.end(), [](bool b) { return b; });

  dynamics::Motion motion(tree);
  for (Eigen::Index k = 0; k < frames.q.cols(); ++k) {
    Vector q = frames.q.col(k);
    const bool posed = q.allFinite() && set_configuration(tree, q, motion);
    if (posed && !frames.height_known) stand_on_floor(model, tree, q, motion);
    for (Line& line : lines) {
      const bool there = posed && known[line.body];
      for (const dynamics::Path& path : line.points)
        append(line.out.xz, there ? position(path, motion.pose) : Vec2(kNaN, kNaN));
    }
    if (whole) append(actor.com, posed ? dynamics::centre_of_mass(tree, motion) : Vec2(kNaN, kNaN));
    if (!posed) {
      loads.nothing();
      continue;
    }
    dynamics::set_rates(tree, frames.v.col(k), motion);
    loads.frame(motion, frames.time[k], known);
  }

  for (Line& line : lines)
    if (known[line.body]) actor.bodies.push_back(std::move(line.out));
  return actor;
}

std::vector<std::vector<Vec2>> stick_lines(const model::PlanarModel& model, const Vector& q) {
  const dynamics::AbsoluteTree tree(model);
  dynamics::Motion motion(tree);
  if (!dynamics::set_configuration(tree, q, motion)) return {};
  std::vector<std::vector<Vec2>> lines;
  for (int b = 0; b < count_of(model.bodies); ++b) {
    lines.emplace_back();
    for (const Vec2& p : body_points(model, b))
      lines.back().push_back(position(tree.path_to(model, b, p), motion.pose));
  }
  return lines;
}

}  // namespace jaculus::report
