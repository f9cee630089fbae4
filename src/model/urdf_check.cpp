#include "model/urdf_check.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tinyxml.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include "jaculus/core/yaml.h"
#include "model/urdf_text.h"

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

/// Checks a document and leaves in it what urdfdom can read: what was assumed is written there.
class Checker {
 public:
  Checker(const std::filesystem::path& file, Assumptions& assumptions)
      : file_(file), assumptions_(assumptions) {}

  UrdfOutline run(TiXmlElement& robot) {
    if (robot.ValueStr() != "robot")
      fail(robot, fmt::format("<{}> given; allowed: <robot>{}", robot.ValueStr(),
                              robot.ValueStr() == "sdf" ? ", for SDF isn't read" : ""));
    if (!robot.Attribute("name")) {
      const std::string name = file_.stem().string();
      assume(robot, "<robot>: attribute 'name' is missing; it must be given",
             "called '" + name + "'");
      robot.SetAttribute("name", name.c_str());
    }

    for (TiXmlElement *next, *e = robot.FirstChildElement(); e; e = next) {
      next = e->NextSiblingElement();
      if (!top(*e)) robot.RemoveChild(e);
    }
    for (const TiXmlElement* e = robot.FirstChildElement("joint"); e;
         e = e->NextSiblingElement("joint"))
      ends(*e);
    return outline_;
  }

 private:
  [[noreturn]] void fail(const TiXmlElement& e, const std::string& what) const {
    throw urdf_error(file_, e.Row(), what);
  }

  void assume(const TiXmlElement& e, const std::string& fault, const std::string& taken) {
    assumptions_.assume(e.Row(), fault, taken);
  }

  /// False where the element is none for this program.
  bool top(TiXmlElement& e) {
    static const Names allowed = {"link", "joint", "material", "gazebo", "transmission", "mujoco"};
    const std::string kind = e.ValueStr();
    if (std::find(allowed.begin(), allowed.end(), kind) == allowed.end()) {
      assume(e,
             fmt::format("unknown element <{}>{}; allowed: {}", kind,
                         yaml::did_you_mean(kind, allowed), fmt::join(allowed, ", ")),
             "skipped");
      return false;
    }

    if (kind != "link" && kind != "joint") {
      if (kind != "material")
        note_once(fmt::format("URDF: <{}> is for other tools and not read", kind));
      return false;
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
      outline_.links.push_back({name, e.Row(), take_shapes(e)});
    } else {
      const bool unlimited = joint(e, name);
      outline_.joints.push_back({name, e.Row(), e.FirstChildElement("parent")->Attribute("link"),
                                 e.FirstChildElement("child")->Attribute("link"), unlimited});
    }
    return true;
  }

  void link(TiXmlElement& e, const std::string& name) {
    TiXmlElement* inertial = e.FirstChildElement("inertial");
    if (!inertial) return;
    for (const char* part : {"mass", "inertia"}) {
      if (inertial->FirstChildElement(part)) continue;
      assume(*inertial,
             fmt::format("link '{}': <inertial> has no <{}>; it must be given", name, part),
             "taken as zero");
      TiXmlElement zero(part);
      for (const std::string& a : schemas().at(part).attributes)
        zero.SetAttribute(a.substr(1), "0");
      inertial->InsertEndChild(zero);
    }
  }

  /// Whether it has no range though its type asks for one.
  bool joint(TiXmlElement& e, const std::string& name) {
    static const Names types = {"fixed", "revolute", "continuous", "prismatic"};
    static const Names spatial = {"floating", "planar", "spherical", "ball"};
    std::string type = e.Attribute("type");
    if (std::find(types.begin(), types.end(), type) == types.end()) {
      const std::string fault =
          fmt::format("joint '{}': type '{}' given{}; allowed: {}", name, type,
                      yaml::did_you_mean(type, types), fmt::join(types, ", "));
      if (std::find(spatial.begin(), spatial.end(), type) == spatial.end()) fail(e, fault);
      assume(e, fault, "taken as fixed");
      type = "fixed";
      e.SetAttribute("type", type);
    }

    for (const char* part : {"parent", "child"}) {
      if (!e.FirstChildElement(part))
        fail(e, fmt::format("joint '{}' has no <{}>; it must be given", name, part));
    }
    if (type != "fixed" && !e.FirstChildElement("axis")) {
      assume(e, fmt::format("joint '{}' has no <axis>; it must be given where a joint moves", name),
             "(1, 0, 0), as URDF has it by default");
    }

    TiXmlElement* limit = e.FirstChildElement("limit");
    const bool ranged = type == "revolute" || type == "prismatic";
    bool unlimited = false;
    if (ranged && (!limit || !limit->Attribute("lower") || !limit->Attribute("upper"))) {
      assume(limit ? *limit : e,
             fmt::format("joint '{}' ({}) needs <limit> with lower, upper, effort and velocity",
                         name, type),
             "no range");
      unlimited = true;
      if (!limit) add_limit(e);
    }

    if (limit || e.FirstChildElement("dynamics"))
      note_once(
          "URDF: effort, velocity, damping and friction of joints are what `robot import` proposes "
          "for motors; those in robot.yaml count");
    return unlimited;
  }

  /// urdfdom wants one where a joint has a range; `unlimited` says that it holds nothing.
  static void add_limit(TiXmlElement& joint) {
    TiXmlElement limit("limit");
    for (const char* key : {"lower", "upper", "effort", "velocity"}) limit.SetAttribute(key, "0");
    joint.InsertEndChild(limit);
  }

