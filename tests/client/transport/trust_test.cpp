// Tests trust between client and server: certificates, tokens and roles over real sockets.

#include <gmock/gmock.h>

#include "core/base/pending_file.hpp"
#include "protocol/session/protocol_versions.hpp"
#include "protocol/wire/session_secrets.hpp"
#include "tests/client/loopback.hpp"
#include "tests/client/peer.hpp"
#include "tests/client/temporary_folder.hpp"
#include "tests/server/raw_socket.hpp"
#include "tests/support/eventually.hpp"

namespace feltwire::trust_test {
namespace {

using ::testing::AllOf;
using testing::error_of;
using ::testing::HasSubstr;
using testing::kPatience;
using testing::Loopback;
using testing::TemporaryFolder;

std::vector<Scene> floor() {
  std::vector<Scene> scenes;
  scenes.push_back(testing::floor_scene());
  return scenes;
}
control::JoinRequest request(Role role = Role::operator_) {
  return {"tester", "floor", builtin_device("simulated"), {}, role};
}
std::string refusal(const ServerAccess& access, const control::JoinRequest& wanted = request()) {
  return error_of<SessionError>([&] { join(access, wanted, kPatience); });
}
ServerAccess pinning(std::uint16_t port, const Identity& identity) {
  ServerAccess access = test::access(port);
  access.credentials.trust = fingerprint(identity);
  return access;
}
ServerAccess trusting(const std::string& host, std::uint16_t port, const std::string& authority) {
  ServerAccess access = test::access(port, host);
  access.credentials.trust = Authorities{authority};
  return access;
}

class Trust : public Loopback {};

TEST_F(Trust, OnlyThePinnedCertificateWillDo) {
  EXPECT_NO_THROW(join(pinning(server->control_port(), test::identity()), request(), kPatience));
  EXPECT_THAT(refusal(pinning(server->control_port(), make_identity({"localhost"}))),
              AllOf(HasSubstr("is not the server whose fingerprint was given"),
                    HasSubstr(to_string(server->fingerprint()))));
}

TEST_F(Trust, AnAuthorityVouchesForAHost) {
  const std::uint16_t port = server->control_port();
  const std::string& own = test::identity().certificate;
  EXPECT_NO_THROW(join(trusting("127.0.0.1", port, own), request(), kPatience));
  EXPECT_NO_THROW(join(trusting("localhost", port, own), request(), kPatience));
  EXPECT_THAT(refusal(trusting("127.0.0.1", port, make_identity({"localhost"}).certificate)),
              HasSubstr("cannot be trusted"));
  EXPECT_THAT(refusal(trusting("127.0.0.1", port, "nonsense")), HasSubstr("--ca"));

  const Identity elsewhere = make_identity({"elsewhere.example", "10.1.2.3"});
  Server other(testing::any_ports(), floor(),
               {elsewhere, {}, TokenFile(Tokens{test::admin_token().token})});
  EXPECT_THAT(refusal(trusting("127.0.0.1", other.control_port(), elsewhere.certificate)),
              AllOf(HasSubstr("cannot be trusted"), HasSubstr("mismatch")));
  EXPECT_THAT(refusal(trusting("localhost", other.control_port(), elsewhere.certificate)),
              AllOf(HasSubstr("cannot be trusted"), HasSubstr("mismatch")));
}

TEST(MutualTls, AClientNeedsACertificateOfTheAuthority) {
  const Identity client = make_identity({"client"}), stranger = make_identity({"client"});
  Server server(
      testing::any_ports(), floor(),
      {test::identity(), client.certificate, TokenFile(Tokens{test::admin_token().token})});
  ServerAccess access = test::access(server.control_port());
  EXPECT_THAT(refusal(access), HasSubstr("--certificate and --key"));
  access.credentials.certificate = stranger.certificate;
  access.credentials.key = stranger.key;
  EXPECT_THAT(refusal(access), HasSubstr("does not take the certificate in --certificate"));
  access.credentials.certificate = client.certificate;
  // This key belongs to another certificate.
  EXPECT_THAT(refusal(access), HasSubstr("cannot be used"));
  access.credentials.key = client.key;
  // A certificate does not replace the token.
  access.credentials.token = issue_token("x", "*", Role::admin, std::nullopt).text;
  EXPECT_THAT(refusal(access), HasSubstr("needs a token"));
  access.credentials.token = test::admin_token().text;
  EXPECT_NO_THROW(join(access, request(), kPatience));
}

/// A renewed certificate must not end sessions. Only new connections get it.
TEST(RenewedCertificate, IsForNewConnectionsAndSessionsGoOn) {
  const TemporaryFolder folder;
  const Identity renewed = make_identity({"localhost"});
  ServerConfig config = testing::any_ports();
  config.certificate = folder / "certificate.pem";
  config.key = folder / "key.pem";
  config.tokens = folder / "tokens.json";
  Server server(config, floor(),
                {test::identity(), {}, TokenFile(Tokens{test::admin_token().token})});
  const std::uint16_t port = server.control_port();
  const ServerAccess old_pin = pinning(port, test::identity()), new_pin = pinning(port, renewed);
  EXPECT_NO_THROW(join(old_pin, request(), kPatience));

  EXPECT_THROW(server.renew_certificate(), FileError);
  replace_file(config.key, make_identity({"localhost"}).key.text(), kPrivate);
  replace_file(config.certificate, renewed.certificate, kPublic);
  EXPECT_THROW(server.renew_certificate(), FileError);  // The key is of another certificate.
  EXPECT_NO_THROW(list_scenes(old_pin, kPatience));

  replace_file(config.key, renewed.key.text(), kPrivate);
  server.renew_certificate();
  EXPECT_TRUE(test::becomes([&] {
    try {
      return list_scenes(new_pin, kPatience).size() == 1;
    } catch (const SessionError&) {
      return false;
    }
  }));
  EXPECT_THAT(refusal(old_pin), HasSubstr("is not the server whose fingerprint was given"));
  EXPECT_EQ(server.summary().front().sessions, 1U);
  server.renew_certificate();  // The files are the same.
  EXPECT_NO_THROW(join(new_pin, request(), kPatience));
}

/// The client must refuse a server with an older TLS version.
TEST(Tls, NothingOlderIsSpoken) {
  testing::LocalSocket socket(SOCK_STREAM);
  ::listen(socket.descriptor(), 1);
  std::thread old([&] {
    const int connection = ::accept(socket.descriptor(), nullptr, nullptr);
    const test::TlsContext context = test::server_context(test::identity(), TLS1_2_VERSION);
    EXPECT_FALSE(test::TlsConnection(context.get(), connection).accept());
    ::close(connection);
  });
  EXPECT_THAT(refusal(test::access(socket.port())), HasSubstr("no TLS with"));
  old.join();
}

TEST_F(Trust, EachJoinHasKeysOfItsOwn) {
  // The first join uses feltwire's client. The others use OpenSSL directly.
  const Joined ours = join(endpoint, request(), kPatience);
  test::ControlClient raw(server->control_port());
  const test::JoinedBy one = raw.join(request()), two = raw.join(request());
  EXPECT_NE(ours.keys.up, Key{});
  const std::vector<Key> keys = {ours.keys.up,  ours.keys.down, one.keys.up,
                                 one.keys.down, two.keys.up,    two.keys.down};
  for (std::size_t i = 0; i < keys.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) EXPECT_NE(keys[i], keys[j]);
  EXPECT_TRUE(ours.accepted.secret_up.empty());
  EXPECT_TRUE(ours.accepted.secret_down.empty());
}

/// Shows a valid token of a client that speaks these versions. Returns the answer.
control::Message answer_to(const ProtocolVersions& versions, std::uint16_t port) {
  test::ControlClient client(port, AF_INET, Secret());
  client.send(control::Authenticate{test::admin_token().text, versions});
  const auto answer = client.receive();
  if (!answer || !std::holds_alternative<control::Authenticated>(*answer)) {
    EXPECT_TRUE(client.closed());
  }
  return answer.value();
}

TEST_F(Trust, AClientOfAnotherVersionIsToldWhy) {
  const auto reason = [&](const ProtocolVersions& versions) {
    const auto refused = std::get<control::Refused>(answer_to(versions, server->control_port()));
    EXPECT_EQ(refused.code, control::RefusalCode::not_supported);
    return refused.reason;
  };
  EXPECT_EQ(reason({.newest = 1, .oldest = 1}),
            "this client speaks version 1 of the feltwire protocol, this server version 2; install "
            "a newer client");
  EXPECT_EQ(reason({.newest = 9, .oldest = 7}),
            "this client speaks versions 7 to 9 of the feltwire protocol, this server version 2; "
            "install a newer server");
  const auto greeting = std::get<control::Authenticated>(
      answer_to({.newest = 9, .oldest = 1}, server->control_port()));
  EXPECT_EQ(greeting.versions, ProtocolVersions{});
}

/// Returns an answer with these secrets to any request.
control::JoinAccepted answer_with(const SessionKeys& keys) {
  control::JoinAccepted accepted;
  accepted.session = 0x1234;
  accepted.port_offset = 1;
  accepted.parameters = request().parameters;
  accepted.silence_timeout = 1.0;
  put_keys(keys, accepted);
  return accepted;
}

TEST(Keys, TheClientHasTheSecretsOfTheAnswer) {
  const SessionKeys keys = random_session_keys(CipherSuite::chacha20_poly1305);
  testing::ControlPeer peer(control::encode(answer_with(keys)));
  const Joined joined = join(peer.access(), request(), kPatience);
  EXPECT_EQ(joined.keys.up, keys.up);
  EXPECT_EQ(joined.keys.down, keys.down);
  EXPECT_NE(joined.keys.up, joined.keys.down);
  EXPECT_EQ(joined.keys.suite, keys.suite);
}

TEST(Keys, AnswersWithoutGoodSecretsMakeNoSession) {
  const SessionKeys keys = random_session_keys(CipherSuite::chacha20_poly1305);
  const auto said_of = [](const control::JoinAccepted& answer) {
    testing::ControlPeer peer(control::encode(answer));
    return error_of<LastingError>([&] { join(peer.access(), request(), kPatience); });
  };
  control::JoinAccepted none = answer_with(keys), shorter = none, longer = none, equal = none;
  none.secret_up = Secret();
  shorter.secret_up = Secret(std::string(kKeySize - 1, 'x'));
  longer.secret_down = Secret(std::string(kKeySize + 1, 'x'));
  equal.secret_down = equal.secret_up;
  EXPECT_THAT(said_of(none), HasSubstr("secret_up has 0 bytes; 32 are needed"));
  EXPECT_THAT(said_of(shorter), HasSubstr("secret_up has 31 bytes; 32 are needed"));
  EXPECT_THAT(said_of(longer), HasSubstr("secret_down has 33 bytes; 32 are needed"));
  EXPECT_THAT(said_of(equal), HasSubstr("secret_up and secret_down are equal"));
}

/// A server with a token for each role.
class Roles : public ::testing::Test {
 protected:
  static IssuedToken token(Role role, const char* scene = "*",
                           std::optional<CalendarTime> expires = std::nullopt) {
    return issue_token(std::string(name(role)), scene, role, expires);
  }
  ServerAccess with(const IssuedToken& issued) const {
    return test::access(server.control_port(), "127.0.0.1", issued.text);
  }
  IssuedToken observer = token(Role::observer), acting = token(Role::operator_),
              admin = token(Role::admin), cellar = token(Role::operator_, "cellar"),
              expired = token(Role::admin, "*", CalendarTime(std::chrono::seconds(1)));
  Server server{
      testing::any_ports(), floor(),
      test::security({observer.token, acting.token, admin.token, cellar.token, expired.token})};
};

TEST_F(Roles, WhatIsWrongWithATokenIsNotSaid) {
  IssuedToken unknown = token(Role::admin), none;
  std::string text(admin.text.text());
  text.back() = text.back() == 'A' ? 'Q' : 'A';
  IssuedToken wrong = admin;
  wrong.text = Secret(text);
  const std::string said = refusal(with(unknown));
  EXPECT_THAT(said, HasSubstr("needs a token"));
  EXPECT_EQ(refusal(with(wrong)), said);
  EXPECT_EQ(refusal(with(expired)), said);
  EXPECT_EQ(refusal(with(none)), said);
  server.stop();
  EXPECT_EQ(server.control_summary().requests.unauthenticated, 4u);
}

TEST_F(Roles, ATokenOpensItsSceneAndItsRole) {
  EXPECT_THAT(refusal(with(cellar)), HasSubstr("does not open scene 'floor'"));
  EXPECT_TRUE(list_scenes(with(cellar), kPatience).empty());
  EXPECT_EQ(list_scenes(with(observer), kPatience).size(), 1u);
  EXPECT_THAT(refusal(with(observer)), HasSubstr("does not join as operator"));
  EXPECT_NO_THROW(join(with(observer), request(Role::observer), kPatience));
  EXPECT_NO_THROW(join(with(acting), request(), kPatience));
  EXPECT_NO_THROW(join(with(acting), request(Role::observer), kPatience));
  EXPECT_NO_THROW(join(with(admin), request(), kPatience));
  EXPECT_THAT(refusal(with(acting), request(Role::admin)), HasSubstr("does not join as admin"));
}

TEST_F(Roles, AdminsListAndEvict) {
  testing::Client hand(with(acting), testing::kStroke, {}, "floor");
  const std::uint64_t session = hand.joined.accepted.session;
  for (const IssuedToken* other : {&acting, &observer}) {
    for (const control::Message& message :
         {control::Message(control::ListSessions{}), control::Message(control::Evict{session}),
          control::Message(control::ReloadScene{"floor"})})
      EXPECT_THAT(error_of<SessionError>([&] { ask(with(*other), message, kPatience); }),
                  HasSubstr("for admins"));
  }
  const auto list =
      std::get<control::SessionList>(ask(with(admin), control::ListSessions{}, kPatience));
  ASSERT_EQ(list.sessions.size(), 1u);
  EXPECT_EQ(list.sessions[0].session, session);
  EXPECT_EQ(list.sessions[0].client, "operator");
  EXPECT_EQ(list.sessions[0].scene, "floor");
  EXPECT_EQ(list.sessions[0].role, Role::operator_);
  EXPECT_THAT(
      error_of<SessionError>([&] { ask(with(admin), control::ReloadScene{"floor"}, kPatience); }),
      HasSubstr("do not come from files"));

  Sample sample;
  sample.index = 1;
  hand.transport.send(sample);
  Reply reply;
  GoodbyeReason reason = GoodbyeReason::leaving;
  const auto arrives = [&](Transport::Arrival arrival) {
    return [&, arrival] { return hand.transport.receive(reply, reason) == arrival; };
  };
  test::eventually("the answer", arrives(Transport::Arrival::reply));
  ask(with(admin), control::Evict{session}, kPatience);
  test::eventually("the goodbye", arrives(Transport::Arrival::goodbye));
  EXPECT_EQ(reason, GoodbyeReason::evicted);
  test::eventually("the end of the session",
                   [&] { return list_scenes(with(admin), kPatience)[0].sessions == 0; });
  EXPECT_THAT(error_of<SessionError>([&] { ask(with(admin), control::Evict{session}, kPatience); }),
              HasSubstr("no session"));
  server.stop();
  EXPECT_EQ(server.summary()[0].counters.evicted, 1u);
}

TEST_F(Roles, ASessionIsItsOwnersAndAnAdmins) {
  const auto id = [&] { return join(with(acting), request(), kPatience).accepted.session; };
  const std::uint64_t session = id();
  EXPECT_THAT(error_of<SessionError>(
                  [&] { ask(with(observer), control::LeaveRequest{session}, kPatience); }),
              HasSubstr("no session"));
  EXPECT_THAT(error_of<SessionError>([&] {
                ask(with(cellar), control::SetParameters{session, {}}, kPatience);
              }),
              HasSubstr("no session"));
  EXPECT_NO_THROW(ask(with(acting), control::LeaveRequest{session}, kPatience));
  EXPECT_NO_THROW(ask(with(admin), control::LeaveRequest{id()}, kPatience));
}

TEST(Limits, SessionsAndJoinsOfAClient) {
  ServerConfig config = testing::any_ports();
  config.max_sessions_per_client = 2;
  Server server(config, floor(), test::security());
  const ServerAccess access = test::access(server.control_port());
  const std::uint64_t first = join(access, request(), kPatience).accepted.session;
  join(access, request(), kPatience);
  EXPECT_THAT(refusal(access), HasSubstr("has all its 2 sessions"));
  ask(access, control::LeaveRequest{first}, kPatience);
  EXPECT_NO_THROW(join(access, request(), kPatience));

  config.max_sessions_per_client = 16;
  config.join_burst = 2;
  config.join_rate = 0.001;
  const IssuedToken berta = issue_token("berta", "*", Role::operator_, std::nullopt);
  Server slow(config, floor(), test::security({berta.token}));
  const ServerAccess here = test::access(slow.control_port());
  const std::uint64_t session = join(here, request(), kPatience).accepted.session;
  join(here, request(), kPatience);
  EXPECT_THAT(refusal(here), HasSubstr("client 'tester' joins too often"));
  // Other clients can still join.
  EXPECT_NO_THROW(
      join(test::access(slow.control_port(), "127.0.0.1", berta.text), request(), kPatience));
  // Parameter changes have a separate limit.
  const control::SetParameters change{session, request().parameters};
  EXPECT_NO_THROW(ask(here, change, kPatience));
  EXPECT_NO_THROW(ask(here, change, kPatience));
  EXPECT_THAT(error_of<SessionError>([&] { ask(here, change, kPatience); }),
              HasSubstr("changes parameters or reloads too often"));
  slow.stop();
  EXPECT_EQ(slow.control_summary().requests.too_many, 2u);
}

/// Another client behind the same address uses wrong tokens. A correct token must still work.
TEST(Limits, WrongTokensKeepNoGoodOneOut) {
  ServerConfig config = testing::any_ports();
  config.join_burst = 6;  // limit of a network; a host has half of this limit
  config.join_rate = 0.001;
  Server server(config, floor(), test::security());
  const ServerAccess guess = test::access(server.control_port(), "127.0.0.1",
                                          issue_token("x", "*", Role::admin, std::nullopt).text);
  for (int i = 0; i < 3; ++i) EXPECT_THAT(refusal(guess), HasSubstr("needs a token"));
  for (int i = 0; i < 20; ++i) {
    EXPECT_THAT(refusal(guess), HasSubstr("too many wrong tokens"));
    EXPECT_NO_THROW(list_scenes(test::access(server.control_port()), kPatience));
  }
  server.stop();
  EXPECT_EQ(server.control_summary().requests.unauthenticated, 3u);
  EXPECT_EQ(server.control_summary().requests.too_many, 20u);
}

/// A revoked token must end its session. An earlier invalid token file must change nothing.
TEST(Revocation, EndsASessionThatRuns) {
  const TemporaryFolder folder;
  const auto file = folder / "tokens.json";
  change_tokens(file, [](Tokens& tokens) { tokens.push_back(test::admin_token().token); });
  Server server(testing::any_ports(), floor(), {test::identity(), {}, TokenFile(file)});
  const ServerAccess access = test::access(server.control_port());
  test::ControlClient open(server.control_port());
  testing::Client hand(access, "t,x,y,z\n0,0,0,-0.001\n1000,0,0,-0.001\n", {}, "floor");
  hand.start();
  hand.next_tick("an answer", [](const TickRecord& row) { return row.age >= 0.0; });
  replace_file(file, "broken", kPrivate);
  EXPECT_NO_THROW(list_scenes(access, kPatience));
  replace_file(file, json({}), kPrivate);
  hand.finish();
  EXPECT_EQ(hand.result->end, EndReason::server_goodbye);
  EXPECT_EQ(hand.result->goodbye, GoodbyeReason::evicted);
  EXPECT_THAT(refusal(access), HasSubstr("needs a token"));
  // An open connection must lose its access too.
  EXPECT_EQ(open.ask<control::Refused>(control::ListScenes{}).code,
            control::RefusalCode::unauthenticated);
  EXPECT_TRUE(open.closed());
}

}  // namespace
}  // namespace feltwire::trust_test
