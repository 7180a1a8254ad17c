// SPDX-License-Identifier: MIT
#include "edvo/core/stamp.hpp"

#include <gtest/gtest.h>

namespace edvo {
namespace {

TEST(Stamp, WritesWhatItRead) {
  for (const char* text : {"1305031102.175304", "0", "12", "-1.5", "1305031449.7996", "0.000000001",
                           "1.000", "1403636579.763555584"}) {
    const auto stamp = parse_stamp(text);
    ASSERT_TRUE(stamp) << text;
    EXPECT_EQ(to_string(*stamp), text);
  }
}

TEST(Stamp, KeepsNanosecondsThatADoubleWouldLose) {
  EXPECT_EQ(parse_stamp("1403636579.763555584")->nanoseconds, 1403636579763555584);
}

TEST(Stamp, ReadsExponentsAsWrittenByNumpySavetxt) {
  EXPECT_EQ(parse_stamp("1.305031102175304000e+09")->nanoseconds, 1305031102175304000);
}

TEST(Stamp, RefusesWhatIsNotATime) {
  for (const char* text : {"", "-", ".", "nan", "inf", "1.2.3", "12a", "1e300", "99999999999999"})
    EXPECT_FALSE(parse_stamp(text)) << text;
}

TEST(Stamp, DifferencesAreExactAtAnyEpoch) {
  EXPECT_DOUBLE_EQ(
      seconds_between(*parse_stamp("1305031102.175304"), *parse_stamp("1305031102.175305")), 1e-6);
}

}  // namespace
}  // namespace edvo
