// SPDX-License-Identifier: MIT
#include "edvo/report/html.hpp"

#include "edvo/core/clean_text.hpp"
#include "report/sample_run.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

namespace edvo {
namespace {

using test::sample_description;
using test::sample_run;
using ::testing::HasSubstr;
using ::testing::Not;

std::string page_of(const test::SampleRun& run, const RunDescription& description) {
  return to_html(summarize(description, run.log, run.outcome), run.log, run.outcome);
}

TEST(Report, ShowsWhatMattersOfARun) {
  const std::string page = page_of(sample_run(300), sample_description());
  for (const char* part :
       {"freiburg1_xyz", "canny+corner", "From above", "From the side", "ground truth",
        "Absolute error over time", "Relative error over time", "Time per frame",
        "Tracking quality", "Keyframes and their reasons", "1.23", "TUM protocol", "levels = 4",
        "edvo run data/rgbd_dataset_freiburg1_xyz --method canny+corner", "summary.json"})
    EXPECT_THAT(page, HasSubstr(part));
}

TEST(Report, NeedsNoNetwork) {
  const std::string page = page_of(sample_run(50), sample_description());
  for (const char* part : {"src=", "@import", "<link", "fetch("})
    EXPECT_THAT(page, Not(HasSubstr(part)));
  // Within the page.
  for (std::size_t at = page.find("url("); at != page.npos; at = page.find("url(", at + 1))
    EXPECT_EQ(page[at + 4], '#');
}

TEST(Report, ShowsTheWorstFramesWithTheirPicturesInside) {
  test::SampleRun run = sample_run(50);
  run.log.worst = {
      {.frame = 17, .seconds = 0.567, .reason = "tracked, <odd>", .picture = "anBlZyE="},
      {.frame = 30, .seconds = 1, .reason = "lost", .picture = ""}};
  const std::string page = page_of(run, sample_description());
  EXPECT_THAT(page, HasSubstr("src=\"data:image/jpeg;base64,anBlZyE=\""));
  EXPECT_THAT(page, HasSubstr("frame 17, 0.57 s: tracked, &lt;odd&gt;"));
  EXPECT_THAT(page, HasSubstr("no picture"));
  // From the plots there, and from nowhere else.
  for (const char* part :
       {"href=\"#worst-1\"", "id=\"worst-1\"", "href=\"#worst-2\"", "id=\"worst-2\""})
    EXPECT_THAT(page, HasSubstr(part));
  for (std::size_t at = page.find("src="); at != page.npos; at = page.find("src=", at + 1))
    EXPECT_EQ(page.substr(at, 10), "src=\"data:");
}

TEST(Report, MarksEventsInThePlotsOverTime) {
  test::SampleRun run = sample_run(420);  // lost: 391 to 399
  run.log.frames[400].status = FrameStatus::kRestarted;
  const std::string page = page_of(run, sample_description());
  for (const char* part : {"<h2>Events</h2>", "href=\"#event-1\"", "id=\"event-1\"",
                           "restarted, frame 400: a new segment", "1 lost · 1 restarted"})
    EXPECT_THAT(page, HasSubstr(part));
  EXPECT_THAT(page_of(sample_run(50), sample_description()), Not(HasSubstr("<h2>Events</h2>")));
}

TEST(Report, DrawsRareEventsOverLoopLinks) {
  test::SampleRun run = sample_run(100);
  run.log.frames[20].new_keyframe = 1;
  run.log.frames[80].new_keyframe = 4;
  run.log.frames[80].status = FrameStatus::kRestarted;
  run.log.links = {{.from = 4, .to = 1}, {.from = 1, .to = 4}};
  const std::string page = page_of(run, sample_description());
  const std::size_t link = page.find("<title>loop link, frame 80");
  ASSERT_NE(link, page.npos);
  EXPECT_LT(link, page.find("<title>restarted, frame 80"));
  EXPECT_THAT(page, HasSubstr("1 restarted · 2 loop links"));
}

TEST(Report, TakesNoMarkupFromNames) {
  RunDescription description = sample_description();
  for (std::string* text :
       {&description.sequence, &description.source, &description.command, &description.method,
        &description.config, &description.camera_origin, &description.depth_origin})
    *text = "<script>alert('x')</script>";
  description.notes = description.warnings = {"<script>note</script>"};
  test::SampleRun run = sample_run(20);
  run.log.skipped = {{.index = 3, .stamp = "<script>", .reason = "<script>file.png</script>"}};
  run.outcome.evaluation->ground_truth = "<script>truth</script>";
  const std::string page = page_of(run, description);
  for (const char* part : {"<script>alert", "<script>note", "<script>file", "<script>truth"})
    EXPECT_THAT(page, Not(HasSubstr(part)));
  EXPECT_THAT(page, HasSubstr("&lt;script&gt;alert(&#39;x&#39;)&lt;/script&gt;"));
}

TEST(Report, IsUtf8WhateverNamesHold) {
  RunDescription description = sample_description();
  description.sequence = description.source = "caf\xE9\x1b[31m";
  const std::string page = page_of(sample_run(20), description);
  EXPECT_EQ(page, clean_text(page));
  EXPECT_THAT(page, HasSubstr("caf??[31m"));
}

TEST(Report, ShowsTheHeightOfACameraWhoseYPointsUp) {
  const std::string page = page_of(sample_run(20), sample_description());
  EXPECT_THAT(page, HasSubstr(">-y, up [m]<"));
  RunDescription description = sample_description();
  description.camera.pinhole.fy *= -1;
  const std::string upward = page_of(sample_run(20), description);
  EXPECT_THAT(upward, HasSubstr(">y, up [m]<"));
  EXPECT_THAT(upward, HasSubstr("data-right=\"2\" data-up=\"1\" data-sign=\"1\""));
}

TEST(Report, NamesTheWorstFrames) {
  test::SampleRun run = sample_run(300);
  run.outcome.evaluation->final_poses.ate_curve.values[123] = 4.5;
  run.log.frames[77].inlier_ratio = 0.125F;
  run.log.frames[55].milliseconds.total = 987;
  const std::string page = page_of(run, sample_description());
  const auto row = [](const std::string& what, const std::string& value, int frame) {
    return fmt::format(
        "<th scope=\"row\">{}</th><td class=\"number\">{}</td><td class=\"number\">{}</td>", what,
        value, frame);
  };
  EXPECT_TRUE(page.find(row("largest error of the position", "4.5 m", 123)) != page.npos);
  EXPECT_TRUE(page.find(row("fewest inliers", "12.5 %", 77)) != page.npos);
  EXPECT_TRUE(page.find(row("slowest", "987.00 ms", 55)) != page.npos);
}

TEST(Report, ShowsWarningsSkippedFramesAndInterruptions) {
  RunDescription description = sample_description();
  description.warnings = {"median depth 25 m"};
  test::SampleRun run = sample_run(20);
  run.log.skipped = {{.index = 7, .stamp = "1", .reason = "7.png: truncated"}};
  run.outcome.interrupted = true;
  const std::string page = page_of(run, description);
  for (const char* part :
       {"median depth 25 m", "Frame 7 skipped: 7.png: truncated", "Stopped by the user"})
    EXPECT_THAT(page, HasSubstr(part));
}

TEST(Report, IsAPageAlsoWithoutGroundTruthAndWithoutFrames) {
  test::SampleRun run = sample_run(20);
  run.outcome.evaluation.reset();
  run.outcome.no_evaluation = "no ground truth";
  std::string page = page_of(run, sample_description());
  EXPECT_THAT(page, Not(HasSubstr("Absolute error over time")));
  EXPECT_THAT(page, HasSubstr("no ground truth"));
  page = page_of({}, sample_description());
  EXPECT_THAT(page, HasSubstr("</html>"));
  EXPECT_THAT(page, Not(HasSubstr("nan")));
}

TEST(Report, StaysSmallForLongRuns) {
  EXPECT_LT(page_of(sample_run(30'000), sample_description()).size(), 3'000'000u);
}

TEST(Report, GivesItsScriptValidData) {
  const std::string page = page_of(sample_run(5000), sample_description());
  const std::string opening = "id=\"route\">";
  const std::size_t start = page.find(opening) + opening.size();
  const auto route =
      nlohmann::json::parse(page.substr(start, page.find("</script>", start) - start));
  EXPECT_GT(route.size(), 500u);
  EXPECT_LT(route.size(), 2000u);
  EXPECT_EQ(route[0].size(), 5u);
}

}  // namespace
}  // namespace edvo
