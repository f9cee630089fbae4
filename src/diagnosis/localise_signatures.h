#pragma once
// Signatures of the catalogue's effects, component by component, as columns of a share system.
//
// A column is [y(theta) - y(nominal)] scale/step, step: the effect's own probe, later the strength that the residual asks for of it
// (a secant, so that a signature holds at the size of the gap and not at zero alone). An effect on all legs gets three candidates:
// front legs alone, rear legs alone, and both, whose column is their sum.

#include <string>
#include <vector>

#include "diagnosis/localise_shares.h"
#include "jaculus/diagnosis/evidence_space.h"

namespace jaculus {

/// One parameter of one effect, acting in one component.
struct SignatureColumn {
  int candidate = 0;  ///< in the hypotheses
  int parameter = 0;  ///< in the effect
  Component part = Component::body;
  bool split = false;   ///< front or rear legs alone
  double step = 0.0;    ///< from nominal, in the parameter's unit
  bool failed = false;  ///< no simulation with it went through
};

struct Signatures {
  std::vector<SignatureColumn> columns;
  std::vector<ShareCandidate> candidates;  ///< refer to columns, then to sums and nuisances behind them
  std::vector<int> hypothesis;             ///< of each candidate
  std::vector<int> nuisances;              ///< columns of condition-wide nuisances
  int total = 0;                           ///< columns of the system
  ShareSystem system{0};
};

/// Sets an effect on a plant, in one component alone where it acts in the front and the rear legs.
void apply_in(const Effect& effect, const Vector& theta, Component part, Plant& plant);

/// Columns and candidates of every effect; sums of front and rear, then nuisances, stand behind the columns.
Signatures plan_columns(const Hypotheses& hypotheses);
/// Fills the columns of sums from their parts' ones.
void sum_parts(const Signatures& signatures, Matrix& S);

/// Builds the system of all conditions in the evidence space about a linearisation; `notes` gets what could not be simulated.
Signatures signatures_of(const DiagnosisProblem& problem, const Linearisation& about, const PlantForward& forward,
                         std::vector<std::string>& notes);

}  // namespace jaculus
