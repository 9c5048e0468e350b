#pragma once
// Hands in a scene with moving bodies, through the server's SceneSessions, with a simulated clock.

#include <gtest/gtest.h>

#include <map>

#include "tests/core/moving.hpp"
#include "tests/server/make.hpp"
#include "tests/server/sample_exchange.hpp"

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

struct MovingBench : SampleExchange {
  using SampleExchange::SampleExchange;

  void join(std::uint64_t id, const SessionParameters& parameters = {},
            const DeviceSpec& held_by = device()) {
    control::JoinRequest request = test::join_request(parameters);
    request.device = held_by;
    request.scene = scene.name();
    ASSERT_TRUE(std::holds_alternative<control::JoinAccepted>(
        sessions.answer(request, id, test::keys(id), now)));
  }
  /// Puts the hand of session `id` at `place`; returns the answer.
  Reply hand(std::uint64_t id, const Vec3& place) {
    Sample sample;
    sample.pose.position = place;
    sample.held = held[id];
    Reply reply;
    EXPECT_EQ(decode(send(id, sample, false), reply), DropReason::none);
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

  std::map<std::uint64_t, Command> held;
};

}  // namespace feltwire::test
