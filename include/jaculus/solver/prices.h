#pragma once
// What each limit costs: the rate of the best objective with the limit, from the multipliers of a solve.
//
// With the Lagrangian of NlpResult, f + lambda' g - z_l' (x - x_l) - z_u' (x_u - x), the envelope theorem gives
//   d f*/d (row limit) = -lambda,   d f*/d x_l = z_l,   d f*/d x_u = -z_u,   d f*/d (fixed value) = z_l - z_u,
// to first order, while the same limits stay active, at a regular local optimum. A price of 0.43 of "rear motor voltage,
// upper" is 0.43 units of the objective a volt: raising the limit by a volt changes the objective by about +0.43.

#include <string>
#include <vector>

#include "jaculus/solver/result.h"
#include "jaculus/transcription/nlp.h"

namespace jaculus {

enum class Side { lower, upper, fixed };  ///< fixed: equal bounds, an equality

/// Price of one active limit.
struct LimitPrice {
  bool is_row = true;
  int index = 0;  ///< of the row or variable
  std::string name;
  std::string unit;  ///< of the limit
  Side side = Side::fixed;
  double limit = 0.0;   ///< in `unit`
  double price = 0.0;   ///< d objective / d limit [objective's unit over `unit`]
  double scaled = 0.0;  ///< price x scale of the limit / scale of the objective [-], to rank by
};

struct PriceOptions {
  bool maximise = false;    ///< the Nlp minimises the negative of what the user maximises: prices of the latter
  double threshold = 1e-6;  ///< smallest |scaled| that is listed: below are inactive limits and round-off
  bool equalities = false;  ///< list equality rows and fixed variables as well (defects have prices nobody can pay)
};

/// Active limits by falling |scaled|, then index. std::logic_error unless the result converged: prices elsewhere mislead.
std::vector<LimitPrice> limit_prices(const Nlp& nlp, const NlpResult& result, const PriceOptions& options = {});

/// "lower", "upper", "fixed".
std::string to_string(Side side);

}  // namespace jaculus
