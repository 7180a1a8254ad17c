// SPDX-License-Identifier: MIT
// How the camera could have moved since the last frame: a guess for alignment to the keyframe.
#pragma once

#include "edvo/align/align.hpp"
#include "edvo/align/image_shift.hpp"
#include "edvo/core/inplace_vector.hpp"
#include "edvo/features/pixel_selection.hpp"
#include "edvo/odometry/config.hpp"

namespace edvo {

constexpr std::size_t kMostMotions = 3;
using Motions = InplaceVector<SE3, kMostMotions>;  // cur_from_last, the likeliest first

// Aligns whole coarse images, each to the last one. Every frame is to be remembered, and every one
// but the first to be asked about before.
class MotionPredictor {
 public:
  // As whole coarse images tell (started from the motion going on, from standing still or from a
  // turn), as before, or not at all.
  Motions likely(const Frame& frame, const SE3& going_on, const Config& config,
                 AlignScratch& scratch);

  void remember(const Frame& frame, const Config& config);

 private:
  SE3 turn_to(const Frame& frame);

  std::vector<SelectedPixel> pixels_;  // of the last frame
  Reference last_;                     // the last frame, whole but coarse
  PhaseCorrelation correlation_;       // of it and the next one
};

}  // namespace edvo
