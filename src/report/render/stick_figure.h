#pragma once
// Robots as stick figures over time: what was planned, simulated or measured, put through the
// kinematics of the planar model.
//
// Coordinates come from channels of their own name; those which have none follow from the joints
// that were measured (least squares over theta = joint_map q + joint_offset). Bodies behind a
// coordinate that nothing determines are not drawn. Where the base's height is not known the lowest
// foot stands on the floor; where its position or pitch is not known, it is zero.
//
// Drag at distance l of the scoop, a unit of length: -1/2 rho C_D w u|u| n, u the air's normal
// speed there (tail_drag.h).

#include <string>
#include <vector>

#include "jaculus/model/planar.h"
#include "jaculus/trajectory/csv.h"
#include "report/document/document.h"
#include "report/render/motion_channels.h"

namespace jaculus::report {

/// Phases of a plan's table, from its column `phase`.
std::vector<ActorPhase> motion_phases(const trajectory::Table& plan);

struct StickFigureOptions {
  std::string name;
  ActorStyle style = ActorStyle::solid;
  int colour = 0;
  std::vector<ActorPhase> phases = {};
  double friction = kNaN;  ///< of the friction cone; NaN: none is drawn
  bool loads = true;       ///< forces of feet and drag where their channels are there
  int most_frames = 400;   ///< longer motions are drawn at as many evenly spaced instants
};

/// The robot over the span of its channels. Without a channel that gives a coordinate: no frames.
Actor stick_figure(const model::PlanarModel& model, const MotionChannels& channels,
                   const StickFigureOptions& options);

/// The lines of a model's bodies in one configuration q (n), by body; empty where a loop can't
/// close.
std::vector<std::vector<Vec2>> stick_lines(const model::PlanarModel& model, const Vector& q);

/// What a body is to the viewer: base, tail, leg or link.
BodyKind body_kind(const model::PlanarModel& model, int body);

}  // namespace jaculus::report
