#include "server/web/viewer_message.hpp"

#include <gtest/gtest.h>

#include <string>

namespace feltwire::web::viewer_message_test {
namespace {

TEST(ViewerMessage, ReadsItsMembers) {
  EXPECT_EQ(parse_viewer_message(R"({"token":"fw_1"})")->token, "fw_1");
  EXPECT_EQ(parse_viewer_message(R"({"watch":"room","more":[1,{"watch":"x"}]})")->watch, "room");
  EXPECT_FALSE(parse_viewer_message(R"({"a":{"token":"fw_1"}})")->token);
  EXPECT_FALSE(parse_viewer_message(R"({"token":7})")->token);
  EXPECT_FALSE(parse_viewer_message("{}")->watch);
}

TEST(ViewerMessage, RefusesWhatIsNoObject) {
  for (const std::string& wrong :
       {std::string(), std::string("7"), std::string("\"token\""), std::string("[]"),
        std::string("[{}]"), std::string("{"), std::string("{}{}"), std::string("null"),
        std::string(2000, '['), "{\"a\":" + std::string(2000, '[')})
    EXPECT_FALSE(parse_viewer_message(wrong)) << wrong;
}

}  // namespace
}  // namespace feltwire::web::viewer_message_test
