// The seats of a scene for robots: who may sit there, and what becomes of them in another scene.

#include "server/scene/robot_seats.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/server/make_slot.hpp"

namespace feltwire::robot_seats_test {
namespace {

using ::testing::HasSubstr;

Scene with_seats(const std::vector<std::string>& names) {
  Scene scene = test::room();
  std::vector<RemoteSeat> seats;
  for (const std::string& name : names) seats.push_back({.name = name});
  scene.set_seats(seats);
  return scene;
}

control::JoinRequest robot(const std::string& seat) {
  control::JoinRequest request = test::join_request({});
  request.role = Role::follower;
  request.seat = seat;
  return request;
}

struct Bench {
  explicit Bench(const std::vector<std::string>& names) : scene(with_seats(names)) {
    seats.take_over(seats.seats_of(scene, nullptr));
  }
  std::string refusal(const control::JoinRequest& request) const {
    const auto refused = seats.refuse(request, scene.name());
    return refused ? refused->reason : std::string();
  }
  std::unique_ptr<SessionSlot> sit(std::uint32_t number, const std::string& seat) {
    auto slot = test::make_slot(scene, number, robot(seat));
    EXPECT_EQ(refusal(robot(seat)), "");
    seats.seat_robot(*slot, robot(seat));
    return slot;
  }
  Scene scene;
  RobotSeats seats;
};

TEST(RobotSeats, AHandNeedsNoSeat) { EXPECT_EQ(Bench({}).refusal(test::join_request({})), ""); }

TEST(RobotSeats, ARobotLearnsWhyItCannotSit) {
  EXPECT_THAT(Bench({}).refusal(robot("")), HasSubstr("has no seat for a robot"));
  EXPECT_THAT(Bench({""}).refusal(robot("left")), HasSubstr("leave out --seat"));
  Bench bench({"left", "right"});
  EXPECT_THAT(bench.refusal(robot("")), HasSubstr("several seats"));
  EXPECT_THAT(bench.refusal(robot("middle")), HasSubstr("choose with --seat: left, right"));
}

TEST(RobotSeats, ASeatIsTakenUntilItsRobotLeaves) {
  Bench bench({"left", "right"});
  const auto slot = bench.sit(7, "right");
  EXPECT_EQ(slot->seat, 1);
  EXPECT_EQ(bench.seats.name(1), "right");
  EXPECT_THAT(bench.refusal(robot("right")),
              HasSubstr("the seat 'right' of scene 'room' is taken"));
  EXPECT_EQ(bench.refusal(robot("left")), "");
  bench.seats.leave(*slot);
  EXPECT_EQ(bench.refusal(robot("right")), "");
}

TEST(RobotSeats, ARobotKeepsItsSeatInASceneWithTheSameSeats) {
  Bench bench({"left", "right"});
  const auto slot = bench.sit(7, "right");
  const Scene same = with_seats({"left", "right"}), other = with_seats({"right", "left"});
  ASSERT_TRUE(bench.seats.is_same(same));
  ASSERT_FALSE(bench.seats.is_same(other));
  EXPECT_EQ(bench.seats.seats_of(other, nullptr)[1].robot, nullptr);
  bench.seats.take_over(bench.seats.seats_of(same, nullptr));
  EXPECT_EQ(bench.seats.seats()[1].robot, slot.get());
  EXPECT_FALSE(bench.refusal(robot("right")).empty());
}

TEST(RobotSeats, AHandThatAsksForASeatThatDoesNotExistLeadsNothing) {
  Bench bench({""});
  const auto robot_slot = bench.sit(1, "");
  const auto hand = test::make_slot(bench.scene, 2, test::join_request({}));
  SampleBatch batch = test::hand_batch(1);
  batch.lead = Lead{};
  batch.lead->seat = 3;
  const Remote reply = bench.seats.lead(*hand, batch, Nanoseconds{0});
  EXPECT_EQ(reply.seat, 3);
  EXPECT_EQ(reply.state, LinkState::disabled);
  EXPECT_FALSE(bench.seats.moves_robot(*hand));
  EXPECT_FALSE(bench.seats.leads_arm(*hand, batch)) << "no arm of the world sits there";
}

/// A robot that has sent nothing yet is not seen, and no address is known for its target.
TEST(RobotSeats, ARobotIsSeenAfterItsFirstState) {
  Bench bench({"left", "right"});
  const auto slot = bench.sit(1, "right");
  const auto observer = test::make_slot(bench.scene, 2, test::join_request({}));
  Peer to;
  DatagramBuffer out;
  EXPECT_FALSE(bench.seats.next_seen(*observer, Nanoseconds{0}));
  EXPECT_TRUE(bench.seats.forward(1, Nanoseconds{0}, to, out).empty());

  RobotState state;
  state.index = 1;
  EXPECT_TRUE(bench.seats.follow(*slot, state, Nanoseconds{0}));
  EXPECT_FALSE(bench.seats.follow(*slot, state, Nanoseconds{0})) << "not newer";
  const auto seen = bench.seats.next_seen(*observer, Nanoseconds{0});
  ASSERT_TRUE(seen);
  EXPECT_EQ(seen->seat, 1);
  EXPECT_EQ(seen->seats, 2) << "the bit of the second seat";
}

}  // namespace
}  // namespace feltwire::robot_seats_test
