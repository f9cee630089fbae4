#pragma once
// The factories of all terms, and what they share. The catalogue is catalogue.cpp.

#include <memory>

#include "jaculus/dynamics/rigid_body.h"
#include "jaculus/transcription/term.h"

namespace jaculus::terms {

// Contact.
void friction(const TermSpec& spec, TermContext& context);
void normal_force(const TermSpec& spec, TermContext& context);
void force_at_end(const TermSpec& spec, TermContext& context);
void swing_clearance(const TermSpec& spec, TermContext& context);
void add_stance(TermContext& context);   ///< feet on the ground and at rest where the first phase begins
void add_impacts(TermContext& context);  ///< at every phase in which a foot lands
// Actuation.
void voltage(const TermSpec& spec, TermContext& context);
void joint_range(const TermSpec& spec, TermContext& context);
void torque_squared(const TermSpec& spec, TermContext& context);
void electrical_energy(const TermSpec& spec, TermContext& context);
// Ends of the plan.
void touchdown_pitch(const TermSpec& spec, TermContext& context);
void mean_acceleration(const TermSpec& spec, TermContext& context);
void final_velocity(const TermSpec& spec, TermContext& context);
void distance(const TermSpec& spec, TermContext& context);
void height(const TermSpec& spec, TermContext& context);
void time(const TermSpec& spec, TermContext& context);

/// Phases named by the key `phases`, all where it is absent.
std::vector<int> chosen_phases(const yaml::Node& node, const TermContext& context);
/// Feet named by the key `feet`, all where it is absent.
std::vector<int> chosen_feet(const yaml::Node& node, const TermContext& context);
int phase_index(const yaml::Node& node, const TermContext& context);
int foot_index(const yaml::Node& node, const TermContext& context);
/// Index of a coordinate that a term cannot do without.
int needed_coordinate(const char* name, const TermSpec& spec, const TermContext& context);
/// Leaves out the first and last collocation points of a phase, counted on the grid of the file. False where none remains.
bool leave_out(int first, int last, const PhaseSpec& phase, Scheme scheme, PathTerm& term);
/// Columns of q and v of a node.
std::vector<int> node_columns(const TermContext& context, int node);
/// A force that is large for this robot: its weight, or 1 N where it has none [N].
double weight_scale(const TermContext& context);

/// Kinematics of a node term's point functions; shared by the copies of the term.
struct PointFunction {
  PointFunction(const AbsoluteTree& tree, PointSum sum)
      : point(std::move(sum)), motion(tree), scratch(tree), gradient(Vector::Zero(2 * tree.n)) {}
  PointSum point;
  Motion motion;
  PointScratch scratch;
  Vector gradient;  // by (q, v)
};

}  // namespace jaculus::terms
