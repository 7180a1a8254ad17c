// SPDX-License-Identifier: MIT
#include "edvo/run/run.hpp"

#include "edvo/run/evaluation.hpp"
#include "edvo/source/prefetch.hpp"

#include <fmt/core.h>

#include <chrono>
#include <cstdint>
#include <span>
#include <variant>

namespace edvo {
namespace {

using Clock = std::chrono::steady_clock;
using PreparedFrame = Prefetched<PreparedImage>;

double seconds_between(Clock::time_point earlier, Clock::time_point later) {
  return std::chrono::duration<double>(later - earlier).count();
}

// Tells all observers the same. What one throws passes through: the later ones are not told.
template <typename Member, typename... Values>
void tell(const Observers& observers, Member member, const Values&... values) {
  for (Observer* const observer : observers) (observer->*member)(values...);
}

// Tells each the same, whatever another throws: the first error is the outcome's if it has none.
template <typename Member, typename... Values>
void tell_each(const Observers& observers, RunOutcome& outcome, Member member,
               const Values&... values) {
  for (Observer* const observer : observers) {
    try {
      (observer->*member)(values...);
    } catch (...) {
      if (!outcome.error) outcome.error = caught_error();
    }
  }
}

// The frame's result (also if it is lost), or why there is none: it could not be read or prepared,
// or not used.
std::variant<FrameResult, Error> track(Tracker& tracker, const PreparedFrame& frame) {
  if (const Error* error = std::get_if<Error>(&frame.content)) return *error;
  try {
    FrameResult result = tracker.process(std::get<PreparedImage>(frame.content));
    result.index = frame.index;  // of the source; the tracker counts only what it was given
    return result;
  } catch (...) {
    return caught_error();
  }
}

void add_result(const FrameResult& result, const MapFrame& map_frame, const Frame& image,
                const Observers& observers, RunOutcome& outcome) {
  if (frames_processed(outcome.counts) == 0) outcome.first_stamp = result.stamp;
  add_to(outcome.counts, result);
  if (result.status != FrameStatus::kLost)
    outcome.online.push_back(
        {.stamp = result.stamp,
         .world_from_camera = map_frame.map_from_odometry * result.world_from_camera,
         .segment = map_frame.segment});
  tell(observers, &Observer::frame, result, image);
}

// The newest keyframe, to those who want it.
void tell_keyframe(const Tracker& tracker, const Observers& observers) {
  KeyframePtr keyframe;
  for (Observer* const observer : observers) {
    if (!observer->wants_keyframes()) continue;
    if (!keyframe) keyframe = tracker.newest_keyframe();
    if (keyframe) observer->keyframe(keyframe);
  }
}

void tell_map(const Map& map, std::uint64_t& version, const Observers& observers) {
  if (map.version() == version) return;
  version = map.version();
  tell(observers, &Observer::map_changed, std::span<const MapKeyframe>(map.keyframes()));
}

void add_skipped(const PreparedFrame& frame, const Error& error, const Observers& observers,
                 RunOutcome& outcome) {
  ++outcome.counts.skipped;
  tell(observers, &Observer::skipped,
       SkippedFrame{.index = frame.index, .stamp = to_string(frame.stamp), .reason = error.what()});
}

// The next frame; none at the end of the source, if asked to stop, or if the source failed (then
// outcome.error says why).
std::optional<PreparedFrame> next_frame(Prefetch<PreparedImage>& frames,
                                        const std::function<bool()>& should_stop,
                                        RunOutcome& outcome) {
  try {
    return frames.next(should_stop);
  } catch (...) {
    outcome.error = caught_error();
  }
  return std::nullopt;
}

void track_all(Prefetch<PreparedImage>& frames, Tracker& tracker, const Observers& observers,
               const std::function<bool()>& should_stop, std::uint64_t& map_version,
               RunOutcome& outcome) {
  while (const std::optional<PreparedFrame> frame = next_frame(frames, should_stop, outcome)) {
    const std::variant<FrameResult, Error> tracked = track(tracker, *frame);
    if (const Error* const error = std::get_if<Error>(&tracked)) {
      if (error->code() != ErrorCode::kInput) {  // kInput is about this frame alone
        outcome.error = *error;
        return;
      }
      add_skipped(*frame, *error, observers, outcome);
    } else {
      const FrameResult& result = std::get<FrameResult>(tracked);
      add_result(result, tracker.map_frame(result.segment),
                 std::get<PreparedImage>(frame->content).frame, observers, outcome);
      if (result.new_keyframe) tell_keyframe(tracker, observers);
      tell_map(tracker.map(), map_version, observers);
    }
    outcome.interrupted = should_stop && should_stop();
    if (outcome.interrupted) return;
  }
  outcome.interrupted = should_stop && should_stop();
}

// What the loop throws, which observers did, ends the run as an error of the source does.
void track_all_kept(Prefetch<PreparedImage>& frames, Tracker& tracker, const Observers& observers,
                    const std::function<bool()>& should_stop, std::uint64_t& map_version,
                    RunOutcome& outcome) {
  try {
    track_all(frames, tracker, observers, should_stop, map_version, outcome);
  } catch (...) {
    outcome.error = caught_error();
  }
}

void evaluate_into(RunOutcome& outcome, const std::optional<GroundTruth>& truth,
                   const SourceInfo& source, const Observers& observers) {
  if (!truth) {
    outcome.no_evaluation = "no usable ground truth";
    return;
  }
  try {
    outcome.evaluation = evaluate_run(*truth, outcome);
    if (const auto warning = warn_of_scale(*outcome.evaluation, source))
      outcome.evaluation->warnings.push_back(*warning);
    for (const std::string& warning : outcome.evaluation->warnings)
      tell_each(observers, outcome, &Observer::warning, warning);
  } catch (const Error& error) {
    outcome.no_evaluation = fmt::format("{}: {}", truth->source, error.what());
    tell_each(observers, outcome, &Observer::warning, "no evaluation: " + outcome.no_evaluation);
  }
}

}  // namespace

RunOutcome run_tracker(RgbdSource& source, Tracker& tracker, const Observers& observers,
                       const RunOptions& options) {
  tell(observers, &Observer::begin, source.info());
  RunOutcome outcome;
  std::uint64_t map_version = 0;  // that observers were told of
  const Clock::time_point start = Clock::now();
  {
    // From disk to Frame: of a recording ahead, mostly on other threads; of a live source on this.
    Prefetch frames([&](const PendingFrame& frame) { return tracker.prepare(frame.load()); },
                    source, {.threads = options.threads});
    track_all_kept(frames, tracker, observers, options.should_stop, map_version, outcome);
    outcome.counts.dropped = frames.dropped();
  }
  const Clock::time_point last_pose = Clock::now();
  outcome.wall_seconds = seconds_between(start, last_pose);
  tracker.finish(options.threads);  // also after an error or a stop
  outcome.finish_seconds = seconds_between(last_pose, Clock::now());
  if (tracker.map().version() != map_version)
    tell_each(observers, outcome, &Observer::map_changed,
              std::span<const MapKeyframe>(tracker.map().keyframes()));
  if (const std::vector<LinkReport> links = tracker.links(); !links.empty())
    tell_each(observers, outcome, &Observer::links, std::span<const LinkReport>(links));
  outcome.trajectory = tracker.trajectory();
  outcome.keyframes = tracker.keyframe_trajectory();
  if (!outcome.trajectory.empty())
    evaluate_into(outcome, options.ground_truth ? options.ground_truth : source.info().ground_truth,
                  source.info(), observers);
  tell_each(observers, outcome, &Observer::end, outcome);
  return outcome;
}

}  // namespace edvo
