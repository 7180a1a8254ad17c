// SPDX-License-Identifier: MIT
#include "edvo/synth/texture.hpp"

#include "edvo/synth/random.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace edvo::synth {
namespace {

TEST(Random, NormalHasMeanZeroAndVarianceOne) {
  Random random{1, 2, 3};
  constexpr int kCount = 200000;
  double sum = 0, squares = 0;
  for (int i = 0; i < kCount; ++i) {
    const double value = random.normal();
    sum += value;
    squares += value * value;
  }
  EXPECT_NEAR(sum / kCount, 0, 0.01);
  EXPECT_NEAR(squares / kCount, 1, 0.01);
}

TEST(Random, StreamsOfOtherKeysDiffer) {
  EXPECT_EQ(Random({1, 2}).word(), Random({1, 2}).word());
  EXPECT_NE(Random({1, 2}).word(), Random({2, 1}).word());
  EXPECT_NE(Random({1, 2}).word(), Random({1, 3}).word());
}

TEST(Texture, EveryLevelHasTheSameMean) {
  for (const Pattern pattern : {Pattern::kPlaster, Pattern::kPoster, Pattern::kWood}) {
    const Texture texture = make_texture(pattern, 7);
    const float mean = texture.levels.back().values.front();
    for (const Texture::Level& level : texture.levels) {
      double sum = 0;
      for (const float value : level.values) sum += value;
      EXPECT_NEAR(sum / static_cast<double>(level.values.size()), mean, 1e-4);
    }
  }
}

TEST(Texture, CoarserLevelsDoNotShiftThePattern) {
  const Texture texture = make_texture(Pattern::kStripes, 1);
  constexpr float kEdge = 26.0F / 512;  // where the first stripe ends, on whole texels [tiles]
  for (const float lod : {0.0F, 1.0F, 2.0F, 2.5F, 3.0F})
    EXPECT_NEAR(sample(texture, kEdge, 0.3F, lod), 0.5, 0.08) << lod;
}

TEST(Texture, RepeatsWithoutASeam) {
  for (const Pattern pattern : {Pattern::kPlaster, Pattern::kSpeckle, Pattern::kFabric})
    for (const float v : {0.1F, 0.6F}) {
      const Texture texture = make_texture(pattern, 3);
      EXPECT_NEAR(sample(texture, 0.25F, v, 1), sample(texture, 1.25F, v - 2, 1), 1e-3);
      const float across = std::abs(sample(texture, -0.002F, v, 0) - sample(texture, 0.002F, v, 0));
      EXPECT_LT(across, 0.15);
    }
}

}  // namespace
}  // namespace edvo::synth
