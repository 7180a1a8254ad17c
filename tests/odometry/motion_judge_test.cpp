// SPDX-License-Identifier: MIT
#include "edvo/odometry/motion_judge.hpp"
#include "edvo/align/reference.hpp"
#include "edvo/align/surface.hpp"
#include "support/plane_frame.hpp"

#include <gtest/gtest.h>

namespace edvo {
namespace {

using test::kVgaCamera;
using test::motion;
using test::plane_frame;

// A wall, from a keyframe and from nearer by.
class RefutedByDepth : public testing::Test {
 protected:
  bool is_refuted(const SE3& claimed, double correlation, const SE3& predicted) {
    AlignResult result;
    result.alignment.cur_from_ref = claimed;
    result.correlation = correlation;
    return is_refuted_by_depth(result, reference_, frame_, predicted, {}, scratch_);
  }

  static SE3 off(double z) { return motion(0, 0, z, 0, 0, 0) * kTrue; }

  inline static const SE3 kTrue = inverse(motion(0.05, 0, 0.3, 0, 0, 0));
  const SE3 expected_ = motion(0.4, 0, 0, 0, 0, 0);  // far off all that is claimed

 private:
  static Reference reference_of(const Frame& key) {
    Reference reference = make_reference(key, test::grid_pixels(key, 7), {});
    reference.surface = make_surface(key.depth, kVgaCamera, 14, 0.003);
    return reference;
  }

  Reference reference_ = reference_of(plane_frame({}));
  Frame frame_ = plane_frame(inverse(kTrue));
  AlignScratch scratch_;
};

TEST_F(RefutedByDepth, IsNeverTheTrueMotion) {
  for (const double correlation : {0.2, 0.9})
    EXPECT_FALSE(is_refuted(kTrue, correlation, expected_));
}

TEST_F(RefutedByDepth, IsAMotionThatPutsTheWallElsewhere) {
  EXPECT_TRUE(is_refuted(off(0.5), 0.9, expected_));
  EXPECT_TRUE(is_refuted(off(-0.5), 0.9, expected_));
}

TEST_F(RefutedByDepth, IsASmallerErrorOnlyIfTheImagesAreUnlike) {
  EXPECT_FALSE(is_refuted(off(0.1), 0.9, expected_));
  EXPECT_TRUE(is_refuted(off(0.1), 0.4, expected_));
}

TEST_F(RefutedByDepth, IsNoMotionAsPredicted) {
  EXPECT_FALSE(is_refuted(off(0.5), 0.4, off(0.5)));
}

}  // namespace
}  // namespace edvo
