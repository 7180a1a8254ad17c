// SPDX-License-Identifier: MIT
#include "observers.hpp"

#include "python_error.hpp"
#include "python_text.hpp"

#include <nanobind/stl/map.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/vector.h>

#include <map>
#include <optional>
#include <string>
#include <utility>

namespace edvo::python {
namespace {

// One image of a run as observers get it, both undistorted or both not; converted only if they ask.
class WatchedImage {
 public:
  WatchedImage(const Frame& frame, std::shared_ptr<const Undistortion> undistortion)
      : bgr_(frame.bgr), depth_(frame.depth), undistortion_(std::move(undistortion)) {}
  [[nodiscard]] nb::object rgb() const {
    return numpy_rgb(cv::Mat_<cv::Vec3b>(undistort_colour(*undistortion_, bgr_)));
  }
  [[nodiscard]] nb::object depth() const { return numpy_depth(depth_.undistorted()); }
  [[nodiscard]] nb::object recorded_rgb() const { return numpy_rgb(cv::Mat_<cv::Vec3b>(bgr_)); }
  [[nodiscard]] nb::object recorded_depth() const { return numpy_depth(depth_.sensor()); }

 private:
  cv::Mat bgr_;
  Depth depth_;
  std::shared_ptr<const Undistortion> undistortion_;
};

// What an observer wrote that failed for the system's reasons is output; anything else is a bug.
ErrorCode code_of(const nb::python_error& error) {
  return error.matches(PyExc_OSError) ? ErrorCode::kOutput : ErrorCode::kInternal;
}

// id, stamp_ns, segment, pose
nb::dict keyframe_fields(std::int64_t id, const Stamp& stamp, int segment, const SE3& pose) {
  nb::dict fields;
  fields["id"] = id;
  fields["stamp_ns"] = stamp.nanoseconds;
  fields["segment"] = segment;
  fields["pose"] = numpy_pose(pose);
  return fields;
}

nb::dict keyframe_dict(const Keyframe& keyframe) {
  std::vector<float> points;
  std::vector<std::uint8_t> colours;
  for (const ColoredPoint& point : keyframe.points) {
    points.insert(points.end(), {point.position.x(), point.position.y(), point.position.z()});
    colours.insert(colours.end(), point.rgb.begin(), point.rgb.end());
  }
  nb::dict fields =
      keyframe_fields(keyframe.id, keyframe.stamp, keyframe.segment, keyframe.world_from_camera);
  fields["rgb"] = numpy_rgb(keyframe.bgr);
  fields["depth"] = numpy_depth(keyframe.depth);
  fields["points"] = numpy_array(std::move(points), {keyframe.points.size(), 3});
  fields["colours"] = numpy_array(std::move(colours), {keyframe.points.size(), 3});
  return fields;
}

nb::dict counts_dict(const FrameCounts& counts) {
  nb::dict fields;
  fields["tracked"] = counts.tracked;
  fields["lost"] = counts.lost;
  fields["restarted"] = counts.restarted;
  fields["relocalized"] = counts.relocalized;
  fields["skipped"] = counts.skipped;
  fields["dropped"] = counts.dropped;
  fields["segments"] = counts.segments;
  return fields;
}

}  // namespace

// The fields of edvo.Link.
nb::list link_list(std::span<const LinkReport> links) {
  nb::list list;
  for (const LinkReport& link : links) {
    nb::dict fields;
    fields["first"] = link.from;
    fields["second"] = link.to;
    fields["status"] = std::string(name_of(link.status));
    fields["similarity"] = link.similarity;
    fields["matches"] = link.matches;
    fields["inliers"] = link.inliers;
    fields["translation_difference"] = link.translation_difference;
    fields["rotation_difference"] = link.rotation_difference;
    fields["overlap"] = link.overlap;
    fields["correlation"] = link.correlation;
    fields["seen_through"] = link.seen_through;
    fields["cycle_chi_square"] = link.cycle_chi_square;
    fields["first_from_second"] = numpy_pose(link.from_pose_to);
    fields["information"] = numpy_matrix(link.information);
    list.append(fields);
  }
  return list;
}

PythonObservers::PythonObservers(const nb::list& observers) {
  for (const nb::handle observer : observers) {
    observers_.push_back(nb::borrow<nb::object>(observer));
    wants_keyframes_ = wants_keyframes_ || nb::cast<bool>(observer.attr("_wants_keyframes")());
  }
}

// Tells each one, whatever another raises; throws the first error.
template <typename Call>
void PythonObservers::tell(const Call& call) {
  if (observers_.empty()) return;
  const nb::gil_scoped_acquire gil;
  std::optional<Error> first;
  for (const nb::object& observer : observers_) {
    try {
      call(observer);
    } catch (nb::python_error& error) {
      if (!cause_) cause_ = nb::borrow<nb::object>(error.value());
      if (!first) first = to_error(error, code_of(error));
    }
  }
  if (first) throw *first;
}

void PythonObservers::begin(const SourceInfo& source) {
  source_ = source;
  if (observers_.empty()) return;
  undistortion_ = std::make_shared<const Undistortion>(make_undistortion(source.camera));
  tell([&](const nb::object& observer) { observer.attr("_begin")(source_fields(source)); });
}

void PythonObservers::frame(const FrameResult& result, const Frame& image) {
  frames_.push_back(result);
  if (observers_.empty()) return;
  const nb::gil_scoped_acquire gil;
  const nb::object picture = nb::cast(WatchedImage(image, undistortion_));
  tell([&](const nb::object& observer) { observer.attr("_frame")(result_dict(result), picture); });
}

void PythonObservers::skipped(const SkippedFrame& frame) {
  skipped_.push_back(frame);
  tell([&](const nb::object& observer) {
    observer.attr("skipped")(frame.index, frame.stamp, python_text(frame.reason));
  });
}

void PythonObservers::keyframe(const KeyframePtr& keyframe) {
  tell([&](const nb::object& observer) {
    if (nb::cast<bool>(observer.attr("_wants_keyframes")()))
      observer.attr("_keyframe")(keyframe_dict(*keyframe));
  });
}

void PythonObservers::map_changed(std::span<const MapKeyframe> keyframes) {
  tell([&](const nb::object& observer) {
    if (!nb::cast<bool>(observer.attr("_wants_map")())) return;
    nb::list poses;
    for (const MapKeyframe& keyframe : keyframes)
      poses.append(keyframe_fields(keyframe.id, keyframe.stamp, keyframe.segment,
                                   keyframe.world_from_camera));
    observer.attr("_map_changed")(poses);
  });
}

void PythonObservers::links(std::span<const LinkReport> links) {
  links_.assign(links.begin(), links.end());
}

void PythonObservers::warning(const std::string& text) {
  tell([&](const nb::object& observer) { observer.attr("warning")(python_text(text)); });
}

void PythonObservers::end(const RunOutcome& outcome) {
  tell([&](const nb::object& observer) { observer.attr("_end")(this->outcome(outcome)); });
}

nb::dict PythonObservers::outcome(const RunOutcome& outcome) const {
  nb::list results, reasons;
  for (const FrameResult& result : frames_) results.append(result_dict(result));
  for (const SkippedFrame& frame : skipped_)
    reasons.append(python_text("frame " + std::to_string(frame.index) + ": " + frame.reason));
  nb::dict fields;
  fields["source"] = source_fields(source_);
  fields["counts"] = counts_dict(outcome.counts);
  fields["trajectory"] = numpy_trajectory(outcome.trajectory);
  fields["online"] = numpy_trajectory(outcome.online);
  fields["keyframes"] = numpy_trajectory(outcome.keyframes);
  fields["frames"] = results;
  fields["skipped"] = reasons;
  fields["links"] = link_list(links_);
  fields["wall_seconds"] = outcome.wall_seconds;
  fields["finish_seconds"] = outcome.finish_seconds;
  fields["interrupted"] = outcome.interrupted;
  fields["error"] = nb::none();
  if (outcome.error)
    fields["error"] =
        nb::make_tuple(python_text(outcome.error->what()), static_cast<int>(outcome.error->code()));
  return fields;
}

void add_observers(nb::module_& module) {
  nb::class_<WatchedImage>(module, "WatchedImage")
      .def_prop_ro("rgb", &WatchedImage::rgb)
      .def_prop_ro("depth", &WatchedImage::depth)
      .def_prop_ro("recorded_rgb", &WatchedImage::recorded_rgb)
      .def_prop_ro("recorded_depth", &WatchedImage::recorded_depth);
}

}  // namespace edvo::python