  /// Shapes for contact; what a link looks like is none of this program's business.
  static std::vector<SpatialShape> take_shapes(TiXmlElement& link) {
    std::vector<SpatialShape> shapes;
    for (TiXmlElement *next, *e = link.FirstChildElement(); e; e = next) {
      next = e->NextSiblingElement();
      if (e->ValueStr() == "inertial") continue;
      if (e->ValueStr() == "collision") read_shape(*e, shapes);
      link.RemoveChild(e);
    }
    return shapes;
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
                          joint.Attribute("name"), part, link, yaml::did_you_mean(link, names),
                          fmt::join(names, ", ")));
    }
  }

  /// Attributes, numbers and children against the schema, recursively.
  void element(TiXmlElement& e, const std::string& where) {
    const auto found = schemas().find(e.ValueStr());
    // looks (<visual>, <collision>) and the like are taken out before urdfdom sees them
    if (found == schemas().end()) return;
    const Schema& schema = found->second;
    attributes(e, schema, where);

    std::set<std::string> seen;
    for (TiXmlElement *next, *child = e.FirstChildElement(); child; child = next) {
      next = child->NextSiblingElement();
      const std::string name = child->ValueStr();
      if (index_of(schema.children, name) < 0) {
        assume(*child,
               fmt::format("unknown element <{}> in <{}>{}; allowed: {}", name, e.ValueStr(),
                           yaml::did_you_mean(name, schema.children),
                           fmt::join(schema.children, ", ")),
               "skipped");
        e.RemoveChild(child);
        continue;
      }
      if (!seen.insert(name).second && index_of(schema.once, name) >= 0) {
        assume(*child, fmt::format("<{}> given twice in <{}>; allowed: once", name, e.ValueStr()),
               "the first counts");
        e.RemoveChild(child);
        continue;
      }
      element(*child, name);
    }
  }

  void attributes(TiXmlElement& e, const Schema& schema, const std::string& where) {
    Names allowed;
    for (const std::string& a : schema.attributes)
      allowed.push_back(a.starts_with('!') ? a.substr(1) : a);

    for (const TiXmlAttribute* a = e.FirstAttribute(); a; a = a->Next()) {
      const std::string name = a->Name();
      if (index_of(allowed, name) >= 0) continue;
      assume(e,
             fmt::format("<{}>: unknown attribute '{}'{}; allowed: {}", where, name,
                         yaml::did_you_mean(name, allowed),
                         allowed.empty() ? "none" : fmt::format("{}", fmt::join(allowed, ", "))),
             "skipped");
    }

    for (const std::string& a : schema.attributes) {
      if (a.starts_with('!') && !e.Attribute(a.substr(1))) missing(e, where, a.substr(1));
    }

    for (const std::string& a : schema.numbers) {
      const std::size_t colon = a.find(':');
      const std::string name = a.substr(0, colon);
      const char* text = e.Attribute(name.c_str());
      if (text) e.SetAttribute(name, numbers(e, name, text, a[colon + 1] - '0'));
    }
  }

  void missing(TiXmlElement& e, const std::string& where, const std::string& name) {
    const std::string fault =
        fmt::format("<{}>: attribute '{}' is missing; it must be given", where, name);
    const bool effort = name == "effort" || name == "velocity";
    const bool product = name == "ixy" || name == "ixz" || name == "iyz";
    if (!effort && !product) fail(e, fault);
    assume(e, fault, effort ? "no limit" : "zero");
    e.SetAttribute(name, "0");
  }

  /// The numbers of an attribute as urdfdom can read them.
  std::string numbers(const TiXmlElement& e, const std::string& name, const std::string& text,
                      int count) {
    if (const auto exact = exact_numbers(text); exact && *exact == count) return text;
    const std::string fault =
        fmt::format("<{}>: {}='{}' given; allowed: {} finite number{}", e.ValueStr(), name,
                    text.substr(0, 60), count, count == 1 ? "" : "s");
    const std::optional<std::string> repaired = repair_numbers(text, count);
    if (!repaired) fail(e, fault);
    assume(e, fault, "read as '" + *repaired + "'");
    return *repaired;
  }

  void note_once(const std::string& note) {
    if (std::find(outline_.notes.begin(), outline_.notes.end(), note) == outline_.notes.end())
      outline_.notes.push_back(note);
  }

  std::filesystem::path file_;
  Assumptions& assumptions_;
  UrdfOutline outline_;
  std::map<std::string, int> link_lines_, joint_lines_;
};

}  // namespace

InputError urdf_error(const std::filesystem::path& file, int line, const std::string& what) {
  return InputError({file.string(), line}, what);
}

UrdfOutline check_urdf_text(const std::string& given, const std::filesystem::path& file,
                            Assumptions& assumptions) {
  const std::string text = without_padding(given, assumptions);
  check_nesting(text, file);
  TiXmlDocument document;
  document.Parse(text.c_str(), nullptr, TIXML_ENCODING_UTF8);
  if (document.Error()) {
    throw urdf_error(file, std::max(1, document.ErrorRow()),
                     fmt::format("not valid XML: {}; allowed: a URDF file", document.ErrorDesc()));
  }
  TiXmlElement* robot = document.RootElement();
  if (!robot) throw urdf_error(file, 1, "the file holds no element; allowed: <robot>");

  UrdfOutline outline = Checker(file, assumptions).run(*robot);
  TiXmlPrinter printer;
  robot->Accept(&printer);
  outline.text = printer.Str();
  return outline;
}

}  // namespace jaculus::model
