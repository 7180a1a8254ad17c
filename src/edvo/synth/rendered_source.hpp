// SPDX-License-Identifier: MIT
// A sequence that is rendered while it is read.
#pragma once

#include "edvo/source/rgbd_source.hpp"
#include "edvo/synth/sequence.hpp"

namespace edvo::synth {

// Frames are rendered where they are loaded: side by side rather than each by several threads.
class RenderedSource final : public RgbdSource {
 public:
  explicit RenderedSource(SyntheticSequence sequence);

  [[nodiscard]] const SourceInfo& info() const override { return info_; }
  [[nodiscard]] std::optional<PendingFrame> next() override;

 private:
  SyntheticSequence sequence_;
  SourceInfo info_;
  int next_ = 0;
};

}  // namespace edvo::synth
