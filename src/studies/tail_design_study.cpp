#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <memory>

#include "jaculus/core/angle.h"
#include "studies/study_kind.h"
#include "studies/tail_design.h"

namespace jaculus::studies {
namespace {

constexpr Dimension kMassPerLength{-1, 1, 0, 0, 0};
constexpr Dimension kMassPerArea{-2, 1, 0, 0, 0};

struct DesignPlan {
  ReorientationSetup base;
  TailLimits limits;
  TailMaterial material;
  SearchSpace gears;
  std::vector<double> lengths, shaft_ratios, widths;
};

// [start, count]: evenly from start to limit, and one step more, which shows whether the limit
// binds.
std::vector<double> steps_beyond(const yaml::Node& node, const Dimension& dimension, double limit) {
  const std::vector<yaml::Node> items = node.items();
  if (items.size() != 2) throw node.error("must be [least value, number of values]");
  const double start = items[0].number(dimension, {1e-9, 1e9});
  const int count = items[1].integer(2, 1000);
  if (!(start < limit))
    throw items[0].error(fmt::format("{}; it must be below the limit {}", start, limit));
  std::vector<double> values;
  const double step = (limit - start) / (count - 1);
  for (int i = 0; i <= count; ++i) values.push_back(i + 1 == count ? limit : start + i * step);
  return values;
}

void read_material(const yaml::Node& node, TailMaterial& material) {
  node.only({"tube", "film", "mount"});
  material.tube = node.at("tube").number(kMassPerLength, {1e-9, 1e3});
  material.film = node.at("film").number(kMassPerArea, {0.0, 1e3});
  material.mount = node.at("mount").number(dimension::mass, {0.0, 1e3});
}

SearchSpace read_gears(const yaml::Node& node) {
  const Bounds gears = node.bounds(dimension::none);
  if (!(gears.lower >= 1.0) || std::ceil(gears.lower) > std::floor(gears.upper) ||
      gears.upper > 1e5) {
    throw node.error(
        fmt::format("[{}, {}]; integers from 1 on are allowed", gears.lower, gears.upper));
  }
  return {gears.lower, gears.upper, true};
}

// The largest tail must make a case, and the lightest must be within the budget.
void check_design(const yaml::Node& root, const DesignPlan& plan) {
  ReorientationSetup probe = plan.base;
  probe.tail_length = plan.limits.stowed_length;
  probe.tail_shaft = 0.0;
  probe.tail_width = plan.limits.width;
  probe.tail_inertia = 1.0;
  probe.motor.gear = plan.gears.upper;
  const std::string fault = check_setup(probe);
  if (!fault.empty()) throw root.at("base").error(fault);
  double least = kInfinity;
  for (double ratio : plan.shaft_ratios) {
    least = std::min(
        least, tail_mass(plan.material, plan.lengths[0], ratio * plan.lengths[0], plan.widths[0]));
  }
  if (least > plan.limits.mass) {
    throw root.at("limits").at("mass").error(
        fmt::format("{} kg; the lightest tail of the grid has {:.4g} kg", plan.limits.mass, least));
  }
}

DesignPlan read_design(const yaml::Node& root) {
  root.only(detail::with_common_keys({"base", "limits", "material", "grid", "gears"}));
  DesignPlan plan;

  const yaml::Node base = root.at("base");
  if (const auto tail = base.find("tail"))
    tail->only({"drag_coefficient", "root_stiffness", "drag"});
  plan.base = read_setup(base);

  const yaml::Node limits = root.at("limits");
  limits.only({"mass", "stowed_length", "width"});
  plan.limits.mass = limits.at("mass").number(dimension::mass, {1e-9, 1e6});
  plan.limits.stowed_length = limits.at("stowed_length").number(dimension::length, {1e-9, 1e6});
  plan.limits.width = limits.at("width").number(dimension::length, {1e-9, 1e6});

  read_material(root.at("material"), plan.material);
  const yaml::Node grid = root.at("grid");
  grid.only({"length", "shaft_ratio", "width"});
  plan.lengths = steps_beyond(grid.at("length"), dimension::length, plan.limits.stowed_length);
  plan.widths = steps_beyond(grid.at("width"), dimension::length, plan.limits.width);

  const std::vector<yaml::Node> shaft = grid.at("shaft_ratio").items();
  if (shaft.size() != 2)
    throw grid.at("shaft_ratio").error("must be [largest value, number of values]");
  const double largest = shaft[0].number(dimension::none, {0.0, 0.999});
  const int count = shaft[1].integer(1, 1000);

  for (int i = 0; i < count; ++i)
    plan.shaft_ratios.push_back(count > 1 ? largest * i / (count - 1) : largest);

  plan.gears = read_gears(root.at("gears"));
  check_design(root, plan);
  return plan;
}

// All designs of one length.
std::string designs_of(const DesignPlan& plan, int index) {
  StudyJson list = StudyJson::array();
  const double length = plan.lengths[index];
  for (double ratio : plan.shaft_ratios) {
    for (double width : plan.widths) {
      const TailDesign d =
          evaluate_design(plan.base, plan.material, length, ratio * length, width, plan.gears);
      list.push_back({d.length, d.shaft, d.width, d.mass, d.inertia, json_number(d.gear),
                      json_number(d.effectiveness), d.body_angle, d.search_bound});
    }
  }
  return list.dump();
}

TailDesign design_from(const StudyJson& j) {
  TailDesign d;
  const auto number = [&](std::size_t i) {
    return j.at(i).is_null() ? kNaN : j.at(i).get<double>();
  };
  d.length = number(0);
  d.shaft = number(1);
  d.width = number(2);
  d.mass = number(3);
  d.inertia = number(4);
  d.gear = number(5);
  d.effectiveness = number(6);
  d.body_angle = number(7);
  d.search_bound = j.at(8).get<std::string>();
  return d;
}

std::vector<StudyJson> front_rows(const DesignPlan& plan, const std::vector<std::string>& bytes) {
  std::vector<TailDesign> designs;
  for (const std::string& b : bytes) {
    for (const StudyJson& j : StudyJson::parse(b)) designs.push_back(design_from(j));
  }
  std::vector<StudyJson> rows;
  for (const TailDesign& d : pareto_front(designs, plan.limits)) {
    rows.push_back({{"tail_mass_kg", d.mass},
                    {"effectiveness", d.effectiveness},
                    {"tail_length_m", d.length},
                    {"tail_shaft_m", d.shaft},
                    {"tail_width_m", d.width},
                    {"gear", d.gear},
                    {"tail_inertia_kg_m2", d.inertia},
                    {"body_angle_at_end_deg", d.body_angle * kDegrees},
                    {"binding", fmt::format("{}", fmt::join(d.binding, "; "))}});
  }
  return rows;
}

}  // namespace

detail::PreparedStudy detail::prepare_tail_design(const yaml::Node& root) {
  const auto plan = std::make_shared<const DesignPlan>(read_design(root));
  PreparedStudy study;
  study.description =
      fmt::format("{} tails, gears {} to {} each",
                  plan->lengths.size() * plan->shaft_ratios.size() * plan->widths.size(),
                  plan->gears.lower, plan->gears.upper);
  study.columns = {"tail_mass_kg",       "effectiveness",         "tail_length_m",
                   "tail_shaft_m",       "tail_width_m",          "gear",
                   "tail_inertia_kg_m2", "body_angle_at_end_deg", "binding"};
  study.tasks = count_of(plan->lengths);
  study.task = [plan](int i) { return designs_of(*plan, i); };
  study.rows = [plan](const std::vector<std::string>& bytes) { return front_rows(*plan, bytes); };
  return study;
}

}  // namespace jaculus::studies
