// SPDX-License-Identifier: MIT
#include "edvo/odometry/witness.hpp"
#include "support/plane_frame.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace edvo {
namespace {

using test::kVgaCamera;
using test::motion;
using test::plane_frame;

const SE3 kMoved = motion(0.03, 0.01, 0, 0, 0.01, 0);  // of the camera, since the witness

// A board with a pattern of its own, 1.2 m away, hides the left `share` of what a camera sees.
Frame behind_board(const SE3& world_from_camera, double share, double board_x) {
  RgbdImage image = test::render_plane(test::kPlane, kVgaCamera, world_from_camera);
  const RgbdImage board =
      test::render_plane({.distance = 1.2}, kVgaCamera, motion(board_x, 0.4, 0, 0, 0, 0));
  const int columns = static_cast<int>(share * image.depth.cols);
  cv::Mat colour = image.bgr.colRange(0, columns), depth = image.depth.colRange(0, columns);
  board.bgr.colRange(0, columns).copyTo(colour);
  board.depth.colRange(0, columns).copyTo(depth);
  return make_frame(image, make_undistortion({kVgaCamera, {}}));
}

Reference reference_of(const Frame& key) {
  Reference reference = make_reference(key, test::grid_pixels(key, 7), {});
  reference.surface = make_surface(key.depth, kVgaCamera, 14, 0.003);
  return reference;
}

// A witness that saw the wall alone, a present keyframe at the same place, and a frame.
struct Scene {
  Witness witness{.reference = reference_of(plane_frame({}))};
  Reference present = witness.reference;
  TrackingState state{.stamp = Stamp{}, .usual_sigma = 3};
  SE3 predicted = inverse(kMoved);
  AlignOptions options;
  AlignScratch scratch;

