// SPDX-License-Identifier: MIT
#include "edvo/report/events.hpp"

#include "report/sample_run.hpp"

#include <gmock/gmock.h>

namespace edvo {
namespace {

using test::sample_run;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(Events, OfAnUneventfulRunAreNone) {
  EXPECT_THAT(events_of(sample_run(100).log), IsEmpty());
  EXPECT_THAT(events_of({}), IsEmpty());
}

TEST(Events, TellLossesRestartsAndRelocalizationsInOrderOfTime) {
  test::SampleRun run = sample_run(420);  // lost: 391 to 399
  run.log.frames[391].loss_cause = LossCause::kTooFast;
  run.log.frames[400].status = FrameStatus::kRestarted;
  run.log.frames[410].status = FrameStatus::kRelocalized;
  const std::vector<RunEvent> events = events_of(run.log);
  ASSERT_EQ(events.size(), 3u);
  EXPECT_EQ(events[0].kind, EventKind::kLost);
  EXPECT_EQ(events[0].frame, 391);
  EXPECT_NEAR(events[0].seconds, 391 / 30.0, 1e-3);
  EXPECT_EQ(events[0].text, "9 frames: " + explain(LossCause::kTooFast));
  EXPECT_EQ(events[1].kind, EventKind::kRestarted);
  EXPECT_EQ(events[1].frame, 400);
  EXPECT_EQ(events[2].kind, EventKind::kRelocalized);
  EXPECT_EQ(events[2].frame, 410);
}

TEST(Events, PlaceALoopLinkAtTheLaterOfItsKeyframes) {
  test::SampleRun run = sample_run(100);
  run.log.frames[20].new_keyframe = 1;
  run.log.frames[80].new_keyframe = 4;
  run.log.links = {{.from = 4, .to = 1}, {.from = 4, .to = 77}};  // 77: of no frame of this run
  const std::vector<RunEvent> events = events_of(run.log);
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].kind, EventKind::kLink);
  EXPECT_EQ(events[0].frame, 80);
  EXPECT_THAT(events[0].text, HasSubstr("frame 20"));
}

TEST(Events, PlaceAWarningAtTheFrameThatFollowedOrAtTheLastOne) {
  test::SampleRun run = sample_run(50);
  run.log.warnings = {{.frames_before = 7, .text = "odd"}, {.frames_before = 50, .text = "late"}};
  const std::vector<RunEvent> events = events_of(run.log);
  ASSERT_EQ(events.size(), 2u);
  EXPECT_EQ(events[0].frame, 7);
  EXPECT_EQ(events[0].text, "odd");
  EXPECT_EQ(events[1].frame, 49);
}

}  // namespace
}  // namespace edvo
