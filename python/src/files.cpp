// SPDX-License-Identifier: MIT
// Sequences, images, cameras and trajectories on disk.
#include "bindings.hpp"
#include "edvo/io/camera_file.hpp"
#include "edvo/io/image_file.hpp"
#include "edvo/io/model_catalogue.hpp"
#include "edvo/io/trajectory_file.hpp"
#include "python_text.hpp"

#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/vector.h>

#include <filesystem>
#include <string>
#include <vector>

namespace edvo::python {
namespace {

namespace fs = std::filesystem;

nb::tuple trajectory_tuple(const TrajectoryFile& file) {
  return nb::make_tuple(numpy_trajectory(file.trajectory), python_texts(file.warnings));
}

nb::list known_models_list() {
  nb::list models;
  for (const KnownModel& model : known_models()) {
    nb::dict fields;
    fields["name"] = std::string(model.name);
    fields["addresses"] = std::vector<std::string>(model.addresses.begin(), model.addresses.end());
    fields["bytes"] = model.bytes;
    fields["sha256"] = std::string(model.sha256);
    fields["licence"] = std::string(model.licence);
    models.append(fields);
  }
  return models;
}

}  // namespace

void add_files(nb::module_& module) {
  using namespace nb::literals;
  module.def("known_models", known_models_list);
  module.def(
      "read_camera",
      [](const fs::path& file, int width, int height) {
        return camera_tuple(read_camera(file, {width, height}));
      },
      "file"_a, "width"_a, "height"_a);
  module.def(
      "require_possible_camera",
      [](const CameraTuple& camera) { require_possible("edvo.Camera", to_camera(camera)); },
      "camera"_a);
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
      [](const fs::path& file, const StampArray& stamps, int decimals, const PoseArray& poses,
         const StampArray& segments) {
        write_trajectory(file, to_trajectory(stamps, decimals, poses, segments));
      },
      "file"_a, "stamps"_a, "decimals"_a, "poses"_a, "segments"_a);
}

}  // namespace edvo::python
