#pragma once
// A tail for a given body: the Pareto front of effectiveness against tail mass, over length, shaft,
// width and gear.
//
// The tail is a tube of constant mass a length with a half-cylinder scoop of film, ends closed,
// over its outer part:
//   mass      m = lambda L + sigma (pi w/2 (L - L0) + 2 pi w^2/8) + m0
//   inertia   I = lambda L^3/3 + sigma (pi w/2 (L^3 - L0^3)/3 + pi w^2/8 (L0^2 + L^2))
// lambda: tube [kg/m], sigma: film [kg/m^2], m0: at the pin (mount) [kg]. Drag by equation 2 of
// Norby et al. 2021.
//
// Every point of the grid gets its best gear. A design is on the front where none that is lighter
// or as light is as effective. A limit binds at a design of the front where a design that breaks
// this limit alone, by one step of the grid, is better: more effective and no heavier for the
// limits on length and width; more effective at all for the mass budget.
//
//   kind: tail_design
//   base: {...}                     as for a reorientation, without the tail's geometry and inertia
//   limits: {mass: 200 g, stowed_length: 1 m, width: 0.3 m}
//   material: {tube: "0.057 kg/m", film: "0.31 kg/m^2", mount: 0 kg}
//   grid: {length: [0.2 m, 24], shaft_ratio: [0.9, 16], width: [0.02 m, 16]}
//     least (shaft: largest) value, count
//   gears: [1, 50]

#include <string>
#include <vector>

#include "studies/search.h"
#include "studies/setup.h"

namespace jaculus::studies {

/// What a tail is made of.
struct TailMaterial {
  double tube = 0.0;   ///< [kg/m]
  double film = 0.0;   ///< [kg/m^2]
  double mount = 0.0;  ///< [kg]
};

/// One tail.
struct TailDesign {
  double length = 0.0;   ///< L [m]
  double shaft = 0.0;    ///< L0 [m]
  double width = 0.0;    ///< w [m]
  double mass = 0.0;     ///< [kg]
  double inertia = 0.0;  ///< about the pin [kg m^2]
  double gear = 0.0;
  double effectiveness = 0.0;
  double body_angle = 0.0;           ///< magnitude at the end [rad]
  std::string search_bound;          ///< see SearchResult
  std::vector<std::string> binding;  ///< limits that bind, for designs of the front
};

/// What holds a design back.
struct TailLimits {
  double mass = kInfinity;           ///< [kg]
  double stowed_length = kInfinity;  ///< [m]
  double width = kInfinity;          ///< [m]
};

double tail_mass(const TailMaterial& material, double length, double shaft, double width);
double tail_inertia(const TailMaterial& material, double length, double shaft, double width);

/// A design with its best gear; effectiveness NaN where no gear could be integrated.
TailDesign evaluate_design(const ReorientationSetup& base, const TailMaterial& material,
                           double length, double shaft, double width, const SearchSpace& gears);

/// The front by rising mass, with what binds at each design. Designs that break a limit take part
/// only in that judgement.
std::vector<TailDesign> pareto_front(const std::vector<TailDesign>& designs,
                                     const TailLimits& limits);

}  // namespace jaculus::studies
