// Effects of users: checks of them, and those that Python computes.

#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <memory>
#include <utility>

#include "bindings.h"
#include "jaculus/effects/check.h"
#include "jaculus/effects/coded_effect.h"

namespace jaculus::python {
namespace {

namespace fs = std::filesystem;
using effects::Check;
using effects::UserEffect;

/// A function of Python that takes the numbers of a law and gives values of it.
class LawCall {
 public:
  LawCall(nb::object function, int readings, int states)
      : function_(held(std::move(function))), readings_(readings), states_(states) {}

  /// Of a thread without the GIL, or with it.
  [[nodiscard]] std::vector<double> operator()(const double* readings, const double* states) const {
    const nb::gil_scoped_acquire gil;
    const nb::object numbers = nb::steal(PyTuple_New(readings_ + states_));
    for (int i = 0; i < readings_ + states_; ++i) {
      const double value = i < readings_ ? readings[i] : states[i - readings_];
      PyTuple_SetItem(numbers.ptr(), i, PyFloat_FromDouble(value));
    }
    const nb::object told = nb::steal(PyObject_CallObject(function_->ptr(), numbers.ptr()));
    if (!told.is_valid()) throw nb::python_error();
    return nb::cast<std::vector<double>>(told);
  }

 private:
  std::shared_ptr<const nb::object> function_;
  int readings_, states_;
};

/// `law(theta)` gives two functions of all readings and states: of the actions at the places
/// `early`, None where there is none, and of those at `late` with the rates of the states behind.
struct PythonLaw {
  std::shared_ptr<const nb::object> law;
  std::vector<int> early, late;
  int readings = 0, states = 0;

  simulation::LawFunctions operator()(const Vector& theta) const {
    const nb::gil_scoped_acquire gil;
    const std::vector<double> values(theta.begin(), theta.end());
    const nb::object both = (*law)(nb::cast(values));
    simulation::LawFunctions functions;
    if (!early.empty()) {
      const LawCall call(both[0], readings, states);
      functions.before = [call, at = early](const double* read, const double* state,
                                            double* actions) {
        const std::vector<double> told = call(read, state);
        for (std::size_t i = 0; i < at.size(); ++i) actions[at[i]] = told[i];
      };
    }
    const LawCall call(both[1], readings, states);
    functions.act = [call, at = late](const double* read, const double* state, double* actions,
                                      double* rates) {
      const std::vector<double> told = call(read, state);
      for (std::size_t i = 0; i < at.size(); ++i) actions[at[i]] = told[i];
      std::copy(told.begin() + std::ssize(at), told.end(), rates);
    };
    if (late.empty() && states == 0)  // not asked for
      functions.act = [](const double*, const double*, double*, double*) {};
    return functions;
  }
};

UserEffect coded_effect(const yaml::Node& node, const std::vector<std::string>& reads,
                        const std::vector<std::string>& actions, const std::vector<int>& early,
                        const std::vector<int>& late, int states, nb::object law) {
  return effects::coded_effect(
      node,
      {reads, actions, PythonLaw{held(std::move(law)), early, late, count_of(reads), states}});
}

std::vector<Check> check(const UserEffect& user, const simulation::Experiment& experiment) {
  user.require(simulation::dataset_robot(experiment.setup).planar);
  return compute_whole([&] { return effects::check_effect(user.effect, experiment); });
}

}  // namespace

void bind_effects(nb::module_& module) {
  nb::class_<UserEffect>(module, "Effect")
      .def_prop_ro("name", [](const UserEffect& e) { return e.effect.name; })
      .def_prop_ro("caption", [](const UserEffect& e) { return e.effect.caption; })
      .def_ro("experiment", &UserEffect::experiment);
  module.def("read_effect", &effects::read_user_effect, nb::arg("file"));
  module.def("coded_effect", &coded_effect, nb::arg("node"), nb::arg("reads"), nb::arg("actions"),
             nb::arg("early"), nb::arg("late"), nb::arg("states"), nb::arg("law"));

  nb::class_<Check>(module, "Check")
      .def_ro("what", &Check::what)
      .def_ro("found", &Check::found)
      .def_ro("passed", &Check::passed);
  module.def("check_effect", &check, nb::arg("effect"), nb::arg("experiment"));
}

}  // namespace jaculus::python
