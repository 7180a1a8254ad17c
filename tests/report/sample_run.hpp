// SPDX-License-Identifier: MIT
// A run that never was, for the tests of what is written about runs.
#pragma once

#include "edvo/report/summary.hpp"

#include <cmath>

namespace edvo::test {

inline FrameResult sample_report(std::int64_t index) {
  const double angle = 0.01 * static_cast<double>(index);
  const bool lost = index % 400 > 390;
  FrameResult report{
      .index = index,
      .stamp = stamp_from_seconds(1305031102.175304 + static_cast<double>(index) / 30.0),
      .status = index == 0 ? FrameStatus::kFirst
                : lost     ? FrameStatus::kLost
                           : FrameStatus::kTracked,
      .world_from_camera = exp((Vector6d() << std::sin(angle), 0.1 * std::sin(3 * angle),
                                std::cos(2 * angle), 0, 0.2 * std::sin(angle), 0)
                                   .finished()),
      .information = 1e6 * Matrix6d::Identity(),
      .points = 8000,
      .inlier_ratio = 0.85 + 0.1 * std::sin(17 * angle),
      .overlap = 1 - 0.01 * static_cast<double>(index % 20),
      .rms = 4.2,
      .levels = {{.level = 3, .iterations = 5, .points = 300, .cost = 1.5, .converged = true},
                 {.level = 0, .iterations = 7, .points = 8000, .cost = 0.9, .converged = false}}};
  if (index % 20 == 0)
    report.keyframe_reason = index == 0 ? KeyframeReason::kFirst : KeyframeReason::kPeriod;
  report.milliseconds = {.frame = 3.1, .edges = 0, .corners = 0, .selection = 0, .tracking = 5};
  if (report.keyframe_reason) report.milliseconds.edges = 2;
  report.milliseconds.tracking += 2 * std::sin(31 * angle) * std::cos(7.7 * angle);
  report.milliseconds.total =
      report.milliseconds.frame + report.milliseconds.edges + report.milliseconds.tracking;
  return report;
}

inline RunDescription sample_description() {
  return {.sequence = "freiburg1_xyz",
          .source = "data/rgbd_dataset_freiburg1_xyz",
          .command = "edvo run data/rgbd_dataset_freiburg1_xyz --method canny+corner",
          .method = "canny+corner",
          .config = "[frame]\nlevels = 4\n",
          .camera = {.pinhole = {517.3, 516.5, 318.6, 255.3, 640, 480},
                     .distortion = {0.2624, -0.9531, -0.0054, 0.0026, 1.1633}},
          .camera_origin = "TUM freiburg1, from the folder's name",
          .depth_scale = 5000,
          .depth_origin = "5000 units per metre, as all TUM sequences",
          .frames = 800};
}

// A log of so many frames and the outcome that belongs to it.
struct SampleRun {
  RunLog log;
  RunOutcome outcome;
};

inline SampleRun sample_run(std::int64_t frames) {
  SampleRun run;
  TrajectoryErrors errors{.ate = 0.0123,
                          .ate_median = 0.011,
                          .ate_max = 0.03,
                          .rpe_translation = 0.021,
                          .rpe_rotation = 1.2,
                          .drift = 0.8,
                          .ate_pairs = frames,
                          .rpe_pairs = frames};
  for (std::int64_t i = 0; i < frames; ++i) {
    const FrameResult report = sample_report(i);
    run.log.frames.push_back({.index = i,
                              .stamp = report.stamp,
                              .status = report.status,
                              .keyframe = report.keyframe_reason,
                              .inlier_ratio = static_cast<float>(report.inlier_ratio),
                              .overlap = static_cast<float>(report.overlap),
                              .milliseconds = report.milliseconds});
    add_to(run.outcome.counts, report);
    if (report.status == FrameStatus::kLost) continue;
    const StampedPose pose{report.stamp, report.world_from_camera};
    run.outcome.trajectory.push_back(pose);
    if (report.keyframe_reason) run.outcome.keyframes.push_back(pose);
    const auto t = static_cast<double>(i);
    for (Curve* curve :
         {&errors.ate_curve, &errors.rpe_translation_curve, &errors.rpe_rotation_curve}) {
      curve->seconds.push_back(t / 30.0);
      curve->values.push_back(0.01 + 0.005 * std::sin(0.05 * t) + 0.002 * std::sin(2.1 * t));
    }
  }
  if (frames > 0) run.outcome.first_stamp = run.log.frames.front().stamp;
  run.outcome.online = run.outcome.trajectory;
  run.outcome.wall_seconds = static_cast<double>(frames) / 100.0;
  run.outcome.finish_seconds = 0.25;
  RunEvaluation evaluation{.ground_truth = "groundtruth.txt",
                           .protocol = "TUM protocol: ATE rmse, RPE rmse over fixed delta 1s",
                           .final_poses = errors,
                           .online_poses = errors,
                           .truth = run.outcome.trajectory};
  for (double& value : evaluation.online_poses.ate_curve.values) value *= 1.2;
  for (StampedPose& pose : evaluation.truth)
    pose.world_from_camera.translation += Eigen::Vector3d(0.01, 0.02, 0);
  run.outcome.evaluation = evaluation;
  return run;
}

}  // namespace edvo::test
