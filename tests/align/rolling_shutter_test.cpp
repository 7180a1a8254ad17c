// SPDX-License-Identifier: MIT
// Images whose rows are read one after the other while the camera moves.
#include "edvo/align/align.hpp"
#include "edvo/align/readout_evidence.hpp"
#include "edvo/align/warp.hpp"
#include "edvo/window/refinement.hpp"
#include "support/matchers.hpp"
#include "support/plane_frame.hpp"

#include <gtest/gtest.h>

namespace edvo {
namespace {

using test::grid_pixels;
using test::kVgaCamera;
using test::motion;
using test::NearPose;
using test::rolling_plane_frame;

constexpr double kReadout = 0.03;  // [s]

Vector6d velocity(double x, double y, double z, double a, double b, double c) {
  return (Vector6d() << x, y, z, a, b, c).finished();
}

// Hand-held, and in another direction at the second frame.
const Vector6d kFirst = velocity(0.3, -0.2, 0.1, 0.2, 0.4, -0.1);
const Vector6d kSecond = velocity(-0.2, 0.3, -0.2, -0.3, -0.3, 0.3);
const SE3 kMoved = motion(0.05, -0.03, 0.02, 0.01, 0.02, -0.01);

Reference reference_of(const Frame& frame) {
  Reference reference = make_reference(frame, grid_pixels(frame, 9), {});
  reference.surface = make_surface(frame.depth, kVgaCamera, 14, 0.003);
  return reference;
}

// The same images, taken as those of a global shutter.
Frame all_at_once(Frame frame) {
  frame.shutter.readout_seconds = 0;
  return frame;
}

TEST(RollingShutter, APointMovesAsTheCameraDoesBetweenTwoRows) {
  const Vector6d readout = kReadout * kFirst;
  const RowMotion rows = row_motion(readout, 480);
  for (const int row : {0, 100, 240, 479}) {
    const Eigen::Vector3d seen(0.4, -0.3, 1.5);
    const Eigen::Vector3d expected = exp((row / 480.0 - 0.5) * readout) * seen;
    Eigen::Vector3f p = seen.cast<float>();
    move_to_middle_row(rows, static_cast<float>(row), p.x(), p.y(), p.z(), 1.F);
    EXPECT_LT((p.cast<double>() - expected).norm(), 1e-4) << row;
    // The same times an inverse depth.
    Eigen::Vector3f q = seen.cast<float>() / 1.5F;
    move_to_middle_row(rows, static_cast<float>(row), q.x(), q.y(), q.z(), 1 / 1.5F);
    EXPECT_LT((1.5F * q - p).norm(), 1e-6F) << row;
    move_from_middle_row(rows, static_cast<float>(row), p.x(), p.y(), p.z(), 1.F);
    EXPECT_LT((p.cast<double>() - seen).norm(), 1e-3) << row;  // but for the second order
  }
}

TEST(RollingShutter, AnAlignmentThatKnowsOfItFindsThePose) {
  const Frame key = rolling_plane_frame({}, kFirst, kReadout);
  const Frame current = rolling_plane_frame(kMoved, kSecond, kReadout);
  const AlignResult with = align(reference_of(key), current, {}, {});
  EXPECT_EQ(with.status, AlignStatus::kTracked);
  EXPECT_THAT(with.alignment.cur_from_ref, NearPose(inverse(kMoved), 4e-4));
  const AlignResult without = align(reference_of(all_at_once(key)), all_at_once(current), {}, {});
  EXPECT_THAT(without.alignment.cur_from_ref, testing::Not(NearPose(inverse(kMoved), 2e-3)));
}

TEST(RollingShutter, ItsReadoutTimeIsSeenInTheResiduals) {
  const Frame key = rolling_plane_frame({}, kFirst, kReadout);
  const Frame current = rolling_plane_frame(kMoved, kSecond, kReadout);
  AlignScratch scratch;
  for (const double taken_as : {0.0, 0.02, 0.04}) {
    Frame from = key, to = current;
    from.shutter.readout_seconds = to.shutter.readout_seconds = taken_as;
    const Reference reference = reference_of(from);
    const AlignResult result = align(reference, to, {}, {});
    const ReadoutEvidence evidence = readout_evidence(reference, to, result, {}, scratch);
    EXPECT_GT(evidence.information, 0);
    EXPECT_NEAR(evidence.seconds, kReadout, 0.004) << taken_as;
  }
}

TEST(RollingShutter, OfACameraAtRestTellsNothing) {
  const Frame still = rolling_plane_frame({}, Vector6d::Zero(), kReadout);
  const Reference reference = reference_of(still);
  AlignScratch scratch;
  const AlignResult result = align(reference, still, {}, {});
  EXPECT_EQ(readout_evidence(reference, still, result, {}, scratch).information, 0);
}

TEST(RollingShutter, AWindowThatKnowsOfItFindsThePoses) {
  const WindowOptions options{.iterations = 20, .tolerance = 1e-9};
  const auto refined = [&](bool knows) {
    std::vector<WindowKeyframe> window;
    for (const auto& [pose, moving] : {std::pair{SE3{}, kFirst}, {kMoved, kSecond}}) {
      Frame frame = rolling_plane_frame(pose, moving, kReadout);
      if (!knows) frame.shutter.readout_seconds = 0;
      window.push_back(make_window_keyframe(frame, pose, grid_pixels(frame, 41), options));
    }
    window[1].world_from_key = kMoved * motion(0.004, -0.003, 0.004, 0.001, 0.002, -0.002);
    std::vector<PairModel> memory;
    (void)refine_window(window, kVgaCamera, 1, options, memory);
    return window[1].world_from_key;
  };
  EXPECT_THAT(refined(true), NearPose(kMoved, 1e-3));
  EXPECT_THAT(refined(false), testing::Not(NearPose(kMoved, 2e-3)));
}

}  // namespace
}  // namespace edvo
