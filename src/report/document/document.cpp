#include "report/document/document.h"

#include <algorithm>
#include <cctype>
#include <memory>

namespace jaculus::report {

Report finished(Document document) {
  return {std::make_shared<const Document>(std::move(document))};
}

std::string report_id(const std::string& name) {
  std::string id;
  for (const char c : name) {
    const auto byte = static_cast<unsigned char>(c);
    const bool plain = byte < 128 && std::isalnum(byte) != 0;
    if (plain)
      id += static_cast<char>(std::tolower(byte));
    else if (!id.empty() && id.back() != '_')
      id += '_';
  }
  while (!id.empty() && id.back() == '_') id.pop_back();
  return id.empty() ? "chart" : id;
}

std::string plain(std::string name) {
  std::replace(name.begin(), name.end(), '_', ' ');
  return name;
}

}  // namespace jaculus::report
