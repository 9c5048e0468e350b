// Tests each reason for a zero force.

#include "client/servo/zero_force_reason.hpp"

#include <gmock/gmock.h>

#include <set>

#include "client/servo/servo.hpp"
#include "tests/client/servo_bench.hpp"

namespace feltwire::zero_force_reason_test {
namespace {

using namespace testing::servo;

/// A servo that got this command as the answer to its first sample.
struct BenchAfterCommand : Bench {
  explicit BenchAfterCommand(const Command& command, const ServoOptions& options = {},
                             std::string_view mode = "none",
                             BoundingSide side = BoundingSide::client)
      : Bench(parameters(mode, side), options) {
    tick();
    servo.take(reply(1, command), now);
  }
  ZeroForceReason why(const DeviceReading& reading = {}, Nanoseconds after = kPeriod) {
    tick(reading, after);
    return servo.no_force();
  }
};

ServoOptions limited(const ChannelLimits& force, double ramp_up = 0.0) {
  ServoOptions options;
  options.safety.force = force;
  options.safety.ramp_up = ramp_up;
  return options;
}
const Command kTwo = elastic(0, 0, 2);

TEST(ZeroForceReason, ThereIsForce) {
  BenchAfterCommand told(kTwo);
  EXPECT_EQ(told.why(), ZeroForceReason::felt);
  EXPECT_EQ(told.servo.statistics().no_force[static_cast<std::size_t>(ZeroForceReason::felt)], 1u);
  EXPECT_EQ(told.servo.statistics().no_force[static_cast<std::size_t>(ZeroForceReason::no_reply)],
            1u);
}

TEST(ZeroForceReason, NoReplyYet) {
  Bench bench(parameters("none"));
  EXPECT_EQ(bench.servo.no_force(), ZeroForceReason::no_reply);
  bench.tick();
  EXPECT_EQ(bench.servo.no_force(), ZeroForceReason::no_reply);
}

TEST(ZeroForceReason, NothingIsTouched) {
  EXPECT_EQ(BenchAfterCommand({}).why(), ZeroForceReason::touches_nothing);
}

TEST(ZeroForceReason, TheSceneAsksForTooLittle) {
  EXPECT_EQ(BenchAfterCommand(elastic(0, 0, 0.004)).why(), ZeroForceReason::too_little);
  EXPECT_EQ(BenchAfterCommand(elastic(0, 0, 0.006)).why(), ZeroForceReason::felt);
}

/// The hand begins in contact. The test uses each bound, because one bound gives a resting hand no
/// force in any case.
TEST(ZeroForceReason, WaitsBecauseItBeganInContact) {
  for (const std::string_view mode : {"none", "contact_frame"}) {
    BenchAfterCommand told(kTwo, limited({.small = 0.05}), mode);
    EXPECT_EQ(told.why(), ZeroForceReason::waiting);
    EXPECT_EQ(told.why(), ZeroForceReason::waiting);
  }
}

/// The servo reports the wait as the reason even if a hundredth of the force remains.
TEST(ZeroForceReason, AWaitThatLeavesNextToNothingIsSaid) {
  ForceTrail trail{.reply = {.answered = true}, .safety = {.waits = true}};
  CommandTrail& command = trail.command;
  command.asked = command.actuated = command.faded = command.bounded = elastic(0, 0, 6);
  command.safe = command.paid = command.held = elastic(0, 0, 0.06);
  EXPECT_EQ(zero_force_reason(trail), ZeroForceReason::waiting);
  command.held = elastic(0, 0, 0.61);
  EXPECT_EQ(zero_force_reason(trail), ZeroForceReason::felt);
  command.held = elastic(0, 0, 0.06);
  trail.safety.waits = false;
  EXPECT_EQ(zero_force_reason(trail), ZeroForceReason::felt);
}

TEST(ZeroForceReason, TheBoundLetsNoneThroughToAHandThatRests) {
  EXPECT_EQ(BenchAfterCommand(kTwo, {}, "contact_frame").why(), ZeroForceReason::bound);
}

TEST(ZeroForceReason, TheSafetyLimits) {
  EXPECT_EQ(BenchAfterCommand(kTwo, limited({}, 1.0)).why(), ZeroForceReason::ramp);
  EXPECT_EQ(BenchAfterCommand(kTwo, limited({.slew = 1.0})).why(), ZeroForceReason::slew);
  EXPECT_EQ(BenchAfterCommand(kTwo, limited({.max = 0.001})).why(), ZeroForceReason::force_limit);
  BenchAfterCommand fast(kTwo, limited({.speed = 0.1}));
  for (int i = 1; i < 20; ++i) fast.tick(at(0.002 * i, 0, 0));
  EXPECT_EQ(fast.why(at(0.04, 0, 0)), ZeroForceReason::velocity_limit);
}

TEST(ZeroForceReason, TheServerIsSilent) {
  BenchAfterCommand told(kTwo);
  EXPECT_EQ(told.why(), ZeroForceReason::felt);
  EXPECT_EQ(told.why({}, std::chrono::seconds(1)), ZeroForceReason::silent);
}

TEST(ZeroForceReason, TheSessionHasJustBeenFoundAgain) {
  BenchAfterCommand told(kTwo);
  EXPECT_EQ(told.why(), ZeroForceReason::felt);
  told.servo.reconnected(false);
  std::set<ZeroForceReason> reasons;
  for (int i = 0; i < 200; ++i) reasons.insert(told.why());
  EXPECT_TRUE(reasons.contains(ZeroForceReason::reconnecting));
}

TEST(ZeroForceReason, TheRunEnds) {
  BenchAfterCommand told(kTwo);
  EXPECT_EQ(told.why(), ZeroForceReason::felt);
  told.servo.release();
  for (int i = 0; i < 500 && !told.servo.let_go(); ++i) told.tick();
  EXPECT_EQ(told.why(), ZeroForceReason::ending);
}

TEST(ZeroForceReason, TheDevice) {
  BenchAfterCommand fault(kTwo), ended(kTwo), weak(kTwo), no_torque({.torque = Vec3(0, 0, 1)});
  EXPECT_EQ(fault.why({.pose = {}, .ok = false}), ZeroForceReason::device_fault);
  EXPECT_EQ(fault.why({.pose = {}, .clutched = true}), ZeroForceReason::clutched);
  for (const auto& [withheld, why] : {std::pair{Withheld::not_homed, ZeroForceReason::not_homed},
                                      std::pair{Withheld::in_inkwell, ZeroForceReason::in_inkwell},
                                      std::pair{Withheld::not_moved, ZeroForceReason::not_moved},
                                      std::pair{Withheld::starting, ZeroForceReason::starting},
                                      std::pair{Withheld::emergency, ZeroForceReason::emergency}})
    EXPECT_EQ(fault.why({.pose = {}, .withheld = withheld}), why);
  EXPECT_EQ(ended.why({.pose = {}, .ended = true}), ZeroForceReason::device_ended);
  weak.now += kPeriod;
  weak.servo.render({}, weak.now);
  weak.servo.hold({});
  EXPECT_EQ(weak.servo.no_force(), ZeroForceReason::not_held);
  EXPECT_EQ(no_torque.why(), ZeroForceReason::not_actuated);
}

TEST(ZeroForceReason, AnObserverIsGivenNone) {
  EXPECT_EQ(BenchAfterCommand({}, {.safety = {}, .observes = true}).why(),
            ZeroForceReason::observer);
}

TEST(ZeroForceReason, WhatTheServerSays) {
  Reply back = reply(2, {}), bounded = reply(2, {});
  back.recovering = true;
  bounded.bound.active = true;
  for (const auto& [said, why] : {std::pair{back, ZeroForceReason::recovering},
                                  std::pair{bounded, ZeroForceReason::server_bound}}) {
    BenchAfterCommand told(kTwo);
    told.tick();
    told.servo.take(said, told.now);
    EXPECT_EQ(told.why(), why);
  }
}

TEST(ZeroForceReason, TheGuardOfAServersForce) {
  EXPECT_EQ(BenchAfterCommand(kTwo, {}, "contact_frame", BoundingSide::server).why(),
            ZeroForceReason::account);
}

TEST(ZeroForceReason, AnAbsurdMovementIsRefused) {
  BenchAfterCommand told(kTwo, {}, "contact_frame");
  DeviceReading far = at(1e200, 0, 0);
  far.jumped = false;  // The driver confirms the movement.
  EXPECT_EQ(told.why(far), ZeroForceReason::refused);
}

TEST(ZeroForceReason, AMovementThatNoHandMakesIsAJump) {
  BenchAfterCommand told(kTwo, {}, "contact_frame");
  EXPECT_EQ(told.why(at(0.02, 0, 0)), ZeroForceReason::jumped);
  EXPECT_NE(told.why(at(0.02, 0, 0)), ZeroForceReason::jumped);
}

TEST(ZeroForceReason, EachHasANameAndWordsOfItsOwn) {
  std::set<std::string_view> names, texts;
  for (std::size_t i = 0; i < kZeroForceReasons; ++i) {
    names.insert(name(static_cast<ZeroForceReason>(i)));
    texts.insert(text(static_cast<ZeroForceReason>(i)));
  }
  EXPECT_EQ(names.size(), kZeroForceReasons);
  EXPECT_EQ(texts.size(), kZeroForceReasons);
  EXPECT_EQ(names.count(""), 0u);
}

/// A reason that withheld a force has priority over the time in free space.
TEST(ZeroForceReason, OfAWholeRun) {
  using Ticks = std::array<std::uint64_t, kZeroForceReasons>;
  const auto of = [](std::initializer_list<std::pair<ZeroForceReason, std::uint64_t>> counts) {
    Ticks ticks{};
    for (const auto& [reason, count] : counts) ticks[static_cast<std::size_t>(reason)] = count;
    return prevailing(ticks);
  };
  EXPECT_EQ(of({{ZeroForceReason::touches_nothing, 9000},
                {ZeroForceReason::no_reply, 5},
                {ZeroForceReason::ending, 9}}),
            ZeroForceReason::touches_nothing);
  EXPECT_EQ(of({{ZeroForceReason::touches_nothing, 9000}, {ZeroForceReason::waiting, 1000}}),
            ZeroForceReason::waiting);
  EXPECT_EQ(of({{ZeroForceReason::touches_nothing, 9000}, {ZeroForceReason::silent, 3}}),
            ZeroForceReason::touches_nothing);
  EXPECT_EQ(of({{ZeroForceReason::bound, 30}, {ZeroForceReason::waiting, 900}}),
            ZeroForceReason::waiting);
  EXPECT_EQ(of({{ZeroForceReason::no_reply, 900}, {ZeroForceReason::ending, 50}}),
            ZeroForceReason::no_reply);
}

}  // namespace
}  // namespace feltwire::zero_force_reason_test
