// SPDX-License-Identifier: MIT
#include "source.hpp"

#include <fmt/core.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/vector.h>
#include "edvo/core/error.hpp"
#include "edvo/source/folder_source.hpp"
#include "python_error.hpp"
#include "python_text.hpp"

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>

namespace edvo::python {
namespace {

namespace fs = std::filesystem;

// What edvo.Source._describe() returns.
SourceInfo info_of(const nb::object& source, const FrameRange& range) {
  const nb::dict fields = nb::cast<nb::dict>(source.attr("_describe")());
  SourceInfo info{
      .name = nb::cast<std::string>(fields["name"]),
      .origin = nb::cast<std::string>(fields["origin"]),
      .camera = to_camera(nb::cast<CameraTuple>(fields["camera"])),
      .camera_origin = nb::cast<std::string>(fields["camera_origin"]),
      .depth_scale = nb::cast<double>(fields["depth_scale"]),
      .depth_origin = nb::cast<std::string>(fields["depth_origin"]),
      .is_depth_assumed = nb::cast<bool>(fields["is_depth_assumed"]),
      .frames = nb::cast<std::optional<std::int64_t>>(fields["frames"]),
      .is_live = nb::cast<bool>(fields["is_live"]),
      .notes = nb::cast<std::vector<std::string>>(fields["notes"]),
      .warnings = nb::cast<std::vector<std::string>>(fields["warnings"]),
  };
  if (const nb::object truth = fields["ground_truth"]; !truth.is_none()) {
    const auto [stamps, decimals, poses, segments] =
        nb::cast<std::tuple<StampArray, int, PoseArray, StampArray>>(truth);
    info.ground_truth = GroundTruth{nb::cast<std::string>(fields["ground_truth_origin"]),
                                    to_trajectory(stamps, decimals, poses, segments)};
  }
  if (info.frames) {
    info.frames = std::max<std::int64_t>(0, *info.frames - range.first);
    if (range.max_frames > 0) info.frames = std::min(*info.frames, range.max_frames);
  }
  return info;
}

// Calls load(), which gives (rgb, depth [m]), and copies the arrays.
RgbdImage load_frame(const Shared& load, const Stamp& stamp) {
  const nb::gil_scoped_acquire gil;
  std::optional<RgbdImage> image;
  rethrow_python_errors([&] {
    const auto [rgb, depth] = nb::cast<std::pair<RgbArray, MetreArray>>((*load)());
    const nb::gil_scoped_release release;
    image = RgbdImage{.stamp = stamp, .bgr = to_bgr(rgb), .depth = to_depth(depth)};
  });
  return std::move(*image);
}

// Whether the arrays of a frame stay as they are while the next one is asked for. A source of
// someone else's may fill the same buffers again; those of edvo that read late make new ones.
bool keeps_arrays(const nb::object& source) {
  const nb::object usual = nb::module_::import_("edvo.sources").attr("Source").attr("_pending");
  return !source.type().attr("_pending").is(usual);
}

// The stamp of an item of source._pending(). [ns]
std::int64_t stamp_of(const nb::object& stamp, std::int64_t index) {
  if (PyIndex_Check(stamp.ptr()) == 0)  // a float is not cut off
    throw Error(ErrorCode::kInput,
                fmt::format("frame {}: stamp_ns {}: whole nanoseconds are expected, as an int; of "
                            "seconds they are round(seconds * 1e9)",
                            index, nb::cast<std::string>(nb::repr(stamp))));
  return nb::cast<std::int64_t>(nb::int_(stamp));
}

// Iterates over source._pending(), which gives (stamp [ns], decimals, load); over
// source._awaited(), whose waits end when asked to, where someone else's code may wait.
class IteratedSource final : public RgbdSource {
 public:
  IteratedSource(const nb::object& source, const FrameRange& range,
                 std::function<bool()> should_stop, Shared* failure)
      : range_(range),
        info_(info_of(source, range)),
        source_(share(source)),
        reads_late_(keeps_arrays(source)),
        failure_(failure) {
    const auto asked_to_stop = [stopped = stopped_, should_stop = std::move(should_stop)] {
      return *stopped || (should_stop && should_stop());
    };
    ask([&] {
      frames_ =
          share(nb::iter(reads_late_ ? source.attr("_pending")()
                                     : source.attr("_awaited")(nb::cpp_function(asked_to_stop))));
    });
  }

  [[nodiscard]] const SourceInfo& info() const override { return info_; }

  [[nodiscard]] std::optional<PendingFrame> next() override {
    const nb::gil_scoped_acquire gil;
    std::optional<PendingFrame> pending;
    ask([&] {
      for (; index_ < range_.first; ++index_)
        if (!next_item()) return;
      if (range_.max_frames > 0 && index_ >= range_.first + range_.max_frames) return;
      const nb::object item = next_item();
      if (!item) return;
      const auto [stamp, decimals, load] = nb::cast<std::tuple<nb::object, int, nb::object>>(item);
      pending = frame_of({.nanoseconds = stamp_of(stamp, index_), .decimals = decimals}, load);
    });
    return pending;
  }

  void stop() override {
    *stopped_ = true;
    const nb::gil_scoped_acquire gil;
    rethrow_python_errors([&] { source_->attr("stop")(); });
  }

 private:
  // Calls what asks the source, and keeps what it raises.
  template <typename Function>
  void ask(const Function& function) {
    rethrow_python_errors([&] {
      try {
        function();
      } catch (const nb::python_error& error) {
        if (failure_ != nullptr) *failure_ = share(nb::borrow<nb::object>(error.value()));
        throw;
      }
    });
  }

  // Empty at the end.
  nb::object next_item() {
    PyObject* const item = PyIter_Next(frames_->ptr());
    if (item == nullptr && PyErr_Occurred() != nullptr) throw nb::python_error();
    return nb::steal<nb::object>(item);
  }

