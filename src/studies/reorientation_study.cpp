#include "studies/reorientation_study.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <stdexcept>

#include "studies/grid.h"
#include "studies/study_kind.h"

namespace jaculus::studies {
namespace {

struct Case {
  std::string name;
  ReorientationSetup setup;
  std::optional<ParameterSearch> search;
  yaml::Node node;
};

struct Plan {
  std::vector<Case> cases;
  bool named = false;  ///< whether a column `case` is wanted
  std::vector<Axis> axes;
  std::vector<const Output*> outputs;
  bool without_drag = false, rigid = false, still = false;

  [[nodiscard]] bool searched() const {
    return std::any_of(cases.begin(), cases.end(),
                       [](const Case& c) { return c.search.has_value(); });
  }
  [[nodiscard]] int size() const { return count_of(cases) * grid_size(axes); }
};

double merit(const ReorientationResult& r, Merit kind) {
  if (!r.converged) return kNaN;
  return kind == Merit::effectiveness ? r.effectiveness : std::abs(r.body_angle);
}

ReorientationResult best_result(ReorientationSetup& setup,
                                const std::optional<ParameterSearch>& search, std::string* bound) {
  if (search) {
    const SearchResult found = maximise(search->space, [&](double value) {
      search->parameter->set(setup, value);
      return merit(simulate_reorientation(to_case(setup)), search->merit);
    });
    if (std::isnan(found.argument))
      throw std::runtime_error("no candidate of the search could be integrated");
    search->parameter->set(setup, found.argument);
    if (bound) *bound = found.bound;
  }
  // The motion that is reported is computed far tighter than those that were compared.
  ReorientationResult r = simulate_reorientation(to_case(setup), 1e-4 * kReorientationTolerance);
  if (!r.converged) throw std::runtime_error("the equations of motion could not be integrated");
  return r;
}

std::optional<ParameterSearch> read_search(const yaml::Node& node) {
  if (node.is_scalar()) {
    static_cast<void>(node.choice({"off"}));
    return std::nullopt;
  }
  node.only({"parameter", "integers", "range", "maximise"});

  ParameterSearch search;
  const bool angle = node.at("maximise").choice({"effectiveness", "body_angle"}) == "body_angle";
  search.merit = angle ? Merit::body_angle : Merit::effectiveness;
  search.parameter = &find_parameter(node.at("parameter").text(), node.at("parameter"));

  if (node.has("integers") == node.has("range"))
    throw node.error("give either integers: [a, b] or range: [a, b]");
  search.space.integer = node.has("integers");
  const yaml::Node at = node.at(search.space.integer ? "integers" : "range");

  const Bounds b = at.bounds(search.parameter->dimension);
  const Bounds& allowed = search.parameter->allowed;
  if (!allowed.contains(b.lower) || !allowed.contains(b.upper)) {
    throw at.error(fmt::format("[{}, {}]; {} must lie in [{}, {}]", b.lower, b.upper,
                               search.parameter->name, allowed.lower, allowed.upper));
  }

  if (search.space.integer && std::ceil(b.lower) > std::floor(b.upper)) {
    throw at.error(fmt::format("[{}, {}] holds no integer", b.lower, b.upper));
  }
  if (search.space.integer && b.upper - b.lower > 1e5) throw at.error("more than 100000 integers");

  search.space.lower = b.lower;
  search.space.upper = b.upper;
  return search;
}

std::vector<Case> read_cases(const yaml::Node& root, const ReorientationSetup& base,
                             const std::optional<ParameterSearch>& search) {
  const auto list = root.find("cases");
  if (!list) return {{"", base, search, root.at("base")}};

  std::vector<Case> cases;
  for (const yaml::Node& node : list->items()) {
    node.only({"name", "set", "search"});
    Case c{node.at("name").text(), base, search, node};

    for (const Case& other : cases) {
      if (other.name == c.name)
        throw node.at("name").error(fmt::format("\"{}\" is there twice", c.name));
    }

    if (const auto set = node.find("set")) {
      for (const auto& [name, value] : set->entries()) set_from(c.setup, name, value);
    }
    if (const auto own = node.find("search")) c.search = read_search(*own);
    cases.push_back(c);
  }

  if (cases.empty())
    throw list->error("an empty list of cases; name one or more, or leave `cases` out");
  return cases;
}

void read_outputs(const yaml::Node& root, Plan& plan) {
  std::vector<std::string> names;
  for (const Output& o : output_catalogue()) names.push_back(o.name);

  for (const yaml::Node& item : root.at("outputs").items()) {
    const std::string name = item.choice(names);
    for (const Output* other : plan.outputs) {
      if (other->name == name) throw item.error(fmt::format("\"{}\" is there twice", name));
    }

    for (const Axis& axis : plan.axes) {
      if (axis.parameter->column == name)
        throw item.error(fmt::format("\"{}\" is a column of the grid already", name));
    }

    for (const Output& o : output_catalogue()) {
      if (o.name != name) continue;
      plan.outputs.push_back(&o);
      plan.without_drag |= o.without_drag;
      plan.rigid |= o.rigid;
      plan.still |= o.still;
    }

    if (name != "time_to_90deg_s") continue;
    for (const Case& c : plan.cases) {
      if (!(std::abs(c.setup.target - 0.5 * std::numbers::pi) < 1e-9)) {
        throw item.error("task.target is not 90 deg; take \"time_to_target_s\"");
      }
    }
  }

  if (plan.outputs.empty()) throw root.at("outputs").error("no outputs; name one or more");
}

ReorientationSetup setup_at(const Plan& plan, int index, int* which = nullptr) {
  const int points = grid_size(plan.axes);
  if (which) *which = index / points;
  ReorientationSetup setup = plan.cases[index / points].setup;
  const std::vector<double> values = grid_point(plan.axes, index % points);
  for (std::size_t i = 0; i < values.size(); ++i) plan.axes[i].parameter->set(setup, values[i]);
  return setup;
}

std::string describe_point(const Plan& plan, int index) {
  std::string text = plan.named ? plan.cases[index / grid_size(plan.axes)].name : "";
  const std::vector<double> values = grid_point(plan.axes, index % grid_size(plan.axes));
  for (std::size_t i = 0; i < values.size(); ++i) {
    text += fmt::format("{}{} = {:.6g}", text.empty() ? "" : ", ", plan.axes[i].parameter->name,
                        values[i]);
  }
  return text.empty() ? "base" : text;
}

// Every point must make a case before any is computed, at both ends of the search.
void check_points(const Plan& plan) {
  for (int i = 0; i < plan.size(); ++i) {
    int which = 0;
    const ReorientationSetup setup = setup_at(plan, i, &which);
    const Case& c = plan.cases[which];
    std::vector<ReorientationSetup> ends{setup};
    if (c.search) {
      ends.push_back(setup);
      c.search->parameter->set(ends[0], c.search->space.lower);
      c.search->parameter->set(ends[1], c.search->space.upper);
    }
    for (const ReorientationSetup& end : ends) {
      const std::string fault = check_setup(end);
      if (!fault.empty())
        throw c.node.error(fmt::format("at {}: {}", describe_point(plan, i), fault));
    }
  }
}

Plan read_plan(const yaml::Node& root) {
  root.only(detail::with_common_keys({"base", "cases", "grid", "search", "outputs"}));
  Plan plan;
  const ReorientationSetup base = read_setup(root.at("base"));
  std::optional<ParameterSearch> search;
  if (const auto node = root.find("search")) search = read_search(*node);
  plan.named = root.has("cases");
  plan.cases = read_cases(root, base, search);
  if (const auto node = root.find("grid")) plan.axes = read_grid(*node);
  for (const Axis& axis : plan.axes) {
    for (const Case& c : plan.cases) {
      if (c.search && c.search->parameter == axis.parameter)
        throw axis.node.error("the search turns this one already");
    }
  }
  read_outputs(root, plan);
  check_points(plan);
  return plan;
}

/// A point's columns of the grid.
StudyJson grid_row(const Plan& plan, int index) {
  StudyJson row = StudyJson::object();
  if (plan.named) row["case"] = plan.cases[index / grid_size(plan.axes)].name;
  const std::vector<double> values = grid_point(plan.axes, index % grid_size(plan.axes));
  for (std::size_t i = 0; i < values.size(); ++i) row[plan.axes[i].parameter->column] = values[i];
  return row;
}

StudyJson compute_row(const Plan& plan, int index) {
  int which = 0;
  const ReorientationSetup setup = setup_at(plan, index, &which);
  const Case& c = plan.cases[which];
  const ReorientationPoint point =
      compute_point(setup, c.search, plan.without_drag, plan.rigid, plan.still);
  StudyJson row = grid_row(plan, index);
  for (const Output* o : plan.outputs) row[o->name] = o->value(point);
  if (plan.searched()) row["search_bound"] = point.search_bound;
  return row;
}

std::vector<std::string> bound_notes(const std::vector<StudyJson>& rows) {
  int count = 0;
  for (const StudyJson& row : rows) {
    const auto bound = row.find("search_bound");
    const bool on_it =
        bound != row.end() && bound->is_string() && !bound->get<std::string>().empty();
    count += on_it ? 1 : 0;
  }
  if (count == 0) return {};
  return {fmt::format(
      "the search ended on its bound at {} of {} points (column search_bound): more may lie beyond",
      count, rows.size())};
}

}  // namespace

ReorientationPoint compute_point(const ReorientationSetup& setup,
                                 const std::optional<ParameterSearch>& search, bool without_drag,
                                 bool rigid, bool still) {
  ReorientationPoint point;
  point.setup = setup;
  point.result = best_result(point.setup, search, &point.search_bound);

  if (without_drag) {
    ReorientationSetup other = setup;
    other.drag = model::DragKind::none;
    point.without_drag = best_result(other, search, nullptr);
  }

  if (rigid) {
    ReorientationSetup other = point.setup;
    other.root_stiffness = kInfinity;
    point.rigid = best_result(other, std::nullopt, nullptr);
  }

  if (still) {
    ReorientationSetup other = setup;
    other.forward_speed = other.climb_speed = other.wind_forward = 0.0;
    point.still = best_result(other, search, nullptr);
  }

  return point;
}

detail::PreparedStudy detail::prepare_reorientation(const yaml::Node& root) {
  const auto plan = std::make_shared<const Plan>(read_plan(root));

  PreparedStudy study;
  study.description = fmt::format("{} points", plan->size());
  if (plan->named) study.columns.emplace_back("case");
  for (const Axis& axis : plan->axes) study.columns.push_back(axis.parameter->column);
  study.axes = study.columns;
  for (const Output* o : plan->outputs) study.columns.push_back(o->name);

  if (plan->searched() && std::find(study.columns.begin(), study.columns.end(), "search_bound") ==
                              study.columns.end()) {
    study.columns.emplace_back("search_bound");
  }

  study.tasks = plan->size();
  study.task = [plan](int i) { return compute_row(*plan, i).dump(); };
  study.rows = [](const std::vector<std::string>& bytes) {
    std::vector<StudyJson> rows;
    for (const std::string& b : bytes) rows.push_back(StudyJson::parse(b));
    return rows;
  };

  study.failed_row = [plan](int i) { return grid_row(*plan, i); };
  study.notes = bound_notes;
  return study;
}

}  // namespace jaculus::studies
