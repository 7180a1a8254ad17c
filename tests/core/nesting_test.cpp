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

std::optional<int> toml_fault_line(std::string_view text) {
  const auto fault = fault_in_toml(text);
  return fault ? std::optional(fault->line) : std::nullopt;
}

TEST(Nesting, OrdinaryTomlPasses) {
  const std::string text = "a.b.c = 1 # [[[[\n[group.sub]\nx = [[1.5, 2.5], [{y = 3}]]\n" +
                           repeated("[[list.item]]\nv = 1.0\n", 1000) + "long = [" +
                           repeated("0.5,", 1000) + "]\n";
  EXPECT_FALSE(toml_fault_line(text));
}

TEST(Nesting, DottedKeysCountInTableNamesAndValuesAlike) {
  const std::string deep = repeated("a.", 40'000) + "a";
  EXPECT_EQ(toml_fault_line("x = 1\n" + deep + " = 1"), 2);
  EXPECT_EQ(toml_fault_line("[" + deep + "]"), 1);
  EXPECT_EQ(toml_fault_line("x = {" + deep + " = 1}"), 1);
  EXPECT_EQ(toml_fault_line(repeated("\"a\" . ", 100) + "a = 1"), 1);
  EXPECT_EQ(toml_fault_line(repeated("'#'.", 100) + "a = 1"), 1);
}

TEST(Nesting, BracketsAndBracesCountTogether) {
  EXPECT_EQ(toml_fault_line("x = " + repeated("[", 300'000)), 1);
  EXPECT_EQ(toml_fault_line("x = " + repeated("[{a=", 20)), 1);
  EXPECT_EQ(line_nested_too_deeply_in_json("\n" + repeated("[", 300'000)), 2);
  EXPECT_EQ(line_nested_too_deeply_in_json(repeated("{\"a\":[", 20)), 1);
}

TEST(Nesting, StringsHideWhatIsInThem) {
  const std::string brackets = repeated("[", 100), dots = repeated("a.", 100);
  for (const char* const quote : {"\"", "'", "\"\"\"", "'''"})
    EXPECT_FALSE(toml_fault_line(std::string("x = ") + quote + brackets + dots + quote + "\n"))
        << quote;
  EXPECT_FALSE(toml_fault_line("x = \"\\\"" + brackets + "\""));
  EXPECT_FALSE(line_nested_too_deeply_in_json("{\"a\": \"\\\"" + brackets + "\"}"));
}

TEST(Nesting, AStringWithoutItsEndHidesNothingBehindItsLine) {
  EXPECT_EQ(toml_fault_line("x = \"\n" + repeated("[", 100)), 2);
}

TEST(Toml, NeedsAsciiOutsideOfQuotesAndComments) {
  for (const char* const text : {"\n\u00E9 = 1", "# \u00E9\na = \u00E9", "a = 'x'\nb\uFEBF = 2"}) {
    const auto fault = fault_in_toml(text);
    ASSERT_TRUE(fault) << text;
    EXPECT_EQ(fault->line, 2) << text;
    EXPECT_NE(fault->what.find("not ASCII"), std::string_view::npos);
  }
  EXPECT_FALSE(fault_in_toml("\uFEFF# caf\u00E9\na = \"caf\u00E9\" # \u00E9\n'\u00E9' = 1\n"));
}

}  // namespace
}  // namespace edvo
