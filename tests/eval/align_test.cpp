// SPDX-License-Identifier: MIT
#include "edvo/eval/align.hpp"

#include "support/error_matcher.hpp"
#include "support/matchers.hpp"
#include "support/paths.hpp"

#include <gtest/gtest.h>

namespace edvo {
namespace {

using test::NearPose;

constexpr double kExact = 1e-12;

Eigen::Matrix3Xd points_of(const Trajectory& path) {
  Eigen::Matrix3Xd points(3, path.size());
  for (std::size_t i = 0; i < path.size(); ++i)
    points.col(i) = path[i].world_from_camera.translation;
  return points;
}

Eigen::Matrix3Xd moved(const Similarity& similarity, Eigen::Matrix3Xd points) {
  for (Eigen::Index i = 0; i < points.cols(); ++i)
    points.col(i) = similarity * Eigen::Vector3d(points.col(i));
  return points;
}

Similarity some_motion(double scale) {
  Vector6d xi;
  xi << 3, -1, 2, 1.5, -2, 0.4;
  return {.scale = scale, .motion = exp(xi)};
}

double determinant(const Similarity& similarity) {
  return similarity.motion.rotation.toRotationMatrix().determinant();
}

TEST(Align, FindsTheMotion) {
  const Eigen::Matrix3Xd source = points_of(test::winding_path(40));
  const Similarity truth = some_motion(1);
  const Similarity found = align(moved(truth, source), source, AlignmentKind::kSe3);
  EXPECT_THAT(found.motion, NearPose(truth.motion, kExact));
  EXPECT_EQ(found.scale, 1);
}

TEST(Align, FindsTheScaleOnlyIfAskedTo) {
  const Eigen::Matrix3Xd source = points_of(test::winding_path(40));
  const Similarity truth = some_motion(2.5);
  const Similarity found = align(moved(truth, source), source, AlignmentKind::kSim3);
  EXPECT_NEAR(found.scale, 2.5, kExact);
  EXPECT_THAT(found.motion, NearPose(truth.motion, 1e-11));
  EXPECT_EQ(align(moved(truth, source), source, AlignmentKind::kSe3).scale, 1);
}

TEST(Align, DoesNothingIfAskedTo) {
  const Eigen::Matrix3Xd source = points_of(test::winding_path(2));
  const Similarity none = align(moved(some_motion(2), source), source, AlignmentKind::kNone);
  EXPECT_EQ(none.scale, 1);
  EXPECT_THAT(none.motion, NearPose(SE3{}, kExact));
}

TEST(Align, NeverMirrors) {
  const Eigen::Matrix3Xd source = points_of(test::winding_path(40));
  Eigen::Matrix3Xd mirrored = source;
  mirrored.row(2) *= -1;
  const Similarity found = align(mirrored, source, AlignmentKind::kSim3);
  EXPECT_NEAR(determinant(found), 1, kExact);
  EXPECT_GT(found.scale, 0);
}

TEST(Align, StaysARotationWherePointsLeaveItOpen) {
  const Eigen::Matrix3Xd line = points_of(test::straight_path(20));
  Eigen::Matrix3Xd plane = points_of(test::winding_path(20));
  plane.row(2).setZero();
  const Eigen::Matrix3Xd place = Eigen::Vector3d(0.1, 0.2, 0.3).replicate(1, 20);
  for (const Eigen::Matrix3Xd& source : {line, plane, place})
    for (const AlignmentKind alignment : {AlignmentKind::kSe3, AlignmentKind::kSim3}) {
      const Similarity truth = some_motion(alignment == AlignmentKind::kSim3 ? 3 : 1);
      const Similarity found = align(moved(truth, source), source, alignment);
      ASSERT_TRUE(is_finite(found.motion));
      EXPECT_NEAR(determinant(found), 1, kExact);
      EXPECT_LT((moved(found, source) - moved(truth, source)).norm(), 1e-10);
    }
}

TEST(Align, KeepsTheScaleOfAStandstill) {
  Eigen::Matrix3Xd place = Eigen::Vector3d(0.1, 0.2, 0.3).replicate(1, 20);
  place(0, 3) += 1e-16;
  const Eigen::Matrix3Xd target = points_of(test::winding_path(20));
  EXPECT_EQ(align(target, place, AlignmentKind::kSim3).scale, 1);
}

TEST(Align, NeedsThreePoints) {
  const Eigen::Matrix3Xd two = points_of(test::winding_path(2));
  EXPECT_TRUE(test::fails_with(ErrorCode::kEvaluation, {"at least 3", "got 2"},
                               [&] { (void)align(two, two, AlignmentKind::kSe3); }));
}

TEST(Align, TransformsPosesAsItDoesPoints) {
  const Similarity similarity = some_motion(2);
  const Trajectory path = test::winding_path(5);
  const Trajectory result = transformed(similarity, path);
  for (std::size_t i = 0; i < path.size(); ++i) {
    const Eigen::Vector3d expected = similarity * path[i].world_from_camera.translation;
    EXPECT_LT((result[i].world_from_camera.translation - expected).norm(), kExact);
    EXPECT_EQ(result[i].stamp, path[i].stamp);
  }
}

}  // namespace
}  // namespace edvo
