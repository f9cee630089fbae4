#pragma once
// Stance rows that fixed variables already imply break the constraint qualification; they are found
// by rank and left out.

#include "jaculus/transcription/term.h"

namespace jaculus::transcription {

/// For every stance term: brings its free variables onto the rows (Gauss-Newton from the middle of
/// their bounds), keeps the rows whose gradients are independent there, in their order, and drops
/// the rest. A dropped row that does not hold is the user's contradiction: InputError naming it.
/// Returns a sentence for each kind of row dropped.
std::vector<std::string> remove_redundant_rows(TermContext& context);

}  // namespace jaculus::transcription
