// What is read: YAML nodes, robots, problems.

#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "bindings.h"
#include "jaculus/core/installation.h"
#include "jaculus/core/yaml.h"
#include "jaculus/model/describe.h"
#include "jaculus/transcription/describe.h"

namespace jaculus::python {
namespace {

using transcription::LoadedProblem;

std::vector<std::string> coordinate_names(const model::Robot& robot) {
  std::vector<std::string> names;
  for (const model::Coordinate& c : robot.planar.coordinates) names.push_back(c.name);
  return names;
}

std::vector<std::string> motor_joints(const model::Robot& robot) {
  std::vector<std::string> names;
  for (const model::PlanarMotor& motor : robot.planar.motors) names.push_back(motor.joint);
  return names;
}

std::vector<std::string> foot_names(const model::Robot& robot) {
  std::vector<std::string> names;
  for (const model::PlanarPoint& foot : robot.planar.feet) names.push_back(foot.name);
  return names;
}

model::Robot read_robot(const std::string& given) {
  return model::read_robot(model::find_robot(given, "."));
}

void bind_nodes(nb::module_& module) {
  nb::class_<yaml::Node>(module, "Node", "A YAML document.")
      .def_static("load", &yaml::Node::load, nb::arg("file"))
      .def_static("parse", &yaml::Node::parse, nb::arg("text"), nb::arg("name"));
  module.def(
      "find_problem_file", &find_problem_file, nb::arg("given"),
      "The file of a problem, experiment or study: a path, or a name that comes with jaculus.");
  module.def("data_folders", &data_folders, "Folders that hold models/, problems/ and effects/.");
}

}  // namespace

void bind_inputs(nb::module_& module) {
  bind_nodes(module);

  nb::class_<model::Robot>(module, "Robot")
      .def_ro("name", &model::Robot::name)
      .def_ro("folder", &model::Robot::folder)
      .def_ro("notes", &model::Robot::notes)
      .def_prop_ro("mass", [](const model::Robot& r) { return r.planar.total_mass(); })
      .def_prop_ro("coordinates", &coordinate_names)
      .def_prop_ro("motors", &motor_joints)
      .def_prop_ro("feet", &foot_names)
      .def_prop_ro("summary", &model::describe_robot)
      .def_prop_ro("override_paths",
                   [](const model::Robot& r) { return model::override_paths(r.folder); });
  module.def("load_robot", &read_robot, nb::arg("robot"));

  nb::class_<LoadedProblem>(module, "Problem")
      .def_prop_ro("name", [](const LoadedProblem& p) { return p.problem.name; })
      .def_prop_ro("caption", [](const LoadedProblem& p) { return p.problem.caption; })
      .def_ro("robot", &LoadedProblem::robot)
      .def_prop_ro("summary",
                   [](const LoadedProblem& p) {
                     return transcription::describe_problem_text(p.problem, p.robot);
                   })
      .def_prop_ro("json", [](const LoadedProblem& p) {
        return transcription::describe_problem(p.problem).dump();
      });
}

}  // namespace jaculus::python
