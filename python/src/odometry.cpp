// SPDX-License-Identifier: MIT
// Options, the odometry and what it says about a frame.
#include "edvo/odometry/odometry.hpp"
#include "bindings.hpp"
#include "edvo/core/error.hpp"
#include "edvo/report/machine.hpp"
#include "edvo/saved_map/map_file.hpp"
#include "edvo/saved_map/map_lock.hpp"
#include "edvo/saved_map/slam_in_map.hpp"
#include "observers.hpp"
#include "python_text.hpp"
#include "serialized.hpp"

#include <fmt/core.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/vector.h>

#include <memory>
#include <string>
#include <vector>

namespace edvo::python {
namespace {

namespace fs = std::filesystem;

Method method_named(const std::string& wanted) {
  std::string known;
  for (const auto& [method, name] : EnumNames<Method>::names) {
    if (name == wanted) return method;
    known += (known.empty() ? "" : ", ") + std::string(name);
  }
  throw Error(ErrorCode::kConfig, fmt::format("method {}: unknown, one of {}", wanted, known));
}

nb::dict level_dict(const LevelStats& level) {
  nb::dict values;
  values["level"] = level.level;
  values["iterations"] = level.iterations;
  values["points"] = level.points;
  values["cost"] = level.cost;
  values["converged"] = level.converged;
  return values;
}

nb::dict times_dict(const StageTimes& times) {
  nb::dict values;
  values["frame"] = times.frame;
  values["edges"] = times.edges;
  values["corners"] = times.corners;
  values["selection"] = times.selection;
  values["tracking"] = times.tracking;
  values["window"] = times.window;
  values["total"] = times.total;
  return values;
}

}  // namespace

Config config_of(const std::string& method, const std::vector<std::string>& changes) {
  Config config = preset(method_named(method));
  for (const std::string& change : changes) set_option(config, change);
  check(config);
  return config;
}

// The fields of edvo.FrameResult.
nb::dict result_dict(const FrameResult& result) {
  nb::list levels;
  for (const LevelStats& level : result.levels) levels.append(level_dict(level));
  nb::dict values;
  values["stamp_ns"] = result.stamp.nanoseconds;
  values["status"] = std::string(name_of(result.status));
  values["pose"] = numpy_pose(result.world_from_camera);
  values["information"] = numpy_matrix(result.information);
  values["points"] = result.points;
  values["inlier_ratio"] = result.inlier_ratio;
  values["overlap"] = result.overlap;
  values["rms"] = result.rms;
  values["readout_seconds"] = result.readout_seconds;
  values["ego_share"] = result.ego_share;
  values["loss_cause"] = std::string(name_of(result.loss_cause));
  values["segment"] = result.segment;
  values["keyframe"] = result.keyframe;
  values["keyframe_from_camera"] = numpy_pose(result.keyframe_from_camera);
  values["new_keyframe"] =
      result.keyframe_reason ? nb::cast(std::string(name_of(*result.keyframe_reason))) : nb::none();
  values["levels"] = nb::tuple(levels);
  values["milliseconds"] = times_dict(result.milliseconds);
  return values;
}

namespace {

// Copies the image and tracks it while other Python threads run.
template <typename Tracker, typename DepthOf>
nb::dict process(Serialized<Tracker>& shared, std::int64_t nanoseconds, int decimals,
                 const RgbArray& rgb, const DepthOf& depth_of) {
  return result_dict(shared.call([&](Tracker& tracker) {
    return tracker.process(RgbdImage{.stamp = {.nanoseconds = nanoseconds, .decimals = decimals},
                                     .bgr = to_bgr(rgb),
                                     .depth = depth_of()});
  }));
}

// What Odometry and Slam have in common.
template <typename Tracker>
nb::class_<Serialized<Tracker>> add_tracker(nb::module_& module, const char* name) {
  using namespace nb::literals;
  using Object = Serialized<Tracker>;
  return nb::class_<Object>(module, name)
      .def(
          "process_metres",
          [](Object& shared, std::int64_t nanoseconds, int decimals, const RgbArray& rgb,
             const MetreArray& depth) {
            return process(shared, nanoseconds, decimals, rgb, [&] { return to_depth(depth); });
          },
          "stamp_ns"_a, "decimals"_a, "rgb"_a, "depth"_a)
      .def(
          "process_units",
          [](Object& shared, std::int64_t nanoseconds, int decimals, const RgbArray& rgb,
             const UnitArray& depth, double units_per_metre) {
            return process(shared, nanoseconds, decimals, rgb,
                           [&] { return to_depth(depth, units_per_metre); });
          },
          "stamp_ns"_a, "decimals"_a, "rgb"_a, "depth"_a, "units_per_metre"_a)
      .def(
          "finish",
          [](Object& shared, int threads) {
            shared.call([threads](Tracker& tracker) { tracker.finish(threads); });
          },
          "threads"_a)
      .def("trajectory",
           [](Object& shared) {
             return numpy_trajectory(
                 shared.call([](const Tracker& tracker) { return tracker.trajectory(); }));
           })
      .def("keyframes", [](Object& shared) {
        return numpy_trajectory(
            shared.call([](const Tracker& tracker) { return tracker.keyframe_trajectory(); }));
      });
}

}  // namespace

void add_odometry(nb::module_& module) {
  using namespace nb::literals;
  module.attr("default_method") = std::string(name_of(kDefaultMethod));
  module.def(
      "options_toml",
      [](const std::string& method, const std::vector<std::string>& changes) {
        return to_toml(config_of(method, changes));
      },
      "method"_a, "changes"_a);
  add_tracker<Odometry>(module, "Odometry")
      .def(
          "__init__",
          [](Serialized<Odometry>* place, const CameraTuple& camera, const std::string& method,
             const std::vector<std::string>& changes, const nb::object& detector) {
            const Config config = config_of(method, changes);
            const DistortedCamera lens = to_camera(camera);
            new (place) Serialized(Odometry(lens, config, detector_of(config, lens, detector)));
          },
          "camera"_a, "method"_a, "changes"_a, "detector"_a.none());
  add_tracker<SlamInMap>(module, "Slam")
      .def(
          "__init__",
          [](Serialized<SlamInMap>* place, const CameraTuple& camera, const std::string& method,
             const std::vector<std::string>& changes, const nb::object& detector, bool keep_colour,
             const std::optional<fs::path>& map) {
            const Config config = config_of(method, changes);
            if (!has_back_end(config))
              throw Error(ErrorCode::kConfig,
                          fmt::format("method {} keeps no keyframes that could be joined: use "
                                      "edvo.Odometry, or another method",
                                      method));
            const DistortedCamera lens = to_camera(camera);
            new (place) Serialized(
                SlamInMap(lens, config, {.loops = {}, .links = {}, .keep_colour = keep_colour},
                          detector_of(config, lens, detector),
                          {.camera = lens.pinhole,
                           .method = method,
                           .config = to_toml(config),
                           .made_by = "edvo " + this_machine().edvo},
                          map ? std::optional(load_map(*map)) : std::nullopt, false));
          },
          "camera"_a, "method"_a, "changes"_a, "detector"_a.none(), "keep_colour"_a, "map"_a.none())
      .def("links",
           [](Serialized<SlamInMap>& shared) {
             return link_list(shared.call([](const SlamInMap& slam) { return slam.links(); }));
           })
      .def("map_segments",
           [](Serialized<SlamInMap>& shared) {
             const std::optional<Localization> found =
                 shared.call([](const SlamInMap& slam) { return slam.localization(); });
             return found ? nb::cast(found->segments) : nb::none();
           })
      .def(
          "save_map",
          [](Serialized<SlamInMap>& shared, const fs::path& file) {
            shared.call([&](const SlamInMap& slam) {
              const MapLock lock(file);
              save_map(file, slam.saved_map());
            });
          },
          "file"_a);
}

}  // namespace edvo::python
