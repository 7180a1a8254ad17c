// SPDX-License-Identifier: MIT
// Sequences, images, cameras and trajectories on disk.
#include "bindings.hpp"
#include "edvo/io/camera_choice.hpp"
#include "edvo/io/camera_file.hpp"
#include "edvo/io/dataset.hpp"
#include "edvo/io/image_file.hpp"
#include "edvo/io/trajectory_file.hpp"

#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <filesystem>
#include <optional>
#include <string>

namespace edvo::python {
namespace {

namespace fs = std::filesystem;

nb::tuple frame_tuple(const Dataset& dataset, std::size_t index) {
  RgbdImage image;
  {
    const nb::gil_scoped_release release;
    image = read_frame(dataset, index);
  }
  return nb::make_tuple(image.stamp.nanoseconds, image.stamp.decimals, numpy_rgb(image.bgr),
                        numpy_depth(image.depth));
}

nb::tuple trajectory_tuple(const TrajectoryFile& file) {
  return nb::make_tuple(numpy_trajectory(file.trajectory), file.warnings);
}

}  // namespace

void add_files(nb::module_& module) {
  using namespace nb::literals;
  nb::class_<Dataset>(module, "Dataset")
      .def_ro("name", &Dataset::name)
      .def_ro("root", &Dataset::root)
      .def_ro("layout", &Dataset::layout)
      .def_ro("notes", &Dataset::notes)
      .def_ro("warnings", &Dataset::warnings)
      .def_ro("ground_truth", &Dataset::ground_truth)
      .def_prop_ro("units_per_metre",
                   [](const Dataset& dataset) { return dataset.depth_scale.units_per_metre; })
      .def("__len__", [](const Dataset& dataset) { return dataset.frames.size(); })
      .def(
          "stamp",
          [](const Dataset& dataset, std::size_t i) {
            const Stamp stamp = dataset.frames.at(i).stamp;
            return std::pair(stamp.nanoseconds, stamp.decimals);
          },
          "index"_a)
      .def(
          "depth_stamp_ns",
          [](const Dataset& dataset, std::size_t i) {
            return dataset.frames.at(i).depth_stamp.nanoseconds;
          },
          "index"_a)
      .def(
          "files",
          [](const Dataset& dataset, std::size_t i) {
            return std::pair(dataset.frames.at(i).colour, dataset.frames.at(i).depth);
          },
          "index"_a)
      .def("poses", [](const Dataset& dataset) { return numpy_trajectory(dataset.poses); })
      .def("read", frame_tuple, "index"_a)
      .def(
          "camera",
          [](const Dataset& dataset, const std::optional<fs::path>& file) {
            const ChosenCamera chosen = choose_camera(dataset, {.file = file});
            return std::pair(camera_tuple(chosen.camera), chosen.source);
          },
          "file"_a.none());
  module.def(
      "open_dataset",
      [](const fs::path& source, std::optional<double> depth_scale, const fs::path& cache) {
        const nb::gil_scoped_release release;
        return open_dataset(source, {.depth_scale = depth_scale, .cache = cache});
      },
      "source"_a, "depth_scale"_a.none(), "cache"_a);
  module.def(
      "read_camera",
      [](const fs::path& file, int width, int height) {
        return camera_tuple(read_camera(file, {width, height}));
      },
      "file"_a, "width"_a, "height"_a);
  module.def(
      "camera_to_toml", [](const CameraTuple& camera) { return camera_to_toml(to_camera(camera)); },
      "camera"_a);
  module.def(
      "read_colour", [](const fs::path& file) { return numpy_rgb(read_colour(file)); }, "file"_a);
  module.def(
      "read_depth",
      [](const fs::path& file) {
        const cv::Mat_<std::uint16_t> raw = read_depth_raw(file);
        return numpy_array(
            std::vector<std::uint16_t>(raw[0], raw[0] + raw.total()),
            {static_cast<std::size_t>(raw.rows), static_cast<std::size_t>(raw.cols)});
      },
      "file"_a);
  module.def(
      "read_trajectory",
      [](const fs::path& file) { return trajectory_tuple(read_trajectory(file)); }, "file"_a);
  module.def(
      "write_trajectory",
      [](const fs::path& file, const StampArray& stamps, int decimals, const PoseArray& poses) {
        write_trajectory(file, to_trajectory(stamps, decimals, poses));
      },
      "file"_a, "stamps"_a, "decimals"_a, "poses"_a);
}

}  // namespace edvo::python
