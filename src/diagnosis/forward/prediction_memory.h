#pragma once
// What a forward model has predicted already, kept.
//
// A search among more candidates begins as the one before it: about the files' values, one effect
// moved at a time. A quarter of all predictions of a diagnosis under a plan are of parameters that
// were predicted before (10 to 47 % of nine cases), most of them from the search's beginning, so
// the first predictions are kept until the memory is full and none is ever left out for another.

#include "diagnosis/forward/problem.h"

namespace jaculus::diagnosis {

/// The same model, bit for bit, that simulates no parameters twice as long as what it has predicted
/// fits into `megabytes`. `nominal`: of the parameters, so that only what differs is kept of them.
ForwardModel remembering(ForwardModel model, Vector nominal, double megabytes);

/// A model of the same data with more effects that leaves to the model before it, and so to what
/// that one remembers, whatever no added effect moves: an effect at nominal changes nothing.
/// `own`: the larger model's hypotheses; those of `before` are these, in order, less the added.
ForwardModel beside(ForwardModel model, const Hypotheses& own, const Problem& before);

}  // namespace jaculus::diagnosis
