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

// A name in a cell, between its two separators.
std::string cell_of(const std::string& name, TableFormat format) {
  const std::string text = format_table({.header = {"h", "n"}, .rows = {{"r", name}}}, format);
  const std::string separator = format == TableFormat::kLatex ? "r & " : "| r | ";
  const std::size_t begin = text.rfind(separator) + separator.size();
  const std::size_t end = text.find(format == TableFormat::kLatex ? " \\\\" : " |\n", begin);
  return text.substr(begin, end - begin);
}

TEST(Table, EscapesWhatIsMarkupInMarkdown) {
  const auto cell = [](const std::string& name) { return cell_of(name, TableFormat::kMarkdown); };
  EXPECT_EQ(cell("<script>"), "\\<script\\>");
  EXPECT_EQ(cell("a\\|b`c`*d*"), "a\\\\\\|b\\`c\\`\\*d\\*");
  EXPECT_EQ(cell("[a](http://x)"), "\\[a](http://x)");
  EXPECT_EQ(cell("_a_b_"), "\\_a_b\\_");
  EXPECT_EQ(cell("&lt;~~x~~"), "\\&lt;\\~\\~x\\~\\~");
  EXPECT_EQ(cell("two\nlines\x1b"), "two lines?");
}

TEST(Table, EscapesWhatIsMarkupInLatex) {
  const auto cell = [](const std::string& name) { return cell_of(name, TableFormat::kLatex); };
  EXPECT_EQ(cell("a\\input{x}"), "a\\textbackslash{}input\\{x\\}");
  EXPECT_EQ(cell("~^<>"), "\\textasciitilde{}\\textasciicircum{}\\textless{}\\textgreater{}");
  EXPECT_EQ(cell("two\n\nlines"), "two  lines");
  EXPECT_EQ(format_note("x\n\\input{y}", TableFormat::kLatex), "% x \\input{y}\n");
}

TEST(Table, NotesAreCommentsWhereTheFormatHasThem) {
  EXPECT_EQ(format_note("x", TableFormat::kText), "x\n");
  EXPECT_EQ(format_note("x", TableFormat::kCsv), "# x\n");
  EXPECT_EQ(format_note("x", TableFormat::kLatex), "% x\n");
}

TEST(Table, CommandsStayAsTheyAreTyped) {
  EXPECT_EQ(format_command("by: ", "a && b < c", TableFormat::kMarkdown), "\nby: `a && b < c`\n\n");
  EXPECT_EQ(format_command("by: ", "a `b`", TableFormat::kMarkdown), "\nby: a \\`b\\`\n\n");
  EXPECT_EQ(format_command("by: ", "a && b", TableFormat::kText), "by: a && b\n");
}

}  // namespace
}  // namespace edvo
