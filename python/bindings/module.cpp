// The module jaculus._core.

#include <utility>

#include "bindings.h"

namespace jaculus::python {
namespace {

std::exception_ptr& fault_of_users() {
  static std::exception_ptr fault;
  return fault;
}

}  // namespace

std::mutex& computing() {
  static std::mutex mutex;
  return mutex;
}

std::shared_ptr<const nb::object> held(nb::object object) {
  return {new nb::object(std::move(object)), [](const nb::object* own) {
            const nb::gil_scoped_acquire gil;
            delete own;
          }};
}

void keep_fault(const std::exception_ptr& fault) {
  if (!fault_of_users()) fault_of_users() = fault;
  request_interrupt();
}

std::exception_ptr take_fault() { return std::exchange(fault_of_users(), nullptr); }

}  // namespace jaculus::python

NB_MODULE(_core, module) {
  module.doc() = "The C++ library behind the package jaculus.";
  module.attr("__version__") = JACULUS_VERSION;
  jaculus::python::bind_errors();
  jaculus::python::bind_tables(module);
  jaculus::python::bind_inputs(module);
  jaculus::python::bind_terms(module);
  jaculus::python::bind_plans(module);
  jaculus::python::bind_datasets(module);
  jaculus::python::bind_imports(module);
  jaculus::python::bind_effects(module);
  jaculus::python::bind_diagnosis(module);
  jaculus::python::bind_preflight(module);
  jaculus::python::bind_studies(module);
}
