#pragma once
// Studies of kind `reorientation`: one computed motion a grid point, with an inner search for the
// best value of a parameter.
//
//   base: {body: {...}, tail: {...}, motor: {...}, task: {...}, air: {...}, scaling: {...}}
//     numbers by name, setup.h
//   cases: [{name: as built}, {name: no drag, set: {tail.drag: none}, search: off}]
//     optional: column `case`
//   grid: {tail.length: [...], ...}                                                optional: grid.h
//   search: {parameter: motor.gear, integers: [1, 50], maximise: effectiveness}
//     optional; or range: [1, 50]
//
// maximise: effectiveness or body_angle. In still air both mean the same for a tail that reaches
// its stop; in wind a tail that hardly turns can have any effectiveness, so body_angle is the
// figure of merit there.
//
//   outputs: [gear, effectiveness, ...]                     columns, from output_catalogue()

#include <optional>
#include <string>
#include <vector>

#include "jaculus/studies/study.h"
#include "studies/search.h"
#include "studies/setup.h"

namespace jaculus::studies {

/// What a search maximises: body over tail angle, or the body's rotation.
enum class Merit { effectiveness, body_angle };

/// The inner search of a study.
struct ParameterSearch {
  const Parameter* parameter = nullptr;
  Merit merit = Merit::effectiveness;
  SearchSpace space;
};

/// A grid point computed. What an output does not need may be absent.
struct ReorientationPoint {
  ReorientationSetup setup;  ///< with the best value found
  ReorientationResult result;
  std::string search_bound;                         ///< see SearchResult
  std::optional<ReorientationResult> without_drag;  ///< its own search, drag none
  std::optional<ReorientationResult> rigid;         ///< no root spring
  std::optional<ReorientationResult> still;         ///< no wind, no speed of the body
};

/// A figure of a point.
struct Output {
  std::string name;                                         ///< column with unit
  bool without_drag = false, rigid = false, still = false;  ///< what it needs besides
  StudyJson (*value)(const ReorientationPoint&);
  std::string meaning;
};

const std::vector<Output>& output_catalogue();

/// The point for a setup, at the best value of `search` where there is one. An integrator that
/// fails counts as no candidate; where every one fails, or the only one, std::runtime_error.
ReorientationPoint compute_point(const ReorientationSetup& setup,
                                 const std::optional<ParameterSearch>& search, bool without_drag,
                                 bool rigid, bool still);

}  // namespace jaculus::studies
