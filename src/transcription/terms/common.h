#pragma once
// What terms share, and the terms that every problem has. Each term that a file may name is one
// function that returns its declaration; catalogue.cpp lists them.

#include <memory>

#include "jaculus/dynamics/rigid_body.h"
#include "jaculus/transcription/term.h"

namespace jaculus::transcription::terms {

// Keys that several terms have.
Key phases_key();     ///< `phases`: all where absent
Key feet_key();       ///< `feet`: all where absent
Key of_key();         ///< `of`: base or com
Key direction_key();  ///< `direction`: x or z

/// feet on the ground and at rest where the first phase begins
void add_stance(TermContext& context);
void add_impacts(TermContext& context);  ///< at every phase in which a foot lands

/// Index of a coordinate that a term cannot do without.
int needed_coordinate(const char* name, const TermSpec& spec, const TermContext& context);
/// Leaves out the first and last collocation points of a phase, counted on the grid of the file.
/// False where none remains.
bool leave_out(int first, int last, const PhaseSpec& phase, Scheme scheme, PathTerm& term);
/// Columns of q and v of a node.
std::vector<int> node_columns(const TermContext& context, int node);
/// A force that is large for this robot: its weight, or 1 N where it has none [N].
double weight_scale(const TermContext& context);

/// Kinematics of a node term's point functions; shared by the copies of the term.
struct PointFunction {
  PointFunction(const dynamics::AbsoluteTree& tree, dynamics::PointSum sum)
      : point(std::move(sum)), motion(tree), scratch(tree), gradient(Vector::Zero(2 * tree.n)) {}
  dynamics::PointSum point;
  dynamics::Motion motion;
  dynamics::PointScratch scratch;
  Vector gradient;  // by (q, v)
};

}  // namespace jaculus::transcription::terms
