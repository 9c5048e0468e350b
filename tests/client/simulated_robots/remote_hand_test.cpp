// Tests the robot's surfaces as the force on the hand that leads the robot.

#include "client/servo/remote_hand.hpp"

#include <gtest/gtest.h>

namespace feltwire::remote_hand_test {
namespace {

constexpr double kPeriod = 1e-3;                           // [s]
constexpr double kStiffness = 500.0, kHalfWidth = 0.5e-3;  // [N/m], [m] of a slot across x

RemoteContact wall(double normal, std::uint32_t surface) {
  return {.surface = surface,
          .point = Vec3(-normal * kHalfWidth, 0.0, 0.0),
          .normal = normal * Vec3::UnitX(),
          .stiffness = kStiffness};
}

struct Hand {
  RemoteHand remote{RemoteTrust{}, 0.02};
  Vec3 before = Vec3::Zero();

  /// Returns the force of the surfaces on a hand at x [m].
  double at(double x) {
    const Vec3 place(x, 0.0, 0.0);
    remote.step(place, place - before, Vec3::Zero(), kPeriod);
    before = place;
    return remote.touch({place, Vec3::Zero()}, {}, 0.0, kPeriod).force().x();
  }
};

Remote slot() {
  Remote remote;
  remote.state = LinkState::engaged;
  remote.contact = wall(-1.0, 2);
  remote.others.surfaces[0] = wall(1.0, 1);
  remote.others.count = 1;
  return remote;
}

TEST(RemoteHand, BothWallsOfASlotPress) {
  Hand hand;
  hand.remote.take(slot());
  for (int n = 0; n < 50; ++n) EXPECT_EQ(hand.at(0.0), 0.0);
  EXPECT_EQ(hand.remote.lead(true, {}).known_surface, 2u);
  constexpr double kDeep = 1e-3;  // [m]
  for (const double side : {1.0, -1.0, 1.0, -1.0}) {
    EXPECT_NEAR(hand.at(side * (kHalfWidth + kDeep)), -side * kStiffness * kDeep, 1e-9);
    EXPECT_EQ(hand.at(0.0), 0.0);
  }
  EXPECT_TRUE(hand.remote.lead(true, {}).offset.isZero(0.0));
}

TEST(RemoteHand, ASurfaceThatIsToldNoMoreIsGone) {
  Hand hand;
  Remote remote = slot();
  hand.remote.take(remote);
  hand.at(0.0);
  EXPECT_GT(hand.at(-1e-3), 0.0);
  remote.others = {};
  hand.remote.take(remote);
  EXPECT_EQ(hand.at(-1e-3), 0.0);
  // When the surface is reported again, it counts as another surface. The new surface begins at the
  // hand's position.
  remote.others.surfaces[0] = wall(1.0, 3);
  remote.others.count = 1;
  hand.remote.take(remote);
  EXPECT_NEAR(hand.at(-1e-3), 0.0, 1e-12);
  EXPECT_NEAR(hand.remote.lead(true, {}).offset.x(), -1e-3 + kHalfWidth, 1e-12);
  EXPECT_EQ(hand.remote.lead(true, {}).known_surface, 3u);
}

/// If a surface has left the tool, ContactEstimator reports it far from the tool. The surface is
/// still known.
TEST(RemoteHand, ASurfaceThatHasLeftPressesNoMoreAndIsMetAgainWhereItIs) {
  Hand hand;
  Remote remote = slot();
  remote.others = {};
  remote.contact.touching = true;
  hand.remote.take(remote);
  constexpr double kDeep = kHalfWidth + 1e-3;
  hand.at(0.0);
  EXPECT_NEAR(hand.at(kDeep), -kStiffness * 1e-3, 1e-9);
  Remote away = remote;
  away.contact.touching = false;
  away.contact.point.x() = kHalfWidth + ContactEstimator::kAway;
  hand.remote.take(away);
  for (int n = 0; n < 50; ++n) EXPECT_EQ(hand.at(kDeep), 0.0) << n;
  EXPECT_EQ(hand.remote.lead(true, {}).known_surface, 2u);
  hand.remote.take(remote);
  EXPECT_NEAR(hand.at(kDeep), -kStiffness * 1e-3, 1e-9);
  EXPECT_TRUE(hand.remote.lead(true, {}).offset.isZero(0.0));
}

/// The contact itself may be forgotten earlier than the other surfaces.
TEST(RemoteHand, SurfacesPressWithoutAContact) {
  Hand hand;
  Remote remote = slot();
  remote.contact = {};
  hand.remote.take(remote);
  hand.at(0.0);
  EXPECT_NEAR(hand.at(-kHalfWidth - 1e-3), kStiffness * 1e-3, 1e-9);
  EXPECT_EQ(hand.at(kHalfWidth + 1e-3), 0.0);
}

}  // namespace
}  // namespace feltwire::remote_hand_test