  PendingFrame frame_of(const Stamp& stamp, const nb::object& load) {
    const std::int64_t index = index_++;
    if (reads_late_)
      return {.index = index, .stamp = stamp, .load = [load = share(load), stamp] {
                return load_frame(load, stamp);
              }};
    try {
      const RgbdImage image = load_frame(share(load), stamp);
      return {.index = index, .stamp = stamp, .load = [image] { return image; }};
    } catch (const Error& error) {  // of this frame alone, which is skipped
      return {.index = index, .stamp = stamp, .load = [error]() -> RgbdImage { throw error; }};
    }
  }

  FrameRange range_;
  SourceInfo info_;
  Shared source_, frames_;
  bool reads_late_;
  Shared* failure_;
  std::shared_ptr<std::atomic<bool>> stopped_ = std::make_shared<std::atomic<bool>>(false);
  std::int64_t index_ = 0;
};

// A folder, read without Python, described by its Python object (which may know another camera).
class NativeSource final : public RgbdSource {
 public:
  NativeSource(const nb::object& source, const FolderSource& folder, const FrameRange& range)
      : info_(info_of(source, range)), folder_(folder), skip_(range.first) {
    folder_.rewind();
    if (range.max_frames > 0) left_ = range.max_frames;
  }

  [[nodiscard]] const SourceInfo& info() const override { return info_; }

  [[nodiscard]] std::optional<PendingFrame> next() override {
    for (; skip_ > 0; --skip_)
      if (!folder_.next()) return std::nullopt;
    if (left_ && (*left_)-- <= 0) return std::nullopt;
    return folder_.next();
  }

 private:
  SourceInfo info_;
  FolderSource folder_;  // a copy: two runs of one source do not meet
  std::int64_t skip_;
  std::optional<std::int64_t> left_;
};

nb::tuple frame_tuple(const FolderSource& folder, std::size_t index) {
  RgbdImage image;
  {
    const nb::gil_scoped_release release;
    image = read_frame(folder.dataset(), index);
  }
  return nb::make_tuple(image.stamp.nanoseconds, image.stamp.decimals, numpy_rgb(image.bgr),
                        numpy_depth(image.depth));
}

nb::dict info_dict(const SourceInfo& info) {
  nb::dict fields;
  fields["name"] = python_text(info.name);
  fields["origin"] = python_text(info.origin);
  fields["camera"] = camera_tuple(info.camera);
  fields["camera_origin"] = python_text(info.camera_origin);
  fields["depth_scale"] = info.depth_scale;
  fields["depth_origin"] = python_text(info.depth_origin);
  fields["is_depth_assumed"] = info.is_depth_assumed;
  fields["frames"] = info.frames;
  fields["is_live"] = info.is_live;
  fields["notes"] = python_texts(info.notes);
  fields["warnings"] = python_texts(info.warnings);
  fields["ground_truth"] = nb::none();
  fields["ground_truth_origin"] = "";
  if (info.ground_truth) {
    fields["ground_truth"] = numpy_trajectory(info.ground_truth->trajectory);
    fields["ground_truth_origin"] = python_text(info.ground_truth->source);
  }
  return fields;
}

}  // namespace

nb::dict source_fields(const SourceInfo& info) {
  return info_dict(info);
}

std::unique_ptr<RgbdSource> make_source(const nb::object& source, const FrameRange& range,
                                        std::function<bool()> should_stop, Shared* failure) {
  const nb::object native = source.attr("_native")();
  if (native.is_none())
    return std::make_unique<IteratedSource>(source, range, std::move(should_stop), failure);
  return std::make_unique<NativeSource>(source, nb::cast<const FolderSource&>(native), range);
}

void add_source(nb::module_& module) {
  using namespace nb::literals;
  nb::class_<FolderSource>(module, "FolderSource")
      .def(
          "__init__",
          [](FolderSource* place, const fs::path& sequence, const std::optional<fs::path>& camera,
             const std::pair<int, int>& camera_size, std::optional<double> depth_scale,
             bool is_depth_registered, const fs::path& cache) {
            const nb::gil_scoped_release release;
            new (place)
                FolderSource(sequence, {.camera_file = camera,
                                        .camera_size = {camera_size.first, camera_size.second},
                                        .depth_scale = depth_scale,
                                        .is_depth_registered = is_depth_registered,
                                        .cache = cache});
          },
          "sequence"_a, "camera"_a.none(), "camera_size"_a, "depth_scale"_a.none(),
          "is_depth_registered"_a, "cache"_a)
      .def("info", [](const FolderSource& folder) { return info_dict(folder.info()); })
      .def("__len__", [](const FolderSource& folder) { return folder.dataset().frames.size(); })
      .def_prop_ro("depth_size",
                   [](const FolderSource& folder) {
                     const cv::Size size = folder.dataset().depth_size;
                     return std::pair(size.width, size.height);
                   })
      .def(
          "stamp",
          [](const FolderSource& folder, std::size_t i) {
            const Stamp stamp = folder.dataset().frames.at(i).stamp;
            return std::pair(stamp.nanoseconds, stamp.decimals);
          },
          "index"_a)
      .def(
          "depth_stamp_ns",
          [](const FolderSource& folder, std::size_t i) {
            return folder.dataset().frames.at(i).depth_stamp.nanoseconds;
          },
          "index"_a)
      .def(
          "files",
          [](const FolderSource& folder, std::size_t i) {
            const FrameEntry& entry = folder.dataset().frames.at(i);
            return std::pair(entry.colour, entry.depth);
          },
          "index"_a)
      .def("read", frame_tuple, "index"_a);
}

}  // namespace edvo::python
