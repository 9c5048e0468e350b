// Programs feltwire-server in a fleet on real NATS servers, and hands by the client library. Hosts
// and directories are killed.

#include <gmock/gmock.h>

#include <csignal>
#include <fstream>

#include "core/base/pending_file.hpp"
#include "tests/server/fleet_host/fleet_hand.hpp"
#include "tests/server/nats_directory/nats_servers.hpp"
#include "tests/support/eventually.hpp"
#include "tests/support/security.hpp"
#include "tests/support/text_of.hpp"

namespace feltwire::fleet_nats_test {
namespace {

using test::eventually;
using test::FleetHand;
using test::NatsServers;
using test::TemporaryFolder;

constexpr const char* kScene = R"({
  "name": "floor",
  "materials": [{ "name": "soft", "stiffness": 500 }],
  "objects": [{ "name": "floor", "plane": {}, "material": "soft" }]
})";

/// The things that the hosts of a fleet share: the directory, the scene and the tokens.
struct Fleet {
  NatsServers directory;
  TemporaryFolder folder;

  explicit Fleet(int servers) : directory(servers) {
    replace_file(folder / "floor.json", kScene, kPublic);
    change_tokens(folder / "tokens.json",
                  [](Tokens& tokens) { tokens.push_back(test::admin_token().token); });
  }
};

/// A program feltwire-server with a certificate of its own.
class Host {
 public:
  Host(const Fleet& fleet, const std::string& name) {
    const NatsOptions options = fleet.directory.options();
    state_ = fleet.folder / name;
    const std::filesystem::path keys = state_ / "fleet";
    std::filesystem::create_directories(keys);
    for (const auto& folder : {state_, keys})
      std::filesystem::permissions(folder, std::filesystem::perms::owner_all);
    const auto copy = [&](const std::filesystem::path& from, const char* to) {
      std::ifstream in(from);
      replace_file(keys / to, std::string(std::istreambuf_iterator<char>(in), {}), kPrivate);
    };
    copy(options.authority, "ca.pem");
    copy(options.certificate, "host.pem");
    copy(options.key, "host.key");
    replace_file(keys / "password", options.password.text(), kPrivate);
    std::string servers;
    for (const std::string& server : options.servers)
      servers += (servers.empty() ? "" : ",") + server.substr(std::string("tls://").size());
    fleet_ = "nats://" + servers + ",name=" + name;
    program_ = std::make_unique<test::Program>(
        FELTWIRE_SERVER_PROGRAM,
        std::vector<std::string>{"--scene", fleet.folder / "floor.json", "--port", "0", "--state",
                                 state_, "--tokens", fleet.folder / "tokens.json", "--log-level",
                                 "error", "--fleet", fleet_});
    const std::string first = program_->line(), ports = program_->line();
    const std::string_view before = "fingerprint: ";
    const auto at = ports.find("tcp ");
    if (!first.starts_with(before) || at == std::string::npos)
      throw std::runtime_error("no server: " + program_->finish().error);
    access_ = {{"127.0.0.1", static_cast<std::uint16_t>(std::stoi(ports.substr(at + 4)))},
               {parse_fingerprint(first.substr(before.size())), {}, {}, test::admin_token().text}};
  }
  const ServerAccess& access() const { return access_; }
  std::uint16_t port() const { return access_.endpoint.port; }
  void kill() { program_->signal(SIGKILL); }
  /// Ends it as a service manager does. Returns its exit status.
  int terminate() {
    program_->signal(SIGTERM);
    return program_->finish().status;
  }
  /// Runs `feltwire-server fleet WORDS` with this host's directory and keys.
  test::Outcome command(std::vector<std::string> words) const {
    words.insert(words.begin(), "fleet");
    return run(std::move(words));
  }
  /// As command(), of any subcommand.
  test::Outcome run(std::vector<std::string> words) const {
    words.insert(words.end(), {"--fleet", fleet_, "--state", state_});
    return test::Program(FELTWIRE_SERVER_PROGRAM, std::move(words)).finish();
  }

 private:
  std::filesystem::path state_;
  std::string fleet_;
  std::unique_ptr<test::Program> program_;
  ServerAccess access_;
};

control::JoinRequest request() { return {"tester", "floor", builtin_device("simulated"), {}}; }

/// Joins there, once a host serves the scene. Returns the port of that host.
std::uint16_t owner_by(const ServerAccess& server) {
  std::uint16_t port = 0;
  eventually("a host takes the join", [&] {
    try {
      port = join(server, request(), FleetHand::kPatience).host.endpoint.port;
    } catch (const LastingError&) {
      throw;
    } catch (const SessionError&) {  // nobody serves the scene yet
    }
    return port != 0;
  });
  return port;
}

/// Waits until the owner tells clients of its standby.
void await_standby(const Host& owner, const Host& standby) {
  eventually("the owner names the other host", [&] {
    try {
      const Joined joined = join(owner.access(), request(), FleetHand::kPatience);
      ask(joined.host, control::LeaveRequest{joined.accepted.session}, FleetHand::kPatience);
      return !joined.others.empty() && joined.others.front().endpoint.port == standby.port();
    } catch (const LastingError&) {
      throw;
    } catch (const SessionError&) {  // this client joins too often
      return false;
    }
  });
}

