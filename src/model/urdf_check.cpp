#include "model/urdf_check.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tinyxml.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <set>
#include <sstream>

#include "jaculus/core/yaml.h"

namespace jaculus::model {
namespace {

using Names = std::vector<std::string>;

/// What an element may hold: attributes ("!" first where they must be there) and children; numbers
/// are checked.
struct Schema {
  Names attributes;
  Names children;
  Names once;     ///< children that may stand once only
  Names numbers;  ///< attributes that hold numbers, as "name:count"
};

const std::map<std::string, Schema>& schemas() {
  static const std::map<std::string, Schema> table = {
      {"link", {{"!name", "type"}, {"inertial", "visual", "collision"}, {"inertial"}, {}}},
      {"inertial", {{}, {"origin", "mass", "inertia"}, {"origin", "mass", "inertia"}, {}}},
      {"mass", {{"!value"}, {}, {}, {"value:1"}}},
      {"inertia",
       {{"!ixx", "!ixy", "!ixz", "!iyy", "!iyz", "!izz"},
        {},
        {},
        {"ixx:1", "ixy:1", "ixz:1", "iyy:1", "iyz:1", "izz:1"}}},
      {"origin", {{"xyz", "rpy"}, {}, {}, {"xyz:3", "rpy:3"}}},
      {"joint",
       {{"!name", "!type"},
        {"origin", "parent", "child", "axis", "limit", "dynamics", "calibration",
         "safety_controller"},
        {"origin", "parent", "child", "axis", "limit", "dynamics", "calibration",
         "safety_controller"},
        {}}},
      {"parent", {{"!link"}, {}, {}, {}}},
      {"child", {{"!link"}, {}, {}, {}}},
      {"axis", {{"!xyz"}, {}, {}, {"xyz:3"}}},
      {"limit",
       {{"lower", "upper", "!effort", "!velocity"},
        {},
        {},
        {"lower:1", "upper:1", "effort:1", "velocity:1"}}},
      {"dynamics", {{"damping", "friction"}, {}, {}, {"damping:1", "friction:1"}}},
  };

  return table;
}

std::string hint(const std::string& name, const Names& names) {
  const std::optional<std::string> near = yaml::nearest_name(name, names);
  return near ? fmt::format(", did you mean '{}'?", *near) : "";
}

class Checker {
 public:
  explicit Checker(const std::filesystem::path& file) : file_(file) {}

  UrdfOutline run(const TiXmlElement& robot) {
    if (robot.ValueStr() != "robot")
      fail(robot, fmt::format("<{}> given; allowed: <robot>", robot.ValueStr()));
    if (!robot.Attribute("name"))
      fail(robot, "<robot>: attribute 'name' is missing; it must be given");
    for (const TiXmlElement* e = robot.FirstChildElement(); e; e = e->NextSiblingElement()) top(*e);
    for (const TiXmlElement* e = robot.FirstChildElement("joint"); e;
         e = e->NextSiblingElement("joint"))
      ends(*e);
    return outline_;
  }

 private:
  [[noreturn]] void fail(const TiXmlElement& e, const std::string& what) const {
    throw urdf_error(file_, e.Row(), what);
  }

  void top(const TiXmlElement& e) {
    static const Names allowed = {"link", "joint", "material", "gazebo", "transmission", "mujoco"};
    const std::string kind = e.ValueStr();
    if (std::find(allowed.begin(), allowed.end(), kind) == allowed.end()) {
      fail(e, fmt::format("unknown element <{}>{}; allowed: {}", kind, hint(kind, allowed),
                          fmt::join(allowed, ", ")));
    }

    if (kind != "link" && kind != "joint") {
      if (kind != "material")
        outline_.notes.push_back(fmt::format("URDF: <{}> is for other tools and not read", kind));
      return;
    }

    element(e, kind);
    const std::string name = e.Attribute("name");
    if (name.empty()) fail(e, fmt::format("<{}>: the name is empty; allowed: a word", kind));

    auto& lines = kind == "link" ? link_lines_ : joint_lines_;
    const auto [old, fresh] = lines.emplace(name, e.Row());
    if (!fresh)
      fail(e, fmt::format("{} '{}' given twice (first in line {}); allowed: once", kind, name,
                          old->second));

    if (kind == "link") {
      link(e, name);
      outline_.links.push_back({name, e.Row()});
    } else {
      joint(e, name);
      outline_.joints.push_back({name, e.Row(), e.FirstChildElement("parent")->Attribute("link"),
                                 e.FirstChildElement("child")->Attribute("link")});
    }
  }

  void link(const TiXmlElement& e, const std::string& name) {
    const TiXmlElement* inertial = e.FirstChildElement("inertial");
    if (!inertial) return;
    for (const char* part : {"mass", "inertia"}) {
      if (!inertial->FirstChildElement(part)) {
        fail(*inertial,
             fmt::format("link '{}': <inertial> has no <{}>; it must be given", name, part));
      }
    }
  }

