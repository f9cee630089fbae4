// The module jaculus._core.

#include <utility>

#include "bindings.h"

namespace jaculus::python {
namespace {

struct Fault {
  std::mutex mutex;
  std::exception_ptr kept;
};

Fault& fault_of_user() {
  static Fault fault;
  return fault;
}

bool has_fault() {
  Fault& fault = fault_of_user();
  const std::lock_guard lock(fault.mutex);
  return fault.kept != nullptr;
}

void keep_fault(const std::exception_ptr& thrown) {
  Fault& fault = fault_of_user();
  const std::lock_guard lock(fault.mutex);
  if (!fault.kept) fault.kept = thrown;
  request_interrupt();
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

bool call_user(const std::function<void()>& code) {
  if (has_fault()) return false;
  try {
    code();
    return true;
  } catch (...) {
    keep_fault(std::current_exception());
    return false;
  }
}

std::exception_ptr take_fault() {
  Fault& fault = fault_of_user();
  const std::lock_guard lock(fault.mutex);
  return std::exchange(fault.kept, nullptr);
}

}  // namespace jaculus::python

NB_MODULE(_core, module) {
  // A program that holds a plan with a term or an effect of its own refers to itself by way of C++,
  // where Python's collector does not look: that is no fault, and users need not read of it.
  nanobind::set_leak_warnings(false);
  module.doc() = "The C++ library behind the package jaculus.";
  module.attr("version") = JACULUS_VERSION;
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
