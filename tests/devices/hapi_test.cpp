// Tests the driver of the 2-dof open board against a board at a pseudo terminal. The board has a
// known true motion.

#include "client/drivers/haply/hapi.hpp"

#include <gmock/gmock.h>

#include <numbers>
#include <random>

#include "client/drivers/haply/hapi_board.hpp"
#include "client/servo/servo.hpp"
#include "protocol/net/clock.hpp"
#include "tests/devices/hapi_stand_in.hpp"
#include "tests/devices/identified.hpp"
#include "tests/devices/stand_in_session.hpp"
#include "tests/support/allocation_counter.hpp"
#include "tests/support/eventually.hpp"
#include "tests/support/hurry.hpp"

namespace feltwire::hapi_test {
namespace {

using stand_in::HapiBoard;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using testing::PacedSession;

struct Hapi : ::testing::Test {
  OpenedDevice open() {
    DeviceRequest request;
    request.name = board.port();
    request.spec.damping = board.mass.damping;
    request.spec.mass = board.mass.mass;
    return open_hapi(request);
  }
  std::string refusal(const std::string& port) const {
    DeviceRequest request;
    request.name = port;
    try {
      open_hapi(request);
    } catch (const std::exception& error) {
      return error.what();
    }
    return "none";
  }
  static Servo servo_of(const OpenedDevice& opened, std::string_view mode = kUnbounded) {
    SessionParameters parameters = testing::session_of(*opened.device);
    parameters.mode = mode;
    return Servo(opened.device->spec(), parameters, {});
  }
  /// Runs until the board's force acts on the hand.
  void feel(Device& device, Servo& servo) {
    session.run(device, servo, [&] { return board.force > 0.5; });
  }
  /// Returns the excess [J] of the true motion's energy over the dissipated energy, in four seconds
  /// at a late wall.
  double made(std::string_view mode) {
    const double kFrames = 1e3 * testing::session_seconds(4.0);
    if (!testing::measures())
      session.patience = std::chrono::seconds(10);  // A busy machine is no fault of the board.
    OpenedDevice opened = open();
    Servo servo = servo_of(opened, mode);
    session.run(*opened.device, servo, [&] { return board.frames >= kFrames; });
    statistics = servo.statistics();
    opened.device.reset();
    board.stop();
    session.tell("hapi", servo, board.mass.largest_force, board.mass.most_made);
    EXPECT_GT(board.mass.largest_force, 0.5);  // The hand must touch the wall.
    return board.mass.most_made;
  }

