// Exceptions: InputError with its place, Ctrl-C where nothing is kept.

#include "bindings.h"
#include "jaculus/core/error.h"

namespace jaculus::python {
namespace {

nb::object or_none(const std::string& text) {
  return text.empty() ? nb::none() : nb::object(nb::str(text.c_str(), text.size()));
}

void raise(const InputError& error) {
  const nb::object type = nb::module_::import_("jaculus._errors").attr("InputError");
  const InputPlace& place = error.place();
  nb::object raised = type(nb::str(error.what()));
  raised.attr("file") = or_none(place.file);
  raised.attr("line") = place.line > 0 ? nb::object(nb::int_(place.line)) : nb::none();
  raised.attr("key") = or_none(place.key);
  PyErr_SetObject(type.ptr(), raised.ptr());
}

void translate(const std::exception_ptr& thrown, void*) {
  try {
    std::rethrow_exception(thrown);
  } catch (const InputError& error) {
    raise(error);
  } catch (const Interrupted&) {
    PyErr_SetNone(PyExc_KeyboardInterrupt);
  }
}

}  // namespace

void bind_errors() { nb::register_exception_translator(translate); }

}  // namespace jaculus::python