TEST(FleetOnNats, HandsFeelAgainAfterTheirHostWasKilled) {
  const Fleet fleet(1);
  Host first(fleet, "a");
  ASSERT_EQ(owner_by(first.access()), first.port());
  Host second(fleet, "b");
  EXPECT_EQ(owner_by(second.access()), first.port());  // by a redirect
  await_standby(first, second);
  const FleetHand one(first.access(), "floor"), two(second.access(), "floor");
  for (const FleetHand* const hand : {&one, &two})
    eventually("the hand feels the floor", [&] { return hand->felt() > 0; });
  EXPECT_EQ(two.port(), first.port());
  first.kill();
  for (const FleetHand* const hand : {&one, &two}) {
    eventually("the hand has a session at the other host",
               [&] { return hand->port() == second.port(); });
    const auto felt = hand->felt();
    eventually("the hand feels the floor again", [&] { return hand->felt() > felt; });
    EXPECT_GE(hand->losses(), 1u);
  }
  const Host third(fleet, "c");
  EXPECT_EQ(owner_by(third.access()), second.port());
}

/// Waits until the hand feels the floor in a session at that host.
void expect_at(const Host& host, const FleetHand& hand) {
  eventually("the hand has a session at that host", [&] { return hand.port() == host.port(); });
  const auto felt = hand.felt();
  eventually("the hand feels the floor there", [&] { return hand.felt() > felt; });
}

TEST(FleetOnNats, AnOperatorMovesAndDrainsAndAHostThatEndsHandsOver) {
  const Fleet fleet(1);
  Host first(fleet, "a");
  ASSERT_EQ(owner_by(first.access()), first.port());
  const Host second(fleet, "b");
  await_standby(first, second);
  const FleetHand hand(second.access(), "floor");
  expect_at(first, hand);

  const test::Outcome nobody = first.command({"move", "floor", "nobody"});
  EXPECT_EQ(nobody.status, 2);
  EXPECT_THAT(nobody.error, ::testing::HasSubstr("nobody"));
  EXPECT_EQ(hand.losses(), 0u);

  const test::Outcome moved = first.command({"move", "floor", "b"});
  EXPECT_EQ(moved.status, 0) << moved.error;
  expect_at(second, hand);
  const test::Outcome drained = first.command({"drain", "b"});
  EXPECT_EQ(drained.status, 0) << drained.error;
  expect_at(first, hand);
  EXPECT_THAT(first.command({"status"}).out, ::testing::HasSubstr("drain"));
  const test::Outcome undrained = second.command({"undrain", "b"});
  EXPECT_EQ(undrained.status, 0) << undrained.error;
  await_standby(first, second);
  EXPECT_EQ(hand.losses(), 2u);
  EXPECT_EQ(first.terminate(), 0);
  expect_at(second, hand);
  EXPECT_EQ(hand.losses(), 3u);
  std::printf("longest time without a session: %.0f ms\n", 1e3 * hand.ticks().without_session());
}

TEST(FleetOnNats, ATokenOfTheFleetCountsAtEveryHostUntilItIsRevoked) {
  Fleet fleet(1);
  const Host first(fleet, "a");
  ASSERT_EQ(owner_by(first.access()), first.port());
  const Host second(fleet, "b");
  await_standby(first, second);
  const test::Outcome added =
      second.run({"token", "add", "--client", "anna", "--scene", "floor", "--role", "operator",
                  "--expires", "1d", "--out", fleet.folder / "anna.token"});
  ASSERT_EQ(added.status, 0) << added.error;
  const std::string text = test::text_of(fleet.folder / "anna.token");
  const auto as_anna = [&](const Host& host) {
    ServerAccess access = host.access();
    access.credentials.token = Secret(text.substr(0, text.find('\n')));
    return access;
  };
  const auto comes_in = [&](const Host& host) {
    try {
      const Joined joined = join(as_anna(host), request(), FleetHand::kPatience);
      ask(joined.host, control::LeaveRequest{joined.accepted.session}, FleetHand::kPatience);
      return true;
    } catch (const SessionError&) {
      return false;
    }
  };
  for (const Host* const host : {&first, &second})
    eventually("the host knows the token", [&] { return comes_in(*host); });
  const FleetHand hand(as_anna(second), "floor");
  expect_at(first, hand);
  const std::string id = text.substr(3, 12);
  EXPECT_THAT(first.run({"token", "list"}).out, ::testing::HasSubstr(id));
  const test::Outcome revoked = first.run({"token", "revoke", id});
  ASSERT_EQ(revoked.status, 0) << revoked.error;
  eventually("the session of the token ends", [&] { return hand.losses() > 0; });
  for (const Host* const host : {&first, &second})
    eventually("the host refuses the token", [&] { return !comes_in(*host); });
  // A directory that is gone brings no token back.
  fleet.directory.kill(0);
  for (const Host* const host : {&first, &second}) EXPECT_FALSE(comes_in(*host));
}

TEST(FleetOnNats, WithoutTheDirectorySessionsJoinsAndTakeoversGoOn) {
  Fleet fleet(1);
  Host first(fleet, "a");
  ASSERT_EQ(owner_by(first.access()), first.port());
  const Host second(fleet, "b");
  EXPECT_EQ(owner_by(second.access()), first.port());
  await_standby(first, second);
  const FleetHand hand(first.access(), "floor");
  eventually("the hand feels the floor", [&] { return hand.felt() > 0; });
  fleet.directory.kill(0);
  auto felt = hand.felt();
  eventually("the hand goes on", [&] { return hand.felt() > felt + 20; });
  EXPECT_EQ(hand.losses(), 0u);
  EXPECT_EQ(owner_by(first.access()), first.port());
  EXPECT_EQ(owner_by(second.access()), first.port());
  EXPECT_EQ(hand.losses(), 0u);
  first.kill();
  eventually("the hand has a session at the other host",
             [&] { return hand.port() == second.port(); });
  felt = hand.felt();
  eventually("the hand feels the floor again", [&] { return hand.felt() > felt; });
}

}  // namespace
}  // namespace feltwire::fleet_nats_test
