#include "core/base/utf8.hpp"

#include <gtest/gtest.h>

namespace feltwire::utf8_test {
namespace {

TEST(Utf8, ATextIsWholeCharactersInTheirShortestForm) {
  for (const char* text : {"", "room", "K\u00fcche 2", "\u624b", "\U0001F91A", "a\nb"})
    EXPECT_TRUE(is_utf8(text)) << text;
  for (const char* text : {"\xff", "caf\xe9", "a\xc3", "\xc3(", "\xc0\x80", "\xed\xa0\x80",
                           "\xf4\x90\x80\x80", "\xe6\x89", "room\x80"})
    EXPECT_FALSE(is_utf8(text)) << text;
}

}  // namespace
}  // namespace feltwire::utf8_test
