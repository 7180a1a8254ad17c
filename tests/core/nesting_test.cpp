// SPDX-License-Identifier: MIT
#include "edvo/core/nesting.hpp"

#include <gtest/gtest.h>

#include <string>

namespace edvo {
namespace {

std::string repeated(std::string_view part, int times) {
  std::string text;
  for (int i = 0; i < times; ++i) text += part;
  return text;
}

TEST(Nesting, OrdinaryTomlPasses) {
  const std::string text = "a.b.c = 1 # [[[[\n[group.sub]\nx = [[1.5, 2.5], [{y = 3}]]\n" +
                           repeated("[[list.item]]\nv = 1.0\n", 1000) + "long = [" +
                           repeated("0.5,", 1000) + "]\n";
  EXPECT_FALSE(line_nested_too_deeply_in_toml(text));
}

TEST(Nesting, DottedKeysCountInTableNamesAndValuesAlike) {
  const std::string deep = repeated("a.", 40'000) + "a";
  EXPECT_EQ(line_nested_too_deeply_in_toml("x = 1\n" + deep + " = 1"), 2);
  EXPECT_EQ(line_nested_too_deeply_in_toml("[" + deep + "]"), 1);
  EXPECT_EQ(line_nested_too_deeply_in_toml("x = {" + deep + " = 1}"), 1);
  EXPECT_EQ(line_nested_too_deeply_in_toml(repeated("\"a\" . ", 100) + "a = 1"), 1);
  EXPECT_EQ(line_nested_too_deeply_in_toml(repeated("'#'.", 100) + "a = 1"), 1);
}

TEST(Nesting, BracketsAndBracesCountTogether) {
  EXPECT_EQ(line_nested_too_deeply_in_toml("x = " + repeated("[", 300'000)), 1);
  EXPECT_EQ(line_nested_too_deeply_in_toml("x = " + repeated("[{a=", 20)), 1);
  EXPECT_EQ(line_nested_too_deeply_in_json("\n" + repeated("[", 300'000)), 2);
  EXPECT_EQ(line_nested_too_deeply_in_json(repeated("{\"a\":[", 20)), 1);
}

TEST(Nesting, StringsHideWhatIsInThem) {
  const std::string brackets = repeated("[", 100), dots = repeated("a.", 100);
  for (const char* const quote : {"\"", "'", "\"\"\"", "'''"})
    EXPECT_FALSE(line_nested_too_deeply_in_toml(std::string("x = ") + quote + brackets + dots +
                                                quote + "\n"))
        << quote;
  EXPECT_FALSE(line_nested_too_deeply_in_toml("x = \"\\\"" + brackets + "\""));
  EXPECT_FALSE(line_nested_too_deeply_in_json("{\"a\": \"\\\"" + brackets + "\"}"));
}

TEST(Nesting, AStringWithoutItsEndHidesNothingBehindItsLine) {
  EXPECT_EQ(line_nested_too_deeply_in_toml("x = \"\n" + repeated("[", 100)), 2);
}

}  // namespace
}  // namespace edvo
