#include "client/transport/control_client.hpp"

#include <gmock/gmock.h>

#include "tests/client/peer.hpp"
#include "tests/client/temporary_folder.hpp"

namespace feltwire::control_client_test {
namespace {

using std::chrono::milliseconds;
using ::testing::AllOf;
using testing::ControlPeer;
using testing::error_of;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr milliseconds kPatience{10'000};

control::JoinRequest request() {
  return {
      .client = "tester", .scene = "wall", .device = builtin_device("simulated"), .parameters = {}};
}
std::string refusal(const ServerAccess& server, milliseconds timeout = kPatience) {
  return error_of<SessionError>([&] { join(server, request(), timeout); });
}
std::vector<std::uint8_t> framed(std::vector<std::uint8_t> body) {
  body.insert(body.begin(), {static_cast<std::uint8_t>(body.size()), 0, 0, 0});
  return body;
}

TEST(Endpoint, ReadsNamesAndBothKindsOfAddresses) {
  EXPECT_EQ(parse_endpoint("localhost:6720").host, "localhost");
  EXPECT_EQ(parse_endpoint("localhost:6720").port, 6720);
  EXPECT_EQ(parse_endpoint("[::1]:80").host, "::1");
  EXPECT_EQ(to_string(parse_endpoint("[fe80::2]:80")), "[fe80::2]:80");
  EXPECT_EQ(to_string(parse_endpoint("10.0.0.1:65535")), "10.0.0.1:65535");
}

TEST(Endpoint, SaysWhatIsWrong) {
  const auto complaint = [](const char* text) {
    return error_of<std::invalid_argument>([&] { parse_endpoint(text); });
  };
  for (const char* text : {"localhost", "localhost:", "localhost:0", "localhost:65536",
                           "localhost:-1", "localhost:80x", ":80", "::1:80", "[]:80", ""})
    EXPECT_THAT(complaint(text),
                AllOf(HasSubstr("'" + std::string(text) + "'"), HasSubstr("write HOST:PORT")));
}

TEST(Join, AsksForWhatWasWantedAndFindsTheScenePort) {
  control::JoinAccepted accepted;
  accepted.session = 77;
  accepted.port_offset = 21;
  accepted.silence_timeout = 2.0;
  accepted.parameters.mode = "per_axis";
  accepted.parameters.redundancy = 5;
  ControlPeer peer(control::encode(testing::with_secrets(accepted)));

  control::JoinRequest wanted = request();
  wanted.parameters.mode = accepted.parameters.mode;
  const Joined joined = join(peer.access(), wanted, kPatience);
  EXPECT_EQ(joined.accepted.session, 77u);
  EXPECT_EQ(joined.accepted.parameters.redundancy, 5);
  sockaddr_in address;
  std::memcpy(&address, &joined.datagrams.storage, sizeof address);
  EXPECT_EQ(address.sin_family, AF_INET);
  EXPECT_EQ(ntohs(address.sin_port), peer.port() + 21);
  EXPECT_EQ(ntohl(address.sin_addr.s_addr), INADDR_LOOPBACK);

  const auto& asked = peer.request();
  ASSERT_TRUE(asked.has_value());
  const auto* join_request = std::get_if<control::JoinRequest>(&*asked);
  ASSERT_NE(join_request, nullptr);
  EXPECT_EQ(join_request->client, "tester");
  EXPECT_EQ(join_request->scene, "wall");
  EXPECT_EQ(join_request->device.damping, wanted.device.damping);
  EXPECT_EQ(join_request->parameters.mode, "per_axis");
}

// An older server without tools ignores the requested tool.
/// A token is easily given for a name. Names are shown to others and logged.
TEST(Join, ATokenIsNeverSentAsAName) {
  const std::string token = "fw_0123456789ab_SHVXhD4MlOFA";
  for (std::string control::JoinRequest::*const name :
       {&control::JoinRequest::client, &control::JoinRequest::scene, &control::JoinRequest::tool,
        &control::JoinRequest::seat}) {
    ControlPeer peer(control::encode(control::Refused{}));
    control::JoinRequest wanted = request();
    wanted.*name = token;
    const std::string error =
        error_of<LastingError>([&] { join(peer.access(), wanted, kPatience); });
    EXPECT_THAT(error, AllOf(HasSubstr("nothing was sent"), Not(HasSubstr(token))));
    EXPECT_FALSE(peer.request().has_value());
  }
}

TEST(Join, AToolThatTheServerDoesNotGiveIsNoSession) {
  control::JoinAccepted accepted;
  accepted.session = 77;
  accepted.port_offset = 21;
  accepted.silence_timeout = 2.0;
  control::JoinRequest wanted = request();
  wanted.tool = "key";
  ControlPeer ignorant(control::encode(accepted));
  EXPECT_THAT(error_of<LastingError>([&] { join(ignorant.access(), wanted, kPatience); }),
              HasSubstr("knows of no tools to choose from; join without naming one"));
  accepted.tool = "key";
  ControlPeer peer(control::encode(testing::with_secrets(accepted)));
  EXPECT_EQ(join(peer.access(), wanted, kPatience).accepted.tool, "key");
  EXPECT_EQ(std::get<control::JoinRequest>(peer.request().value()).tool, "key");
}

TEST(Join, AServerOfAnotherVersionIsSaidInOneLine) {
  struct Case {
    ProtocolVersions server;
    const char* said;
  };
  const std::vector<Case> cases = {
      {{.newest = 1, .oldest = 1},
       "speaks version 1 of the feltwire protocol, this client version 2; install a newer server"},
      {{.newest = 5, .oldest = 3},
       "speaks versions 3 to 5 of the feltwire protocol, this client version 2; install a newer "
       "client"}};
  for (const Case& c : cases) {
    ControlPeer peer({}, c.server);
    const std::string said =
        error_of<LastingError>([&] { join(peer.access(), request(), kPatience); });
    EXPECT_THAT(said, HasSubstr(c.said));
    EXPECT_EQ(said.find('\n'), std::string::npos);
    EXPECT_EQ(peer.greeted_by(), ProtocolVersions{});
  }
}

TEST(Join, ARefusalBringsTheServersReason) {
  ControlPeer peer(control::encode(control::Refused{control::RefusalCode::unknown_scene,
                                                    "there is no scene 'wall'; there are: room"}));
  EXPECT_THAT(refusal(peer.access()),
              AllOf(HasSubstr("127.0.0.1:"),
                    HasSubstr("refused: there is no scene 'wall'; there are: room")));
}

TEST(Join, AnswersThatMakeNoSenseAreRefused) {
  control::JoinAccepted portless;
  portless.session = 1;
  portless.silence_timeout = 1.0;
  control::JoinAccepted impossible = portless;
  impossible.port_offset = 1;
  impossible.parameters.hold_time = -1.0;

  struct Case {
    std::vector<std::uint8_t> answer;
    const char* said;
  };
  const std::vector<Case> cases = {
      {{}, "no answer"},                      // The connection was closed without an answer.
      {{8, 0, 0, 0, 1, 2}, "no answer"},      // The answer is cut off.
      {{0, 0, 0, 0}, "no feltwire message"},  // The answer is empty.
      {{255, 255, 255, 255}, "no feltwire message"},  // The answer is far too long.
      {framed({1, 2, 3, 4, 5, 6, 7, 8}), "no feltwire message"},
      {{'H', 'T', 'T', 'P', '/', '1', '.', '1'}, "no feltwire message"},
      // The answer belongs to another request.
      {control::encode(control::SceneList{}), "no feltwire message"},
      {control::encode(portless), "no feltwire message"},
      {control::encode(impossible), "granted parameters that cannot be: hold_time"},
  };
  for (const Case& c : cases) {
    ControlPeer peer(c.answer);
    EXPECT_THAT(refusal(peer.access()), HasSubstr(c.said));
  }
}

TEST(Join, AnUnreachableServerIsSaid) {
  std::uint16_t free_port;
  {
    const testing::LocalSocket closed_again(SOCK_STREAM);
    free_port = closed_again.port();
  }
  EXPECT_THAT(refusal(test::access(free_port)),
              AllOf(HasSubstr("cannot connect to 127.0.0.1:"), HasSubstr("refused"),
                    HasSubstr("is feltwire-server running")));
  EXPECT_THAT(refusal(test::access(1, "no-such-host.invalid")),
              HasSubstr("cannot find host 'no-such-host.invalid'"));
}

TEST(Join, AServerThatNeverAnswersTimesOut) {
  // A listening socket that never accepts a connection. The connection exists, but no answer comes.
  const testing::LocalSocket deaf(SOCK_STREAM);
  ::listen(deaf.descriptor(), 1);
  EXPECT_THAT(refusal(test::access(deaf.port()), milliseconds(20)), HasSubstr("within 20 ms"));
}

TEST(ListScenes, GivesThemInOrder) {
  control::SceneList list;
  list.scenes = {{"wall", 1, 1, 0}, {"room", 2, 9, 2}};
  ControlPeer peer(control::encode(list));
  const auto scenes = list_scenes(peer.access(), kPatience);
  ASSERT_EQ(scenes.size(), 2u);
  EXPECT_EQ(scenes[0].name, "wall");
  EXPECT_EQ(scenes[1].objects, 9u);
  EXPECT_EQ(scenes[1].sessions, 2u);
  EXPECT_TRUE(std::holds_alternative<control::ListScenes>(*peer.request()));
}

TEST(Join, ALinkLocalAddressNeedsAZone) {
  ServerAccess server;
  server.endpoint = {"fe80::1", 6720};
  const std::string refused = refusal(server);
  EXPECT_THAT(refused, HasSubstr("[fe80::1]:6720"));
  EXPECT_THAT(refused, HasSubstr("link-local IPv6 address"));
  EXPECT_THAT(refused, HasSubstr("zone: fe80::1%"));
  server.endpoint.host = "fe80::1%nosuch0";
  EXPECT_THAT(refusal(server), HasSubstr("the zone behind its %"));
}

}  // namespace
}  // namespace feltwire::control_client_test
