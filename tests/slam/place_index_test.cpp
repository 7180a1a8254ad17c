// SPDX-License-Identifier: MIT
#include "edvo/slam/place_index.hpp"

#include "support/rendered_sequence.hpp"

#include <gtest/gtest.h>
#include <limits>
#include <opencv2/imgproc.hpp>

namespace edvo {
namespace {

struct GrayDepth {
  cv::Mat_<std::uint8_t> gray;
  cv::Mat_<float> depth;
};

GrayDepth render(synth::SceneName scene, int seed, int index) {
  const RgbdImage image = synth::make_frame(
      test::make_sequence({.scene = scene, .seed = seed, .frames = 40}, test::kQvgaCamera), index);
  GrayDepth result;
  cv::cvtColor(image.bgr, result.gray, cv::COLOR_BGR2GRAY);
  result.depth = image.depth;
  return result;
}

FernCode code_of(const GrayDepth& image) {
  return make_fern_code(image.gray, image.depth);
}

TEST(FernCode, IsTheSameForBrighterImages) {
  const GrayDepth image = render(synth::SceneName::kOffice, 1, 0);
  cv::Mat_<std::uint8_t> dimmed;
  image.gray.convertTo(dimmed, CV_8U, 0.7, 10);
  EXPECT_GT(similarity(code_of(image), make_fern_code(dimmed, image.depth)), 0.9);
}

TEST(FernCode, TellsTheNextFrameFromAnotherRoom) {
  const FernCode first = code_of(render(synth::SceneName::kOffice, 1, 0));
  const FernCode next = code_of(render(synth::SceneName::kOffice, 1, 3));
  const FernCode other = code_of(render(synth::SceneName::kLivingRoom, 1, 0));
  EXPECT_GT(similarity(first, next), similarity(first, other) + 0.1);
}

TEST(FernCode, ImagesWithoutDepthHaveOneToo) {
  const GrayDepth image = render(synth::SceneName::kOffice, 1, 0);
  const cv::Mat_<float> none(image.depth.size(), std::numeric_limits<float>::quiet_NaN());
  EXPECT_GT(similarity(code_of(image), make_fern_code(image.gray, none)), 0.3);
}

FernCode numbered(int i) {
  FernCode code{};
  for (std::size_t k = 0; k < code.size(); ++k)
    code[k] = static_cast<std::uint8_t>((static_cast<int>(k) + 1) * i % 251);
  return code;
}

TEST(PlaceIndex, FindsTheSameInAnyOrderOfAdding) {
  PlaceIndex forward, backward;
  for (int i = 0; i < 100; ++i) forward.add(i, numbered(i));
  for (int i = 99; i >= 0; --i) backward.add(i, numbered(i));
  const std::vector<PlaceMatch> a = forward.search(numbered(42), 90, 5);
  const std::vector<PlaceMatch> b = backward.search(numbered(42), 90, 5);
  ASSERT_EQ(a.size(), 5U);
  ASSERT_EQ(b.size(), 5U);
  EXPECT_EQ(a.front().id, 42);
  EXPECT_EQ(a.front().similarity, 1.0);
  for (std::size_t i = 0; i < 5; ++i) EXPECT_EQ(a[i].id, b[i].id);
}

TEST(PlaceIndex, LeavesOutNewerPlaces) {
  PlaceIndex places;
  for (int i = 0; i < 10; ++i) places.add(i, numbered(i));
  for (const PlaceMatch& match : places.search(numbered(7), 7, 10)) EXPECT_LT(match.id, 7);
}

}  // namespace
}  // namespace edvo
