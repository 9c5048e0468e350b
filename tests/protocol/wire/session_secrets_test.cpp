#include "protocol/wire/session_secrets.hpp"

#include <gtest/gtest.h>

#include <set>

#include "flatbuffers/flatbuffers.h"
#include "protocol/wire/control_generated.h"
#include "tests/protocol/control_messages.hpp"

namespace feltwire::session_secrets_test {
namespace {

using control::JoinAccepted;
using test::body;
using test::round_trip;

TEST(SessionSecrets, AreDifferentForEverySession) {
  std::set<Key> all;
  constexpr std::size_t kSessions = 100;
  for (std::size_t i = 0; i < kSessions; ++i) {
    const SessionKeys keys = random_session_keys(CipherSuite::aes_256_gcm);
    EXPECT_EQ(keys.suite, CipherSuite::aes_256_gcm);
    all.insert(keys.up);
    all.insert(keys.down);
  }
  EXPECT_EQ(all.size(), 2 * kSessions);
}

TEST(SessionSecrets, TravelInTheAnswerAndAreTakenOutOnce) {
  const SessionKeys keys = random_session_keys(CipherSuite::aes_256_gcm);
  JoinAccepted sent;
  put_keys(keys, sent);
  JoinAccepted got = round_trip(sent);
  const SessionKeys taken = take_keys(got);
  EXPECT_EQ(taken.suite, keys.suite);
  EXPECT_EQ(taken.up, keys.up);
  EXPECT_EQ(taken.down, keys.down);
  EXPECT_TRUE(got.secret_up.empty());
  EXPECT_TRUE(got.secret_down.empty());
  EXPECT_THROW(take_keys(got), std::invalid_argument);
}

TEST(SessionSecrets, OfAnotherLengthAreNamed) {
  const auto said_of = [](std::size_t up, std::size_t down) {
    JoinAccepted accepted;
    accepted.secret_up = Secret(std::string(up, 'u'));
    accepted.secret_down = Secret(std::string(down, 'd'));
    JoinAccepted got = round_trip(accepted);  // such a message can be read, so it can be refused
    try {
      take_keys(got);
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(said_of(kKeySize, kKeySize), "");
  EXPECT_EQ(said_of(0, kKeySize), "secret_up has 0 bytes; 32 are needed");
  EXPECT_EQ(said_of(kKeySize, 0), "secret_down has 0 bytes; 32 are needed");
  EXPECT_EQ(said_of(kKeySize - 1, kKeySize), "secret_up has 31 bytes; 32 are needed");
  EXPECT_EQ(said_of(kKeySize, kKeySize + 1), "secret_down has 33 bytes; 32 are needed");
  EXPECT_EQ(said_of(5000, kKeySize), "secret_up has 5000 bytes; 32 are needed");
}

TEST(SessionSecrets, MayNotBeEqual) {
  JoinAccepted accepted;
  accepted.secret_up = accepted.secret_down = Secret(std::string(kKeySize, 'x'));
  EXPECT_THROW(take_keys(accepted), std::invalid_argument);
}

/// A client of version 1 has no fields for versions. It sends the token alone, and reads no field
/// of Refused but these two.
TEST(ProtocolVersions, AClientOfVersionOneIsReadAndCanReadTheRefusal) {
  flatbuffers::FlatBufferBuilder builder;
  const auto token = builder.CreateString("fw_1");
  const auto start = builder.StartTable();
  builder.AddOffset(wire::Authenticate::VT_TOKEN, token);
  const flatbuffers::Offset<wire::Authenticate> old(builder.EndTable(start));
  builder.Finish(wire::CreateControlMessage(builder, wire::Body::Authenticate, old.Union()));
  const auto message = control::decode({builder.GetBufferPointer(), builder.GetSize()});
  const auto& shown = std::get<control::Authenticate>(message.value());
  EXPECT_EQ(shown.token.text(), "fw_1");
  EXPECT_EQ(shown.versions, (ProtocolVersions{.newest = 1, .oldest = 1}));

  const auto frame = control::encode(control::Refused{control::RefusalCode::not_supported, "old"});
  const auto* refused = wire::GetControlMessage(body(frame).data())->body_as_Refused();
  ASSERT_NE(refused, nullptr);
  EXPECT_EQ(static_cast<int>(refused->code()), 10);  // its code in version 1
  EXPECT_EQ(refused->reason()->str(), "old");
}

TEST(ProtocolVersions, TravelWithTheTokenAndItsAnswer) {
  EXPECT_EQ(round_trip(control::Authenticate{Secret("fw_1")}).versions, ProtocolVersions{});
  const ProtocolVersions later{.newest = 9, .oldest = 3};
  EXPECT_EQ(round_trip(control::Authenticate{Secret("fw_1"), later}).versions, later);
  EXPECT_EQ(round_trip(control::Authenticated{"anna", "*", Role::admin, later}).versions, later);
  const ProtocolVersions never{.newest = 2, .oldest = 3};
  EXPECT_FALSE(control::decode(body(control::encode(control::Authenticate{Secret("x"), never}))));
  EXPECT_FALSE(
      control::decode(body(control::encode(control::Authenticated{"a", "*", Role::admin, never}))));
}

TEST(SessionSecrets, ALongAnswerIsEncodedWhole) {
  JoinAccepted accepted;
  put_keys(random_session_keys(CipherSuite::chacha20_poly1305), accepted);
  accepted.seats = {std::string(control::kMaxName, 'a'), std::string(control::kMaxName, 'b')};
  accepted.workspace.count = Workspace::kMostGiven;
  const JoinAccepted got = round_trip(accepted);
  EXPECT_EQ(got.secret_up.text(), accepted.secret_up.text());
  EXPECT_EQ(got.secret_down.text(), accepted.secret_down.text());
  EXPECT_GT(control::encode(accepted).size(), 1024u);
}

}  // namespace
}  // namespace feltwire::session_secrets_test
