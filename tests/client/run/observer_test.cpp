// Two hands and an observer run as complete clients over real sockets. The observer must see both
// hands.

#include <gmock/gmock.h>

#include "client/run/observed_scene.hpp"
#include "tests/client/loopback.hpp"
#include "tests/core/moving.hpp"
#include "tests/support/eventually.hpp"

namespace feltwire::observer_test {
namespace {

using testing::kPatience;

/// An observer without a servo loop. It sends a sample and takes the view of the reply.
struct ObserverClient {
  ObserverClient(const ServerAccess& server, const std::string& of)
      : joined(join(server, {"eye", of, builtin_device("simulated"), fast(), Role::observer},
                    kPatience)),
        transport({joined.datagrams, joined.accepted.session, joined.keys},
                  joined.accepted.parameters, false) {}

  /// A short servo period allows frequent views.
  static SessionParameters fast() {
    SessionParameters parameters;
    parameters.servo_period = 1e-5;
    return parameters;
  }
  /// Returns the newest view.
  const ObservedScene& look() {
    Sample sample;
    sample.index = ++index;
    sample.client_time = Nanoseconds(static_cast<std::int64_t>(1'000'000 * index));
    // The position is deep in the floor, but an observer gets no force.
    sample.pose.position = {0, 0, -0.1};
    transport.send(sample);
    Reply reply;
    GoodbyeReason reason{};
    test::eventually("the answer to the newest sample", [&] {
      return transport.receive(reply, reason) == Transport::Arrival::reply &&
             reply.sample_index >= index;
    });
    EXPECT_EQ(reply.command, Command{});
    EXPECT_NE(transport.view(), nullptr);
    if (transport.view() != nullptr) scene.take(*transport.view());
    return scene;
  }

  Joined joined;
  Transport transport;
  ObservedScene scene;
  std::uint64_t index = 0;
};

std::string standing(double x) {
  const std::string place = "," + std::to_string(x) + ",0,0.125\n";
  return "t,x,y,z\n0" + place + "1000" + place;
}

TEST(Observing, TwoHandsAndWhatMoves) {
  std::vector<Scene> scenes;
  scenes.push_back(
      test::moving({test::object("floor", Plane{}, {.stiffness = 500}),
                    test::object("ball", Sphere{0.03}, {.stiffness = 1000}, {0, 0, 2})},
                   {-1, 0}, {test::body("ball", 0.2, {0, 0, 2})}));
  Server server(testing::any_ports(), std::move(scenes), test::security());
  const ServerAccess access = test::access(server.control_port());
  testing::Client left(access, standing(-0.25).c_str(), {}, "moving"),
      right(access, standing(0.5).c_str(), {}, "moving");
  left.start();
  right.start();
  ObserverClient eye(access, "moving");
  test::eventually("both hands in sight", [&] { return eye.look().hands().size() >= 2; });
  EXPECT_EQ(eye.scene.hands().at(1).pose.position, Vec3(-0.25, 0, 0.125));
  EXPECT_EQ(eye.scene.hands().at(2).pose.position, Vec3(0.5, 0, 0.125));
  ASSERT_EQ(eye.scene.bodies().size(), 1u);
  EXPECT_EQ(eye.scene.bodies().begin()->first, 1u);
  // The ball falls straight down. The observer's hand in the floor must not support it.
  double height = eye.scene.bodies().at(1).pose.position.z();
  test::eventually("a fall of 0.1 m", [&] {
    const Vec3 at = eye.look().bodies().at(1).pose.position;
    EXPECT_LE(at.z(), height + 1e-6);
    EXPECT_NEAR(at.x(), 0.0, 1e-6);
    height = at.z();
    return height <= 1.9;
  });

  right.stop.set();
  right.finish();
  test::eventually("one hand gone", [&] { return eye.look().hands().size() <= 1; });
  EXPECT_EQ(eye.scene.hands().begin()->first, 1u);
  left.stop.set();
}

/// The servo loop passes the views on when they arrive, even if the test does not read. The
/// observer's hand deep in the floor must get no force.
TEST(Observing, TheLoopGivesItsViewsToWhoeverReads) {
  std::vector<Scene> scenes;
  scenes.push_back(testing::floor_scene());
  Server server(testing::any_ports(), std::move(scenes), test::security());
  const ServerAccess access = test::access(server.control_port());
  testing::Client hand(access, standing(0.25).c_str(), {}, "floor");
  testing::Client eye(access, "t,x,y,z\n0,0,0,-0.1\n1000,0,0,-0.1\n", {}, "floor", nullptr, nullptr,
                      Role::observer);
  hand.start();
  eye.start();
  ObservedScene scene;
  TimedView shown;
  double before = 0.0;
  test::eventually("a hand in sight", [&] {
    if (!eye.views.pop(shown)) return false;
    EXPECT_GE(shown.time, before);  // Views that arrive together share one time.
    before = shown.time;
    scene.take(shown.view);
    return !scene.hands().empty();
  });
  EXPECT_EQ(scene.hands().at(1).pose.position, Vec3(0.25, 0, 0.125));
  const std::uint64_t enough = 16 + 1;  // more views than the ring can hold
  for (std::uint64_t rows = 0; rows < 20 * enough; ++rows) {
    const TickRecord row = eye.next_tick("a tick", [](const TickRecord&) { return true; });
    EXPECT_EQ(row.elastic, Vec3::Zero());
    EXPECT_EQ(row.held, Vec3::Zero());
  }
  eye.stop.set();
  eye.finish();
  EXPECT_GT(eye.servo.statistics().replies.answered, enough);
  EXPECT_GT(eye.result->views_dropped, 0u);
  EXPECT_EQ(eye.transport.statistics().dropped, TransportStatistics{}.dropped);
  hand.stop.set();
  hand.finish();
  EXPECT_FALSE(hand.views.pop(shown));  // An operator gets no views.
}

}  // namespace
}  // namespace feltwire::observer_test
