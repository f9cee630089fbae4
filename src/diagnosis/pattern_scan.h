#pragma once
// Forces of a stated form (place_patterns.h) as candidates beside the catalogue, and what each
// would explain about a fitted model, by simulation of whole motions and linear algebra.
//
// About a model p, with tolerances and gains at t (prior scales), white residuals are
//   r_0 = r - J_t t = J_t t' + sum_k Y_k b_k + e,   Y_k = T df/db_k,   b_k ~ N(0, 1) prior scales,
// f simulated with the force of a pattern k at work; t' ~ N(0, 1) again, for a pattern that
// explains what they were strained for lets them go back; e with the misfits of
// noise/random_effects.h of most likely size. Contacts, closures and free flight are the
// simulation's: a force at a foot acts where the foot touches, and no coordinate has to be
// measured.
//   gain of a set S:  G(S) = log Z(S) - log Z(nothing),  Z by linear algebra
// What is set beside data held out is both without what t' can do, M = I + J_t J_t^T:
//   M^-1/2 r_0,  M^-1/2 Y_k

#include <optional>
#include <string>
#include <vector>

#include "diagnosis/build_problem.h"
#include "diagnosis/noise/columns.h"
#include "diagnosis/remainder/place_patterns.h"

namespace jaculus::diagnosis {

/// A model in a problem: its effects, and every parameter.
struct KnownModel {
  const Problem* problem = nullptr;
  std::vector<int> candidates;  ///< of the problem
  Vector p;
};

/// Its parameters in a problem about other effects or windows of the same data; what it doesn't
/// have is nominal.
Vector carried_over(const KnownModel& model, const Hypotheses& hypotheses);

/// Patterns with the problem in which they are candidates.
struct PatternProblem {
  std::vector<PlacePattern> patterns;
  BuiltProblem built;
  Comparison comparison;
  Vector p;                  ///< of the model about which all is
  std::vector<Vector> rows;  ///< predicted there, a dataset each
};

/// About a model, streams aligned as stated, or anew where nothing is stated. Nothing where it
/// can't be simulated.
std::optional<PatternProblem> pattern_problem(const KnownModel& about,
                                              const std::vector<Alignment>& alignments);

/// The linear problem of the patterns.
struct LinearPatterns {
  Columns model;                ///< [r_0 J_t]
  Shrinkage nuisances;          ///< M^-1/2
  Vector residual;              ///< M^-1/2 r_0
  std::vector<Columns> acting;  ///< Y_k, a pattern each; empty where it can't act
  std::vector<Matrix> columns;  ///< M^-1/2 Y_k, likewise
  int tried = 0;
};
/// The same before any pattern's columns are known, which take a simulation or two each.
LinearPatterns without_patterns(const PatternProblem& own);
void add_columns(const PatternProblem& own, LinearPatterns& linear);

/// M^-1/2 Y_k of some patterns, side by side.
Matrix columns_of(const LinearPatterns& linear, const std::vector<int>& members);

/// log Z of some patterns at work.
double log_evidence(const PatternProblem& own, const LinearPatterns& linear,
                    const std::vector<int>& members);

/// A pattern that may be at work.
struct LikelyPattern {
  PlacePattern pattern;
  double gain = 0.0;  ///< [nats]
};

/// Those that gain anything, of each place and kind the best one, most gain first.
struct PatternScan {
  std::vector<LikelyPattern> likely;
  int tried = 0;
};

/// Patterns that the catalogue doesn't have about a model, settings.patterns_tried at most.
PatternScan likely_patterns(const KnownModel& about, const std::vector<Alignment>& alignments);

/// A pattern as a candidate, its shape free.
effects::Effect pattern_effect(const PlacePattern& pattern);

}  // namespace jaculus::diagnosis
