#pragma once
// White columns with their products, put side by side or added without another pass over the rows
// of the random effects: that pass costs a hundred times what the columns' own products do.

#include "diagnosis/noise/random_effects.h"

namespace jaculus::diagnosis {

struct Columns {
  Matrix X;           ///< rows x n
  Products products;  ///< of X
};

Columns columns_of(const RandomEffects& effects, Matrix X);

/// [A B].
Columns side_by_side(const RandomEffects& effects, const Columns& a, const Columns& b);

/// A with the one column of `moved` added to its first.
Columns first_moved(const RandomEffects& effects, const Columns& a, const Columns& moved);

}  // namespace jaculus::diagnosis
