#include "model/mjcf_load.h"

#ifdef JACULUS_HAS_MUJOCO

#include <fmt/format.h>
#include <tinyxml.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>
#include <set>

#include "jaculus/core/error.h"
#include "model/assumptions.h"

namespace jaculus::model {
namespace {

/// Words that one file may have too many of; a file of a hundred different ones is no MJCF.
constexpr int kMostUnknown = 100;

using Model = std::unique_ptr<mjModel, void (*)(mjModel*)>;

/// MuJoCo's messages have several lines.
std::string one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  while (text.ends_with(' ')) text.pop_back();
  return text;
}

/// A text that stands for a file: what it includes and its meshes are found beside that file.
Model load(const std::filesystem::path& file, const std::string* text, std::string& message) {
  std::array<char, 1000> error{};
  const auto size = static_cast<int>(error.size());
  Model model(nullptr, mj_deleteModel);
  if (text == nullptr) {
    model.reset(mj_loadXML(file.c_str(), nullptr, error.data(), size));
  } else {
    const auto files = std::make_unique<mjVFS>();  // too large for the stack
    mj_defaultVFS(files.get());
    mj_makeEmptyFileVFS(files.get(), file.filename().c_str(), static_cast<int>(text->size()));
    std::memcpy(files->filedata[0], text->data(), text->size());
    model.reset(mj_loadXML(file.c_str(), files.get(), error.data(), size));
    mj_deleteVFS(files.get());
  }
  message = one_line(error.data());
  return model;
}

/// Elements of that name, in the order of the file.
std::vector<TiXmlElement*> elements_of(TiXmlElement& from, const std::string& name) {
  std::vector<TiXmlElement*> found;
  if (from.ValueStr() == name) found.push_back(&from);
  for (TiXmlElement* e = from.FirstChildElement(); e != nullptr; e = e->NextSiblingElement()) {
    const std::vector<TiXmlElement*> below = elements_of(*e, name);
    found.insert(found.end(), below.begin(), below.end());
  }
  return found;
}

/// What a message names as unknown: an attribute of an element, a word that one of its attributes
/// has, or the element itself.
struct Unknown {
  std::string element, attribute, word;
};

/// What stands between a text and the next quote; empty where the text doesn't occur.
std::string quoted_after(const std::string& message, const std::string& text) {
  const std::size_t at = message.find(text);
  if (at == std::string::npos) return {};
  const std::size_t from = at + text.size();
  return message.substr(from, message.find('\'', from) - from);
}

std::optional<Unknown> unknown_in(const std::string& message) {
  Unknown found{quoted_after(message, "Element '"),
                quoted_after(message, "unrecognized attribute: '"),
                quoted_after(message, "invalid keyword: '")};
  const bool whole = message.find("unrecognized element") != std::string::npos;
  if (found.element.empty() || (found.attribute.empty() && found.word.empty() && !whole)) return {};
  return found;
}

/// Removes every attribute of that name, or with that word, from an element; whether there were.
bool remove_attributes(TiXmlElement& element, const Unknown& unknown) {
  std::vector<std::string> names;
  for (const TiXmlAttribute* a = element.FirstAttribute(); a != nullptr; a = a->Next())
    if (unknown.word.empty() ? a->Name() == unknown.attribute : a->ValueStr() == unknown.word)
      names.emplace_back(a->Name());
  for (const std::string& name : names) element.RemoveAttribute(name.c_str());
  return !names.empty();
}

/// Leaves out what a message names; false where the file has no such thing (an included file may).
bool leave_out(const Unknown& unknown, TiXmlElement& root, Assumptions& assumed) {
  const bool whole = unknown.attribute.empty() && unknown.word.empty();
  const std::string what = whole ? "" : fmt::format("'{}' of ", unknown.attribute + unknown.word);
  bool any = false;
  for (TiXmlElement* e : elements_of(root, unknown.element)) {
    const int line = e->Row();
    const bool removed =
        whole ? e != &root && e->Parent()->RemoveChild(e) : remove_attributes(*e, unknown);
    if (!removed) continue;
    any = true;
    assumed.assume(line,
                   fmt::format("{}<{}>, which MuJoCo {} doesn't know", what, unknown.element,
                               mj_versionString()),
                   "left out");
    if (whole) break;  // others may have been within it; the reader asks again
  }
  return any;
}

/// Tells the reader that ranges are limits unless the file says otherwise.
void state_limits(TiXmlElement& root, Assumptions& assumed) {
  std::vector<TiXmlElement*> compilers = elements_of(root, "compiler");
  for (const TiXmlElement* e : compilers)
    if (e->Attribute("autolimits") != nullptr) return;
  if (compilers.empty())
    compilers.push_back(root.InsertEndChild(TiXmlElement("compiler"))->ToElement());
  compilers.front()->SetAttribute("autolimits", "true");
  assumed.assume(compilers.front()->Row(), "no autolimits",
                 "a range by itself is a limit, as since MuJoCo 3");
}

std::string attribute_of(const TiXmlElement& element, const char* name) {
  const char* value = element.Attribute(name);
  return value == nullptr ? "" : value;
}

/// Where the compiler looks for files of that kind: `which` is meshdir or texturedir.
std::filesystem::path folder_of(TiXmlElement& root, const std::filesystem::path& file,
                                const char* which) {
  std::filesystem::path folder = file.parent_path();
  for (const TiXmlElement* e : elements_of(root, "compiler")) {
    const std::string own = attribute_of(*e, which), all = attribute_of(*e, "assetdir");
    if (!own.empty() || !all.empty()) folder = file.parent_path() / (own.empty() ? all : own);
  }
  return folder;
}

/// Names of assets of a kind whose file isn't there, without which the file then is.
std::vector<std::string> absent_assets(TiXmlElement& root, const std::filesystem::path& file,
                                       const char* kind, const char* which) {
  std::vector<std::string> names;
  for (TiXmlElement* e : elements_of(root, kind)) {
    const std::filesystem::path asset = attribute_of(*e, "file");
    const std::filesystem::path folder = folder_of(root, file, which);
    if (asset.empty() || std::filesystem::exists(folder / asset)) continue;
    const std::string name = attribute_of(*e, "name");
    names.push_back(name.empty() ? asset.stem().string() : name);
    e->Parent()->RemoveChild(e);
  }
  return names;
}

using Bodies = std::set<const TiXmlNode*>;

/// Where geoms give links their inertias whatever these state, a link that lost a geom keeps what
/// it states, and all others what their geoms give.
void keep_stated_inertias(TiXmlElement& root, const Bodies& without_mesh, Assumptions& assumed) {
  TiXmlElement* by_geoms = nullptr;
  for (TiXmlElement* e : elements_of(root, "compiler"))
    if (attribute_of(*e, "inertiafromgeom") == "true") by_geoms = e;
  if (by_geoms == nullptr || without_mesh.empty()) return;

  by_geoms->SetAttribute("inertiafromgeom", "auto");
  for (TiXmlElement* e : elements_of(root, "inertial")) {
    TiXmlNode* body = e->Parent();
    if (without_mesh.count(body) != 0) {
      assumed.assume(
          e->Row(),
          fmt::format("inertiafromgeom, and a mesh of link '{}' isn't there",
                      attribute_of(*body->ToElement(), "name")),
          fmt::format("the link's own <inertial> counts, {} kg", attribute_of(*e, "mass")));
    } else if (body->FirstChildElement("geom") != nullptr) {
      body->RemoveChild(e);  // which MuJoCo doesn't look at there
    }
  }
}

/// Meshes and textures whose files aren't there, as where a robot's file comes without its folder.
/// A link whose inertia is stated needs no mesh; another one has its mass from them.
void leave_out_absent(TiXmlElement& root, const std::filesystem::path& file, Assumptions& assumed) {
  for (const std::string& name : absent_assets(root, file, "texture", "texturedir"))
    for (TiXmlElement* e : elements_of(root, "material"))
      if (attribute_of(*e, "texture") == name) e->RemoveAttribute("texture");

  Bodies without_mesh;
  for (const std::string& name : absent_assets(root, file, "mesh", "meshdir")) {
    for (TiXmlElement* e : elements_of(root, "geom")) {
      if (attribute_of(*e, "mesh") != name) continue;
      const TiXmlNode& body = *e->Parent();
      if (body.FirstChildElement("inertial") == nullptr && attribute_of(*e, "mass") != "0")
        throw InputError({file.string(), e->Row(), "mesh"},
                         fmt::format("the file of mesh '{}' isn't there, and its link has its "
                                     "mass from it; allowed: the file, or <inertial>",
                                     name));
      assumed.assume(e->Row(), "a mesh whose file isn't there, on a link that states its inertia",
                     "left out");
      if (attribute_of(*e, "mass") != "0") without_mesh.insert(&body);
      e->Parent()->RemoveChild(e);
    }
  }
  keep_stated_inertias(root, without_mesh, assumed);
}

std::string text_of(const TiXmlDocument& document) {
  TiXmlPrinter printer;
  document.Accept(&printer);
  return printer.Str();
}

}  // namespace

LoadedMjcf load_mjcf(const std::filesystem::path& file, Reading reading) {
  std::string message;
  LoadedMjcf out{load(file, nullptr, message), {}};
  if (out.model) return out;
  const auto refused = [&file](const std::string& why) {
    return InputError(
        fmt::format("{}: MuJoCo refuses the file: {}; allowed: MJCF that MuJoCo {} reads",
                    file.string(), why, mj_versionString()));
  };

  TiXmlDocument document;
  if (reading == Reading::strict || !document.LoadFile(file.string()) ||
      document.RootElement() == nullptr)
    throw refused(message);
  TiXmlElement& root = *document.RootElement();
  Assumptions assumed(file, false);
  state_limits(root, assumed);
  leave_out_absent(root, file, assumed);
  for (int round = 0; round < kMostUnknown; ++round) {
    const std::string text = text_of(document);
    out.model = load(file, &text, message);
    if (out.model) {
      out.notes = assumed.notes();
      return out;
    }

    const std::optional<Unknown> unknown = unknown_in(message);
    if (!unknown || !leave_out(*unknown, root, assumed)) throw refused(message);
  }
  throw refused(message);
}

}  // namespace jaculus::model

#endif
