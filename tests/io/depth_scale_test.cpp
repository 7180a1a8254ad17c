// SPDX-License-Identifier: MIT
#include "edvo/io/depth_scale.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <initializer_list>

namespace edvo {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

// One pixel of each value.
DepthValues values_of(std::initializer_list<int> values) {
  cv::Mat_<std::uint16_t> raw(1, static_cast<int>(values.size()));
  std::copy(values.begin(), values.end(), raw.begin());
  DepthValues all;
  add_image(all, raw);
  return all;
}

std::vector<std::string> warnings_of(std::initializer_list<int> values, double units_per_metre) {
  return check_depth(values_of(values), {units_per_metre, "as given"}).warnings;
}

TEST(DepthScale, MedianLeavesHolesAndSaturatedPixelsOut) {
  EXPECT_EQ(median_value(values_of({0, 3, 1, 2, 0, 65535})), 2);
  EXPECT_EQ(median_value(values_of({0, 0, 65535})), std::nullopt);
}

TEST(DepthScale, APlausibleOneIsNotWarnedOf) {
  EXPECT_THAT(warnings_of({0, 6000, 7500, 9000}, 5000), IsEmpty());
}

TEST(DepthScale, FindsTheLikelyScale) {
  // Millimetres, read as if one unit were a metre.
  EXPECT_THAT(warnings_of({1700, 1800, 1900}, 1), ElementsAre(HasSubstr("--depth-scale 1000")));
  // 2 m in TUM's units.
  EXPECT_THAT(warnings_of({9000, 10000, 11000}, 100), ElementsAre(HasSubstr("--depth-scale 5000")));
  // 2 m in KITTI's.
  EXPECT_THAT(warnings_of({500, 512, 524}, 10240), ElementsAre(HasSubstr("--depth-scale 256")));
}

TEST(DepthScale, AdvisesNothingThatItWouldWarnOf) {
  for (const double units : {0.01, 1.0, 100.0, 1000.0, 5000.0, 1e6})
    for (const int median : {1, 2, 5, 15, 19, 21, 50, 300, 1000, 5000, 20000, 60000})
      for (const std::string& warning : warnings_of({median - 1, median, median + 1}, units)) {
        const std::string flag = "--depth-scale ";
        const std::size_t at = warning.find(flag);
        if (at == std::string::npos) continue;
        const double metres = median / std::stod(warning.substr(at + flag.size()));
        EXPECT_GE(metres, 0.1) << warning;
        EXPECT_LE(metres, 20) << warning;
      }
}

TEST(DepthScale, WholeMetresAreToldByTheirValues) {
  const auto warnings = warnings_of({0, 1, 1, 2, 2, 2, 3, 4}, 5000);
  EXPECT_THAT(warnings, ElementsAre(AllOf(HasSubstr("values 1 to 4"), HasSubstr("fractions"),
                                          HasSubstr("--depth-scale 1"))));
  EXPECT_THAT(warnings_of({1, 2, 2, 3}, 1),
              ElementsAre(AllOf(HasSubstr("fractions"), Not(HasSubstr("--depth-scale")))));
}

TEST(DepthScale, DepthOfOneValueIsNoMeasurement) {
  EXPECT_THAT(warnings_of({0, 5000, 5000, 5000}, 5000),
              ElementsAre(AllOf(HasSubstr("has the same, 5000 (1 m)"), HasSubstr("measured"))));
}

TEST(DepthScale, AFarLimitThatFillsTheImageIsWarnedOf) {
  EXPECT_THAT(warnings_of({2000, 3000, 10000, 10000, 10000}, 1000),
              ElementsAre(AllOf(HasSubstr("60 % of the depths are the largest value, 10000"),
                                HasSubstr("selection.max_depth=9.9"))));
}

TEST(DepthScale, NoDepthAtAllIsWarnedOf) {
  EXPECT_THAT(warnings_of({0, 0, 0}, 5000), ElementsAre(HasSubstr("no pixel has a depth")));
  EXPECT_THAT(warnings_of({0, 65535}, 5000), ElementsAre(HasSubstr("all are 0 or 65535")));
}

TEST(DepthScale, SaturatedPixelsAreReadAsNoneAndThatIsSaid) {
  const DepthFindings findings =
      check_depth(values_of({5000, 6000, 7000, 65535}), {5000, "as given"});
  EXPECT_THAT(findings.notes, Contains(AllOf(HasSubstr("65535"), HasSubstr("25.0 %"))));
  EXPECT_THAT(findings.warnings, IsEmpty());
}

TEST(DepthScale, NamesTheUsualOneNearby) {
  EXPECT_EQ(nearest_usual_scale(1080), 1000);
  EXPECT_EQ(nearest_usual_scale(4700), 5000);
  EXPECT_EQ(nearest_usual_scale(2500), 2500);
}

}  // namespace
}  // namespace edvo
