#pragma once
// Self-contained HTML around a script, its style and its data.

#include <nlohmann/json.hpp>
#include <string>

namespace jaculus::report {

/// Text that no HTML parser reads as markup.
std::string html_escaped(const std::string& text);

/// JSON that can stand in a <script> element: no '<', '>' or '&' and no line separators that a
/// script would read as such. Bytes that are no UTF-8 become U+FFFD.
std::string json_for_script(const nlohmann::ordered_json& json);

struct Page {
  std::string title;
  std::string style;            ///< CSS, ours
  std::string script;           ///< JavaScript, ours; empty: none
  std::string body;             ///< HTML, already safe
  nlohmann::ordered_json data;  ///< for the script
};

/// The page. Its content security policy forbids every request and every script but `script`, which
/// it names by its hash.
std::string html_page(const Page& page);

}  // namespace jaculus::report
