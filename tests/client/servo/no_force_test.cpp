// Each reason for a zero force.

#include "client/servo/no_force.hpp"

#include <gmock/gmock.h>

#include <set>

#include "client/servo/servo.hpp"
#include "tests/client/servo_bench.hpp"

namespace feltwire::no_force_test {
namespace {

using namespace testing::servo;

/// An unbounded servo whose first sample got this command.
struct Told : Bench {
  explicit Told(const Command& command, const ServoOptions& options = {},
                std::string_view mode = "none", BoundingSide side = BoundingSide::client)
      : Bench(parameters(mode, side), options) {
    tick();
    servo.take(reply(1, command), now);
  }
  NoForce why(const DeviceReading& reading = {}, Nanoseconds after = kPeriod) {
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

TEST(NoForce, ThereIsForce) {
  Told told(kTwo);
  EXPECT_EQ(told.why(), NoForce::felt);
  EXPECT_EQ(told.servo.statistics().no_force[static_cast<std::size_t>(NoForce::felt)], 1u);
  EXPECT_EQ(told.servo.statistics().no_force[static_cast<std::size_t>(NoForce::no_reply)], 1u);
}

TEST(NoForce, NoReplyYet) {
  Bench bench(parameters("none"));
  EXPECT_EQ(bench.servo.no_force(), NoForce::no_reply);
  bench.tick();
  EXPECT_EQ(bench.servo.no_force(), NoForce::no_reply);
}

TEST(NoForce, NothingIsTouched) { EXPECT_EQ(Told({}).why(), NoForce::touches_nothing); }

TEST(NoForce, TheSceneAsksForTooLittle) {
  EXPECT_EQ(Told(elastic(0, 0, 0.004)).why(), NoForce::too_little);
  EXPECT_EQ(Told(elastic(0, 0, 0.006)).why(), NoForce::felt);
}

/// The hand begins in contact, under each bound. One bound gives a resting hand no force anyway.
TEST(NoForce, WaitsBecauseItBeganInContact) {
  for (const std::string_view mode : {"none", "contact_frame"}) {
    Told told(kTwo, limited({.small = 0.05}), mode);
    EXPECT_EQ(told.why(), NoForce::waiting);
    EXPECT_EQ(told.why(), NoForce::waiting);
  }
}

/// The wait is the named reason even if a hundredth of the force is left.
TEST(NoForce, AWaitThatLeavesNextToNothingIsSaid) {
  ForceTrail trail{.answered = true, .stage_waits = true};
  trail.asked = trail.actuated = trail.faded = trail.bounded = elastic(0, 0, 6);
  trail.safe = trail.paid = trail.held = elastic(0, 0, 0.06);
  EXPECT_EQ(why_no_force(trail), NoForce::waiting);
  trail.held = elastic(0, 0, 0.61);
  EXPECT_EQ(why_no_force(trail), NoForce::felt);
  trail.held = elastic(0, 0, 0.06);
  trail.stage_waits = false;
  EXPECT_EQ(why_no_force(trail), NoForce::felt);
}

TEST(NoForce, TheBoundLetsNoneThroughToAHandThatRests) {
  EXPECT_EQ(Told(kTwo, {}, "contact_frame").why(), NoForce::bound);
}

TEST(NoForce, TheSafetyLimits) {
  EXPECT_EQ(Told(kTwo, limited({}, 1.0)).why(), NoForce::ramp);
  EXPECT_EQ(Told(kTwo, limited({.slew = 1.0})).why(), NoForce::slew);
  EXPECT_EQ(Told(kTwo, limited({.max = 0.001})).why(), NoForce::force_limit);
  Told fast(kTwo, limited({.speed = 0.1}));
  for (int i = 1; i < 20; ++i) fast.tick(at(0.002 * i, 0, 0));
  EXPECT_EQ(fast.why(at(0.04, 0, 0)), NoForce::velocity_limit);
}

TEST(NoForce, TheServerIsSilent) {
  Told told(kTwo);
  EXPECT_EQ(told.why(), NoForce::felt);
  EXPECT_EQ(told.why({}, std::chrono::seconds(1)), NoForce::silent);
}

TEST(NoForce, TheSessionHasJustBeenFoundAgain) {
  Told told(kTwo);
  EXPECT_EQ(told.why(), NoForce::felt);
  told.servo.reconnected(false);
  std::set<NoForce> reasons;
  for (int i = 0; i < 200; ++i) reasons.insert(told.why());
  EXPECT_TRUE(reasons.contains(NoForce::reconnecting));
}

TEST(NoForce, TheRunEnds) {
  Told told(kTwo);
  EXPECT_EQ(told.why(), NoForce::felt);
  told.servo.release();
  for (int i = 0; i < 500 && !told.servo.let_go(); ++i) told.tick();
  EXPECT_EQ(told.why(), NoForce::ending);
}

TEST(NoForce, TheDevice) {
  Told fault(kTwo), ended(kTwo), weak(kTwo), no_torque({.torque = Vec3(0, 0, 1)});
  EXPECT_EQ(fault.why({.pose = {}, .ok = false}), NoForce::device_fault);
  EXPECT_EQ(fault.why({.pose = {}, .clutched = true}), NoForce::clutched);
  for (const auto& [withheld, why] : {std::pair{Withheld::not_homed, NoForce::not_homed},
                                      std::pair{Withheld::in_inkwell, NoForce::in_inkwell},
                                      std::pair{Withheld::starting, NoForce::starting},
                                      std::pair{Withheld::emergency, NoForce::emergency}})
    EXPECT_EQ(fault.why({.pose = {}, .withheld = withheld}), why);
  EXPECT_EQ(ended.why({.pose = {}, .ended = true}), NoForce::device_ended);
  weak.now += kPeriod;
  weak.servo.render({}, weak.now);
  weak.servo.hold({});
  EXPECT_EQ(weak.servo.no_force(), NoForce::not_held);
  EXPECT_EQ(no_torque.why(), NoForce::not_actuated);
}

TEST(NoForce, AnObserverIsGivenNone) {
  EXPECT_EQ(Told({}, {.safety = {}, .observes = true}).why(), NoForce::observer);
}

TEST(NoForce, WhatTheServerSays) {
  Reply back = reply(2, {}), bounded = reply(2, {});
  back.recovering = true;
  bounded.active = true;
  for (const auto& [said, why] :
       {std::pair{back, NoForce::recovering}, std::pair{bounded, NoForce::server_bound}}) {
    Told told(kTwo);
    told.tick();
    told.servo.take(said, told.now);
    EXPECT_EQ(told.why(), why);
  }
}

TEST(NoForce, TheGuardOfAServersForce) {
  EXPECT_EQ(Told(kTwo, {}, "contact_frame", BoundingSide::server).why(), NoForce::account);
}

TEST(NoForce, AnAbsurdMovementIsRefused) {
  Told told(kTwo, {}, "contact_frame");
  DeviceReading far = at(1e200, 0, 0);
  far.jumped = false;  // the driver says that a hand moved there
  EXPECT_EQ(told.why(far), NoForce::refused);
}

TEST(NoForce, AMovementThatNoHandMakesIsAJump) {
  Told told(kTwo, {}, "contact_frame");
  EXPECT_EQ(told.why(at(0.02, 0, 0)), NoForce::jumped);
  EXPECT_NE(told.why(at(0.02, 0, 0)), NoForce::jumped);
}

TEST(NoForce, EachHasANameAndWordsOfItsOwn) {
  std::set<std::string_view> names, texts;
  for (std::size_t i = 0; i < kNoForceReasons; ++i) {
    names.insert(name(static_cast<NoForce>(i)));
    texts.insert(text(static_cast<NoForce>(i)));
  }
  EXPECT_EQ(names.size(), kNoForceReasons);
  EXPECT_EQ(texts.size(), kNoForceReasons);
  EXPECT_EQ(names.count(""), 0u);
}

/// A reason that withheld a force prevails over the time in free space.
TEST(NoForce, OfAWholeRun) {
  using Ticks = std::array<std::uint64_t, kNoForceReasons>;
  const auto of = [](std::initializer_list<std::pair<NoForce, std::uint64_t>> counts) {
    Ticks ticks{};
    for (const auto& [reason, count] : counts) ticks[static_cast<std::size_t>(reason)] = count;
    return prevailing(ticks);
  };
  EXPECT_EQ(of({{NoForce::touches_nothing, 9000}, {NoForce::no_reply, 5}, {NoForce::ending, 9}}),
            NoForce::touches_nothing);
  EXPECT_EQ(of({{NoForce::touches_nothing, 9000}, {NoForce::waiting, 1000}}), NoForce::waiting);
  EXPECT_EQ(of({{NoForce::touches_nothing, 9000}, {NoForce::silent, 3}}), NoForce::touches_nothing);
  EXPECT_EQ(of({{NoForce::bound, 30}, {NoForce::waiting, 900}}), NoForce::waiting);
  EXPECT_EQ(of({{NoForce::no_reply, 900}, {NoForce::ending, 50}}), NoForce::no_reply);
}

}  // namespace
}  // namespace feltwire::no_force_test
