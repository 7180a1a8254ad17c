// SPDX-License-Identifier: MIT
// Python objects that C++ keeps.
#pragma once

#include <nanobind/nanobind.h>

#include <memory>
#include <utility>

namespace edvo::python {

// A Python object that any thread may drop, with the GIL or without.
using Shared = std::shared_ptr<nanobind::object>;

[[nodiscard]] inline Shared share(nanobind::object object) {
  return {new nanobind::object(std::move(object)), [](nanobind::object* kept) {
            const nanobind::gil_scoped_acquire gil;
            delete kept;
          }};
}

}  // namespace edvo::python
