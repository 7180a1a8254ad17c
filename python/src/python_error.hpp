// SPDX-License-Identifier: MIT
// Exceptions of Python code that C++ calls.
#pragma once

#include "edvo/core/error.hpp"
#include "python_text.hpp"

#include <nanobind/nanobind.h>

#include <string>

namespace edvo::python {

// The message and, of an edvo.Error, its code; of anything else fallback.
[[nodiscard]] inline Error to_error(nanobind::python_error& error, ErrorCode fallback) {
  namespace nb = nanobind;
  const nb::gil_scoped_acquire gil;
  const nb::object value = nb::borrow<nb::object>(error.value());
  const nb::object type = nb::module_::import_("edvo.errors").attr("Error");
  const auto message = nb::cast<std::string>(nb::str(value));
  if (!nb::isinstance(value, type)) {
    const auto name = nb::cast<std::string>(error.type().attr("__name__"));
    const bool is_usual = name == "ValueError" || name == "TypeError";
    return {fallback, is_usual ? message : name + ": " + message};
  }
  return {static_cast<ErrorCode>(nb::cast<int>(value.attr("code"))), message};
}

// Runs what calls Python, with the GIL held. What Python raises there becomes Error, by default
// about the input, which is what the library expects of sources.
template <typename Function>
void rethrow_python_errors(const Function& function, ErrorCode fallback = ErrorCode::kInput) {
  try {
    function();
  } catch (nanobind::python_error& error) {
    throw to_error(error, fallback);
  } catch (const nanobind::cast_error&) {
    throw Error(fallback, "a Python source gave something that is no frame");
  }
}

}  // namespace edvo::python
