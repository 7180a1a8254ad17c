// SPDX-License-Identifier: MIT
// Whether an alignment can be believed, and if not, why.
#pragma once

#include "edvo/align/align.hpp"
#include "edvo/features/pixel_selection.hpp"
#include "edvo/odometry/frame_result.hpp"
#include "edvo/odometry/tracking_state.hpp"

namespace edvo {

// kNone = believe it. state: before the frame.
[[nodiscard]] LossCause loss_cause(const AlignResult& result, const AlignOptions& options,
                                   const TrackingState& state, const Stamp& stamp);

// What an image itself lacks: kNoDepth, kNoTexture, kFewPoints, or kNone. Reads a grid of pixels.
[[nodiscard]] LossCause image_fault(const Frame& frame, const SelectOptions& options);

// Whether all depths in range, but for a few, are the same number: a frame without depth, stored as
// if it had some. Reads a grid of pixels.
[[nodiscard]] bool has_constant_depth(const Frame& frame, const SelectOptions& options);

// Local correlation of the images as a result brings them together [-1..1]; 1 where residuals are
// small enough not to need it.
[[nodiscard]] double local_fit(const AlignResult& result, const Reference& reference,
                               const Frame& frame, const AlignOptions& options,
                               AlignScratch& scratch);

// Whether a result of this local fit leaves room for a better one.
[[nodiscard]] bool fits_poorly(double fit);

// Whether the images have nothing in common as a result of this local fit brings them together. Of
// the first motion of a segment, for which no residuals are usual yet, more is asked.
[[nodiscard]] bool is_unlike(const AlignResult& result, double fit, const TrackingState& state);

}  // namespace edvo
