// SPDX-License-Identifier: MIT
#include "edvo/synth/rendered_source.hpp"

#include <fmt/core.h>

#include <utility>

namespace edvo::synth {

RenderedSource::RenderedSource(SyntheticSequence sequence) : sequence_(std::move(sequence)) {
  sequence_.threads = 1;
  const SequenceOptions& made = sequence_.options;
  info_ = {.name = "demo",
           .origin = fmt::format("rendered: scene {}, path {}", name_of(made.scene),
                                 sequence_.path.recorded.empty() ? name_of(made.path) : "recorded"),
           .camera = sequence_.camera,
           .camera_origin = "the one that the images are rendered with",
           .depth_scale = 0,
           .depth_origin = "rendered in metres",
           .frames = frame_count(sequence_),
           .seed = static_cast<std::uint64_t>(made.seed),
           .ground_truth = GroundTruth{"the rendered path", ground_truth(sequence_)},
           .notes = {fmt::format("noise of a Kinect-like sensor, seed {}", made.seed)}};
}

std::optional<PendingFrame> RenderedSource::next() {
  if (next_ >= frame_count(sequence_)) return std::nullopt;
  const int i = next_++;
  return PendingFrame{.index = i, .stamp = pose_of(sequence_, i).stamp, .load = [this, i] {
                        return make_frame(sequence_, i);
                      }};
}

}  // namespace edvo::synth
