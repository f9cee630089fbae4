#pragma once
// A document as JSON for its viewers (render/web/src, render/figures.py). Numbers of series and
// figures stand apart, in `arrays`: each is base64 of little-endian single precision, and is
// referred to by its index; equal arrays (times, above all) are kept once.

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "report/document/document.h"

namespace jaculus::report {

/// Arrays of a page, each kept once.
class NumberArrays {
 public:
  /// its index; null where it is empty
  nlohmann::ordered_json add(const std::vector<double>& values);
  [[nodiscard]] nlohmann::ordered_json list() const { return list_; }

 private:
  std::map<std::string, int> index_;
  std::vector<std::string> list_;
};

nlohmann::ordered_json document_json(const Document& document);

}  // namespace jaculus::report
