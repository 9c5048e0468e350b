// Servers of a fleet in one process, with a directory in memory, over real sockets.

#include <gmock/gmock.h>

#include "server/app/fleet_wishes.hpp"
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
  FleetServer(const std::string& name, const std::string& scene)
      : host_(scene + "-" + name), scene_(scene) {
    ServerConfig config = testing::any_ports();
    config.fleet = "memory,name=" + host_ + ",keys=" + (keys_ / name).string();
    std::vector<Scene> scenes;
    scenes.push_back(named_floor(scene));
    server_.emplace(config, std::move(scenes), test::security());
  }
  ServerAccess access() const { return test::access(server_->control_port()); }
  std::uint16_t port() const { return server_->control_port(); }
  void stop() { server_->stop(); }
  void leave() { server_->leave_fleet(); }
  std::string host() const { return host_; }

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
  std::string host_, scene_;
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

/// The error of a wish; empty: it was met.
template <class Work>
std::string refusal(Work work) {
  try {
    work();
  } catch (const std::exception& error) {
    return error.what();
  }
  return {};
}

/// Hands that have gone to the host, and feel there without a step of the force.
void expect_at(const FleetServer& host, std::initializer_list<const FleetHand*> hands) {
  for (const FleetHand* const hand : hands) {
    eventually("the hand has a session at the other host",
               [&] { return hand->port() == host.port(); });
    const auto felt = hand->felt();
    eventually("the hand feels the floor again", [&] { return hand->felt() > felt; });
    constexpr double kStep = 0.5;  // [N] the floor pushes with 1 N at most
    EXPECT_LT(hand->ticks().step_up(), kStep);
    std::printf("longest time without a session: %.0f ms\n", 1e3 * hand->ticks().without_session());
  }
}

void await_standby(const std::string& scene) {
  await_record(scene, "the owner names its standby",
               [](const SceneRecord& record) { return record.standby.number != 0; });
}

TEST(Fleet, TheHandsOfAHostThatDrainsGoToAnother) {
  Directory& directory = *memory_directory();
  const FleetServer first("a", "drains");
  first.joined();
  const FleetServer second("b", "drains");
  await_standby("drains");
  const FleetHand one(first.access(), "drains"), two(second.access(), "drains");
  expect_at(first, {&one, &two});
  EXPECT_THAT(drain_host(directory, first.host()), HasSubstr("serves no scene"));
  expect_at(second, {&one, &two});
  EXPECT_EQ(one.losses(), 1u);
  EXPECT_THAT(refusal([&] { drain_host(directory, first.host()); }), HasSubstr("drains already"));
  EXPECT_THAT(refusal([&] { move_scene(directory, "drains", first.host()); }),
              HasSubstr("drains, so it takes no scene"));
  EXPECT_THAT(refusal([&] { drain_host(directory, second.host()); }),
              HasSubstr("keeps drains: no other host that takes scenes has its files"));
  undrain_host(directory, second.host());
  undrain_host(directory, first.host());
  EXPECT_THAT(move_scene(directory, "drains", first.host()), HasSubstr("serves scene drains now"));
  expect_at(first, {&one, &two});
  EXPECT_EQ(one.losses(), 2u);
}

TEST(Fleet, AWishThatCannotBeMetSaysWhy) {
  Directory& directory = *memory_directory();
  const FleetServer owner("a", "wishes");
  owner.joined();
  const FleetServer other("b", "has other scenes");
  EXPECT_THAT(refusal([&] { drain_host(directory, "nobody"); }), HasSubstr("has no host 'nobody'"));
  EXPECT_THAT(refusal([&] { move_scene(directory, "nothing", owner.host()); }),
              HasSubstr("has no scene 'nothing'"));
  EXPECT_THAT(refusal([&] { move_scene(directory, "wishes", owner.host()); }),
              HasSubstr("already"));
  EXPECT_THAT(refusal([&] { move_scene(directory, "wishes", other.host()); }),
              HasSubstr("with the files of the host that serves it"));
  EXPECT_THAT(refusal([&] { undrain_host(directory, owner.host()); }), HasSubstr("not drain"));
  HostRecord dead;
  dead.host = {"dead", 66};
  directory.put(Bucket::hosts, "dead", encode(dead));
  EXPECT_THAT(refusal([&] { move_scene(directory, "wishes", "dead"); }), HasSubstr("is silent"));
}

TEST(Fleet, AHostThatEndsHandsItsScenesOver) {
  FleetServer owner("a", "leaves");
  owner.joined();
  const FleetServer other("b", "leaves");
  await_standby("leaves");
  const FleetHand hand(owner.access(), "leaves");
  expect_at(owner, {&hand});
  owner.leave();
  await_record("leaves", "the other host serves the scene",
               [&](const SceneRecord& record) { return record.owner.name == other.host(); });
  owner.stop();
  expect_at(other, {&hand});
  EXPECT_EQ(hand.losses(), 1u);
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
