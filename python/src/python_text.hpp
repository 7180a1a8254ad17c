// SPDX-License-Identifier: MIT
// Texts for Python.
#pragma once

#include <nanobind/nanobind.h>

#include <string>
#include <string_view>
#include <vector>

namespace edvo::python {

// Messages quote files and paths, whose bytes need not be UTF-8: those become \xff.
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
