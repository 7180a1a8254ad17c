// SPDX-License-Identifier: MIT
#include "edvo/report/table.hpp"

#include <gtest/gtest.h>

namespace edvo {
namespace {

Table small_table() {
  return {.header = {"name", "error [%]"}, .rows = {{"a_b", "1.5"}, {"c|d, \"e\"", "10.25"}}};
}

TEST(Table, LinesUpAsText) {
  EXPECT_EQ(format_table(small_table(), TableFormat::kText),
            "name      error [%]\n"
            "a_b             1.5\n"
            "c|d, \"e\"      10.25\n");
}

TEST(Table, CountsCharactersNotBytes) {
  const Table table{.header = {"a", "b"}, .rows = {{"\xC3\xA4", "1"}}};
  EXPECT_EQ(format_table(table, TableFormat::kText), "a  b\n\xC3\xA4  1\n");
}

TEST(Table, EscapesBarsInMarkdown) {
  EXPECT_EQ(format_table(small_table(), TableFormat::kMarkdown),
            "| name      | error [%] |\n"
            "|-----------|----------:|\n"
            "| a_b       |       1.5 |\n"
            "| c\\|d, \"e\" |     10.25 |\n");
}

TEST(Table, QuotesInCsv) {
  EXPECT_EQ(format_table(small_table(), TableFormat::kCsv),
            "name,error [%]\na_b,1.5\n\"c|d, \"\"e\"\"\",10.25\n");
}

TEST(Table, EscapesInLatex) {
  const std::string text = format_table(small_table(), TableFormat::kLatex);
  EXPECT_NE(text.find("\\begin{tabular}{lr}"), std::string::npos);
  EXPECT_NE(text.find("name & error [\\%] \\\\"), std::string::npos);
  EXPECT_NE(text.find("a\\_b & 1.5 \\\\"), std::string::npos);
}

TEST(Table, NotesAreCommentsWhereTheFormatHasThem) {
  EXPECT_EQ(format_note("x", TableFormat::kText), "x\n");
  EXPECT_EQ(format_note("x", TableFormat::kCsv), "# x\n");
  EXPECT_EQ(format_note("x", TableFormat::kLatex), "% x\n");
}

}  // namespace
}  // namespace edvo
