// SPDX-License-Identifier: MIT
// The odometry with a network for edges.
#include "edvo/io/camera_choice.hpp"
#include "edvo/io/dataset.hpp"
#include "edvo/network/edge_network.hpp"
#include "edvo/odometry/odometry.hpp"
#include "support/error_matcher.hpp"
#include "support/shared_data.hpp"
#include "support/synthetic_plane.hpp"
#include "support/tiny_network.hpp"

#include <gtest/gtest.h>

namespace edvo {
namespace {

Config with_network() {
  Config config = preset(Method::kCnnCorner);
  config.network.model = test::kTinyModel.string();
  return config;
}

TEST(NetworkOdometry, HasTheNetworkHandedIn) {
  EXPECT_TRUE(test::fails_with(ErrorCode::kConfig, {"edge.detector", "handed in"}, [] {
    (void)Odometry({.pinhole = test::kSmallCamera}, preset(Method::kCnnCorner));
  }));
}

TEST(NetworkOdometry, TracksARealSequence) {
  const auto folder = test::shared_data() / "tum" / "rgbd_dataset_freiburg1_xyz";
  EDVO_REQUIRE_SHARED(folder);
  const Dataset dataset = open_dataset(folder);
  const Config config = with_network();
  const DistortedCamera camera = choose_camera(dataset).camera;
  Odometry odometry(camera, config,
                    make_strength_detector(
                        open_network(config.network, {camera.pinhole.width, camera.pinhole.height}),
                        config.network));
  constexpr std::size_t kFrames = 30;
  for (std::size_t i = 0; i < kFrames; ++i)
    EXPECT_NE(odometry.process(read_frame(dataset, i)).status, FrameStatus::kLost) << i;
}

}  // namespace
}  // namespace edvo
