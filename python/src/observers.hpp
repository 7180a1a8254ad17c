// SPDX-License-Identifier: MIT
// Python objects that watch a run.
#pragma once

#include "bindings.hpp"
#include "edvo/image/undistortion.hpp"
#include "edvo/run/observer.hpp"

#include <memory>
#include <span>
#include <vector>

namespace edvo::python {

[[nodiscard]] nb::dict result_dict(const FrameResult& result);
[[nodiscard]] nb::list link_list(std::span<const LinkReport> links);
[[nodiscard]] nb::dict source_fields(const SourceInfo& info);

// Keeps the results and tells a list of edvo.Observer. Takes the GIL only if there is someone to
// tell. Created and destroyed with the GIL; what Python raises becomes Error, and cause().
class PythonObservers final : public Observer {
 public:
  explicit PythonObservers(const nb::list& observers);

  void begin(const SourceInfo& source) override;
  void frame(const FrameResult& result, const Frame& image) override;
  void skipped(const SkippedFrame& frame) override;
  [[nodiscard]] bool wants_keyframes() const override { return wants_keyframes_; }
  void keyframe(const KeyframePtr& keyframe) override;
  void map_changed(std::span<const MapKeyframe> keyframes) override;
  void links(std::span<const LinkReport> links) override;
  void warning(const std::string& text) override;
  void end(const RunOutcome& outcome) override;

  // With the GIL.
  // The fields of edvo.Run, but for its evaluation.
  [[nodiscard]] nb::dict outcome(const RunOutcome& outcome) const;
  // The first exception of an observer; null if there was none.
  [[nodiscard]] const nb::object& cause() const { return cause_; }

 private:
  template <typename Call>
  void tell(const Call& call);

  std::vector<nb::object> observers_;
  bool wants_keyframes_ = false;
  SourceInfo source_;
  std::shared_ptr<const Undistortion> undistortion_;
  nb::object cause_;
  std::vector<FrameResult> frames_;
  std::vector<SkippedFrame> skipped_;
  std::vector<LinkReport> links_;
};

}  // namespace edvo::python
