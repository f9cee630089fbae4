#include "report/document/html.h"

#include <fmt/format.h>
#include <sodium.h>

#include <array>
#include <stdexcept>

namespace jaculus::report {
namespace {

/// sha256 of a text as base64, as a content security policy wants it.
std::string hash_of(const std::string& text) {
  std::array<unsigned char, crypto_hash_sha256_BYTES> hash{};
  crypto_hash_sha256(hash.data(), reinterpret_cast<const unsigned char*>(text.data()), text.size());
  std::array<char,
             sodium_base64_ENCODED_LEN(crypto_hash_sha256_BYTES, sodium_base64_VARIANT_ORIGINAL)>
      base64{};
  sodium_bin2base64(base64.data(), base64.size(), hash.data(), hash.size(),
                    sodium_base64_VARIANT_ORIGINAL);
  return base64.data();
}

void replace_all(std::string& text, const std::string& from, const std::string& to) {
  for (std::size_t at = text.find(from); at != std::string::npos;
       at = text.find(from, at + to.size()))
    text.replace(at, from.size(), to);
}

}  // namespace

std::string html_escaped(const std::string& text) {
  // A round trip through JSON replaces what is no UTF-8.
  std::string clean =
      nlohmann::json::parse(
          nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace))
          .get<std::string>();
  replace_all(clean, "&", "&amp;");
  replace_all(clean, "<", "&lt;");
  replace_all(clean, ">", "&gt;");
  replace_all(clean, "\"", "&quot;");
  replace_all(clean, "'", "&#39;");
  return clean;
}

std::string json_for_script(const nlohmann::ordered_json& json) {
  std::string text = json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
  std::string safe;
  safe.reserve(text.size());

  for (const char c : text) {
    // Outside strings JSON has none of these, inside they may be escaped.
    switch (c) {
      case '<':
        safe += "\\u003c";
        break;
      case '>':
        safe += "\\u003e";
        break;
      case '&':
        safe += "\\u0026";
        break;
      default:
        safe += c;
    }
  }

  replace_all(safe, "\xE2\x80\xA8", "\\u2028");
  replace_all(safe, "\xE2\x80\xA9", "\\u2029");
  return safe;
}

std::string html_page(const Page& page) {
  // A bundle never holds the end of its own element: esbuild writes it as <\/script.
  if (page.script.find("</script") != std::string::npos)
    throw std::logic_error("a bundle ends its own element");

  const std::string allowed =
      page.script.empty() ? "'none'" : fmt::format("'sha256-{}'", hash_of(page.script));
  std::string text = "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n";
  text += fmt::format(
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src "
      "'unsafe-inline'; img-src "
      "data: "
      "blob:; script-src {}\">\n",
      allowed);
  text += "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n";
  text +=
      "<meta name=\"color-scheme\" content=\"light dark\">\n<link rel=\"icon\" href=\"data:,\">\n";
  text += fmt::format("<title>{}</title>\n<style>\n{}\n</style>\n</head>\n<body>\n",
                      html_escaped(page.title), page.style);
  text += page.body;
  if (!page.script.empty()) {
    text += fmt::format("<script type=\"application/json\" id=\"data\">{}</script>\n",
                        json_for_script(page.data));
    text += "<script>" + page.script + "</script>\n";
  }

  return text + "</body>\n</html>\n";
}

}  // namespace jaculus::report
