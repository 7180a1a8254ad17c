// SPDX-License-Identifier: MIT
#include "edvo/report/html_space.hpp"

#include "report/sample_run.hpp"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

namespace edvo {
namespace {

using nlohmann::json;
using test::sample_run;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

Trajectory two_poses() {
  return {{stamp_from_seconds(1), {.translation = {1, 2, 3}}},
          {stamp_from_seconds(2), {.translation = {4, 5, 6}}}};
}

json data_of(const std::string& card) {
  const std::string opening = "<script type=\"application/json\">";
  const std::size_t begin = card.find(opening) + opening.size();
  return json::parse(card.substr(begin, card.find("</script>", begin) - begin));
}

TEST(SpaceCard, GivesItsScriptThePositionsWithUpAsTheSecondCoordinate) {
  const std::string card =
      space_card({{.name = "a", .color = "#123456", .trajectory = two_poses()}}, -1, "caption");
  const json lines = data_of(card);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_EQ(lines[0]["name"], "a");
  EXPECT_EQ(lines[0]["dots"], false);
  EXPECT_THAT(lines[0]["points"], ElementsAre(json({1, -2, 3}), json({4, -5, 6})));
}

TEST(SpaceCard, HasAPictureForPagesWithoutScripts) {
  const std::string card =
      space_card({{.name = "a", .color = "#123456", .trajectory = two_poses()}}, -1, "caption");
  EXPECT_THAT(card, HasSubstr("<svg"));
  EXPECT_THAT(card, HasSubstr("class=\"series\""));
  EXPECT_THAT(card, HasSubstr("caption"));
}

TEST(SpaceCard, InterruptsTheLineWhereTrackingWasLost) {
  const Timeline timeline{.start = stamp_from_seconds(1), .range = {0, 1}, .lost = {{0.4, 0.6}}};
  const json lines = data_of(space_card(
      {{.name = "a", .color = "#123456", .trajectory = two_poses(), .interrupted_by = &timeline}},
      -1, ""));
  ASSERT_EQ(lines[0]["points"].size(), 3u);
  EXPECT_TRUE(lines[0]["points"][1].is_null());
}

TEST(SpaceCard, StaysSmallForLongRunsAndIsEmptyWithoutPoses) {
  const test::SampleRun run = sample_run(30'000);
  const std::string card =
      space_card({{.name = "a", .color = "#123456", .trajectory = run.outcome.trajectory}}, -1, "");
  EXPECT_LT(card.size(), 200'000u);
  EXPECT_THAT(space_card({{.name = "a", .color = "#123456", .trajectory = {}}}, -1, ""), IsEmpty());
}

TEST(SpaceCard, TakesNoMarkupFromNames) {
  const std::string name = "</script><script>alert(\"x\")</script>";
  const std::string card =
      space_card({{.name = name, .color = "#123456", .trajectory = two_poses()}}, -1, "");
  EXPECT_THAT(card, Not(HasSubstr("<script>alert")));
  EXPECT_EQ(data_of(card)[0]["name"], name);
}

}  // namespace
}  // namespace edvo
