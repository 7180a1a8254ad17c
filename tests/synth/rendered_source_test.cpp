// SPDX-License-Identifier: MIT
#include "edvo/synth/rendered_source.hpp"

#include "support/same_bits.hpp"

#include <gtest/gtest.h>

namespace edvo::synth {
namespace {

SyntheticSequence small_sequence() {
  const Camera pinhole{.fx = 40, .fy = 40, .cx = 23.5, .cy = 17.5, .width = 48, .height = 36};
  return make_sequence({.frames = 4}, {.pinhole = pinhole, .distortion = {}});
}

TEST(RenderedSource, GivesTheSequencesFramesWithTheirStamps) {
  const SyntheticSequence sequence = small_sequence();
  RenderedSource source(sequence);
  EXPECT_EQ(source.info().frames, 4);
  for (int i = 0; i < 4; ++i) {
    const auto frame = source.next();
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->index, i);
    EXPECT_EQ(frame->stamp, pose_of(sequence, i).stamp);
    const RgbdImage image = frame->load(), expected = make_frame(sequence, i);
    EXPECT_TRUE(test::same_bits(image.bgr, expected.bgr));
    EXPECT_TRUE(test::same_bits(image.depth, expected.depth));
  }
  EXPECT_FALSE(source.next());
}

TEST(RenderedSource, BringsItsGroundTruthAndSeed) {
  SyntheticSequence sequence = small_sequence();
  sequence.options.seed = 7;
  const RenderedSource source(sequence);
  ASSERT_TRUE(source.info().ground_truth);
  EXPECT_EQ(source.info().ground_truth->trajectory.size(), ground_truth(sequence).size());
  EXPECT_EQ(source.info().seed, 7U);
  EXPECT_EQ(source.info().depth_scale, 0);
}

}  // namespace
}  // namespace edvo::synth
