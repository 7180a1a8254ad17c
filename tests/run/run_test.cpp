// SPDX-License-Identifier: MIT
#include "edvo/run/run.hpp"

#include "support/error_matcher.hpp"
#include "support/made_source.hpp"

#include <gmock/gmock.h>

#include <stdexcept>

namespace edvo {
namespace {

using test::FakeLiveSource;
using test::MadeSource;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

// Frame i is at x = i [m]. The first is the only keyframe.
class FakeTracker {
 public:
  [[nodiscard]] PreparedImage prepare(const RgbdImage& image) const {
    PreparedImage prepared;
    prepared.frame.stamp = image.stamp;
    return prepared;
  }

  FrameResult process(const PreparedImage& image) {
    const int i = processed_++;
    if (i == fails_at && throws) throws();
    if (i == fails_at) throw Error(fails_with, "tracker: cannot");
    FrameResult result{.stamp = image.frame.stamp,
                       .status = i == 0 ? FrameStatus::kFirst : FrameStatus::kTracked,
                       .world_from_camera = {.translation = {1.0 * i, 0, 0}}};
    if (i == lost_at) {
      result.status = FrameStatus::kLost;
      result.loss_cause = LossCause::kUnlike;
    } else if (i == restarts_at) {
      result.status = FrameStatus::kRestarted;
      result.segment = 1;
    }
    if (i == 0) result.new_keyframe = map_.add(result.stamp, 0, result.world_from_camera);
    if (result.status != FrameStatus::kLost)
      poses_.push_back({result.stamp, result.world_from_camera});
    return result;
  }

  void finish(int /*threads*/) {
    if (!map_.keyframes().empty()) map_.set_pose(0, {.translation = {0, 0, 0.5}});
  }
  [[nodiscard]] Trajectory trajectory() const { return poses_; }
  [[nodiscard]] const Map& map() const { return map_; }
  [[nodiscard]] KeyframePtr newest_keyframe() const {
    ++keyframes_made;
    return std::make_shared<const Keyframe>(Keyframe{.id = map_.keyframes().back().id});
  }
  [[nodiscard]] Trajectory keyframe_trajectory() const {
    return {poses_.begin(), poses_.begin() + (poses_.empty() ? 0 : 1)};
  }

  int lost_at = -1, restarts_at = -1, fails_at = -1;
  mutable int keyframes_made = 0;
  ErrorCode fails_with = ErrorCode::kInput;
  std::function<void()> throws = nullptr;  // instead of an Error with this code

 private:
  int processed_ = 0;
  Trajectory poses_;
  Map map_;
};

// Writes down what it is told.
class Diary final : public Observer {
 public:
  void begin(const SourceInfo& source) override { lines.push_back("begin " + source.name); }
  void frame(const FrameResult& result, const Frame& image) override {
    EXPECT_EQ(result.stamp, image.stamp);
    lines.push_back(std::string(name_of(result.status)) + " " + std::to_string(result.index));
  }
  void skipped(const SkippedFrame& frame) override {
    lines.push_back("skipped " + std::to_string(frame.index) + " at " + frame.stamp);
  }
  void warning(const std::string& text) override { lines.push_back("warning: " + text); }
  void end(const RunOutcome& outcome) override {
    lines.push_back("end after " + std::to_string(frames_due(outcome.counts)));
  }

