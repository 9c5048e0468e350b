// Tests messages of the Foxglove WebSocket protocol against its specification.

#include "server/web/foxglove_messages.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace feltwire::web {
namespace {

using Json = nlohmann::json;

TEST(FoxgloveMessages, WhatIsSaidFirst) {
  const Json info = Json::parse(foxglove_server_info("a \"room\""));
  EXPECT_EQ(info["op"], "serverInfo");
  EXPECT_EQ(info["capabilities"], Json::array());
  EXPECT_EQ(info["metadata"]["scene"], "a \"room\"");
  const Json offered = Json::parse(foxglove_advertisement());
  EXPECT_EQ(offered["op"], "advertise");
  ASSERT_EQ(offered["channels"].size(), kFoxgloveChannels);
  for (std::size_t i = 0; i < kFoxgloveChannels; ++i) {
    const Json& channel = offered["channels"][i];
    EXPECT_EQ(channel["id"], i);
    EXPECT_EQ(channel["encoding"], "protobuf");
    EXPECT_EQ(channel["schemaEncoding"], "protobuf");
    EXPECT_EQ(channel["schema"].get<std::string>().size() % 4, 0u) << "base64 is padded";
  }
  EXPECT_EQ(offered["channels"][3]["schemaName"], "feltwire.Hands");
}

TEST(FoxgloveMessages, TheBeginOfData) {
  const Bytes expected = {1, 4, 3, 2, 1, 8, 7, 6, 5, 4, 3, 2, 1};
  EXPECT_EQ(foxglove_data_head(0x01020304, 0x0102030405060708), expected);
}

TEST(FoxgloveMessages, Status) {
  EXPECT_EQ(Json::parse(foxglove_status(FoxgloveLevel::error, "no")),
            Json({{"op", "status"}, {"level", 2}, {"message", "no"}}));
}

TEST(FoxgloveMessages, Requests) {
  const auto wanted = parse_foxglove_request(
      R"({"op":"subscribe","subscriptions":[{"id":7,"channelId":2},{"channelId":1,"id":4294967295}]})");
  ASSERT_TRUE(wanted);
  EXPECT_EQ(wanted->operation, "subscribe");
  ASSERT_EQ(wanted->subscriptions.size(), 2u);
  EXPECT_EQ(wanted->subscriptions[0].id, 7u);
  EXPECT_EQ(wanted->subscriptions[0].channel, 2u);
  EXPECT_EQ(wanted->subscriptions[1].id, 4294967295u);
  EXPECT_EQ(wanted->subscriptions[1].channel, 1u);
  const auto ended = parse_foxglove_request(R"({"subscriptionIds":[1,2],"op":"unsubscribe"})");
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->ended, (std::vector<std::uint32_t>{1, 2}));
  // Unknown members, and ids in other places, must have no effect.
  const auto other = parse_foxglove_request(
      R"({"op":"advertise","id":-1,"channels":[{"id":1.5,"channelId":"x"}],"subscription":[{"id":3}]})");
  ASSERT_TRUE(other);
  EXPECT_TRUE(other->subscriptions.empty());
  EXPECT_TRUE(other->ended.empty());
}

TEST(FoxgloveMessages, WhatIsNoRequest) {
  for (const char* text :
       {"", "1", "[]", "{}", "{\"op\":1}", "{\"op\":\"subscribe\"", "[{\"op\":\"subscribe\"}]",
        R"({"op":"subscribe","subscriptions":[{"id":-1,"channelId":0}]})",
        R"({"op":"subscribe","subscriptions":[{"id":4294967296,"channelId":0}]})",
        R"({"op":"subscribe","subscriptions":[{"id":"1","channelId":0}]})",
        R"({"op":"unsubscribe","subscriptionIds":[1.5]})", R"({"op":"x","a":[[[[[[[[1]]]]]]]]})"})
    EXPECT_FALSE(parse_foxglove_request(text)) << text;
}

}  // namespace
}  // namespace feltwire::web
