// SPDX-License-Identifier: MIT
#include "edvo/eval/associate.hpp"

#include "support/paths.hpp"

#include <gmock/gmock.h>

namespace edvo {
namespace {

using test::stamp_at;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

using Indices = std::pair<std::size_t, std::size_t>;

Trajectory at(const std::vector<std::int64_t>& milliseconds) {
  Trajectory trajectory;
  for (const std::int64_t ms : milliseconds)
    trajectory.push_back({.stamp = stamp_at(ms), .world_from_camera = {}});
  return trajectory;
}

std::vector<Indices> matches(const std::vector<std::int64_t>& truth,
                             const std::vector<std::int64_t>& estimate,
                             const AssociateOptions& options) {
  std::vector<Indices> pairs;
  for (const Match& match : associate(at(truth), at(estimate), options))
    pairs.emplace_back(match.truth, match.estimate);
  return pairs;
}

TEST(Associate, TakesTheClosestPairFirst) {
  // 1000 is close to both estimates; the closer one gets it, the other one goes without.
  EXPECT_THAT(matches({1000}, {990, 1005}, {}), ElementsAre(Indices{0, 1}));
}

TEST(Associate, GivesTheLoserOfAPairItsSecondChoice) {
  EXPECT_THAT(matches({1000, 1012}, {1003, 1001}, {}), ElementsAre(Indices{0, 1}, Indices{1, 0}));
}

TEST(Associate, LeavesOutWhatIsTooFarApart) {
  EXPECT_THAT(matches({1000, 2000}, {1019, 2021}, {}), ElementsAre(Indices{0, 0}));
}

TEST(Associate, AddsTheOffsetToTheEstimate) {
  EXPECT_THAT(matches({1000, 1100}, {0, 100}, {.offset = 1.0}),
              ElementsAre(Indices{0, 0}, Indices{1, 1}));
  EXPECT_THAT(matches({1000, 1100}, {0, 100}, {}), IsEmpty());
}

TEST(Associate, FindsNothingInNothing) {
  EXPECT_THAT(matches({}, {1, 2}, {}), IsEmpty());
  EXPECT_THAT(matches({1, 2}, {}, {.protocol = Protocol::kEvo}), IsEmpty());
}

TEST(Associate, EvoTakesTheNearestOneMoreThanOnce) {
  const AssociateOptions evo{.protocol = Protocol::kEvo};
  EXPECT_THAT(matches({1000, 5000, 6000}, {990, 1005}, evo),
              ElementsAre(Indices{0, 0}, Indices{0, 1}));
}

TEST(Associate, EvoStartsFromTheShorterTrajectory) {
  const AssociateOptions evo{.protocol = Protocol::kEvo, .offset = -1.0};
  EXPECT_THAT(matches({0, 10}, {990, 1000, 1009, 1020}, evo),
              ElementsAre(Indices{0, 1}, Indices{1, 2}));
}

TEST(Associate, StampsBecomeTheDoublesThatTheirTextMeans) {
  for (const char* text : {"1311868164.363181", "1305031102.1758", "1403636579.763555584", "0.1"})
    EXPECT_EQ(script_stamps({{.stamp = *parse_stamp(text), .world_from_camera = {}}})[0],
              std::stod(text))
        << text;
}

}  // namespace
}  // namespace edvo
