#include "model/urdf_text.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <sstream>

#include "model/urdf_check.h"

namespace jaculus::model {
namespace {

/// The number that a word begins with, and whether it is all of the word.
struct Leading {
  double value = kNaN;
  std::size_t length = 0;
};

Leading leading_number(const std::string& word) {
  Leading number;
  const char* begin = word.data() + (word.starts_with('+') ? 1 : 0);
  const auto [end, code] = std::from_chars(begin, word.data() + word.size(), number.value);
  if (code != std::errc() || !std::isfinite(number.value)) return {};
  number.length = static_cast<std::size_t>(end - word.data());
  return number;
}

Vec3 vector_of(const TiXmlElement* e, const char* attribute) {
  const char* text = e ? e->Attribute(attribute) : nullptr;
  std::istringstream words(text ? text : "");
  Vec3 value = Vec3::Zero();
  for (int i = 0; i < 3; ++i) words >> value[i];
  return words.fail() ? Vec3(Vec3::Zero()) : value;
}

double number_of(const TiXmlElement& e, const char* attribute) {
  double value = 0.0;
  return e.QueryDoubleAttribute(attribute, &value) == TIXML_SUCCESS ? value : 0.0;
}

}  // namespace

std::string without_padding(const std::string& text, Assumptions& assumptions) {
  const std::size_t end = text.find_last_not_of(std::string("\0 \t\r\n", 5));
  const std::size_t padding = text.find('\0', end == std::string::npos ? 0 : end);
  if (padding == std::string::npos) return text;

  const auto line =
      std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(padding), '\n');
  assumptions.assume(static_cast<int>(line) + 1, "byte 0x00 found; allowed: XML text",
                     "the end of the file");
  return text.substr(0, padding);
}

/// tinyxml descends by recursion, so hostile nesting is refused before it is parsed.
void check_nesting(const std::string& text, const std::filesystem::path& file) {
  constexpr int kMaxDepth = 50;
  int depth = 0;
  int line = 1;

  for (std::size_t at = 0; at < text.size(); ++at) {
    const char c = text[at];
    if (c == '\n') ++line;
    if (c == '\0') throw urdf_error(file, line, "byte 0x00 found; allowed: XML text");

    if (c == '<' && text.compare(at, 4, "<!--") == 0) {
      const std::size_t end = std::min(text.find("-->", at), text.size());
      line += static_cast<int>(std::count(text.begin() + at, text.begin() + end, '\n'));
      at = end;
    } else if (c == '<' && at + 1 < text.size()) {
      const char next = text[at + 1];
      depth += next == '/' ? -1 : next == '?' || next == '!' ? 0 : 1;
    } else if (c == '/' && at + 1 < text.size() && text[at + 1] == '>') {
      --depth;
    }

    if (depth > kMaxDepth)
      throw urdf_error(file, line,
                       fmt::format("elements nested deeper than {}; allowed: less", kMaxDepth));
  }
}

std::optional<int> exact_numbers(const std::string& text) {
  std::istringstream words(text);
  int found = 0;
  for (std::string word; words >> word; ++found) {
    if (leading_number(word).length != word.size()) return {};
  }
  return found;
}

std::optional<std::string> repair_numbers(const std::string& text, int count) {
  std::string numbers = text;
  // xacro and roslaunch: $(optenv NAME DEFAULT...)
  const std::string substitution = "$(optenv ";
  if (text.starts_with(substitution) && text.ends_with(')')) {
    const std::size_t name_end = text.find(' ', substitution.size());
    if (name_end == std::string::npos) return {};
    numbers = text.substr(name_end + 1, text.size() - name_end - 2);
  }

  std::istringstream words(numbers);
  std::string repaired;
  int found = 0;
  for (std::string word; found < count && words >> word; ++found) {
    const Leading number = leading_number(word);
    // "2 kg" and "0x1" are no slips of a dot
    const bool slip = word.find_first_not_of(".,;", number.length) == std::string::npos;
    if (number.length == 0 || !slip) return {};
    repaired += fmt::format("{}{}", repaired.empty() ? "" : " ", number.value);
  }
  const bool one_too_many = count == 1 && words >> numbers;
  if (found < count || one_too_many) return {};
  return repaired;
}

void read_shape(const TiXmlElement& collision, std::vector<SpatialShape>& shapes) {
  const TiXmlElement* geometry = collision.FirstChildElement("geometry");
  const TiXmlElement* e = geometry ? geometry->FirstChildElement() : nullptr;
  if (!e) return;

  SpatialShape shape;
  const std::string kind = e->ValueStr();
  if (kind == "sphere") {
    shape.kind = ShapeKind::sphere;
    shape.size = Vec3::Constant(number_of(*e, "radius"));
  } else if (kind == "box") {
    shape.kind = ShapeKind::box;
    shape.size = vector_of(e, "size") / 2.0;
  } else if (kind == "cylinder" || kind == "capsule") {
    shape.kind = kind == "cylinder" ? ShapeKind::cylinder : ShapeKind::capsule;
    const double radius = number_of(*e, "radius");
    shape.size = Vec3(radius, radius, number_of(*e, "length") / 2.0);
  } else {
    return;
  }

  const TiXmlElement* origin = collision.FirstChildElement("origin");
  const Vec3 rpy = vector_of(origin, "rpy");
  shape.position = vector_of(origin, "xyz");
  shape.rotation =
      (Eigen::AngleAxisd(rpy.z(), Vec3::UnitZ()) * Eigen::AngleAxisd(rpy.y(), Vec3::UnitY()) *
       Eigen::AngleAxisd(rpy.x(), Vec3::UnitX()))
          .toRotationMatrix();
  shapes.push_back(shape);
}

}  // namespace jaculus::model
