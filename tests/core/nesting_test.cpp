// SPDX-License-Identifier: MIT
#include "edvo/core/nesting.hpp"

#include "edvo/core/parse_toml.hpp"

#include <gtest/gtest.h>

#include <algorithm>
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
  EXPECT_FALSE(fault_in_toml("# caf\u00E9\na = \"caf\u00E9\" # \u00E9\n'\u00E9' = 1\n"));
}

TEST(Toml, IsReadTheSameAsBeforeItsCharactersAreEscaped) {
  const toml::table table = parse_toml(
      "\uFEFF# caf\u00E9\n'\u00E9' = 1\na = \"x\u00E9\\n\" # \u00E9\nb = 'C:\\\u00E9\"'\n"
      "c = \"\"\"\n\U0001F600 \"two\"\nlines\"\"\"\nd = '''\n\u00FC\\n'''\ne = 'plain\\'\n",
      "my.toml", ErrorCode::kConfig);
  EXPECT_EQ(table["\u00E9"].value<int>(), 1);
  EXPECT_EQ(table["a"].value<std::string>(), "x\u00E9\n");
  EXPECT_EQ(table["b"].value<std::string>(), "C:\\\u00E9\"");
  EXPECT_EQ(table["c"].value<std::string>(), "\U0001F600 \"two\"\nlines");
  EXPECT_EQ(table["d"].value<std::string>(), "\u00FC\\n");
  EXPECT_EQ(table["e"].value<std::string>(), "plain\\");
  EXPECT_EQ(table["e"].node()->source().begin.line, 10U);
}

TEST(Toml, LeavesTheParserNothingButAscii) {
  for (const char* const text : {"a = 5[[\"\"\"\uFEBF1", "a = 5='\uFEBF", "a = \"\\\uFEBF\"",
                                 "a = \"\xBF\"", "a = '\xE9", "# \xE9"}) {
    const std::string ascii = toml_in_ascii(text);
    EXPECT_TRUE(std::all_of(ascii.begin(), ascii.end(), [](char c) { return c > 0; })) << text;
    if (text[0] != '#') {
      EXPECT_THROW((void)parse_toml(text, "my.toml", ErrorCode::kConfig), Error) << text;
    }
  }
}

}  // namespace
}  // namespace edvo
