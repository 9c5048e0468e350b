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

TEST(ViewerMessage, ReadsWhereTheHandShallBe) {
  const auto point = [](const std::string& text) { return parse_viewer_message(text)->point; };
  EXPECT_EQ(point(R"({"point":[0.5,-1,2e-3]})"), Vec3(0.5, -1, 2e-3));
  EXPECT_EQ(point(R"({"more":[1,2,3,4],"point":[1,2,3],"other":[7]})"), Vec3(1, 2, 3));
  EXPECT_FALSE(point(R"({"a":{"point":[1,2,3]}})"));
  EXPECT_FALSE(point(R"({"point":7})"));
  for (const char* wrong : {R"({"point":[]})", R"({"point":[1,2]})", R"({"point":[1,2,3,4]})",
                            R"({"point":["1","2","3"]})", R"({"point":[[1,2,3]]})"}) {
    ASSERT_TRUE(point(wrong)) << wrong;
    EXPECT_FALSE(point(wrong)->allFinite()) << wrong;
  }
  EXPECT_FALSE(parse_viewer_message(R"({"point":[NaN,0,0]})"));
  EXPECT_FALSE(parse_viewer_message(R"({"point":[1e999,0,0]})"));
  EXPECT_EQ(parse_viewer_message(R"({"hand":"take"})")->hand, "take");
  EXPECT_FALSE(parse_viewer_message(R"({"hand":"take"})")->mode);
  EXPECT_EQ(parse_viewer_message(R"({"hand":"take","mode":"per_axis"})")->mode, "per_axis");
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
