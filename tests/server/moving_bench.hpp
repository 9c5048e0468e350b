#pragma once
// Hands in a scene in which something moves, through SceneSessions as a server has it: by the
// test's clock.

#include <gtest/gtest.h>

#include <map>

#include "server/scene/scene_sessions.hpp"
#include "tests/core/moving.hpp"
#include "tests/protocol/sealed.hpp"
#include "tests/server/make.hpp"
#include "tests/support/allocation_counter.hpp"

namespace feltwire::test {

inline constexpr std::uint64_t kLeft = 1 << 8, kRight = 2 << 8, kThird = 3 << 8, kFourth = 4 << 8;

inline const Material kGrippy{
    .stiffness = 1000, .damping = 1.0, .static_friction = 0.9, .dynamic_friction = 0.7};

/// A box of 4 cm and `mass` [kg] on a table at z = 0.
inline Scene box_on_table(double mass = 0.1) {
  return moving({object("table", Plane{}, kGrippy),
                 object("box", Box{Vec3::Constant(0.02)}, kGrippy, {0, 0, 0.02})},
                {-1, 0}, {body("box", mass, {0, 0, 0.02})});
}

struct MovingBench {
  explicit MovingBench(const Scene& of) : scene(of) {}

  void join(std::uint64_t id, const SessionParameters& parameters = {},
            const DeviceSpec& held_by = device()) {
    control::JoinRequest request = test::join_request(parameters);
    request.device = held_by;
    request.scene = scene.name();
    ASSERT_TRUE(std::holds_alternative<control::JoinAccepted>(
        sessions.answer(request, id, test::keys(id), now)));
  }
  /// The hand of session `id` is at `place` now; what it is answered.
  Reply hand(std::uint64_t id, const Vec3& place) {
    SampleBatch batch;
    batch.count = 1;
    Sample& sample = batch.samples[0];
    sample.index = ++index[id];
    sample.client_time = now;
    sample.pose.position = place;
    sample.held = held[id];
    DatagramBuffer out;
    const Bytes datagram = encoder.samples(id, sample.index, batch);
    const std::size_t before = test::allocations();
    const Bytes answer = sessions.receive(datagram, {}, now, out);
    allocated += test::allocations() - before;
    Reply reply;
    EXPECT_EQ(decode(test::opened(answer, test::Way::down), reply), DropReason::none);
    held[id] = reply.command;
    return reply;
  }
  void advance(Nanoseconds by = std::chrono::milliseconds(1)) {
    now += by;
    const std::size_t before = test::allocations();
    sessions.tick(now);
    allocated += test::allocations() - before;
  }
  const World& world() const { return *sessions.world(); }
  Vec3 place(std::size_t at) const { return world().objects()[at].pose.position; }

  const Scene& scene;
  SceneSessions sessions{scene, std::chrono::seconds(2), 4};
  test::SealedEncoder encoder{test::Way::up};
  Nanoseconds now{std::chrono::seconds(1)};
  std::size_t allocated = 0;  // by the server's side
  std::map<std::uint64_t, std::uint64_t> index;
  std::map<std::uint64_t, Command> held;
};

}  // namespace feltwire::test
