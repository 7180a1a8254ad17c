// SPDX-License-Identifier: MIT
// Pictures of the frames that may turn out to be the worst of a run.
#pragma once

#include "edvo/odometry/frame_result.hpp"

#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace edvo {

inline constexpr int kPictureWidth = 320;  // [px], at most

// Which frames were worst is known at the end only, when most images are gone. This keeps, small,
// the first frame of the longest losses, and of each stretch of the run the frame with the largest
// residuals: about 70 pictures (16 MB) whatever the length of the run.
class PictureCandidates {
 public:
  // bgr: CV_8UC3 or CV_8UC1; one that is empty is passed over. Its pixels must not be written
  // again.
  void offer(const FrameResult& result, const cv::Mat& bgr);

  // By index in the input.
  [[nodiscard]] std::vector<std::int64_t> frames() const;

  // As JPEG; empty if the frame is no candidate.
  [[nodiscard]] std::string jpeg_of(std::int64_t frame) const;

 private:
  struct Candidate {
    std::int64_t frame = -1;
    double rms = -1;               // [grey levels]
    std::int64_t lost_frames = 0;  // that begin with this one
    cv::Mat image;
  };

  void offer_lost(std::int64_t frame, const cv::Mat& bgr);
  void close_stretch();
  [[nodiscard]] std::vector<Candidate> all() const;

  std::vector<Candidate> losses_, stretches_;
  Candidate stretch_;             // of the stretch that goes on; its image in full size
  std::int64_t in_stretch_ = 0;   // frames
  std::int64_t per_stretch_ = 4;  // frames; doubles as the run grows
  bool was_lost_ = false;
};

}  // namespace edvo
