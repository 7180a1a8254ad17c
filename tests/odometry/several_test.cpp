// SPDX-License-Identifier: MIT
// Several odometries at once, each in a thread of its own: they share nothing.
#include "edvo/network/edge_network.hpp"
#include "edvo/odometry/odometry.hpp"
#include "support/rendered_sequence.hpp"
#include "support/tiny_network.hpp"

#include <gtest/gtest.h>

#include <thread>

namespace edvo {
namespace {

std::vector<RgbdImage> frames_of(int seed) {
  const synth::SyntheticSequence sequence =
      test::make_sequence({.seed = seed, .frames = 12}, test::kQvgaCamera);
  std::vector<RgbdImage> frames;
  for (int i = 0; i < 12; ++i) frames.push_back(synth::make_frame(sequence, i));
  return frames;
}

Odometry with_canny() {
  return {{test::kQvgaCamera, {}}, preset(Method::kCannyCorner)};
}

Odometry with_network() {
  Config config = preset(Method::kCnnCorner);
  config.network.model = test::kTinyModel.string();
  return {{test::kQvgaCamera, {}},
          config,
          make_strength_detector(open_network(config.network, {320, 240}), config.network)};
}

Trajectory track(Odometry odometry, const std::vector<RgbdImage>& frames) {
  for (const RgbdImage& frame : frames) (void)odometry.process(frame);
  odometry.finish();
  return odometry.trajectory();
}

bool are_same(const Trajectory& a, const Trajectory& b) {
  return std::ranges::equal(a, b, [](const StampedPose& x, const StampedPose& y) {
    return x.stamp == y.stamp &&
           x.world_from_camera.translation == y.world_from_camera.translation &&
           x.world_from_camera.rotation.coeffs() == y.world_from_camera.rotation.coeffs();
  });
}

class SeveralOdometries : public ::testing::TestWithParam<Odometry (*)()> {};

TEST_P(SeveralOdometries, GiveTheBitsThatEachGivesAlone) {
  constexpr int kThreads = 4;
  std::vector<std::vector<RgbdImage>> frames;
  std::vector<Trajectory> alone, together(kThreads);
  for (int i = 0; i < kThreads; ++i) {
    frames.push_back(frames_of(i));
    alone.push_back(track(GetParam()(), frames.back()));
  }
  {
    std::vector<std::jthread> threads;
    for (std::size_t i = 0; i < kThreads; ++i)
      threads.emplace_back([&, i] { together[i] = track(GetParam()(), frames[i]); });
  }
  for (std::size_t i = 0; i < kThreads; ++i) {
    EXPECT_EQ(alone[i].size(), 12U);
    EXPECT_TRUE(are_same(alone[i], together[i])) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Detector, SeveralOdometries, ::testing::Values(with_canny, with_network),
                         [](const auto& detector) {
                           return detector.index == 0 ? "Canny" : "Network";
                         });

}  // namespace
}  // namespace edvo
