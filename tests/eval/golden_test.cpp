// SPDX-License-Identifier: MIT
// The figures of the TUM scripts and of evo on evo's public test files, to the last printed digit.
#include "edvo/eval/evaluate.hpp"
#include "edvo/io/trajectory_file.hpp"

#include "support/shared_data.hpp"

#include <fmt/core.h>
#include <gtest/gtest.h>

namespace edvo {
namespace {

struct Files {
  Trajectory truth, estimate;
};

std::filesystem::path folder() {
  return test::shared_data() / "evaluation";
}

Files files() {
  return {.truth = read_trajectory(folder() / "fr2_desk_groundtruth.txt").trajectory,
          .estimate = read_trajectory(folder() / "fr2_desk_ORB.txt").trajectory};
}

std::string printed(double value, int decimals) {
  return fmt::format("{:.{}f}", value, decimals);
}

Evaluation evaluated(Protocol protocol, double max_difference, const char* delta) {
  const Files f = files();
  return evaluate(
      f.truth, f.estimate,
      {.association = {.protocol = protocol, .max_difference = max_difference, .offset = 0},
       .alignment = AlignmentKind::kSe3,
       .rpe = {.delta = parse_delta(delta)}});
}

TEST(Golden, TumAte) {
  EDVO_REQUIRE_SHARED(folder());
  const Evaluation wide = evaluated(Protocol::kTum, 0.02, "1s");
  EXPECT_EQ(wide.matches.size(), 2223u);
  EXPECT_EQ(printed(wide.ate.distance.rmse, 6), "0.008144");
  const Evaluation narrow = evaluated(Protocol::kTum, 0.01, "1s");
  EXPECT_EQ(narrow.matches.size(), 2174u);
  EXPECT_EQ(printed(narrow.ate.distance.rmse, 6), "0.008119");
}

TEST(Golden, TumRpe) {
  EDVO_REQUIRE_SHARED(folder());
  struct Row {
    const char* delta;
    std::size_t pairs;
    const char *translation, *rotation;
  };
  for (const Row& row :
       {Row{"1s", 1998, "0.007161", "0.455005"}, Row{"1f", 2060, "0.003381", "0.266378"},
        Row{"30f", 1995, "0.007213", "0.459717"}}) {
    const Evaluation evaluation = evaluated(Protocol::kTum, 0.02, row.delta);
    ASSERT_TRUE(evaluation.rpe);
    EXPECT_EQ(evaluation.rpe->errors.size(), row.pairs) << row.delta;
    EXPECT_EQ(printed(evaluation.rpe->translation.rmse, 6), row.translation) << row.delta;
    EXPECT_EQ(printed(evaluation.rpe->rotation.rmse, 6), row.rotation) << row.delta;
  }
}

TEST(Golden, TumRpeOverAllPairsIsNearTheUnseededOriginal) {
  EDVO_REQUIRE_SHARED(folder());
  const Evaluation evaluation = evaluated(Protocol::kTum, 0.02, "all");
  ASSERT_TRUE(evaluation.rpe);
  EXPECT_NEAR(evaluation.rpe->translation.rmse, 0.0374, 0.0008);
}

TEST(Golden, Evo) {
  EDVO_REQUIRE_SHARED(folder());
  const Evaluation narrow = evaluated(Protocol::kEvo, 0.01, "1f");
  EXPECT_EQ(narrow.matches.size(), 2174u);
  EXPECT_EQ(printed(narrow.ate.distance.rmse, 7), "0.0081190");
  ASSERT_TRUE(narrow.rpe);
  EXPECT_EQ(narrow.rpe->errors.size(), 2173u);
  EXPECT_EQ(printed(narrow.rpe->translation.rmse, 7), "0.0034903");
  EXPECT_EQ(printed(narrow.rpe->rotation.rmse, 4), "0.2805");
  const Evaluation wide = evaluated(Protocol::kEvo, 0.02, "1f");
  EXPECT_EQ(wide.matches.size(), 2225u);
  EXPECT_EQ(printed(wide.ate.distance.rmse, 7), "0.0081460");
}

}  // namespace
}  // namespace edvo