  Testimony ask(const Frame& frame, const SE3& claimed) {
    AlignResult result;
    result.alignment.cur_from_ref = claimed;
    result.sigma = 3;
    const MotionCandidates none;
    return question(witness, result, 0.9,
                    {.reference = present,
                     .frame = frame,
                     .candidates = none,
                     .predicted = predicted,
                     .state = state},
                    options, scratch);
  }
};

TEST(Witness, SaysNothingAgainstTheTrueMotion) {
  Scene scene;
  for (const double share : {0.0, 0.4}) {
    const Testimony said = scene.ask(behind_board(kMoved, share, 0), inverse(kMoved));
    EXPECT_FALSE(said.contradicts) << share;
    EXPECT_FALSE(said.correction) << share;
    EXPECT_NEAR(said.in_front, share, 0.04) << share;
  }
}

TEST(Witness, CorrectsAMotionThatABoardPulledAside) {
  Scene scene;
  const SE3 pulled = motion(0.1, 0, 0, 0, 0, 0) * inverse(kMoved);
  const Testimony said = scene.ask(behind_board(kMoved, 0.4, 0), pulled);
  ASSERT_TRUE(said.correction);
  const SE3 error = said.correction->alignment.cur_from_ref * kMoved;
  EXPECT_LT(error.translation.norm(), 0.01);
  EXPECT_LT(rotation_angle(error), 0.004);
  EXPECT_FALSE(said.contradicts);
}

// The same frame, seen from a keyframe elsewhere that is brighter than the witness.
// On a wall whose pattern repeats another place explains the witness's image as well.
TEST(Witness, CorrectsNoMotionByAJumpUnlessSomethingIsInFront) {
  Scene scene;
  const SE3 pulled = motion(0.15, 0, 0, 0, 0, 0) * inverse(kMoved);
  const Frame frame = behind_board(kMoved, 0.1, 0), hidden = behind_board(kMoved, 0.4, 0);
  EXPECT_TRUE(scene.ask(frame, pulled).correction);  // to the expected motion
  scene.predicted = pulled;
  EXPECT_FALSE(scene.ask(frame, pulled).correction);
  EXPECT_TRUE(scene.ask(hidden, pulled).correction);
}

TEST(Witness, CorrectsRelativeToThePresentKeyframe) {
  const Frame frame = behind_board(kMoved, 0.4, 0);
  const SE3 pulled = motion(0.1, 0, 0, 0, 0, 0) * inverse(kMoved);
  Scene here, elsewhere;
  const Testimony found = here.ask(frame, pulled);
  const SE3 present_from_witness = motion(-0.02, 0.01, 0.03, 0.01, 0, 0.02);
  elsewhere.witness.alignment = {.cur_from_ref = present_from_witness, .gain = 1.1, .bias = -3};
  const SE3 present_from_there = inverse(present_from_witness);
  elsewhere.predicted = inverse(kMoved) * present_from_there;
  const Testimony said = elsewhere.ask(frame, pulled * present_from_there);
  ASSERT_TRUE(found.correction && said.correction);
  const Alignment& a = found.correction->alignment;
  const Alignment& b = said.correction->alignment;
  const SE3 error = inverse(a.cur_from_ref) * (b.cur_from_ref * present_from_witness);
  EXPECT_LT(error.translation.norm(), 0.001);
  EXPECT_LT(rotation_angle(error), 0.001);
  EXPECT_NEAR(b.gain * 1.1, a.gain, 0.01);
  EXPECT_NEAR(b.bias + b.gain * -3, a.bias, 1);
}

// After a large motion a wrong one may explain a few cells more, with residuals far above the
// usual.
TEST(Witness, CorrectsByNoMotionThatFitsFarWorseThanUsual) {
  Frame frame = behind_board(kMoved, 0.4, 0);
  cv::Mat noise(frame.levels.front().gray.size(), CV_16S);
  cv::RNG random(3);
  random.fill(noise, cv::RNG::NORMAL, 0, 30);
  for (Level& level : frame.levels) {
    level.gray = level.gray.clone();
    const cv::Mat here = noise(cv::Rect(0, 0, level.gray.cols, level.gray.rows));
    cv::add(level.gray, here, level.gray, cv::noArray(), CV_8U);
  }
  const SE3 pulled = motion(0.1, 0, 0, 0, 0, 0) * inverse(kMoved);
  Scene scene;
  scene.state.usual_sigma = 30;
  EXPECT_TRUE(scene.ask(frame, pulled).correction);
  scene.state.usual_sigma = 3;
  EXPECT_FALSE(scene.ask(frame, pulled).correction);
}

TEST(Witness, ContradictsWhoFollowsABoardThatHidesTheRest) {
  Scene scene;
  const Testimony said =
      scene.ask(behind_board(kMoved, 0.9, 0.2), motion(0.25, 0, 0, 0, 0, 0) * inverse(kMoved));
  EXPECT_TRUE(said.contradicts);
  EXPECT_FALSE(said.correction);
}

TEST(Witness, IsNotAskedAboutAViewThatItHardlySees) {
  Scene scene;
  const Testimony said = scene.ask(behind_board(kMoved, 0.9, 0.2), motion(2.5, 0, 0, 0, 0, 0));
  EXPECT_FALSE(said.contradicts);
  EXPECT_FALSE(said.correction);
}

TEST(Witness, SeesThatItsViewIsHidden) {
  Scene scene;
  const auto hidden = [&](const Frame& frame) {
    return is_hidden(scene.present, frame, inverse(kMoved), scene.options, scene.scratch);
  };
  EXPECT_TRUE(hidden(behind_board(kMoved, 0.6, 0)));
  EXPECT_FALSE(hidden(behind_board(kMoved, 0.2, 0)));
  EXPECT_FALSE(hidden(plane_frame(kMoved)));
  // Elsewhere, half of it is nearer and half of it is farther.
  RgbdImage elsewhere = test::render_plane(test::kPlane, kVgaCamera, kMoved);
  elsewhere.depth.colRange(0, elsewhere.depth.cols / 2) *= 0.6F;
  elsewhere.depth.colRange(elsewhere.depth.cols / 2, elsewhere.depth.cols) *= 1.5F;
  EXPECT_FALSE(hidden(make_frame(elsewhere, make_undistortion({kVgaCamera, {}}))));
}

// Keyframes at 0, 3 and 6 cm, with the present one's points and the state of the next.
TEST(Witness, StaysWhileSomethingElseMovesAndIsReplacedAfterwards) {
  const AlignOptions options;
  AlignScratch scratch;
  std::optional<Witness> witness;
  const auto next_keyframe = [&](double present, double next, int doubtful) {
    const SE3 at_present = motion(present, 0, 0, 0, 0, 0), at_next = motion(next, 0, 0, 0, 0, 0);
    TrackingState state{.usual_sigma = 3, .doubtful_frames = doubtful};
    state.alignment.cur_from_ref = inverse(at_next) * at_present;
    hand_over(witness, reference_of(plane_frame(at_present)), plane_frame(at_next), state, options,
              scratch);
  };
  next_keyframe(0, 0.3, 0);
  ASSERT_TRUE(witness);
  EXPECT_GT(witness->explained, 0.95);
  EXPECT_NEAR(witness->alignment.cur_from_ref.translation.x(), -0.3, 1e-9);
  next_keyframe(0.3, 0.6, 5);  // in doubt: the witness stays
  EXPECT_NEAR(witness->alignment.cur_from_ref.translation.x(), -0.6, 1e-9);
  next_keyframe(0.6, 0.9, 0);
  EXPECT_NEAR(witness->alignment.cur_from_ref.translation.x(), -0.3, 1e-9);
}

}  // namespace
}  // namespace edvo
