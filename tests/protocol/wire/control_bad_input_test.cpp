// Tests frames without a valid message, and messages at the limits.

#include <gtest/gtest.h>

#include <random>

#include "flatbuffers/flatbuffers.h"
#include "protocol/wire/control_generated.h"
#include "tests/protocol/control_messages.hpp"
#include "tests/protocol/misaligned.hpp"

namespace feltwire::control {
namespace {

using test::body;
using test::request;
using test::round_trip;
using test::unusual_parameters;

TEST(ControlBadInput, LimitsOfNamesAndFrames) {
  JoinRequest r = request();
  r.client = std::string(kMaxName, 'x');
  EXPECT_TRUE(decode(body(encode(r))));
  r.client += 'x';
  EXPECT_FALSE(decode(body(encode(r))));
  JoinRequest longest_request = request();
  longest_request.client = std::string(kMaxFrame, 'x');
  EXPECT_THROW(encode(longest_request), std::length_error);
  const std::vector<std::uint8_t> large(kMaxFrame + 1);
  EXPECT_FALSE(decode(large));
  SceneList most;
  for (std::size_t i = 0; i < kMaxScenes; ++i)
    most.scenes.push_back({std::string(kMaxName, 'x'), 1, 1, 1});
  EXPECT_EQ(round_trip(most).scenes.size(), kMaxScenes);
  SessionList longest;
  for (std::size_t i = 0; i < kMaxSessionEntries; ++i)
    longest.sessions.push_back(
        {i + 1, std::string(kMaxName, 'x'), std::string(kMaxName, 'y'), Role::admin});
  EXPECT_EQ(round_trip(longest).sessions.size(), kMaxSessionEntries);
  EXPECT_FALSE(decode(body(encode(Authenticate{Secret(std::string(kMaxName + 1, 'x'))}))));
  // The longest token must fit in the first frame of an unknown client.
  EXPECT_LE(encode(Authenticate{Secret(std::string(kMaxName, 'x'))}).size(), kMaxFirstFrame);
}

/// FlatBuffers' verifier accepts misaligned numbers, but reading them is undefined.
TEST(ControlBadInput, NumbersOutOfPlaceAreNoMessage) {
  JoinRequest sent = request();
  sent.device.damping = Vec3(1, 2, 3);
  const auto frame = encode(sent);
  const std::vector<std::uint8_t> bytes(body(frame).begin(), body(frame).end());
  const wire::DeviceSpec* device =
      wire::GetControlMessage(bytes.data())->body_as_JoinRequest()->device();
  const auto moved = test::with_misaligned_vector(
      bytes, bytes.data(), device, wire::DeviceSpec::VT_DAMPING_TENSOR, 3 * sizeof(double));
  flatbuffers::Verifier verifier(moved.data(), moved.size());
  ASSERT_TRUE(wire::VerifyControlMessageBuffer(verifier));
  EXPECT_TRUE(decode(bytes));
  EXPECT_FALSE(decode(moved));
}

TEST(ControlBadInput, WallsOutOfPlaceAreNoMessage) {
  JoinRequest sent = request();
  sent.workspace.add_box(Vec3(-1, -1, -1), Vec3(1, 1, 1));
  const auto frame = encode(sent);
  const std::vector<std::uint8_t> bytes(body(frame).begin(), body(frame).end());
  const wire::Workspace* workspace =
      wire::GetControlMessage(bytes.data())->body_as_JoinRequest()->workspace();
  const auto moved = test::with_misaligned_vector(
      bytes, bytes.data(), workspace, wire::Workspace::VT_WALLS, 6 * sizeof(wire::Wall));
  EXPECT_TRUE(decode(bytes));
  EXPECT_FALSE(decode(moved));
}

TEST(ControlBadInput, ChoicesThatAreNoneAreRefused) {
  SessionParameters p;
  for (const int which : {0, 1, 2, 3, 4}) {
    p = {};
    if (which == 0) p.mode = std::string(kLongestMethodName + 1, 'm');
    if (which == 1) p.projection = static_cast<Projection>(2);
    if (which == 2) p.side = static_cast<BoundingSide>(3);
    if (which == 3) p.reference = static_cast<PassivityReference>(2);
    if (which == 4) p.storage = static_cast<Storage>(2);
    EXPECT_FALSE(decode(body(encode(SetParameters{1, p})))) << which;
  }
  JoinRequest nobody = request();
  nobody.role = static_cast<Role>(kRoleNames.size());
  EXPECT_FALSE(decode(body(encode(nobody))));
  for (const int suite : {0, 3}) {
    JoinAccepted sealed;
    sealed.suite = static_cast<CipherSuite>(suite);
    EXPECT_FALSE(decode(body(encode(sealed)))) << suite;
  }
  EXPECT_FALSE(decode(body(encode(Refused{static_cast<RefusalCode>(15), "x"}))));
}

/// A list may point to one entry many times. A small frame would then decode to an enormous list.
TEST(ControlBadInput, ListThatMultipliesOneEntry) {
  flatbuffers::FlatBufferBuilder builder;
  const auto entry = wire::CreateSceneEntryDirect(builder, "again", 1, 1, 1);
  const std::vector<flatbuffers::Offset<wire::SceneEntry>> entries(10'000, entry);
  const auto list = wire::CreateSceneList(builder, builder.CreateVector(entries));
  builder.Finish(wire::CreateControlMessage(builder, wire::Body::SceneList, list.Union()));
  ASSERT_LT(builder.GetSize(), kMaxFrame);
  EXPECT_FALSE(decode({builder.GetBufferPointer(), builder.GetSize()}));
}

TEST(ControlFuzz, TruncationsAndFlipsAreHarmless) {
  std::mt19937_64 random(1);
  JoinRequest tool = request();
  tool.tool = "key";
  const std::vector<Message> messages = {request(),
                                         SceneList{{{"a", 1, 2, 3}, {"b", 4, 5, 6}}},
                                         SetParameters{5, unusual_parameters()},
                                         Refused{RefusalCode::full, "no"},
                                         JoinAccepted{},
                                         tool,
                                         Authenticate{Secret("fw_1")},
                                         SessionList{{{1, "a", "b", Role::admin}}, false}};
  int valid = 0;
  for (const Message& message : messages) {
    const auto frame = encode(message);
    const std::vector<std::uint8_t> bytes(body(frame).begin(), body(frame).end());
    for (std::size_t size = 0; size < bytes.size(); ++size)
      valid +=
          decode(std::vector<std::uint8_t>(bytes.begin(), bytes.begin() + static_cast<long>(size)))
              .has_value();
    for (int round = 0; round < 5000; ++round) {
      auto spoiled = bytes;
      for (std::size_t flips = 1 + random() % 6; flips > 0; --flips)
        spoiled[random() % spoiled.size()] = static_cast<std::uint8_t>(random());
      valid += decode(spoiled).has_value();
    }
  }
  EXPECT_GT(valid, 0);  // Some flips change only numbers. Such frames are still messages.
}

}  // namespace
}  // namespace feltwire::control
