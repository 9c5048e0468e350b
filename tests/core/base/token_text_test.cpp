#include "core/base/token_text.hpp"

#include <gtest/gtest.h>

namespace feltwire::token_text_test {
namespace {

const std::string kToken = "fw_ce78c23a9528_3SHVXhD4MlOFA_Q4ltcJY5PYj2j7GPWiUL0HuEBogIo";

TEST(TokenText, FindsATokenAnywhere) {
  EXPECT_TRUE(has_token(kToken));
  EXPECT_TRUE(has_token("anna" + kToken));
  EXPECT_TRUE(has_token("fw_fw_" + kToken));
  EXPECT_TRUE(has_token("fw_ce78c23a9528_")) << "cut off by a careless copy";
  for (const char* other :
       {"", "fw_", "room", "fw_room", "fw_ce78c23a9528", "fw_CE78C23A9528_x", "fw_ce78c23a952_8"})
    EXPECT_FALSE(has_token(other)) << other;
}

TEST(TokenText, ShowsNone) {
  EXPECT_EQ(without_tokens("'" + kToken + "' here"), "'fw_...' here");
  EXPECT_EQ(without_tokens("anna" + kToken + " (simulated)"), "annafw_... (simulated)");
  EXPECT_EQ(without_tokens("--" + kToken), "--fw_...");
  EXPECT_EQ(without_tokens("page/#token=" + kToken + "\n"), "page/#token=fw_...\n");
  EXPECT_EQ(without_tokens("a=fw_short, b"), "a=fw_..., b") << "a word that begins as one does";
  EXPECT_EQ(without_tokens("scene 'my_fw_room'"), "scene 'my_fw_room'");
}

}  // namespace
}  // namespace feltwire::token_text_test
