#pragma once
// The names of rows and variables, "rear_feet, node 7: front_a voltage", in their parts.

#include <string>

namespace jaculus::solver {

struct RowWords {
  std::string phase;  ///< "rear_feet"; empty where the row belongs to none
  std::string place;  ///< "node 7", "interval 3"; may be empty
  std::string what;   ///< "front_a voltage"
  std::string kind;   ///< "motor voltage"; `what` itself where that is no kind of several
  std::string of;     ///< "front_a"; empty where kind is `what`
};
RowWords row_words(const std::string& name);

}  // namespace jaculus::solver
