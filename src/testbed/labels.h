#pragma once
// Labels of cases as text.

#include <string>
#include <vector>

#include "jaculus/testbed/blinded_cases.h"

namespace jaculus::testbed {

/// One line of JSON.
std::string label_text(const CaseLabel& label);

/// What is encrypted: all labels, each as label_text() gives it, and where the batch comes from.
std::string sealed_text(const std::vector<std::string>& labels, const std::string& provenance);
std::vector<CaseLabel> labels_in(const std::string& sealed, std::string* provenance);

}  // namespace jaculus::testbed
