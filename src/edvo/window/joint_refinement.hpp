// SPDX-License-Identifier: MIT
// Joint photometric refinement of all keyframes of a segment, each with those that share its view,
// whenever they were taken (bundle adjustment on pixels; the residuals are the window's).
#pragma once

#include "edvo/window/window_keyframe.hpp"

#include <vector>

namespace edvo {

struct JointOptions {
  int neighbours = 16;  // keyframes in which each one's points are looked for, at most
  int iterations = 8;   // linearizations
  double tolerance = 5e-4;
  int threads = 2;  // the result is the same for any number
};

// Of each keyframe the others in which its points are looked for: those next to it in time, and of
// all others those with most of the view in common, spread over time. Indices, ascending.
[[nodiscard]] std::vector<std::vector<int>> keyframes_in_view(
    const std::vector<WindowKeyframe>& keyframes, const Camera& camera, int count);

struct JointSummary {
  int iterations = 0;
  double first_cost = 0, cost = 0;
};

// Lowers the joint cost over poses, brightness and inverse depths. The first keyframe stays where
// it is. targets: as keyframes_in_view() tells.
JointSummary refine_jointly(std::vector<WindowKeyframe>& keyframes,
                            const std::vector<std::vector<int>>& targets, const Camera& camera,
                            const WindowOptions& window, const JointOptions& options);

}  // namespace edvo
