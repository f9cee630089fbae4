#pragma once
// Compares an Nlp's gradient, Jacobian and Hessian with central differences, entry by entry,
// sparsity included: an entry that the pattern leaves out counts as a zero.

#include <cstdint>

#include "jaculus/transcription/nlp.h"

namespace jaculus::transcription {

/// The largest disagreement found in one kind of derivative. Errors are relative to 1 + the largest
/// entry of the row.
struct DerivativeError {
  double error = 0.0;
  double analytic = 0.0;
  double difference = 0.0;
  std::string row;     ///< name of the row ("objective" for the gradient)
  std::string column;  ///< name of the variable
};

struct DerivativeReport {
  bool defined = false;  ///< the functions could be evaluated at all points needed
  DerivativeError gradient, jacobian, hessian;
};

/// Checks at x with steps h times the variables' scales. The Hessian is that of f + lambda . g with
/// random lambda from `seed`. Outputs are filled with NaN beforehand, so an entry never written is
/// found.
DerivativeReport check_derivatives(Nlp& nlp, const ConstVectorRef& x, double h = 1e-5,
                                   std::uint64_t seed = 1);

/// A random point within the bounds (within `spread` scales of zero where unbounded).
Vector random_point(const Nlp& nlp, const ConstVectorRef& centre, double spread,
                    std::uint64_t seed);

}  // namespace jaculus::transcription
