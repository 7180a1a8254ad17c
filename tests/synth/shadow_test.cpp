// SPDX-License-Identifier: MIT
#include "edvo/synth/shadow.hpp"

#include "edvo/synth/sequence.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>

namespace edvo::synth {
namespace {

const Eigen::Vector3f kLamp{0, 0, 2};

// A solid of half a metre across, a metre below the lamp.
std::vector<Caster> one_below_the_lamp(Shape shape) {
  Scene scene;
  scene.solids = {{.shape = shape,
                   .world_from_solid = {.translation = {0, 0, 1}},
                   .half = Eigen::Vector3f::Constant(0.25F)}};
  return casters_of(scene, 0);
}

constexpr int kOtherSolid = 7;

TEST(Shadow, EndsWhereTheLineToTheLampClearsTheSolid) {
  for (const Shape shape : {Shape::kBox, Shape::kSphere, Shape::kCylinder}) {
    const std::vector<Caster> casters = one_below_the_lamp(shape);
    // On the floor, two metres below: as far as a ball's tangent, as the others' top edge.
    const float slope = shape == Shape::kSphere ? 0.25F / std::sqrt(1 - 0.25F * 0.25F) : 1 / 3.0F;
    const float reach = 2 * slope;
    const float penumbra = 3 * kLampRadius;
    EXPECT_EQ(lamp_share(casters, kOtherSolid, {reach - penumbra, 0, 0}, kLamp), 0);
    EXPECT_EQ(lamp_share(casters, kOtherSolid, {reach + penumbra, 0, 0}, kLamp), 1);
    EXPECT_EQ(lamp_share(casters, kOtherSolid, {0, 0, 1.9F}, kLamp), 1) << "above the solid";
  }
}

TEST(Shadow, AConvexSolidIsNoObstacleToItself) {
  EXPECT_EQ(lamp_share(one_below_the_lamp(Shape::kBox), 0, {0.1F, 0, 0.75F}, kLamp), 1);
}

TEST(Shadow, ARoomCastsNone) {
  Scene scene;
  scene.solids = {{.shape = Shape::kRoom, .half = {3, 3, 2}}};
  EXPECT_TRUE(casters_of(scene, 0).empty());
}

RgbdImage frame_of(SequenceOptions options, int index) {
  options.sensor.kind = SensorKind::kClean;
  options.path = PathName::kStill;
  const Camera small{
      .fx = 131.25, .fy = 131.25, .cx = 79.5, .cy = 59.5, .width = 160, .height = 120};
  return make_frame(make_sequence(options, {.pinhole = small}), index);
}

double difference(const RgbdImage& a, const RgbdImage& b) {
  return cv::norm(a.bgr, b.bgr, cv::NORM_L1) / static_cast<double>(a.bgr.total());
}

TEST(Shadow, DarkensAndMovesOnlyWithASwingingLamp) {
  SequenceOptions plain, shadows, swinging;
  shadows.shadows = swinging.shadows = true;
  swinging.lamp_swing = 0.3;
  EXPECT_GT(cv::sum(frame_of(plain, 0).bgr)[0], 1.01 * cv::sum(frame_of(shadows, 0).bgr)[0]);
  EXPECT_EQ(difference(frame_of(shadows, 0), frame_of(shadows, 15)), 0);
  EXPECT_GT(difference(frame_of(swinging, 0), frame_of(swinging, 15)), 1);
}

TEST(SyntheticSequence, WithoutTextureAFaceIsPlain) {
  const auto edges = [](double texture) {
    SequenceOptions options;
    options.texture = texture;
    options.scene = SceneName::kBoxes;
    const cv::Mat_<cv::Vec3b> bgr = frame_of(options, 0).bgr;
    int count = 0;
    for (int y = 0; y < bgr.rows; ++y)
      for (int x = 1; x < bgr.cols; ++x) count += std::abs(bgr(y, x)[1] - bgr(y, x - 1)[1]) > 4;
    return count;
  };
  EXPECT_LT(edges(0), 0.3 * edges(1));
}

}  // namespace
}  // namespace edvo::synth
