// SPDX-License-Identifier: MIT
#include "edvo/report/comparison.hpp"

#include "report/sample_run.hpp"

#include <gmock/gmock.h>

namespace edvo {
namespace {

using test::sample_description;
using test::sample_run;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

StoredRun stored(const std::string& folder, std::int64_t frames = 100) {
  test::SampleRun run = sample_run(frames);
  return {.folder = folder,
          .summary = summarize(sample_description(), run.log, run.outcome),
          .log = run.log,
          .outcome = run.outcome};
}

// The points of a line in the plot of a title.
std::string line_in(const std::string& page, const std::string& figure, const std::string& name) {
  const std::size_t title = page.find("<title>" + name + "</title>", page.find(figure));
  const std::size_t begin = page.rfind("d=\"", title) + 3;
  return page.substr(begin, page.find('"', begin) - begin);
}

TEST(ShortNames, AreTheLastPartsOfFoldersOrTheFoldersThemselves) {
  EXPECT_THAT(short_names({stored("runs/a/"), stored("runs/b")}), ElementsAre("a", "b"));
  EXPECT_THAT(short_names({stored("x/latest"), stored("y/latest")}),
              ElementsAre("x/latest", "y/latest"));
}

TEST(Comparison, ShowsTheNumbersOfEachRunInOneTableAndItsLinesInTheSamePlots) {
  StoredRun first = stored("one"), second = stored("two");
  second.summary.evaluation->final_poses.ate = 0.0456;
  second.summary.run.method = "cnn+corner";
  const std::string page = comparison_page({first, second});
  for (const char* part :
       {"Comparison of 2 runs", "1.23", "4.56", "canny+corner", "cnn+corner", "100 of 100",
        "From above", "Absolute error over time", "Time per frame"})
    EXPECT_THAT(page, HasSubstr(part));
  for (const char* figure : {"From above", "From the side", "Absolute error over time",
                             "Relative error over time: rotation", "Inliers", "Time per frame"})
    for (const char* name : {"one", "two"})
      EXPECT_THAT(line_in(page, std::string("<h2>") + figure, name), HasSubstr("M")) << figure;
}

TEST(Comparison, LaysRunsOnEachOtherByTheirGroundTruth) {
  const StoredRun first = stored("one");
  StoredRun second = stored("two");
  // The same run, as seen from another world.
  const SE3 other{.translation = {3, -1, 7}};
  for (StampedPose& pose : second.outcome.trajectory)
    pose.world_from_camera = other * pose.world_from_camera;
  for (StampedPose& pose : second.summary.evaluation->truth)
    pose.world_from_camera = other * pose.world_from_camera;
  const std::string page = comparison_page({first, second});
  EXPECT_EQ(line_in(page, "<h2>From above", "one"), line_in(page, "<h2>From above", "two"));
  second.summary.evaluation.reset();
  const std::string apart = comparison_page({first, second});
  EXPECT_NE(line_in(apart, "<h2>From above", "one"), line_in(apart, "<h2>From above", "two"));
  EXPECT_THAT(apart, HasSubstr("each in the frame of its own first camera"));
}

TEST(Comparison, SaysWhereRunsAreOfDifferentSequencesOrNotWhole) {
  StoredRun second = stored("two");
  second.summary.run.sequence = "freiburg1_desk";
  second.missing = {"no report.html"};
  const std::string page = comparison_page({stored("one"), second});
  EXPECT_THAT(page, HasSubstr("two: another sequence (freiburg1_desk)"));
  EXPECT_THAT(page, HasSubstr("two: no report.html"));
}

TEST(Comparison, NeedsNoNetworkAndTakesNoMarkupFromNames) {
  StoredRun run = stored("<script>alert(1)</script>");
  run.summary.run.sequence = run.summary.run.method = run.summary.run.command = "<b>name</b>";
  const std::string page = comparison_page({run, stored("two")});
  for (const char* part :
       {"src=", "@import", "url(", "<link", "fetch(", "<script>alert", "<b>name"})
    EXPECT_THAT(page, Not(HasSubstr(part)));
}

TEST(Comparison, IsAPageAlsoOfRunsWithoutFrames) {
  const StoredRun empty{.folder = "empty", .summary = summarize(sample_description(), {}, {})};
  const std::string page = comparison_page({empty, stored("two")});
  EXPECT_THAT(page, HasSubstr("</html>"));
  EXPECT_THAT(page, Not(HasSubstr("nan")));
}

}  // namespace
}  // namespace edvo
