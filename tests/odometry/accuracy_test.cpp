// SPDX-License-Identifier: MIT
// Real recordings of two kinds of sensor, by the default method and by the network that ships.
#include "edvo/eval/evaluate.hpp"
#include "edvo/io/trajectory_file.hpp"
#include "edvo/network/edge_network.hpp"
#include "edvo/odometry/odometry.hpp"
#include "edvo/source/folder_source.hpp"
#include "support/shared_data.hpp"

#include <gtest/gtest.h>

#include <ostream>

namespace edvo {
namespace {

// Measured on one machine, 5 % slack; every frame must be tracked.
struct Recording {
  std::string name;
  Method method;
  std::string folder;  // below the shared data
  int step;            // every so many-th frame
  std::size_t frames;
  double ate, rpe, rpe_degrees;  // [m], [m/s], [deg/s]
};

void PrintTo(const Recording& recording, std::ostream* out) {
  *out << recording.name;
}

std::unique_ptr<EdgeDetector> detector_of(const Config& config, const Camera& camera) {
  if (config.edge.detector != Detector::kNetwork) return nullptr;
  return make_strength_detector(open_network(config.network, {camera.width, camera.height}),
                                config.network);
}

class RealOdometry : public testing::TestWithParam<Recording> {};

TEST_P(RealOdometry, KeepsItsAccuracy) {
  const Recording& recording = GetParam();
  const auto folder = test::shared_data() / recording.folder;
  EDVO_REQUIRE_SHARED(folder);
  FolderSource source(folder, {.depth_scale = 5000});
  const Config config = preset(recording.method);
  const DistortedCamera camera = source.info().camera;
  Odometry odometry(camera, config, detector_of(config, camera.pinhole));
  for (int i = 0; auto frame = source.next(); ++i) {
    if (i % recording.step != 0) continue;
    const FrameStatus status = odometry.process(frame->load()).status;
    EXPECT_EQ(status, i == 0 ? FrameStatus::kFirst : FrameStatus::kTracked) << i;
  }
  odometry.finish();
  EXPECT_EQ(odometry.trajectory().size(), recording.frames);
  const Evaluation evaluation =
      evaluate(read_trajectory(folder / "groundtruth.txt").trajectory, odometry.trajectory(), {});
  EXPECT_LT(evaluation.ate.distance.rmse, 1.05 * recording.ate);
  ASSERT_TRUE(evaluation.rpe);
  EXPECT_LT(evaluation.rpe->translation.rmse, 1.05 * recording.rpe);
  EXPECT_LT(evaluation.rpe->rotation.rmse, 1.05 * recording.rpe_degrees);
}

const std::string kFr1Xyz = "tum/rgbd_dataset_freiburg1_xyz";

INSTANTIATE_TEST_SUITE_P(
    Recordings, RealOdometry,
    testing::Values(
        Recording{"fr1_xyz", Method::kCannyCorner, kFr1Xyz, 1, 792, 0.00443, 0.00811, 0.537},
        // At 5 Hz the same motion is six times as fast from frame to frame.
        Recording{"fr1_xyz_at_5_Hz", Method::kCannyCorner, kFr1Xyz, 6, 132, 0.0069, 0.0115, 0.651},
        Recording{"fr1_xyz_network", Method::kCnnCorner, kFr1Xyz, 1, 792, 0.00441, 0.00817, 0.528},
        Recording{"icl_kt3", Method::kCannyCorner, "icl_kt3", 1, 100, 0.00078, 0.00108, 0.0177},
        Recording{"icl_kt3_network", Method::kCnnCorner, "icl_kt3", 1, 100, 0.00098, 0.00124,
                  0.0202}),
    [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace edvo
