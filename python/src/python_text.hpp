// SPDX-License-Identifier: MIT
// Texts between Python and C++, also those that are no UTF-8: paths may have any bytes, and
// messages quote paths and files. To be included in place of nanobind/stl/string.h.
#pragma once

#include <nanobind/nanobind.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace nanobind::detail {

// Other bytes are what Python's own functions for paths make of them (surrogateescape), so that
// they come back as they were.
template <>
struct type_caster<std::string> {
  NB_TYPE_CASTER(std::string, const_name("str"))

  bool from_python(handle source, std::uint32_t, cleanup_list*) noexcept {
    if (!PyUnicode_Check(source.ptr())) return false;
    const object bytes = steal(PyUnicode_AsEncodedString(source.ptr(), "utf-8", "surrogateescape"));
    if (!bytes.is_valid()) {
      PyErr_Clear();
      return false;
    }
    value.assign(PyBytes_AS_STRING(bytes.ptr()),
                 static_cast<std::size_t>(PyBytes_GET_SIZE(bytes.ptr())));
    return true;
  }

  static handle from_cpp(const std::string& text, rv_policy, cleanup_list*) noexcept {
    return PyUnicode_DecodeUTF8(text.data(), static_cast<Py_ssize_t>(text.size()),
                                "surrogateescape");
  }
};

}  // namespace nanobind::detail

namespace edvo::python {

// To be read by people: other bytes become \xff, which can be printed everywhere.
[[nodiscard]] inline nanobind::object python_text(std::string_view text) {
  PyObject* const made =
      PyUnicode_DecodeUTF8(text.data(), static_cast<Py_ssize_t>(text.size()), "backslashreplace");
  if (made == nullptr) throw nanobind::python_error();
  return nanobind::steal(made);
}

[[nodiscard]] inline nanobind::list python_texts(const std::vector<std::string>& texts) {
  nanobind::list made;
  for (const std::string& text : texts) made.append(python_text(text));
  return made;
}

}  // namespace edvo::python
