#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <memory>

#include "jaculus/model/robot.h"
#include "jaculus/solver/plan.h"
#include "studies/study_kind.h"

// Studies of kind `plan`: a problem solved anew for every length of one of the robot's links.
//   problem: leap_tail.yaml                          relative to this file
//   stretch: {link: tail, factors: [0.5, 1, 1.5]}    of the link's length; each its own plan
//
// A link that is k times as long keeps its cross-section and its material: lengths along it, mass
// and drag area are k times what they were, its inertia about its centre of mass k^3, a scoop's
// width and the rotor stay. The link carries no other.

namespace jaculus::studies {
namespace {

struct PlanStudy {
  transcription::Problem problem;
  model::PlanarModel model;  ///< overrides applied, nothing locked
  int body = -1;
  std::vector<double> factors;
};

std::string file_text(const std::filesystem::path& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

int read_link(const yaml::Node& node, const model::PlanarModel& model) {
  std::vector<std::string> names;
  for (std::size_t b = 1; b < model.bodies.size(); ++b) names.push_back(model.bodies[b].name);
  const std::string name = node.choice(names);
  int body = 0;
  while (model.bodies[body].name != name) ++body;
  bool bears = false;
  for (const model::PlanarBody& other : model.bodies) bears = bears || other.parent == body;
  for (const model::PlanarLoop& loop : model.loops)
    bears = bears || loop.body_a == body || loop.body_b == body;
  if (bears)
    throw node.error(fmt::format(
        "link '{}' carries others or closes a loop; allowed: a link at a chain's end", name));
  return body;
}

PlanStudy read_plan_study(const yaml::Node& root) {
  root.only(detail::with_common_keys({"problem", "stretch"}));

  PlanStudy study;
  study.problem = transcription::read_problem(detail::named_file(root.at("problem")));
  study.model = model::read_robot(study.problem.robot_folder, study.problem.overrides).planar;
  transcription::check_problem(study.problem, study.model);

  const yaml::Node stretch = root.at("stretch");
  stretch.only({"link", "factors"});
  study.body = read_link(stretch.at("link"), study.model);

  for (const yaml::Node& factor : stretch.at("factors").items()) {
    study.factors.push_back(factor.number(dimension::none, {0.05, 20.0}));
    for (std::size_t i = 0; i + 1 < study.factors.size(); ++i)
      if (study.factors[i] == study.factors.back())
        throw factor.error("a factor that is there already");
  }
  if (study.factors.empty())
    throw stretch.at("factors").error("an empty list; allowed: one factor or more");

  static_cast<void>(transcription::NonlinearProgram(
      study.problem, transcription::planning_model(study.problem, study.model)));

  return study;
}

model::PlanarModel stretched(model::PlanarModel model, int body, double k) {
  model::PlanarBody& link = model.bodies[body];
  link.mass *= k;
  link.com *= k;
  link.inertia *= k * k * k;
  for (std::vector<model::PlanarPoint>* points : {&model.feet, &model.points})
    for (model::PlanarPoint& point : *points)
      if (point.body == body) point.position *= k;
  for (model::PlanarDrag& drag : model.drags) {
    if (drag.body != body) continue;
    for (double* length : {&drag.start, &drag.end, &drag.point_distance, &drag.point_area})
      *length *= k;
  }
  return model;
}

/// The first thing that a plan's verification holds against it.
std::string failure(const solver::Plan& plan) {
  return plan.verification && !plan.verification->failures.empty()
             ? plan.verification->failures.front()
             : "";
}

std::string solve_point(const PlanStudy& study, int index) {
  const double k = study.factors[index];
  const model::PlanarModel model = stretched(study.model, study.body, k);
  const solver::Plan plan = solver::make_plan(study.problem, model);
  const model::PlanarBody& link = model.bodies[study.body];

  StudyJson row{
      {"stretch", k},
      {"link_mass_kg", link.mass},
      {"link_inertia_about_joint_kg_m2", link.inertia + link.mass * link.com.squaredNorm()},
      {"total_mass_kg", model.total_mass()},
      {"status", to_string(plan.result.status)},
      {"objective", nullptr},
      {"duration_s", nullptr},
      {"liftoff_velocity_m_s", nullptr},
      {"average_acceleration_m_s2", nullptr},
      {"drag_momentum_share", nullptr},
      {"verified", plan.verification && plan.verification->passed ? "yes" : "no"},
      {"failure", failure(plan)},
      {"iterations", plan.result.iterations}};

  if (!plan.converged()) return row.dump();
  const trajectory::Trajectory& t = *plan.trajectory;
  const double duration = t.time[t.samples() - 1] - t.time[0];
  row["objective"] =
      json_number(study.problem.maximise ? -plan.result.objective : plan.result.objective);
  row["duration_s"] = json_number(duration);
  row["drag_momentum_share"] = json_number(plan.verification->drag_momentum_share);

  const int x = model.coordinate_index("x");
  if (x < 0) return row.dump();
  const double velocity = t.velocity(x, t.samples() - 1);
  row["liftoff_velocity_m_s"] = json_number(velocity);
  row["average_acceleration_m_s2"] = json_number(velocity / duration);

  return row.dump();
}

/// What a reader should not overlook: points without a plan, the best one at the end of the list.
std::vector<std::string> plan_notes(const std::vector<StudyJson>& rows) {
  std::vector<std::string> notes;

  const StudyJson* best = nullptr;
  for (const StudyJson& row : rows) {
    if (row.at("average_acceleration_m_s2").is_null()) {
      notes.push_back(fmt::format("stretch {}: ended '{}', no plan", row.at("stretch").dump(),
                                  row.at("status").get<std::string>()));
      continue;
    }

    if (row.at("verified") == "no")
      notes.push_back(fmt::format("stretch {}: the plan fails its verification: {}",
                                  row.at("stretch").dump(), row.at("failure").get<std::string>()));

    if (best == nullptr ||
        row.at("average_acceleration_m_s2") > best->at("average_acceleration_m_s2"))
      best = &row;
  }

  if (best == nullptr) return notes;
  notes.push_back(fmt::format(
      "largest v/T at stretch {}{}; every point is a local optimum from the problem's own guess",
      best->at("stretch").dump(),
      best == &rows.front() || best == &rows.back() ? ", an end of the list" : ""));
  return notes;
}

}  // namespace

detail::PreparedStudy detail::prepare_plan(const yaml::Node& root) {
  const auto read = std::make_shared<const PlanStudy>(read_plan_study(root));
  PreparedStudy study;
  study.description = fmt::format("{} plans of {}", read->factors.size(), read->problem.name);
  study.columns = {"stretch",
                   "link_mass_kg",
                   "link_inertia_about_joint_kg_m2",
                   "total_mass_kg",
                   "status",
                   "objective",
                   "duration_s",
                   "liftoff_velocity_m_s",
                   "average_acceleration_m_s2",
                   "drag_momentum_share",
                   "verified",
                   "failure",
                   "iterations"};
  study.axes = {"stretch"};

  study.isolate = true;  // the solver's linear algebra keeps state of its own
  study.fingerprint = read->problem.node.dump() +
                      file_text(read->problem.robot_folder / "robot.yaml") +
                      file_text(read->problem.robot_folder / "robot.urdf");

  study.tasks = count_of(read->factors);
  study.task = [read](int i) { return solve_point(*read, i); };
  study.rows = [](const std::vector<std::string>& bytes) {
    std::vector<StudyJson> rows;
    for (const std::string& b : bytes) rows.push_back(StudyJson::parse(b));
    return rows;
  };
  study.notes = plan_notes;

  return study;
}

}  // namespace jaculus::studies