  HapiBoard board;
  PacedSession session{.normal = Vec3::UnitX()};  // towards the user
  ServoStatistics statistics;
};

TEST_F(Hapi, SaysWhatItIs) {
  DeviceRequest request;
  request.name = board.port();
  const OpenedDevice opened = open_hapi(request);
  EXPECT_EQ(opened.device->spec().name, "hapi_2dof");
  EXPECT_EQ(opened.device->spec().actuation.late_ticks, 1);
  EXPECT_EQ(opened.device->spec().translation_dof, 2);
  EXPECT_GE(opened.device->longest_tick(), std::chrono::microseconds(1250));
  EXPECT_EQ(board.offset, 180.0);
  EXPECT_THAT(opened.notes, Contains(HasSubstr("damping 0.02 N s/m is an assumption")));
  EXPECT_THAT(opened.notes, Contains(HasSubstr("not calibrated")));
  EXPECT_THAT(opened.notes, Contains(HasSubstr("watchdog")));
  EXPECT_THAT(opened.notes, Contains(HasSubstr("no longest tick")));
}

TEST_F(Hapi, WhatIsWrongIsSaid) {
  EXPECT_THAT(refusal("/dev/no_such_port"), AllOf(HasSubstr("no_such_port"), HasSubstr("check")));
  EXPECT_THAT(refusal("/dev/null"), HasSubstr("no serial port"));
  board.not_numbers = 1;
  EXPECT_THAT(refusal(board.port()), HasSubstr("not a frame of torques"));
}

TEST_F(Hapi, OtherFirmwareIsRefused) {
  board.firmware = HapiBoard::Firmware::silent;
  EXPECT_THAT(refusal(board.port()), HasSubstr("no answer"));
  EXPECT_GT(board.setups, 1);  // The driver must request the setup again.
}
TEST_F(Hapi, AnotherDeviceIsRefused) {
  board.firmware = HapiBoard::Firmware::other_device;
  EXPECT_THAT(refusal(board.port()), HasSubstr("not a board with hAPI firmware"));
}
TEST_F(Hapi, ATalkativeFirmwareIsRefused) {
  board.firmware = HapiBoard::Firmware::talkative;
  EXPECT_THAT(refusal(board.port()), HasSubstr("not a board with hAPI firmware"));
}

TEST_F(Hapi, AxesAreOurs) {
  board.mass.position = {0.01, 0.0, -0.02};
  board.mass.stiffness = board.mass.hand_damping = 0.0;
  const OpenedDevice opened = open();
  ASSERT_TRUE(opened.device->await_tick(monotonic_now() + std::chrono::seconds(10)));
  const DeviceReading reading = opened.device->read({});
  ASSERT_TRUE(reading.ok);
  EXPECT_NEAR((reading.pose.position - Vec3(-0.02, 0.01, 0.0)).norm(), 0.0, 5e-5);
}

/// A force along an axis must move the free mass in this direction. The magnitude of the force must
/// be in newtons.
TEST_F(Hapi, ForcesAreOurs) {
  board.mass.stiffness = board.mass.hand_damping = board.mass.friction = 0.0;
  const OpenedDevice opened = open();
  Device& device = *opened.device;
  const auto tick = [&] {
    ASSERT_TRUE(device.await_tick(monotonic_now() + std::chrono::seconds(10)));
  };
  tick();
  device.read({});
  device.write({.elastic = Vec3(0.2, -0.1, 0.0)});
  tick();
  EXPECT_NEAR(board.force, std::hypot(0.2, 0.1), 1e-3);
  device.read({});
  // The device holds this force until the next reading.
  EXPECT_EQ(device.write({}).force(), Vec3(0.2, -0.1, 0.0));
  tick();
  device.read({});
  EXPECT_EQ(device.write({}).force(), Vec3::Zero());
  board.stop();
  EXPECT_GT(board.mass.velocity[2], 0.0);
  EXPECT_LT(board.mass.velocity[0], 0.0);
}

TEST_F(Hapi, IdentifyMeasuresAFreeHandle) {
  const test::Hurry hurry;
  testing::let_free(board.mass);
  const OpenedDevice opened = open();
  testing::Identified identified(*opened.device);
  identified.run(*opened.device, [&] { return 1e-3 * board.frames.load(); });
  board.stop();
  identified.expect_below(board.mass);
}

/// A force above the board's largest torque must be scaled down. The account must use the scaled
/// force.
TEST_F(Hapi, AForceBeyondTheMotorsKeepsItsDirection) {
  const OpenedDevice opened = open();
  Device& device = *opened.device;
  const auto tick = [&] {
    EXPECT_TRUE(device.await_tick(monotonic_now() + std::chrono::seconds(10)));
    device.read({});
  };
  const Vec3 asked(30.0, -40.0, 0.0);
  tick();
  device.write({.elastic = asked});
  tick();
  const Vec3 held = device.write({}).force();
  EXPECT_LT(held.norm(), 0.9 * asked.norm());
  EXPECT_NEAR((held.normalized() - asked.normalized()).norm(), 0.0, 1e-12);
  tick();
  board.stop();
  EXPECT_NEAR(board.mass.largest_force, held.norm(), 0.01 * held.norm());
}

TEST_F(Hapi, MakesNoEnergy) {
  EXPECT_LE(made(kSessionMethod), 1e-12);
  EXPECT_GT(statistics.samples, 3900u);
  EXPECT_EQ(statistics.device.faults, 0u);
}
/// Without a bound the wall must make energy. This shows that the measurement can fail.
TEST_F(Hapi, TheWallAloneWouldMakeEnergy) { EXPECT_GT(made(kUnbounded), 0.005); }

TEST_F(Hapi, ATickDoesNotTouchTheHeap) {
  const OpenedDevice opened = open();
  Servo servo = servo_of(opened);
  const std::size_t before = test::allocations();
  for (int n = 0; n < 500; ++n)
    if (opened.device->await_tick(monotonic_now() + std::chrono::milliseconds(25)))
      servo.tick(*opened.device, monotonic_now());
  EXPECT_EQ(test::allocations() - before, 0u);
}

TEST_F(Hapi, ReleaseTakesTheForceOffForGood) {
  const OpenedDevice opened = open();
  Servo servo = servo_of(opened);
  feel(*opened.device, servo);
  opened.device->release();
  test::eventually("it is let go", [&] { return board.force == 0.0; });
  const std::uint64_t samples = servo.statistics().samples;
  session.run(*opened.device, servo, [&] { return servo.statistics().samples > samples + 20; });
  EXPECT_EQ(board.force, 0.0);
  EXPECT_EQ(servo.held(), Command{});
}

TEST_F(Hapi, AnotherThreadMayLetItGo) {
  const OpenedDevice opened = open();
  Servo servo = servo_of(opened);
  feel(*opened.device, servo);
  session.run_released(*opened.device, servo, [&] { return board.force == 0.0; });
}

TEST_F(Hapi, TheEndTakesTheForceOff) {
  {
    const OpenedDevice opened = open();
    Servo servo = servo_of(opened);
    feel(*opened.device, servo);
    board.loses = 1;
  }
  test::eventually("it is let go", [&] { return board.force == 0.0; });
}

/// After any fault of a reply the force must end and return later.
struct Fault {
  const char* name;
  std::atomic<int> HapiBoard::*count;
};
struct HapiFault : Hapi, ::testing::WithParamInterface<Fault> {};

TEST_P(HapiFault, LetsTheForceGoAndIsOver) {
  const OpenedDevice opened = open();
  Servo servo = servo_of(opened);
  feel(*opened.device, servo);
  const std::uint64_t faults = servo.statistics().device.faults;
  session.suffer(*opened.device, servo, board.edge, board.*GetParam().count);
  EXPECT_EQ(servo.given(), Command{});
  // A single faulty tick suffices, but the lost frame can be the one that takes the force off.
  session.run(*opened.device, servo, [&] { return board.edge.ended(); });
  session.expect_let_go("hapi", GetParam().name, board.edge);
  feel(*opened.device, servo);
  // A busy machine misses ticks, and each is a fault.
  EXPECT_LT(servo.statistics().device.faults, faults + 20 + session.missed - session.struck.second);
}

INSTANTIATE_TEST_SUITE_P(Of, HapiFault,
                         ::testing::Values(Fault{"ADroppedReply", &HapiBoard::drops},
                                           Fault{"ALateReply", &HapiBoard::late},
                                           Fault{"ALostFrame", &HapiBoard::loses},
                                           Fault{"Garbage", &HapiBoard::garbles},
                                           Fault{"AReplyTwice", &HapiBoard::repeats},
                                           Fault{"NotANumber", &HapiBoard::not_numbers},
                                           Fault{"AJump", &HapiBoard::jumps}),
                         [](const auto& fault) { return std::string(fault.param.name); });

TEST_F(Hapi, AnUnpluggedBoardIsAFaultForGood) {
  const OpenedDevice opened = open();
  Servo servo = servo_of(opened);
  feel(*opened.device, servo);
  board.unplug();
  test::eventually("it is unplugged", [&] { return board.unplugged.load(); });
  const std::uint64_t faults = servo.statistics().device.faults;
  session.run(*opened.device, servo, [&] { return servo.statistics().device.faults > faults + 3; });
  EXPECT_EQ(servo.given(), Command{});
  EXPECT_EQ(servo.no_force(), ZeroForceReason::device_fault);
}

/// The servo must not wait for a blocked port. A zero force must directly follow a force that
/// waited in the port.
TEST_F(Hapi, ABlockedPortNeverHoldsTheServoUp) {
  const OpenedDevice opened = open();
  Servo servo = servo_of(opened);
  feel(*opened.device, servo);
  board.blocks.store(true);
  const std::uint64_t faults = servo.statistics().device.faults;
  session.run(*opened.device, servo,
              [&] { return servo.statistics().device.faults > faults + 20; });
  EXPECT_EQ(servo.given(), Command{});
  session.stiffness = 0.0;
  board.blocks.store(false);
  test::eventually("it is let go", [&] { return board.force == 0.0; });
}

/// Two other computations must confirm the tool's position, and differences must confirm the
/// Jacobian.
TEST(HapiPantograph, IsWhereItsLinksMeet) {
  std::mt19937 random(19);
  std::uniform_real_distribution<double> left(1.8, 3.4), right(-0.3, 1.3);
  int possible = 0;
  for (int n = 0; n < 2000; ++n) {
    const hapi::Vec2 angles(left(random), right(random));
    const auto tool = hapi::tool_point(angles);
    if (!tool) continue;
    ++possible;
    const hapi::Vec2 a = 0.05 * hapi::Vec2(std::cos(angles.x()), std::sin(angles.x()));
    const hapi::Vec2 b =
        hapi::Vec2(0.02, 0.0) + 0.05 * hapi::Vec2(std::cos(angles.y()), std::sin(angles.y()));
    EXPECT_NEAR((tool->position - a).norm(), 0.07, 1e-12);
    EXPECT_NEAR((tool->position - b).norm(), 0.07, 1e-12);
    constexpr double kStep = 1e-6;
    for (int i = 0; i < 2; ++i) {
      const hapi::Vec2 step = kStep * hapi::Vec2::Unit(i);
      const auto more = hapi::tool_point(angles + step), less = hapi::tool_point(angles - step);
      if (!more || !less) continue;
      const hapi::Vec2 slope = (more->position - less->position) / (2.0 * kStep);
      EXPECT_NEAR((slope - tool->jacobian.col(i)).norm(), 0.0, 1e-7);
    }
  }
  EXPECT_GT(possible, 1000);
  EXPECT_TRUE(hapi::tool_point({std::numbers::pi, 0.0}));  // elbows 0.12 m apart
  EXPECT_TRUE(hapi::tool_point({0.0, 0.0}));               // elbows 0.02 m apart
  const double meet = std::acos(0.2);
  EXPECT_FALSE(hapi::tool_point({meet, std::numbers::pi - meet}));  // both elbows at one position
}

}  // namespace
}  // namespace feltwire::hapi_test
