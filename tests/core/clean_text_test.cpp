// SPDX-License-Identifier: MIT
#include "edvo/core/clean_text.hpp"

#include <gtest/gtest.h>

namespace edvo {
namespace {

TEST(CleanText, KeepsTextOfAnyLanguage) {
  const std::string text = "a\tb\n\xC3\xA4 \xE4\xB8\xAD \xF0\x9F\x98\x80";
  EXPECT_EQ(clean_text(text), text);
}

TEST(CleanText, TakesWhatControlsATerminal) {
  EXPECT_EQ(clean_text("a\x1b[31m\r\x07\x7f"), "a?[31m???");
  EXPECT_EQ(clean_text("\xC2\x9B"
                       "31m"),
            "?31m");  // C1's CSI
  EXPECT_EQ(clean_text("a\xE2\x80\xAE"
                       "txt.exe"),
            "a?txt.exe");  // right-to-left override
  EXPECT_EQ(clean_text(std::string_view("a\0b", 3)), "a?b");
}

TEST(CleanText, TakesBytesThatAreNoUtf8) {
  EXPECT_EQ(clean_text("\xE4"
                       "b"),
            "?b");                                    // Latin-1
  EXPECT_EQ(clean_text("\xC0\xAF"), "??");            // overlong
  EXPECT_EQ(clean_text("\xED\xA0\x80"), "???");       // surrogate
  EXPECT_EQ(clean_text("\xF4\x90\x80\x80"), "????");  // beyond Unicode
  EXPECT_EQ(clean_text("\xE4\xB8"), "??");            // cut off
}

}  // namespace
}  // namespace edvo