  void joint(const TiXmlElement& e, const std::string& name) {
    static const Names types = {"fixed", "revolute", "continuous", "prismatic"};
    const std::string type = e.Attribute("type");
    if (std::find(types.begin(), types.end(), type) == types.end()) {
      fail(e, fmt::format("joint '{}': type '{}' given{}; allowed: {}", name, type,
                          hint(type, types), fmt::join(types, ", ")));
    }

    for (const char* part : {"parent", "child"}) {
      if (!e.FirstChildElement(part))
        fail(e, fmt::format("joint '{}' has no <{}>; it must be given", name, part));
    }
    if (type != "fixed" && !e.FirstChildElement("axis")) {
      fail(e, fmt::format("joint '{}' has no <axis>; it must be given where a joint moves", name));
    }

    const TiXmlElement* limit = e.FirstChildElement("limit");
    if ((type == "revolute" || type == "prismatic") &&
        (!limit || !limit->Attribute("lower") || !limit->Attribute("upper"))) {
      fail(limit ? *limit : e,
           fmt::format("joint '{}' ({}) needs <limit> with lower, upper, effort and velocity", name,
                       type));
    }

    if (limit)
      note_once(
          "URDF: effort and velocity limits of joints are not read; motors in robot.yaml have "
          "their own");

    const TiXmlElement* dynamics = e.FirstChildElement("dynamics");
    if (dynamics)
      note_once(fmt::format("URDF: damping and friction of joint '{}' are not read", name));
  }

  /// Both ends of a joint must be links of this file.
  void ends(const TiXmlElement& joint) const {
    Names names;
    for (const UrdfOutline::Link& link : outline_.links) names.push_back(link.name);
    for (const char* part : {"parent", "child"}) {
      const TiXmlElement& e = *joint.FirstChildElement(part);
      const std::string link = e.Attribute("link");
      if (link_lines_.count(link) != 0) continue;
      fail(e, fmt::format("joint '{}': {} link '{}' is unknown{}; allowed: {}",
                          joint.Attribute("name"), part, link, hint(link, names),
                          fmt::join(names, ", ")));
    }
  }

  /// Attributes, numbers and children against the schema, recursively.
  void element(const TiXmlElement& e, const std::string& where) {
    const auto found = schemas().find(e.ValueStr());
    // looks (<visual>, <collision>) and the like: urdfdom checks what it reads
    if (found == schemas().end()) return;
    const Schema& schema = found->second;
    attributes(e, schema, where);

    std::set<std::string> seen;
    for (const TiXmlElement* child = e.FirstChildElement(); child;
         child = child->NextSiblingElement()) {
      const std::string name = child->ValueStr();
      if (std::find(schema.children.begin(), schema.children.end(), name) ==
          schema.children.end()) {
        fail(*child, fmt::format("unknown element <{}> in <{}>{}; allowed: {}", name, e.ValueStr(),
                                 hint(name, schema.children), fmt::join(schema.children, ", ")));
      }

      const bool once =
          std::find(schema.once.begin(), schema.once.end(), name) != schema.once.end();
      if (!seen.insert(name).second && once)
        fail(*child, fmt::format("<{}> given twice in <{}>; allowed: once", name, e.ValueStr()));
      element(*child, name);
    }
  }

  void attributes(const TiXmlElement& e, const Schema& schema, const std::string& where) const {
    Names allowed;
    for (const std::string& a : schema.attributes)
      allowed.push_back(a.starts_with('!') ? a.substr(1) : a);

    for (const TiXmlAttribute* a = e.FirstAttribute(); a; a = a->Next()) {
      const std::string name = a->Name();
      if (std::find(allowed.begin(), allowed.end(), name) == allowed.end()) {
        fail(e, fmt::format(
                    "<{}>: unknown attribute '{}'{}; allowed: {}", where, name, hint(name, allowed),
                    allowed.empty() ? "none" : fmt::format("{}", fmt::join(allowed, ", "))));
      }
    }

    for (const std::string& a : schema.attributes) {
      if (a.starts_with('!') && !e.Attribute(a.substr(1).c_str())) {
        fail(e,
             fmt::format("<{}>: attribute '{}' is missing; it must be given", where, a.substr(1)));
      }
    }

    for (const std::string& a : schema.numbers) {
      const std::size_t colon = a.find(':');
      const char* text = e.Attribute(a.substr(0, colon).c_str());
      if (text) numbers(e, a.substr(0, colon), text, a[colon + 1] - '0');
    }
  }

  void numbers(const TiXmlElement& e, const std::string& name, const std::string& text,
               int count) const {
    std::istringstream words(text);
    std::string word;
    int found = 0;
    bool good = true;
    for (; words >> word; ++found) {
      double value = 0.0;
      const char* begin = word.data() + (word.starts_with('+') ? 1 : 0);
      const auto [end, code] = std::from_chars(begin, word.data() + word.size(), value);
      good =
          good && code == std::errc() && end == word.data() + word.size() && std::isfinite(value);
    }
    if (good && found == count) return;
    fail(e, fmt::format("<{}>: {}='{}' given; allowed: {} finite number{}", e.ValueStr(), name,
                        text.substr(0, 60), count, count == 1 ? "" : "s"));
  }

  void note_once(const std::string& note) {
    if (std::find(outline_.notes.begin(), outline_.notes.end(), note) == outline_.notes.end())
      outline_.notes.push_back(note);
  }

  std::filesystem::path file_;
  UrdfOutline outline_;
  std::map<std::string, int> link_lines_, joint_lines_;
};

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

}  // namespace

InputError urdf_error(const std::filesystem::path& file, int line, const std::string& what) {
  return InputError(fmt::format("{}:{}: {}", file.string(), line, what));
}

UrdfOutline check_urdf_text(const std::string& text, const std::filesystem::path& file) {
  check_nesting(text, file);
  TiXmlDocument document;
  document.Parse(text.c_str(), nullptr, TIXML_ENCODING_UTF8);
  if (document.Error()) {
    throw urdf_error(file, std::max(1, document.ErrorRow()),
                     fmt::format("not valid XML: {}; allowed: a URDF file", document.ErrorDesc()));
  }
  const TiXmlElement* robot = document.RootElement();
  if (!robot) throw urdf_error(file, 1, "the file holds no element; allowed: <robot>");
  return Checker(file).run(*robot);
}

}  // namespace jaculus::model
