#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "model/fields.h"

namespace jaculus::model {

bool matches(std::string_view pattern, std::string_view path) {
  for (;;) {
    const std::size_t a = pattern.find('.');
    const std::size_t b = path.find('.');
    const std::string_view head = pattern.substr(0, a);
    if (head != "*" && head != path.substr(0, b)) return false;
    if (a == std::string_view::npos || b == std::string_view::npos) return a == b;
    pattern.remove_prefix(a + 1);
    path.remove_prefix(b + 1);
  }
}

namespace {

bool names(const std::string& pattern, const Field& field) {
  return matches(pattern, field.path) || (!field.alias.empty() && matches(pattern, field.alias));
}

bool is_reference(const yaml::Node& node) {
  return node.is_scalar() && node.dump().find('=') != std::string::npos;
}

class Applier {
 public:
  Applier(PlanarModel& model, const std::vector<OverrideInput>& overrides)
      : fields_(model_fields(model)) {
    for (const bool wild : {true, false}) {
      for (const OverrideInput& o : overrides) {
        if ((o.path.find('*') != std::string::npos) == wild) assign(o, wild);
      }
    }
  }

  void run() {
    for (const auto& [field, assigned] : assigned_) resolve(field);
  }

 private:
  struct Assigned {
    OverrideInput source;
    bool wild = false;
    int state = 0;  ///< 0 to do, 1 being done, 2 done
  };

  void assign(const OverrideInput& o, bool wild) {
    bool found = false;
    for (std::size_t f = 0; f < fields_.size(); ++f) {
      if (!names(o.path, fields_[f])) continue;
      found = true;
      const auto old = assigned_.find(f);
      if (old != assigned_.end() && old->second.wild == wild) {
        throw o.value.error(fmt::format(
            "override '{}' sets {}, which '{}' (line {}) sets as well; allowed: once", o.path,
            fields_[f].path, old->second.source.path, old->second.source.value.line()));
      }
      assigned_[f] = {o, wild, 0};
    }
    if (!found) throw unknown(o.value, o.path);
  }

  [[nodiscard]] InputError unknown(const yaml::Node& node, const std::string& path) const {
    std::vector<std::string> paths;
    for (const Field& field : fields_) {
      paths.push_back(field.path);
      if (!field.alias.empty()) paths.push_back(field.alias);
    }
    return node.error(
        fmt::format("unknown model value '{}'{}; allowed: a path that `jaculus check` lists for "
                    "this robot, as {}",
                    path, yaml::did_you_mean(path, paths), examples()));
  }

  /// One path of every kind that this robot has.
  [[nodiscard]] std::string examples() const {
    std::string text;
    std::vector<std::string> seen;
    for (const Field& field : fields_) {
      const std::string head = field.path.substr(0, field.path.find('.'));
      if (std::find(seen.begin(), seen.end(), head) != seen.end()) continue;
      seen.push_back(head);
      text += (text.empty() ? "" : ", ") + field.path;
    }
    return text;
  }

  void resolve(std::size_t f) {
    const auto found = assigned_.find(f);
    if (found == assigned_.end() || found->second.state == 2) return;
    Assigned& a = found->second;

    trail_.push_back(fields_[f].path);
    if (a.state == 1) {
      std::string text;
      for (const std::string& step : trail_) text += (text.empty() ? "" : " -> ") + step;
      throw a.source.value.error(fmt::format(
          "override goes round in a circle: {}; allowed: a chain that ends in a value", text));
    }

    a.state = 1;
    if (is_reference(a.source.value)) {
      copy(a.source.value, f);
    } else {
      fields_[f].read(a.source.value);
    }

    a.state = 2;
    trail_.pop_back();
  }

  void copy(const yaml::Node& node, std::size_t f) {
    std::string path = node.text();
    if (!path.starts_with('='))
      throw node.error(
          fmt::format("'{}' given; allowed: a value, or =path of another value", path));
    path.erase(0, 1);

    const auto source = std::find_if(fields_.begin(), fields_.end(), [&](const Field& field) {
      return field.path == path || field.alias == path;
    });
    if (path.empty() || source == fields_.end()) throw unknown(node, path);

    const Field& target = fields_[f];
    if (source->target.index() != target.target.index() ||
        !(source->dimension == target.dimension)) {
      throw node.error(fmt::format("{} is {}, {} is {}; allowed: a value of the same kind and unit",
                                   path, source->shown(), target.path, target.shown()));
    }

    resolve(source - fields_.begin());
    std::visit([&](auto* to) { *to = **std::get_if<decltype(to)>(&source->target); },
               target.target);
  }

  std::vector<Field> fields_;
  std::map<std::size_t, Assigned> assigned_;
  std::vector<std::string> trail_;
};

}  // namespace

void apply_overrides(PlanarModel& model, const std::vector<OverrideInput>& overrides) {
  Applier(model, overrides).run();
}

}  // namespace jaculus::model
