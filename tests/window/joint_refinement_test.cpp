// SPDX-License-Identifier: MIT
#include "edvo/window/joint_refinement.hpp"

#include "edvo/window/keyframe_window.hpp"
#include "support/matchers.hpp"
#include "support/plane_frame.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

namespace edvo {
namespace {

using test::grid_pixels;
using test::kVgaCamera;
using test::motion;
using test::NearPose;
using test::plane_frame;

// To one side and back, each place seen twice.
std::vector<SE3> to_and_fro() {
  std::vector<SE3> poses;
  for (const int k : {0, 1, 2, 3, 4, 4, 3, 2, 1, 0})
    poses.push_back(motion(0.06 * k, 0.01 * k, 0, 0, 0.01 * k, 0));
  return poses;
}

std::vector<WindowKeyframe> keyframes_at(const std::vector<SE3>& poses,
                                         const WindowOptions& options) {
  std::vector<WindowKeyframe> keyframes;
  for (const SE3& pose : poses) {
    const Frame frame = plane_frame(pose);
    keyframes.push_back(make_window_keyframe(frame, pose, grid_pixels(frame, 41), options));
    keyframes.back().id = static_cast<std::int64_t>(keyframes.size()) - 1;
  }
  return keyframes;
}

// Each keyframe a little farther off than the one before.
std::vector<WindowKeyframe> drifted(const std::vector<SE3>& poses, const WindowOptions& options) {
  std::vector<WindowKeyframe> keyframes = keyframes_at(poses, options);
  SE3 drift;
  for (WindowKeyframe& key : keyframes) {
    key.world_from_key = key.world_from_key * drift;
    drift = drift * motion(0.0006, -0.0004, 0.0005, 0.0002, 0.0003, -0.0002);
  }
  return keyframes;
}

TEST(JointRefinement, TakesDriftOutOfAPathThatComesBack) {
  const WindowOptions window;
  const std::vector<SE3> poses = to_and_fro();
  std::vector<WindowKeyframe> keyframes = drifted(poses, window);
  const auto targets = keyframes_in_view(keyframes, kVgaCamera, 12);
  const JointSummary done =
      refine_jointly(keyframes, targets, kVgaCamera, window, {.iterations = 20, .tolerance = 1e-6});
  EXPECT_LT(done.cost, done.first_cost);
  ASSERT_THAT(drifted(poses, window).back().world_from_key,
              testing::Not(NearPose(poses.back(), 4e-3)));
  for (std::size_t k = 0; k < poses.size(); ++k)
    EXPECT_THAT(keyframes[k].world_from_key, NearPose(poses[k], 1.5e-3)) << k;
}

TEST(JointRefinement, HoldsTheFirstKeyframe) {
  const WindowOptions window;
  std::vector<WindowKeyframe> keyframes = drifted(to_and_fro(), window);
  const SE3 first = keyframes.front().world_from_key;
  refine_jointly(keyframes, keyframes_in_view(keyframes, kVgaCamera, 12), kVgaCamera, window, {});
  EXPECT_EQ(keyframes.front().world_from_key.translation, first.translation);
  EXPECT_EQ(keyframes.front().world_from_key.rotation.coeffs(), first.rotation.coeffs());
}

TEST(JointRefinement, SameBitsWithAnyNumberOfThreads) {
  const WindowOptions window;
  const auto refined = [&](int threads) {
    std::vector<WindowKeyframe> keyframes = drifted(to_and_fro(), window);
    refine_jointly(keyframes, keyframes_in_view(keyframes, kVgaCamera, 12), kVgaCamera, window,
                   {.threads = threads});
    return keyframes;
  };
  const auto one = refined(1), three = refined(3);
  for (std::size_t k = 0; k < one.size(); ++k) {
    EXPECT_EQ(one[k].world_from_key.translation, three[k].world_from_key.translation);
    EXPECT_EQ(one[k].world_from_key.rotation.coeffs(), three[k].world_from_key.rotation.coeffs());
  }
}

TEST(JointRefinement, LeavesASingleKeyframeAlone) {
  std::vector<WindowKeyframe> keyframes = keyframes_at({SE3{}}, {});
  EXPECT_EQ(refine_jointly(keyframes, {{}}, kVgaCamera, {}, {}).iterations, 0);
  EXPECT_THAT(keyframes.front().world_from_key, NearPose(SE3{}, 1e-12));
}

TEST(KeyframesInView, FindsTheViewsOfAnEarlierVisitButNotThoseOfElsewhere) {
  std::vector<SE3> poses;
  for (int k = 0; k < 12; ++k) poses.push_back(motion(0.5 * std::min(k, 11 - k), 0, 0, 0, 0, 0));
  const auto keyframes = keyframes_at(poses, {});
  const auto neighbours = keyframes_in_view(keyframes, kVgaCamera, 10);
  EXPECT_THAT(neighbours[11], testing::Contains(0));                // the same place
  EXPECT_THAT(neighbours[11], testing::IsSupersetOf({8, 9, 10}));   // just before
  EXPECT_THAT(neighbours[11], testing::Not(testing::Contains(5)));  // 2.5 m away
  for (const auto& all : neighbours) EXPECT_LE(all.size(), 10U);
}

TEST(KeyframeWindow, DropsKeyframesWhereManyAreAndKeepsTheEarliest) {
  const WindowOptions options{.keyframes = 2, .candidate_keyframes = 3, .points = 50};
  KeyframeWindow window;
  // Two at nearly the same place among others.
  const double places[] = {0, 0.1, 0.2, 0.21, 0.3, 0.4, 0.5};
  std::int64_t id = 0;
  for (const double x : places) {
    const SE3 pose = motion(x, 0, 0, 0, 0, 0);
    const Frame frame = plane_frame(pose);
    window.add(id++, frame, pose, {}, grid_pixels(frame, 60), options);
  }
  std::set<std::int64_t> kept;
  for (const WindowKeyframe& key : window.keyframes()) kept.insert(key.id);
  EXPECT_EQ(kept.size(), 5U);
  EXPECT_TRUE(kept.contains(0));
  EXPECT_TRUE(kept.contains(5) && kept.contains(6));
  EXPECT_FALSE(kept.contains(2) && kept.contains(3));
}

}  // namespace
}  // namespace edvo
