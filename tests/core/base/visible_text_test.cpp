#include "core/base/visible_text.hpp"

#include <gmock/gmock.h>

#include <random>

namespace feltwire::visible_text_test {
namespace {

TEST(VisibleText, OrdinaryTextStaysAsItIs) {
  for (const char* text : {"", "room", "K\u00fcche 2", "\u624b", "a\\b 'c' \"d\"", "\U0001F91A"})
    EXPECT_EQ(visible(text), text);
}

TEST(VisibleText, WhatATerminalObeysIsWrittenOut) {
  EXPECT_EQ(visible("a\x1b]0;owned\x07z"), "a\\x1b]0;owned\\x07z");
  EXPECT_EQ(visible(std::string_view("\0\t\r\n\x7f", 5)), "\\x00\\x09\\x0d\\x0a\\x7f");
  EXPECT_EQ(visible("\u009b31m"), "\\x9b31m");  // the one-byte form of ESC [
}

TEST(VisibleText, WhatMisleadsAReaderIsWrittenOut) {
  EXPECT_EQ(visible("room\u202egnp"), "room\\u{202e}gnp");
  EXPECT_EQ(visible("\u2066a\u200bb\ufeff\u2028\u00ad"),
            "\\u{2066}a\\u{200b}b\\u{feff}\\u{2028}\\xad");
}

TEST(VisibleText, WhatIsNotUtf8IsWrittenOutByteByByte) {
  EXPECT_EQ(visible("\xff"), "\\xff");
  EXPECT_EQ(visible("a\xc3"), "a\\xc3");         // The sequence ends too early.
  EXPECT_EQ(visible("\xc3("), "\\xc3(");         // The second byte is missing.
  EXPECT_EQ(visible("\xc0\x9b"), "\\xc0\\x9b");  // ESC in two bytes is not the shortest form.
  EXPECT_EQ(visible("\xe0\x82\x9b"), "\\xe0\\x82\\x9b");
  EXPECT_EQ(visible("\xed\xa0\x80"), "\\xed\\xa0\\x80");           // a surrogate
  EXPECT_EQ(visible("\xf4\x90\x80\x80"), "\\xf4\\x90\\x80\\x80");  // beyond the last code point
}

TEST(VisibleText, LinesStayWhereTheyAreWanted) {
  EXPECT_EQ(visible_lines("a\n\tb\x1b"), "a\n\\x09b\\x1b");
}

/// For any bytes the result must be UTF-8 without a control byte. A second pass must not change it.
TEST(VisibleText, AnyBytesComeOutPrintable) {
  std::mt19937 random(7);
  std::uniform_int_distribution<int> byte(0, 255), size(0, 40);
  for (int round = 0; round < 20000; ++round) {
    std::string text(static_cast<std::size_t>(size(random)), '\0');
    for (char& c : text) c = static_cast<char>(byte(random));
    const std::string shown = visible(text);
    ASSERT_EQ(visible(shown), shown);
    for (const char c : shown) {
      const auto b = static_cast<unsigned char>(c);
      ASSERT_TRUE(b >= 0x20 && b != 0x7f) << int{b};
    }
  }
}

}  // namespace
}  // namespace feltwire::visible_text_test
