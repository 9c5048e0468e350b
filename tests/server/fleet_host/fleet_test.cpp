// Servers of a fleet in one process, with a directory in memory, over real sockets.

#include <gmock/gmock.h>

#include "server/fleet/record_codec.hpp"
#include "server/fleet_host/open_directory.hpp"
#include "tests/client/floor_server.hpp"
#include "tests/server/fleet_host/fleet_hand.hpp"
#include "tests/support/eventually.hpp"
#include "tests/support/security.hpp"
#include "tests/support/temporary_folder.hpp"

namespace feltwire::fleet_test {
namespace {

using test::eventually;
using test::FleetHand;
using ::testing::HasSubstr;

constexpr std::chrono::milliseconds kPatience{10'000};

Scene named_floor(const std::string& name) {
  const Scene floor = testing::floor_scene();
  return Scene(name, floor.objects());
}

/// A server with one scene, in the fleet of this process. Each test has a scene name of its own,
/// because the directory outlives the test.
class FleetServer {
 public:
  FleetServer(const std::string& name, const std::string& scene) : scene_(scene) {
    ServerConfig config = testing::any_ports();
    config.fleet = "memory,name=" + scene + "-" + name + ",keys=" + (keys_ / name).string();
    std::vector<Scene> scenes;
    scenes.push_back(named_floor(scene));
    server_.emplace(config, std::move(scenes), test::security());
  }
  ServerAccess access() const { return test::access(server_->control_port()); }
  std::uint16_t port() const { return server_->control_port(); }
  void stop() { server_->stop(); }

  control::JoinRequest request() const {
    return {"tester", scene_, builtin_device("simulated"), {}};
  }
  /// Joins once a host serves the scene.
  Joined joined() const {
    std::optional<Joined> joined;
    eventually("a host takes the join", [&] {
      try {
        joined = join(access(), request(), kPatience);
      } catch (const LastingError&) {
        throw;
      } catch (const SessionError&) {  // nobody serves the scene yet
      }
      return joined.has_value();
    });
    return *joined;
  }

 private:
  test::TemporaryFolder keys_;
  std::string scene_;
  std::optional<Server> server_;
};

/// The record of the scene, once it meets the condition.
template <class Condition>
SceneRecord await_record(const std::string& scene, const std::string& what, Condition condition) {
  const auto watch = memory_directory()->watch(Bucket::scenes);
  SceneRecord found;
  eventually(what, [&] {
    const auto entry = watch->next(std::chrono::milliseconds(50));
    if (!entry || entry->key != scene) return false;
    const auto record = decode_scene_record(entry->value);
    if (!record || !condition(*record)) return false;
    found = *record;
    return true;
  });
  return found;
}

TEST(Fleet, AnyHostAnswersAJoin) {
  const FleetServer owner("a", "answers");
  const Joined direct = owner.joined();
  EXPECT_EQ(direct.host.endpoint.port, owner.port());
  EXPECT_GE(direct.accepted.epoch.term, 1u);
  const FleetServer other("b", "answers");
  const Joined joined = other.joined();
  EXPECT_EQ(joined.host.endpoint.port, owner.port());
  EXPECT_EQ(joined.accepted.epoch, direct.accepted.epoch);
}

TEST(Fleet, AClientWithoutRedirectsIsToldWhereToJoin) {
  const FleetServer owner("a", "told");
  const Joined direct = owner.joined();
  const FleetServer other("b", "told");
  other.joined();  // the other host knows the owner now
  control::JoinRequest request = other.request();
  request.follows_redirects = false;
  std::string said;
  try {
    ask_to_join(other.access(), request, kPatience, {});
  } catch (const LastingError& error) {
    said = error.what();
  }
  EXPECT_THAT(said, HasSubstr("join at 127.0.0.1:" + std::to_string(owner.port())));
}

TEST(Fleet, ATicketOpensOneJoinAtTheOwner) {
  const FleetServer owner("a", "ticket");
  owner.joined();
  const FleetServer other("b", "ticket");
  other.joined();
  control::JoinRequest request = other.request();
  request.follows_redirects = true;
  const auto redirection =
      std::get<Redirection>(ask_to_join(other.access(), request, kPatience, {}));
  EXPECT_EQ(redirection.host.endpoint.port, owner.port());
  request.ticket = redirection.ticket;
  const auto refusal = [&](const ServerAccess& server) -> std::string {
    try {
      ask_to_join(server, request, kPatience, {});
    } catch (const LastingError& error) {
      return std::string("for good: ") + error.what();
    } catch (const SessionError& error) {
      return error.what();
    }
    return {};
  };
  EXPECT_THAT(refusal(other.access()), HasSubstr("is not good: wrong host"));
  EXPECT_EQ(refusal(redirection.host), "");
  EXPECT_THAT(refusal(redirection.host), HasSubstr("is not good: used"));
  const Server alone(
      testing::any_ports(),
      [] {
        std::vector<Scene> scenes;
        scenes.push_back(named_floor("ticket"));
        return scenes;
      }(),
      test::security());
  EXPECT_THAT(refusal(test::access(alone.control_port())), HasSubstr("is in no fleet"));
}

TEST(Fleet, TheHandsOfAHostThatEndsFeelAgainAtItsStandby) {
  FleetServer owner("a", "ends");
  owner.joined();
  const FleetServer standby("b", "ends");
  await_record("ends", "the owner names its standby",
               [](const SceneRecord& record) { return record.standby.number != 0; });
  const FleetHand hand(owner.access(), "ends");
  eventually("the hand feels the floor", [&] { return hand.felt() > 0; });
  EXPECT_EQ(hand.port(), owner.port());
  owner.stop();
  eventually("the hand has a session at the standby",
             [&] { return hand.port() == standby.port(); });
  const auto felt = hand.felt();
  eventually("the hand feels the floor again", [&] { return hand.felt() > felt; });
  const SceneRecord taken = await_record(
      "ends", "the standby tells the directory",
      [&](const SceneRecord& record) { return record.version.epoch > hand.first_epoch(); });
  // The host before, started again, is behind: a client that has seen the standby refuses it.
  control::JoinRequest request = standby.request();
  request.epoch = taken.version.epoch;
  const FleetServer again("a", "ends");
  eventually("the host that began anew sends the client to the standby", [&] {
    try {
      FleetRoute route(again.access());
      return route.join(request, kPatience).host.endpoint.port == standby.port();
    } catch (const SessionError&) {
      return false;
    }
  });
}

TEST(Fleet, AnOwnerThatHearsOfAHigherEpochEndsItsSessions) {
  const FleetServer owner("a", "higher");
  const Joined joined = owner.joined();
  const FleetHand hand(owner.access(), "higher");
  eventually("the hand feels the floor", [&] { return hand.felt() > 0; });
  SceneRecord record;
  record.owner = {"elsewhere", 99};
  record.version = {{joined.accepted.epoch.term + 7, 99}, 1};
  memory_directory()->put(Bucket::scenes, "higher", encode(record));
  eventually("the session ends", [&] { return hand.losses() > 0; });
  // The new owner is gone for good, so the scene comes back above its epoch, and the hand with it.
  const auto felt = hand.felt();
  eventually("the hand feels the floor again", [&] { return hand.felt() > felt; });
  EXPECT_GT(owner.joined().accepted.epoch, record.version.epoch);
}

}  // namespace
}  // namespace feltwire::fleet_test
