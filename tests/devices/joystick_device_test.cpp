// Tests gamepads and 3D mice: the movement of the tool for each event. The input devices' events
// and ioctls follow the kernel's documentation.

#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <random>

#include "tests/devices/joystick_hand.hpp"

namespace feltwire::steered_device_test {
namespace {

using testing::kFull;
using testing::Maker;
using testing::Steered;

TEST_F(Steered, StandsStillWhenNothingIsTold) {
  gamepad();
  EXPECT_EQ(begun, Vec3(0, 0, 0.02));
  const DeviceReading reading = move(10.0);
  EXPECT_TRUE(reading.ok);
  EXPECT_FALSE(reading.deadman);
  EXPECT_EQ(way(), Vec3::Zero());
}

struct Deflection {
  const char* name;
  Maker maker;
  const char* kind;
  unsigned code;
  int value;
  Vec3 move, turn;  // unit vectors
};
struct Direction : Steered, ::testing::WithParamInterface<Deflection> {};

TEST_P(Direction, IsWhereThePersonPushes) {
  const Deflection& d = GetParam();
  start(d.maker, d.kind);
  move(0.01);
  push(d.code, d.value);
  move(1.0);
  EXPECT_NEAR((way() - 0.1 * d.move).norm(), 0.0, 0.005);
  const Vec3 turned = rotation_between(Quaternion::Identity(), device->true_orientation());
  EXPECT_NEAR((turned - 0.8 * d.turn).norm(), 0.0, 0.05);
}

const Vec3 kNone = Vec3::Zero(), kNear = Vec3::UnitX(), kRight = Vec3::UnitY(), kUp = Vec3::UnitZ();
const std::array kDeflections = {
    Deflection{"LeftStickRight", stand_in::be_xpad, "gamepad", ABS_X, kFull, kRight, kNone},
    Deflection{"LeftStickUp", stand_in::be_xpad, "gamepad", ABS_Y, -kFull - 1, -kNear, kNone},
    Deflection{"RightStickUp", stand_in::be_xpad, "gamepad", ABS_RY, -kFull - 1, kUp, kNone},
    Deflection{"RightStickRight", stand_in::be_xpad, "gamepad", ABS_RX, kFull, kNone, -kUp},
    Deflection{"CrossRight", stand_in::be_xpad, "gamepad", ABS_HAT0X, 1, kNone, -kNear},
    Deflection{"CrossDown", stand_in::be_xpad, "gamepad", ABS_HAT0Y, 1, kNone, kRight},
    Deflection{"GenericRightStickUp", stand_in::be_generic_pad, "gamepad", ABS_RZ, 0, kUp, kNone},
    Deflection{"GenericRightStickLeft", stand_in::be_generic_pad, "gamepad", ABS_Z, 0, kNone, kUp},
    Deflection{"CapRight", stand_in::be_spacemouse, "spacemouse", ABS_X, 350, kRight, kNone},
    Deflection{"CapTowardsThePerson", stand_in::be_spacemouse, "spacemouse", ABS_Y, 350, kNear,
               kNone},
    Deflection{"CapDown", stand_in::be_spacemouse, "spacemouse", ABS_Z, 350, -kUp, kNone},
    Deflection{"CapTiltsToThePerson", stand_in::be_spacemouse, "spacemouse", ABS_RX, 350, kNone,
               kRight},
    Deflection{"CapTiltsLeft", stand_in::be_spacemouse, "spacemouse", ABS_RY, 350, kNone, kNear},
    Deflection{"CapTurnsClockwise", stand_in::be_spacemouse, "spacemouse", ABS_RZ, 350, kNone,
               -kUp}};
INSTANTIATE_TEST_SUITE_P(Of, Direction, ::testing::ValuesIn(kDeflections),
                         [](const auto& d) { return std::string(d.param.name); });

TEST_F(Steered, TheSpeedIsLimitedInEveryDirection) {
  gamepad();
  move(0.01);
  for (const unsigned code : {ABS_X, ABS_Y, ABS_RY}) input.axis(code, kFull);
  input.report();
  move(1.0);
  EXPECT_NEAR(way().norm(), 0.1, 0.005);
  EXPECT_NEAR(way().normalized().dot(Vec3(1, 1, -1).normalized()), 1.0, 1e-3);
}

TEST_F(Steered, SpeedDeadZoneAndShapeAreThoseOfTheOptions) {
  start(stand_in::be_spacemouse, "spacemouse", {.speed = 0.2, .turn = 1.0, .dead_zone = 0.2});
  move(0.01);
  push(ABS_X, 70);  // A fifth of the range is in the dead zone.
  move(1.0);
  EXPECT_EQ(way(), Vec3::Zero());
  push(ABS_X, 210);  // Half of the remaining range gives a quarter of the speed.
  move(1.0);
  EXPECT_NEAR(way().y(), 0.05, 0.003);
}

TEST_F(Steered, TheKernelsDeadZoneCountsWhereItIsMore) {
  stand_in::be_xpad(input);
  input.axes[ABS_X].flat = 16384;
  device.emplace(node(), "gamepad", JoystickHandOptions{builtin_device("simulated_6dof"), {}, {}});
  move(0.01);
  push(ABS_X, 16000);
  move(1.0);
  EXPECT_EQ(device->true_position(), Vec3::Zero());
}

TEST_F(Steered, TheOtherButtonsAreNumberedFromOne) {
  gamepad();
  EXPECT_EQ(move(0.01).buttons, 0u);
  for (std::size_t i = 0; i < kPadButtons.size(); ++i) {
    input.key(kPadButtons[i], true);
    input.report();
    EXPECT_EQ(move(0.01).buttons, 1u << i);
    input.key(kPadButtons[i], false);
  }
  input.report();
  EXPECT_EQ(move(0.01).buttons, 0u);
  input.key(BTN_TR, true);  // This button has its own meaning.
  input.report();
  EXPECT_EQ(move(0.01).buttons, 0u);
}

TEST_F(Steered, ButtonsAreTheEnablingSwitchTheClutchAndTheGripper) {
  gamepad();
  EXPECT_FALSE(move(0.01).deadman);
  EXPECT_EQ(move(0.01).gripper, 0.08);
  input.key(BTN_TR, true);
  push(ABS_RZ, 255);
  const DeviceReading held = move(0.01);
  EXPECT_TRUE(held.deadman);
  EXPECT_EQ(held.gripper, 0.0);
  input.key(BTN_TL, true);
  push(ABS_X, kFull);
  move(1.0);
  EXPECT_EQ(way(), Vec3::Zero());
  input.key(BTN_TL, false);
  input.report();
  move(0.5);
  EXPECT_GT(way().y(), 0.04);
  input.key(BTN_TR, false);
  input.report();
  EXPECT_FALSE(move(0.01).deadman);
}

TEST_F(Steered, TheSecondButtonOfA3DMouseIsTheClutch) {
  spacemouse();
  move(0.01);
  input.key(BTN_0, true);
  input.key(BTN_1, true);
  push(ABS_X, 350);
  const DeviceReading reading = move(1.0);
  EXPECT_TRUE(reading.deadman);
  EXPECT_FALSE(reading.gripper);
  EXPECT_EQ(way(), Vec3::Zero());
}

TEST_F(Steered, AStickThatIsHeldAtTheStartCountsOnceItWasAtRest) {
  stand_in::be_xpad(input);
  input.axes[ABS_X].value = kFull;
  device.emplace(node(), "gamepad", JoystickHandOptions{builtin_device("simulated_6dof"), {}, {}});
  move(1.0);
  EXPECT_EQ(device->true_position(), Vec3::Zero());
  push(ABS_X, 0);
  move(0.1);
  push(ABS_X, kFull);
  move(1.0);
  EXPECT_NEAR(device->true_position().y(), 0.1, 0.005);
}

/// A gamepad out of radio range repeats no events.
TEST_F(Steered, ADeflectionThatIsToldNoMoreEnds) {
  gamepad();
  move(0.01);
  push(ABS_X, kFull);
  move(10.0);
  EXPECT_NEAR(way().y(), 0.2, 0.005);  // Two seconds of the deflection count.
  push(ABS_X, kFull - 1);
  move(1.0);
  EXPECT_NEAR(way().y(), 0.3, 0.01);
}

/// More events arrive between two ticks than the kernel keeps. The device must still detect a
/// release among them.
TEST_F(Steered, LostEventsAreMadeUpForByTheState) {
  gamepad();
  input.key(BTN_TR, true);
  push(ABS_X, kFull);
  EXPECT_TRUE(move(0.1).deadman);
  input.key(BTN_TR, false);
  for (int n = 0; n < 100; ++n) push(ABS_X, n);
  push(ABS_X, 0);
  const int asked = input.abs_asked;
  EXPECT_FALSE(move(0.5).deadman);
  EXPECT_GT(input.abs_asked, asked);
  const Vec3 rests = way();
  move(1.0);
  EXPECT_EQ(way(), rests);
}

/// The events between SYN_DROPPED and the end of its packet are invalid.
TEST_F(Steered, TheRestOfATornPacketDoesNotCount) {
  stand_in::be_xpad(input);
  const EventNode events = node();
  InputState state(events, "gamepad", {});
  const auto take = [&](unsigned type, unsigned code, int value) {
    input_event event{};
    event.type = static_cast<std::uint16_t>(type);
    event.code = static_cast<std::uint16_t>(code);
    event.value = value;
    return state.take(event, now, events);
  };
  EXPECT_EQ(state.steering(now).velocity, Vec3::Zero());
  EXPECT_TRUE(take(EV_ABS, ABS_X, kFull));
  EXPECT_EQ(state.steering(now).velocity, Vec3::Zero());  // The packet has not ended.
  EXPECT_TRUE(take(EV_SYN, SYN_DROPPED, 0));
  EXPECT_TRUE(take(EV_KEY, BTN_TR, 1));
  EXPECT_TRUE(take(EV_SYN, SYN_REPORT, 0));
  EXPECT_EQ(state.steering(now).velocity, Vec3::Zero());
  EXPECT_FALSE(state.steering(now).enabled);
  EXPECT_TRUE(take(EV_ABS, ABS_X, kFull));
  EXPECT_TRUE(take(EV_SYN, SYN_REPORT, 0));
  EXPECT_NEAR(state.steering(now).velocity.y(), 0.1, 1e-6);
  EXPECT_TRUE(take(EV_SYN, SYN_DROPPED, 0));
  input.unplug();
  EXPECT_FALSE(take(EV_SYN, SYN_REPORT, 0));
}

/// For any events the tool must move within the limits.
TEST_F(Steered, NoEventMakesItFasterThanTheLimits) {
  stand_in::be_xpad(input);
  const EventNode events = node();
  InputState state(events, "gamepad", {});
  std::mt19937 random(19);
  std::uniform_int_distribution<int> any(std::numeric_limits<int>::min(),
                                         std::numeric_limits<int>::max()),
      type(0, 6), small(0, 0x20);
  for (int n = 0; n < 100000; ++n) {
    input_event event{};
    event.type = static_cast<std::uint16_t>(n % 5 == 0 ? EV_SYN : type(random));
    event.code = static_cast<std::uint16_t>(n % 7 == 0 ? any(random) : small(random));
    event.value = any(random);
    if (event.type == EV_SYN) event.code %= 4;
    state.take(event, now, events);
    const Steering told = state.steering(now);
    ASSERT_LE(told.velocity.norm(), 0.1 + 1e-12);
    ASSERT_LE(told.turn.norm(), 0.8 + 1e-12);
    ASSERT_TRUE(!told.gripper || (*told.gripper >= 0.0 && *told.gripper <= 0.08));
  }
}

/// Axes that the kernel treats as relative report no zero.
struct Relative : Steered {
  Relative() { start(stand_in::be_relative_spacemouse, "spacemouse"); }
  /// Sends the packets of a deflected cap at 125 Hz for `time` [s].
  void hold(const Vec3& moved, const Vec3& turned, double time) {
    for (double t = 0.0; t < time; t += 0.008) {
      for (unsigned i = 0; i < 3; ++i) input.relative(REL_X + i, static_cast<int>(moved[i]));
      input.report();
      for (unsigned i = 0; i < 3; ++i) input.relative(REL_RX + i, static_cast<int>(turned[i]));
      input.report();
      move(0.008);
    }
  }
};

TEST_F(Relative, MovesWhileItIsTold) {
  move(0.01);
  hold({350, 0, 0}, kNone, 1.0);
  EXPECT_NEAR(way().y(), 0.1, 0.01);
  move(0.5);
  const Vec3 rests = way();
  EXPECT_NEAR(rests.y(), 0.11, 0.01);  // The tool stops a tenth of a second later.
  move(1.0);
  EXPECT_EQ(way(), rests);
}

TEST_F(Relative, AnAxisThatIsLeftOutIsAtRest) {
  move(0.01);
  hold({350, 0, 0}, kNone, 0.2);
  hold({0, 0, 350}, kNone, 0.2);
  const double right = way().y();
  hold({0, 0, 350}, {0, 350, 0}, 0.5);
  EXPECT_NEAR(way().y(), right, 1e-3);
  EXPECT_NEAR(way().z(), -0.07, 0.01);
  const Vec3 turned = rotation_between(Quaternion::Identity(), device->true_orientation());
  EXPECT_NEAR((turned - Vec3(0.4, 0, 0)).norm(), 0.0, 0.05);
}

}  // namespace
}  // namespace feltwire::steered_device_test
