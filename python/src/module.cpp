// SPDX-License-Identifier: MIT
// edvo._core: the library as Python sees it. Thin: names, documentation and checks of arguments are
// in python/edvo.
#include "bindings.hpp"
#include "edvo/core/error.hpp"
#include "python_text.hpp"
#include "source.hpp"

#include <exception>

namespace {

namespace nb = nanobind;

// edvo.Error(message, code), the class of python/edvo/errors.py.
void translate(const std::exception_ptr& exception, void*) {
  try {
    std::rethrow_exception(exception);
  } catch (const edvo::Error& error) {
    const nb::object type = nb::module_::import_("edvo.errors").attr("Error");
    const nb::object instance =
        type(edvo::python::python_text(error.what()), static_cast<int>(error.code()));
    PyErr_SetObject(type.ptr(), instance.ptr());
  }
}

}  // namespace

NB_MODULE(_core, module) {
  module.doc() = "The C++ library of edvo; use the package edvo instead.";
  nb::register_exception_translator(translate);
  edvo::python::add_odometry(module);
  edvo::python::add_evaluation(module);
  edvo::python::add_files(module);
  edvo::python::add_source(module);
  edvo::python::add_observers(module);
  edvo::python::add_run(module);
  edvo::python::add_registration(module);
  edvo::python::add_program(module);
}
