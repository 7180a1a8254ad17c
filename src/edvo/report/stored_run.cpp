// SPDX-License-Identifier: MIT
#include "edvo/report/stored_run.hpp"

#include "edvo/core/error.hpp"
#include "edvo/io/file.hpp"
#include "edvo/io/trajectory_file.hpp"
#include "edvo/report/stored_summary.hpp"
#include "edvo/report/worst_frames.hpp"
#include "edvo/run/evaluation.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <map>
#include <system_error>

namespace edvo {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void refuse(const fs::path& where, const std::string& what) {
  throw Error(ErrorCode::kInput, fmt::format("{}: {}", where.string(), what));
}

// Says which folder was probably meant.
void check_is_run(const fs::path& folder) {
  std::error_code error;
  if (!fs::exists(folder, error))
    refuse(folder, "there is no such folder; give the folder that edvo run has written");
  if (!fs::is_directory(folder, error))
    refuse(folder, fmt::format("is a file, not the folder of a run; try {}",
                               folder.has_parent_path() ? folder.parent_path().string() : "."));
  if (fs::exists(folder / "summary.json", error)) return;
  if (fs::exists(folder / "frames.jsonl", error))
    refuse(folder,
           "this run has not ended, or was killed: it has no summary.json; wait for its "
           "end, or run the sequence again");
  if (fs::exists(folder / "latest" / "summary.json", error))
    refuse(folder, fmt::format("holds runs, but is none; try {}", (folder / "latest").string()));
  refuse(folder,
         "is not the folder of a run: it has no summary.json; give one that edvo run has "
         "written");
}

Trajectory read_poses(const fs::path& file) {
  std::error_code error;
  if (!fs::exists(file, error))
    refuse(file,
           "the file is missing, though the run has ended; put it back, or run the sequence "
           "again");
  // A run without any pose leaves an empty file, which is no trajectory for others.
  if (fs::is_regular_file(file, error) && fs::file_size(file, error) == 0) return {};
  return read_trajectory(file).trajectory;
}

std::string read_text(const fs::path& file) {
  std::error_code error;
  if (!fs::exists(file, error))
    refuse(file, "the file is missing; put it back, or run the sequence again");
  return read_file(file);
}

// The curves of the errors again, under the numbers that the run has found.
void add_curves(StoredRun& run) {
  RunEvaluation& evaluation = *run.summary.evaluation;
  const fs::path file = run.folder / "groundtruth.tum";
  std::error_code error;
  if (!fs::exists(file, error)) {
    run.missing.push_back(
        "no groundtruth.tum: errors over time are not known, their numbers are; "
        "run the sequence again for the curves");
    return;
  }
  const GroundTruth truth{.source = evaluation.ground_truth,
                          .trajectory = read_trajectory(file).trajectory};
  try {
    const RunEvaluation again = evaluate_run(truth, run.outcome);
    const auto take = [](TrajectoryErrors& errors, const TrajectoryErrors& from) {
      errors.ate_curve = from.ate_curve;
      errors.rpe_translation_curve = from.rpe_translation_curve;
      errors.rpe_rotation_curve = from.rpe_rotation_curve;
    };
    take(evaluation.final_poses, again.final_poses);
    take(evaluation.online_poses, again.online_poses);
    evaluation.truth = truth.trajectory;
  } catch (const Error& problem) {
    if (problem.code() != ErrorCode::kEvaluation) throw;
    run.missing.push_back(fmt::format("no errors over time: {}", problem.what()));
  }
}

// By frame: what an earlier report shows, in base64.
std::map<std::int64_t, std::string> pictures_in(const std::string& page) {
  constexpr std::string_view kFrame = "data-frame=\"";
  constexpr std::string_view kBytes = "src=\"data:image/jpeg;base64,";
  constexpr std::string_view kAlphabet =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/=";
  std::map<std::int64_t, std::string> pictures;
  for (std::size_t at = page.find(kFrame); at != std::string::npos; at = page.find(kFrame, at)) {
    at += kFrame.size();
    std::int64_t frame = 0;
    const auto [end, status] = std::from_chars(page.data() + at, page.data() + page.size(), frame);
    const std::size_t begin = static_cast<std::size_t>(end - page.data()) + 2;  // past the "\" "
    if (status != std::errc() || page.compare(begin, kBytes.size(), kBytes) != 0) continue;
    const std::size_t first = begin + kBytes.size();
    const std::size_t last = page.find_first_not_of(kAlphabet, first);
    if (last == std::string::npos || page[last] != '"') continue;
    pictures[frame] = page.substr(first, last - first);
  }
  return pictures;
}

void add_pictures(StoredRun& run) {
  const fs::path file = run.folder / "report.html";
  std::error_code error;
  if (!fs::is_regular_file(file, error)) {
    run.missing.push_back("no report.html: the pictures of the worst frames are gone");
    return;
  }
  const std::map<std::int64_t, std::string> pictures = pictures_in(read_file(file));
  std::vector<std::int64_t> frames;
  for (const auto& [frame, picture] : pictures) frames.push_back(frame);
  run.log.worst = choose_worst_frames(run.log, run.summary.evaluation, frames);
  for (WorstFrame& worst : run.log.worst) worst.picture = pictures.at(worst.frame);
}

}  // namespace

StoredRun read_run(const fs::path& folder) {
  check_is_run(folder);
  const auto text_of = [&](const char* name) { return read_text(folder / name); };
  const auto path_of = [&](const char* name) { return (folder / name).string(); };
  StoredRun run{.folder = folder,
                .summary = parse_summary(text_of("summary.json"), path_of("summary.json")),
                .log = parse_frames(text_of("frames.jsonl"), path_of("frames.jsonl")),
                .outcome = {}};
  run.summary.run.config = text_of("config.toml");
  std::error_code error;
  if (fs::exists(folder / "links.jsonl", error))
    run.log.links = parse_links(text_of("links.jsonl"), path_of("links.jsonl"));
  RunOutcome& outcome = run.outcome;
  outcome.counts = run.summary.counts;
  if (!run.log.frames.empty()) outcome.first_stamp = run.log.frames.front().stamp;
  outcome.trajectory = read_poses(folder / "trajectory.tum");
  outcome.online = read_poses(folder / "trajectory_online.tum");
  outcome.keyframes = read_poses(folder / "keyframes.tum");
  outcome.wall_seconds = run.summary.wall_seconds;
  outcome.finish_seconds = run.summary.finish_seconds;
  outcome.interrupted = run.summary.interrupted;
  if (run.summary.evaluation) add_curves(run);
  outcome.evaluation = run.summary.evaluation;
  add_pictures(run);
  return run;
}

}  // namespace edvo
