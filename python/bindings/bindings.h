#pragma once
// What the files of the bindings share. A file binds what a module of the library gives; classes of
// jaculus/*.py wrap it for users. Structures of many figures pass as the JSON of their files.

#include <nanobind/nanobind.h>

#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <type_traits>

#include "jaculus/core/interrupt.h"

namespace jaculus::python {

namespace nb = nanobind;

// One function a file; each adds its part to the module.
void bind_errors();
void bind_inputs(nb::module_& module);
void bind_tables(nb::module_& module);
void bind_terms(nb::module_& module);
void bind_plans(nb::module_& module);
void bind_datasets(nb::module_& module);
void bind_imports(nb::module_& module);
void bind_effects(nb::module_& module);
void bind_diagnosis(nb::module_& module);
void bind_preflight(nb::module_& module);
void bind_studies(nb::module_& module);

/// One computation at a time: MUMPS is not re-entrant, and SIGINT has one handler.
std::mutex& computing();

/// A Python object that threads without the GIL may copy and let go of.
std::shared_ptr<const nb::object> held(nb::object object);

/// An exception of the user's code within C++ that expects none, of any thread with the GIL: the
/// first of a compute() is kept, asks the work to end as Ctrl-C does, and is thrown when it did.
void keep_fault(const std::exception_ptr& fault);
/// What was kept, which then isn't any more.
std::exception_ptr take_fault();

/// Work without the GIL; Ctrl-C raises interrupt_requested() while it lasts.
template <class Work>
auto compute(Work&& work) {
  const nb::gil_scoped_release released;
  const std::lock_guard one(computing());
  const InterruptScope interrupts;
  take_fault();
  const auto rethrow = [] {
    if (const std::exception_ptr fault = take_fault()) std::rethrow_exception(fault);
  };
  if constexpr (std::is_void_v<decltype(work())>) {
    work();
    rethrow();
  } else {
    auto result = work();
    rethrow();
    return result;
  }
}

/// A callback of the user within C++ that expects no exceptions: the first is kept, asks the work
/// to end as Ctrl-C does, and is thrown again by rethrow().
class Callback {
 public:
  template <class Call>
  void operator()(Call&& call) {
    if (fault_) return;
    try {
      call();
    } catch (...) {
      fault_ = std::current_exception();
      request_interrupt();
    }
  }

  void rethrow() const {
    if (fault_) std::rethrow_exception(fault_);
  }

 private:
  std::exception_ptr fault_;
};

}  // namespace jaculus::python