  std::vector<std::string> lines;
};

RgbdImage image_of(std::int64_t index) {
  RgbdImage image;
  image.stamp = {.nanoseconds = 100'000'000 * index, .decimals = 1};
  return image;
}

Trajectory straight_line(int count) {
  Trajectory line;
  for (int i = 0; i < count; ++i)
    line.push_back({image_of(i).stamp, {.translation = {1.0 * i, 0, 0}}});
  return line;
}

TEST(Run, TellsEveryObserverEachFrameInItsOrder) {
  MadeSource source(3, image_of);
  FakeTracker tracker;
  Diary one, other;
  const RunOutcome outcome = run(source, tracker, {&one, &other});
  EXPECT_THAT(one.lines,
              ElementsAre("begin made", "first 0", "tracked 1", "tracked 2", "end after 3"));
  EXPECT_EQ(other.lines, one.lines);
  EXPECT_EQ(outcome.counts.tracked, 3);
  EXPECT_EQ(outcome.online.size(), 3U);
  EXPECT_EQ(outcome.keyframes.size(), 1U);
  EXPECT_FALSE(outcome.interrupted);
  EXPECT_FALSE(failure_of(outcome, "made"));
}

TEST(Run, SkipsWhatCannotBeReadOrUsedAndLeavesLostFramesOut) {
  MadeSource source(5, [](std::int64_t i) {
    if (i == 1) throw Error(ErrorCode::kInput, "damaged");
    return image_of(i);
  });
  FakeTracker tracker;  // does not see the damaged one
  tracker.fails_at = 1;
  tracker.lost_at = 2;
  Diary diary;
  const RunOutcome outcome = run(source, tracker, {&diary}, {.threads = 3});
  EXPECT_THAT(diary.lines, ElementsAre("begin made", "first 0", "skipped 1 at 0.1",
                                       "skipped 2 at 0.2", "lost 3", "tracked 4", "end after 5"));
  EXPECT_EQ(outcome.counts.skipped, 2);
  EXPECT_EQ(outcome.counts.lost, 1);
  EXPECT_EQ(outcome.trajectory.size(), 2U);
  EXPECT_EQ(outcome.online.size(), 2U);
}

TEST(Run, MakesAKeyframeOnceAndOnlyIfSomeoneWantsIt) {
  class Collector final : public Observer {
   public:
    [[nodiscard]] bool wants_keyframes() const override { return true; }
    void keyframe(const KeyframePtr& keyframe) override { got.push_back(keyframe); }
    std::vector<KeyframePtr> got;
  };
  MadeSource source(3, image_of), again(3, image_of);
  FakeTracker tracker, other;
  Collector one, two;
  Diary diary;
  (void)run(source, tracker, {&diary});
  EXPECT_EQ(tracker.keyframes_made, 0);
  (void)run(again, other, {&one, &diary, &two});
  EXPECT_EQ(other.keyframes_made, 1);
  ASSERT_EQ(one.got.size(), 1U);
  EXPECT_EQ(one.got, two.got);
  EXPECT_EQ(one.got.front()->id, 0);
}

TEST(Run, TellsWhenKeyframesComeOrMove) {
  class MapWatcher final : public Observer {
   public:
    void map_changed(std::span<const MapKeyframe> keyframes) override {
      heights.push_back(keyframes.front().world_from_camera.translation.z());
    }
    std::vector<double> heights;
  };
  MadeSource source(3, image_of);
  FakeTracker tracker;
  MapWatcher watcher;
  (void)run(source, tracker, {&watcher});
  EXPECT_THAT(watcher.heights, ElementsAre(0, 0.5));  // the first frame, finish()
}

TEST(Run, CountsGuessedPosesAsRestartedInASegmentOfTheirOwn) {
  MadeSource source(5, image_of);
  FakeTracker tracker;
  tracker.lost_at = 2;
  tracker.restarts_at = 3;
  const RunOutcome outcome = run(source, tracker);
  EXPECT_EQ(outcome.counts.tracked, 3);
  EXPECT_EQ(outcome.counts.lost, 1);
  EXPECT_EQ(outcome.counts.restarted, 1);
  EXPECT_EQ(outcome.counts.segments, 2);
  EXPECT_EQ(outcome.counts.causes.at(LossCause::kUnlike), 1);
  EXPECT_EQ(frames_due(outcome.counts), 5);
  EXPECT_EQ(outcome.online[2].segment, 1);
}

TEST(Run, KeepsWhatWasDoneWhenTheSourceEndsInAnError) {
  MadeSource source(4, image_of);
  source.error = Error(ErrorCode::kInput, "recording: cut short");
  FakeTracker tracker;
  Diary diary;
  const RunOutcome outcome = run(source, tracker, {&diary});
  EXPECT_EQ(outcome.trajectory.size(), 4U);
  EXPECT_EQ(diary.lines.back(), "end after 4");
  const std::optional<Error> failure = failure_of(outcome, "made");
  ASSERT_TRUE(failure);
  EXPECT_EQ(failure->code(), ErrorCode::kInput);
  EXPECT_THAT(failure->what(), HasSubstr("cut short"));
}

TEST(Run, EndsAtAnErrorOfTheTrackerThatIsNotAboutOneFrame) {
  MadeSource source(9, image_of);
  FakeTracker tracker;
  tracker.fails_at = 2;
  tracker.fails_with = ErrorCode::kModel;
  const RunOutcome outcome = run(source, tracker);
  EXPECT_EQ(outcome.trajectory.size(), 2U);
  EXPECT_EQ(failure_of(outcome, "made")->code(), ErrorCode::kModel);
}

TEST(Run, KeepsWhatWasDoneWhateverTheTrackerThrows) {
  const auto thrown = [](const std::function<void()>& throws) {
    MadeSource source(9, image_of);
    FakeTracker tracker;
    tracker.fails_at = 2;
    tracker.throws = throws;
    const RunOutcome outcome = run(source, tracker);
    EXPECT_EQ(outcome.trajectory.size(), 2U);
    return outcome.error->code();
  };
  EXPECT_EQ(thrown([] { throw std::bad_alloc(); }), ErrorCode::kResources);
  EXPECT_EQ(thrown([] { CV_Error(cv::Error::StsNoMem, "no memory"); }), ErrorCode::kResources);
  EXPECT_EQ(thrown([] { throw std::logic_error("a bug"); }), ErrorCode::kInternal);
}

// Throws from one call on, as on a full disk.
struct FullDisk final : Observer {
  explicit FullDisk(int lasts) : left(lasts) {}
  void frame(const FrameResult& /*result*/, const Frame& /*image*/) override { write(); }
  void end(const RunOutcome& /*outcome*/) override { write(); }
  void write() {
    if (--left < 0) throw Error(ErrorCode::kOutput, "disk full");
  }
  int left;
};

TEST(Run, KeepsWhatWasDoneWhenAnObserverThrows) {
  struct Listener final : Observer {
    void end(const RunOutcome& outcome) override { told = outcome.error.has_value(); }
    bool told = false;
  };
  const auto run_with = [](int lasts) {
    MadeSource source(9, image_of);
    FakeTracker tracker;
    FullDisk disk(lasts);
    Listener listener;
    const RunOutcome outcome = run(source, tracker, {&disk, &listener});
    EXPECT_TRUE(listener.told);
    EXPECT_EQ(failure_of(outcome, "made")->code(), ErrorCode::kOutput);
    EXPECT_THAT(outcome.error->what(), ::testing::HasSubstr("disk full"));
    EXPECT_FALSE(outcome.interrupted);
    return outcome.trajectory.size();
  };
  EXPECT_EQ(run_with(4), 5U);  // at the fifth frame
  EXPECT_EQ(run_with(9), 9U);  // at the end
}

TEST(Run, WhatAnObserverThrowsAtTheBeginningPassesThrough) {
  struct Refuses final : Observer {
    void begin(const SourceInfo& /*source*/) override {
      throw Error(ErrorCode::kOutput, "no such folder");
    }
  };
  MadeSource source(9, image_of);
  FakeTracker tracker;
  Refuses refuses;
  EXPECT_TRUE(test::fails_with(ErrorCode::kOutput, {"no such folder"},
                               [&] { (void)run(source, tracker, {&refuses}); }));
}

TEST(Run, StopsBetweenTwoFramesWhenAskedTo) {
  MadeSource source(100, image_of);
  FakeTracker tracker;
  int asked = 0;
  const RunOutcome outcome =
      run(source, tracker, {}, {.should_stop = [&] { return ++asked == 3; }});
  EXPECT_TRUE(outcome.interrupted);
  EXPECT_EQ(outcome.counts.tracked, 3);
  EXPECT_FALSE(failure_of(outcome, "made"));
}

TEST(Run, StopsWhileACameraIsSilent) {
  FakeLiveSource camera(image_of);
  FakeTracker tracker;
  int asked = 0;
  const RunOutcome outcome = run(camera, tracker, {}, {.should_stop = [&] { return ++asked > 2; }});
  EXPECT_TRUE(outcome.interrupted);
  EXPECT_EQ(frames_due(outcome.counts), 0);
}

TEST(Run, CountsTheFramesOfACameraThatItWasTooLateFor) {
  // Four frames come while the first is processed.
  class Slow final : public Observer {
   public:
    explicit Slow(FakeLiveSource& camera) : camera_(camera) {}
    void frame(const FrameResult& result, const Frame& /*image*/) override {
      if (result.index > 0) return camera_.stop();
      for (int i = 0; i < 4; ++i) camera_.deliver();
      camera_.wait_until_taken();
    }

   private:
    FakeLiveSource& camera_;
  };
  FakeLiveSource camera(image_of);
  FakeTracker tracker;
  Slow slow(camera);
  Diary diary;
  camera.deliver();
  const RunOutcome outcome = run(camera, tracker, {&diary, &slow});
  EXPECT_THAT(diary.lines, ElementsAre("begin camera", "first 0", "tracked 4", "end after 2"));
  EXPECT_EQ(outcome.counts.dropped, 3);
}

TEST(Run, ComparesWithTheSourcesGroundTruthOrTheOneGiven) {
  MadeSource source(5, image_of);
  source.info().ground_truth = GroundTruth{"the source's", straight_line(5)};
  FakeTracker tracker;
  const RunOutcome outcome = run(source, tracker);
  ASSERT_TRUE(outcome.evaluation);
  EXPECT_EQ(outcome.evaluation->ground_truth, "the source's");
  EXPECT_NEAR(outcome.evaluation->final_poses.ate, 0, 1e-9);
  MadeSource again(5, image_of);
  FakeTracker other;
  EXPECT_EQ(run(again, other, {}, {.ground_truth = GroundTruth{"given", straight_line(5)}})
                .evaluation->ground_truth,
            "given");
}

TEST(Run, WarnsWhereGroundTruthDoesNotOverlap) {
  MadeSource source(5, image_of);
  source.info().ground_truth = GroundTruth{"old", {{stamp_from_seconds(1e6), {}}}};
  FakeTracker tracker;
  Diary diary;
  const RunOutcome outcome = run(source, tracker, {&diary});
  EXPECT_FALSE(outcome.evaluation);
  EXPECT_THAT(outcome.no_evaluation, HasSubstr("old: "));
  EXPECT_THAT(diary.lines[diary.lines.size() - 2], HasSubstr("warning: no evaluation: old"));
}

TEST(Run, OnePoseOfManyFramesIsNoTracking) {
  RunOutcome outcome;
  outcome.counts = {.tracked = 1, .lost = 3, .skipped = 2};
  const std::optional<Error> failure = failure_of(outcome, "made");
  ASSERT_TRUE(failure);
  EXPECT_EQ(failure->code(), ErrorCode::kTrackingLost);
  EXPECT_THAT(failure->what(),
              HasSubstr("made: none of 6 frames could be tracked (3 lost, 2 skipped)"));
  outcome.counts.causes = {{LossCause::kNoTexture, 1}, {LossCause::kNoDepth, 2}};
  EXPECT_THAT(failure_of(outcome, "made")->what(),
              HasSubstr("; 2 of them because hardly a pixel has a depth"));
  outcome.counts = {.tracked = 1};
  EXPECT_FALSE(failure_of(outcome, "made"));
}

}  // namespace
}  // namespace edvo
