#pragma once
// What the files of the bindings share. A file binds what a module of the library gives; classes of
// jaculus/*.py wrap it for users. Structures of many figures pass as the JSON of their files.

#include <nanobind/nanobind.h>

#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
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

/// Code of the user within C++ that expects no exceptions, called from any thread: the first of a
/// compute() is kept, asks the work to end as Ctrl-C does, and is thrown when it did; until then
/// nothing more is called. False where the code did not run to its end.
bool call_user(const std::function<void()>& code);
/// What call_user() kept, which then isn't any more.
std::exception_ptr take_fault();

/// Takes the name of each stage as it begins.
using StageProgress = std::function<void(const std::string&)>;

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

/// Work that keeps nothing half done: a Ctrl-C that came in it raises KeyboardInterrupt, even where
/// the work took no notice and went to its end.
template <class Work>
auto compute_whole(Work&& work) {
  return compute([&] {
    auto result = work();
    stop_if_interrupted();
    return result;
  });
}

}  // namespace jaculus::python
