// SPDX-License-Identifier: MIT
#include "run_result.hpp"

#include "edvo/run/evaluation.hpp"
#include "terminal.hpp"

#include <fmt/core.h>

#include <cmath>

#include <nlohmann/json.hpp>

namespace edvo::app {
namespace {

using Json = nlohmann::ordered_json;

std::string counted(std::int64_t count, const char* noun) {
  return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

void print_counts(const RunSummary& summary) {
  const FrameCounts& counts = summary.counts;
  print("frames     {} tracked, {} lost ({}), {} skipped; coverage {:.1f} %\n", counts.tracked,
        counts.lost, counted(summary.lost_events, "event"), counts.skipped, 100 * summary.coverage);
  if (counts.segments > 1)
    print("           {} segments, {} begun at a guessed pose\n", counts.segments,
          counted(counts.restarted, "frame"));
  if (counts.dropped > 0) print("           {} dropped, as later ones had come\n", counts.dropped);
  print("keyframes  {}\n", summary.keyframes);
  if (summary.readout_seconds != 0)
    print("shutter    rolling, {:.1f} ms from the first row to the last, as estimated\n",
          1e3 * summary.readout_seconds);
  if (summary.ego_share > 0)
    print("left out   {:.0f} % of the image, at most: it moves along with the camera\n",
          100 * summary.ego_share);
  print("path       {:.3f} m{}\n", summary.path_length,
        summary.run.is_depth_assumed
            ? fmt::format(", if depth has {} units per metre, which is assumed (--depth-scale)",
                          summary.run.depth_scale)
            : "");
  print("time       {:.2f} ms per frame (median), {:.2f} ms (p95); {:.1f} frames/s with reading\n",
        summary.total_milliseconds.median, summary.total_milliseconds.p95,
        frames_per_second(summary));
  if (summary.slowest_second)
    print("           {} in the slowest second\n", counted(*summary.slowest_second, "frame"));
  print("           {:.2f} s for the last pass, after the last frame\n", summary.finish_seconds);
  print("memory     {:.0f} MB at most\n", summary.peak_memory);
}

void print_error_row(const char* name, const char* unit, double final_pose, double online_pose,
                     bool known) {
  if (known) {
    print("{:<16} {:<8} {:>10.5f} {:>10.5f}\n", name, unit, final_pose, online_pose);
  } else {
    print("{:<16} {:<8} {:>10} {:>10}\n", name, unit, "-", "-");
  }
}

void print_errors(const RunEvaluation& evaluation) {
  const TrajectoryErrors& final_poses = evaluation.final_poses;
  const TrajectoryErrors& online = evaluation.online_poses;
  const bool has_rpe = final_poses.rpe_pairs > 0 && online.rpe_pairs > 0;
  const bool has_drift = final_poses.drift && online.drift;
  print("\n{:<16} {:<8} {:>10} {:>10}\n", "error", "unit", "final", "live");
  print_error_row("ATE", "m", final_poses.ate, online.ate, true);
  print_error_row("RPE translation", "m/s", final_poses.rpe_translation, online.rpe_translation,
                  has_rpe);
  print_error_row("RPE rotation", "deg/s", final_poses.rpe_rotation, online.rpe_rotation, has_rpe);
  print_error_row("drift at the end", "%", final_poses.drift.value_or(0), online.drift.value_or(0),
                  has_drift);
  if (std::abs(evaluation.scale - 1) > kScaleTolerance)
    print("{:<16} {:<8} {:>10.4f}   (Sim(3): what the motion must be multiplied by)\n", "scale", "",
          evaluation.scale);
  print("{:<16} {:<8} {:>10} {:>10}\n", "pairs", "ATE", final_poses.ate_pairs, online.ate_pairs);
  print("{:<16} {:<8} {:>10} {:>10}\n", "", "RPE", final_poses.rpe_pairs, online.rpe_pairs);
  print("{}\nagainst {}\n", evaluation.protocol, evaluation.ground_truth);
}

void print_profile(const RunSummary& summary) {
  print("\n{:<12} {:>9} {:>9} {:>9} {:>9}\n", "stage [ms]", "mean", "median", "p95", "p99");
  const auto print_row = [](std::string_view name, const TimeStatistics& ms) {
    print("{:<12} {:>9.3f} {:>9.3f} {:>9.3f} {:>9.3f}\n", name, ms.mean, ms.median, ms.p95, ms.p99);
  };
  for (std::size_t i = 0; i < kStages.size(); ++i)
    print_row(kStages[i].name, summary.stage_milliseconds[i]);
  print_row("total", summary.total_milliseconds);
}

}  // namespace

void show_choices(const RunDescription& run, const RunFlags& flags) {
  if (!flags.quiet) {
    say("sequence  {}, {}\n", run.source,
        run.frames ? counted(*run.frames, "frame") : "length not known");
    say("camera    {}\n", run.camera_origin);
    say("method    {}\n", run.method);
    for (const std::string& note : run.notes) say("note: {}\n", note);
  }
  for (const std::string& warning : run.warnings) say("warning: {}\n", warning);
}

void show_result(const RecordedRun& result, const RunFlags& flags) {
  const RunSummary& summary = result.summary;
  if (flags.json) {
    Json json = Json::parse(to_json(summary));
    json["folder"] = result.folder.string();
    if (result.localized)
      json["map"] = {{"file", flags.map}, {"localized_frames", *result.localized}};
    print_bytes(json.dump(2, ' ', false, Json::error_handler_t::replace) + '\n');
  } else {
    print("{}, {}{}\n", summary.run.sequence, summary.run.method,
          summary.interrupted ? ", interrupted" : "");
    print_counts(summary);
    if (result.localized)
      print("map        {} of {} in the frame of {}\n", *result.localized,
            counted(frames_processed(summary.counts), "frame"), flags.map);
    if (summary.evaluation) print_errors(*summary.evaluation);
    if (flags.profile) print_profile(summary);
    print("\nwritten to {}\n", result.folder.string());
  }
}

}  // namespace edvo::app
