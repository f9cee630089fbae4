#pragma once
// A report as JSON for its viewers (web/src, figures.py). Numbers of series and figures stand apart, in `arrays`: each is base64
// of little-endian single precision, and is referred to by its index; equal arrays (times, above all) are kept once.

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "jaculus/report/report.h"

namespace jaculus {

/// Arrays of a page, each kept once.
class NumberArrays {
 public:
  nlohmann::ordered_json add(const std::vector<double>& values);  ///< its index; null where it is empty
  [[nodiscard]] nlohmann::ordered_json list() const { return list_; }

 private:
  std::map<std::string, int> index_;
  std::vector<std::string> list_;
};

nlohmann::ordered_json report_json(const Report& report);

}  // namespace jaculus
