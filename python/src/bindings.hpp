// SPDX-License-Identifier: MIT
// The parts of the module edvo._core: each adds its functions and classes.
#pragma once

#include "edvo/core/camera.hpp"
#include "edvo/odometry/odometry.hpp"
#include "numpy.hpp"

#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/tuple.h>

#include <array>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

namespace edvo::python {

void add_odometry(nb::module_& module);
void add_evaluation(nb::module_& module);
void add_files(nb::module_& module);
void add_observers(nb::module_& module);
void add_registration(nb::module_& module);
void add_run(nb::module_& module);
void add_program(nb::module_& module);

// The options of a method after changes spelled "group.field=value".
[[nodiscard]] Config config_of(const std::string& method, const std::vector<std::string>& changes);

// own: an edvo.EdgeDetector, or None for what the options name; then null where they name no
// network. With the GIL; the result needs none, also when it is destroyed.
[[nodiscard]] std::unique_ptr<EdgeDetector> detector_of(const Config& config,
                                                        const DistortedCamera& camera,
                                                        const nb::object& own);

// fx, fy, cx, cy [px], width, height [px], distortion, whether the lens is equidistant.
using CameraTuple =
    std::tuple<double, double, double, double, int, int, std::array<double, 8>, bool>;

[[nodiscard]] inline DistortedCamera to_camera(const CameraTuple& values) {
  const auto& [fx, fy, cx, cy, width, height, distortion, is_equidistant] = values;
  return {.pinhole = {.fx = fx, .fy = fy, .cx = cx, .cy = cy, .width = width, .height = height},
          .distortion = distortion,
          .lens = is_equidistant ? LensModel::kEquidistant : LensModel::kPolynomial};
}

[[nodiscard]] inline CameraTuple camera_tuple(const DistortedCamera& camera) {
  const Camera& k = camera.pinhole;
  return {k.fx,
          k.fy,
          k.cx,
          k.cy,
          k.width,
          k.height,
          camera.distortion,
          camera.lens == LensModel::kEquidistant};
}

}  // namespace edvo::python
