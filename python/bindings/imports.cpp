// Logs into datasets: what the importers of jaculus/*.py have from the library.

#include <nanobind/eigen/dense.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "bindings.h"
#include "jaculus/core/error.h"
#include "jaculus/model/robot.h"
#include "jaculus/trajectory/bag_map.h"
#include "jaculus/trajectory/import.h"

namespace jaculus::python {
namespace {

namespace fs = std::filesystem;
using namespace trajectory;

Dataset begin_import(const std::string& experiment, const std::string& robot, const fs::path& plan,
                     const std::string& controller) {
  const auto kind = experiment_kinds().find(experiment);
  if (!kind) {
    std::string names;
    for (const std::string& name : experiment_kinds().names())
      names += (names.empty() ? "" : ", ") + name;
    throw InputError("experiment: '" + experiment + "' given; allowed: " + names);
  }

  const fs::path folder = model::find_robot(robot, fs::current_path());
  Dataset dataset = begin_dataset({*kind, robot, plan, controller});
  // As `jaculus import`: the dataset lies elsewhere, so a robot that is a place stands in full.
  if (fs::path(robot).has_parent_path() || fs::is_directory(robot))
    dataset.robot = fs::absolute(folder).lexically_normal().string();
  return dataset;
}

/// A stream as the importers have it, channels x samples.
Stream make_stream(const std::string& name, double rate_hz, const Vector& time,
                   const std::vector<std::string>& channels, const std::vector<std::string>& units,
                   const Matrix& values) {
  return {name, rate_hz, time, channels, units, values};
}

void add_trial(Dataset& dataset, const std::string& name, const std::vector<Stream>& streams) {
  dataset.trials.push_back({name, streams});
}

/// Poses of one body, positions 3 x samples, quaternions (x, y, z, w) 4 x samples, in a frame whose
/// z is up. Notes say what was assumed.
std::pair<Stream, std::vector<std::string>> planar_pose(const std::string& body, const Vector& time,
                                                        const Matrix& position,
                                                        const Matrix& rotation,
                                                        MocapForward forward, double rest) {
  const MocapTake take{"", kNaN, time, {{body, position, rotation}}, {}};
  std::vector<std::string> notes;
  Stream stream = mocap_stream(take, {MocapUp::z, forward, body, rest}, notes);
  return {std::move(stream), notes};
}

void bind_maps(nb::module_& module) {
  nb::class_<MappedChannel>(module, "MappedChannel")
      .def_ro("channel", &MappedChannel::channel)
      .def_ro("columns", &MappedChannel::columns)
      .def_ro("unit", &MappedChannel::unit)
      .def_ro("scale", &MappedChannel::scale)
      .def_ro("shift", &MappedChannel::shift)
      .def_ro("apart", &MappedChannel::apart);
  nb::class_<ColumnMap>(module, "ColumnMap")
      .def_ro("stream", &ColumnMap::stream)
      .def_ro("rate_hz", &ColumnMap::rate_hz)
      .def_prop_ro("separator", [](const ColumnMap& m) { return std::string(1, m.separator); })
      .def_ro("skip_lines", &ColumnMap::skip_lines)
      .def_ro("header", &ColumnMap::header)
      .def_ro("gaps", &ColumnMap::gaps)
      .def_ro("channels", &ColumnMap::channels);
  module.def("read_column_map", &read_column_map, nb::arg("node"));

  nb::class_<BagTopic>(module, "BagTopic")
      .def_ro("topic", &BagTopic::topic)
      .def_ro("stream", &BagTopic::stream)
      .def_ro("rate_hz", &BagTopic::rate_hz)
      .def_prop_ro("stamp",
                   [](const BagTopic& t) {
                     return t.stamp ? std::string(bag_stamps().name(*t.stamp)) : std::string();
                   })
      .def_ro("joints", &BagTopic::joints)
      .def_prop_ro("forward",
                   [](const BagTopic& t) {
                     return t.forward ? std::string(mocap_forwards().name(*t.forward))
                                      : std::string();
                   })
      .def_ro("rest", &BagTopic::rest)
      .def_ro("channels", &BagTopic::channels);
  module.def("read_bag_map", &read_bag_map, nb::arg("node"));
}

/// Joints in the plane: name, whether it slides, and the joints of the file with their signs.
nb::list joints_of(const model::Robot& robot) {
  nb::list joints;
  for (const model::PlanarBody& body : robot.planar.bodies) {
    if (body.joint.empty()) continue;
    nb::dict file;
    for (const model::FileJoint& joint : body.file_joints) file[joint.name.c_str()] = joint.sign;
    joints.append(
        nb::make_tuple(body.joint, body.kind == model::JointKind::prismatic, std::move(file)));
  }
  return joints;
}

}  // namespace

void bind_imports(nb::module_& module) {
  bind_maps(module);
  module.def("robot_joints", &joints_of, nb::arg("robot"));
  module.def("begin_import", &begin_import, nb::arg("experiment"), nb::arg("robot"),
             nb::arg("plan"), nb::arg("controller"));
  module.def("make_stream", &make_stream, nb::arg("name"), nb::arg("rate_hz"), nb::arg("time"),
             nb::arg("channels"), nb::arg("units"), nb::arg("values"));
  module.def("add_trial", &add_trial, nb::arg("dataset"), nb::arg("name"), nb::arg("streams"));
  module.def(
      "planar_pose",
      [](const std::string& body, const Vector& time, const Matrix& position,
         const Matrix& rotation, const std::string& forward, double rest) {
        const auto [stream, notes] =
            planar_pose(body, time, position, rotation, *mocap_forwards().find(forward), rest);
        return nb::make_tuple(stream, notes);
      },
      nb::arg("body"), nb::arg("time"), nb::arg("position"), nb::arg("rotation"),
      nb::arg("forward"), nb::arg("rest"));
  module.def(
      "write_dataset",
      [](Dataset& dataset, const fs::path& folder, const std::string& provenance) {
        dataset.provenance = provenance;
        trajectory::write_dataset(dataset, folder);
      },
      nb::arg("dataset"), nb::arg("folder"), nb::arg("provenance"));
}

}  // namespace jaculus::python
