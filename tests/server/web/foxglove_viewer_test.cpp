// A Foxglove viewer must get only the newest messages of its subscriptions.

#include "server/web/foxglove_viewer.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/little_endian.hpp"
#include "core/recording/protobuf.hpp"
#include "tests/server/make.hpp"

namespace feltwire::web {
namespace {

using ::testing::HasSubstr;
constexpr std::size_t kHead = 13;  // [bytes] head of a binary message

struct KeepingViewer : Viewer {
  void send(const std::string& text) override { texts.push_back(text); }
  void show_text(const SharedBytes& text) override { texts.emplace_back(text.text()); }
  void show_binary(std::span<const std::uint8_t> head, const SharedBytes& shown) override {
    Bytes message(head.begin(), head.end());
    message.insert(message.end(), shown.bytes().begin(), shown.bytes().end());
    data.push_back(std::move(message));
  }
  void ping() override {}
  bool ready() const override { return true; }
  void close(WebSocketClose, std::string_view) override { closed = true; }
  void admitted() override {}

  std::vector<std::uint32_t> subscriptions() const {
    std::vector<std::uint32_t> ids;
    for (const Bytes& message : data)
      ids.push_back(get_little_endian<std::uint32_t>(message.data() + 1));
    return ids;
  }
  std::vector<std::string> texts;
  std::vector<Bytes> data;
  bool closed = false;
};

std::string subscribe(int id, FoxgloveChannel channel) {
  return R"({"op":"subscribe","subscriptions":[{"id":)" + std::to_string(id) + R"(,"channelId":)" +
         std::to_string(static_cast<int>(channel)) + "}]}";
}

Picture picture_of(std::vector<std::uint32_t> numbers) {
  Picture picture;
  picture.time = std::chrono::seconds(5);
  picture.version = 1;
  for (const std::uint32_t number : numbers) {
    PictureHand hand;
    hand.number = number;
    hand.states = bit(HandState::touching) | bit(HandState::gap);
    hand.held = {0.0, 0.0, 2.0};
    hand.depth = 0.25;
    picture.hands.push_back(hand);
  }
  return picture;
}

/// Returns the ids of the entities, or of the deletions, of a foxglove.SceneUpdate.
std::vector<std::string> ids(const Bytes& message, std::uint32_t which) {
  const std::string payload(message.begin() + kHead, message.end());
  std::vector<std::string> found;
  protobuf::Fields parts(payload);
  while (const auto part = parts.next()) {
    if (part->number != which) continue;
    protobuf::Fields fields(part->bytes);
    while (const auto field = fields.next())
      if (field->number == 3 && field->is_bytes) found.emplace_back(field->bytes);
  }
  EXPECT_TRUE(parts.ok());
  return found;
}
constexpr std::uint32_t kDeletions = 1, kEntities = 2;

class FoxgloveViewers : public ::testing::Test {
 protected:
  FoxgloveViewers() { seen.set(room, 1, std::chrono::seconds(1)); }
  Scene room = test::room();
  FoxgloveScene seen{1'700'000'000'000'000'000};
  KeepingViewer way;
  FoxgloveViewer viewer{way, "room"};
};

TEST_F(FoxgloveViewers, GetNothingUnasked) {
  seen.set(picture_of({1}));
  viewer.show(seen);
  EXPECT_TRUE(way.data.empty());
  ASSERT_EQ(way.texts.size(), 2u);
  EXPECT_THAT(way.texts[0], HasSubstr("serverInfo"));
  EXPECT_THAT(way.texts[1], HasSubstr("advertise"));
}

TEST_F(FoxgloveViewers, GetTheNewestOnce) {
  viewer.receive(subscribe(7, FoxgloveChannel::geometry));
  viewer.receive(subscribe(8, FoxgloveChannel::hands));
  viewer.show(seen);
  viewer.show(seen);
  EXPECT_EQ(way.subscriptions(), (std::vector<std::uint32_t>{7}));  // no picture yet
  EXPECT_EQ(ids(way.data[0], kEntities).size(), room.objects().size());
  for (int i = 0; i < 3; ++i) seen.set(picture_of({1}));
  viewer.show(seen);
  EXPECT_EQ(way.subscriptions(), (std::vector<std::uint32_t>{7, 8}));
  constexpr std::uint64_t kTime = 1'700'000'005'000'000'000;
  EXPECT_EQ(get_little_endian<std::uint64_t>(way.data[1].data() + 5), kTime);
  seen.set(room, 2, std::chrono::seconds(9));  // a reload
  viewer.show(seen);
  EXPECT_EQ(way.subscriptions(), (std::vector<std::uint32_t>{7, 8, 7}));
  EXPECT_FALSE(way.closed);
}

TEST_F(FoxgloveViewers, AreToldWhoLeftAlsoAfterPicturesThatTheyMissed) {
  viewer.receive(subscribe(1, FoxgloveChannel::picture));
  seen.set(picture_of({2, 10, 3}));
  viewer.show(seen);
  EXPECT_THAT(ids(way.data[0], kEntities), ::testing::ElementsAre("hand 2", "hand 10", "hand 3"));
  EXPECT_TRUE(ids(way.data[0], kDeletions).empty());
  seen.set(picture_of({3}));  // The viewer misses this picture.
  seen.set(picture_of({3, 11}));
  viewer.show(seen);
  EXPECT_THAT(ids(way.data[1], kEntities), ::testing::ElementsAre("hand 3", "hand 11"));
  EXPECT_THAT(ids(way.data[1], kDeletions), ::testing::ElementsAre("hand 2", "hand 10"));
}

TEST_F(FoxgloveViewers, EndASubscriptionAndBeginItAgain) {
  viewer.receive(subscribe(1, FoxgloveChannel::geometry));
  viewer.show(seen);
  viewer.receive(R"({"op":"unsubscribe","subscriptionIds":[1]})");
  seen.set(room, 2, std::chrono::seconds(2));
  viewer.show(seen);
  EXPECT_EQ(way.data.size(), 1u);
  viewer.receive(subscribe(2, FoxgloveChannel::geometry));
  viewer.show(seen);
  EXPECT_EQ(way.subscriptions(), (std::vector<std::uint32_t>{1, 2}));
  EXPECT_EQ(way.texts.size(), 2u) << "nothing to complain of";
}

TEST_F(FoxgloveViewers, AreToldWhatCannotBeDone) {
  const auto complaint = [&](const std::string& message) {
    const std::size_t before = way.texts.size();
    viewer.receive(message);
    EXPECT_EQ(way.texts.size(), before + 1) << message;
    return way.texts.back();
  };
  EXPECT_THAT(complaint("nonsense"), HasSubstr("status"));
  EXPECT_THAT(complaint(R"({"op":"setParameters"})"), HasSubstr("setParameters"));
  EXPECT_THAT(complaint(R"({"op":"subscribe","subscriptions":[{"id":1,"channelId":9}]})"),
              HasSubstr("channel 9"));
  EXPECT_THAT(complaint(R"({"op":"unsubscribe","subscriptionIds":[5]})"), HasSubstr("5"));
  viewer.receive(subscribe(1, FoxgloveChannel::hands));
  EXPECT_THAT(complaint(subscribe(1, FoxgloveChannel::geometry)), HasSubstr("in use"));
  EXPECT_THAT(complaint(subscribe(2, FoxgloveChannel::hands)), HasSubstr("in use"));
  EXPECT_FALSE(way.closed);
}

TEST(FoxgloveScene, TheFiguresOfAHand) {
  FoxgloveScene seen(0);
  seen.set(picture_of({4}));
  const FoxgloveTopic& topic = seen.topic(FoxgloveChannel::hands);
  protobuf::Fields hands(topic.payload.text());
  ASSERT_EQ(hands.next()->real(), 5.0);
  const auto hand = hands.next();
  ASSERT_TRUE(hand && hand->number == 2);
  protobuf::Fields fields(hand->bytes);
  std::vector<std::string> reasons;
  while (const auto field = fields.next()) {
    if (field->number == 1) {
      EXPECT_EQ(field->value, 4u);
    } else if (field->number == 8) {
      EXPECT_EQ(field->real(), 0.25);
    } else if (field->number == 15) {
      reasons.emplace_back(field->bytes);
    }
    EXPECT_NE(field->number, 11u) << "a balance that nobody said";
  }
  EXPECT_TRUE(fields.ok());
  EXPECT_THAT(reasons, ::testing::ElementsAre("touching", "gap"));
}

}  // namespace
}  // namespace feltwire::web
