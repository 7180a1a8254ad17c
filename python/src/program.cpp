// SPDX-License-Identifier: MIT
// The program's verbs: the same entry that the executable has.
#include "program.hpp"

#include "bindings.hpp"

#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <cstdio>
#include <string>
#include <vector>

namespace edvo::python {

void add_program(nb::module_& module) {
  using namespace nb::literals;
  module.attr("version") = EDVO_VERSION;
  module.def(
      "main",
      [](std::vector<std::string> arguments) {
        std::vector<char*> argv;
        for (std::string& argument : arguments) argv.push_back(argument.data());
        argv.push_back(nullptr);
        const int status = app::run_program(static_cast<int>(arguments.size()), argv.data());
        std::fflush(nullptr);
        return status;
      },
      "arguments"_a, nb::call_guard<nb::gil_scoped_release>());
}

}  // namespace edvo::python
