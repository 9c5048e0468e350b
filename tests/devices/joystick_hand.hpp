#pragma once
// A person with an input device, and the hand that it steers.

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <string>

#include "client/drivers/joystick/joystick_device.hpp"
#include "core/base/numeric.hpp"
#include "tests/devices/input_stand_in.hpp"
#include "tests/devices/tick.hpp"

namespace feltwire::testing {

using Maker = void (*)(stand_in::InputDevice&);

inline constexpr int kFull = 32767;

struct Steered : ::testing::Test {
  EventNode node() {
    return {input.open(), [this](int, unsigned long request, void* room) {
              return input.control(request, room);
            }};
  }
  JoystickDevice& start(Maker maker, std::string_view kind, const SteeringOptions& steering = {}) {
    maker(input);
    JoystickHandOptions options;
    options.spec = builtin_device("simulated_6dof");
    options.steering = steering;
    device.emplace(node(), kind, options);
    device->begin(Vec3::Zero(), Vec3::UnitZ());
    begun = device->true_position();
    return *device;
  }
  JoystickDevice& gamepad() { return start(stand_in::be_xpad, "gamepad"); }
  JoystickDevice& spacemouse() { return start(stand_in::be_spacemouse, "spacemouse"); }
  /// Moves through free space for `time` [s].
  DeviceReading move(double time) {
    DeviceReading reading;
    for (long left = std::lround(time / kTick); left > 0; --left) {
      input.deliver();
      now += from_seconds(kTick);
      reading = device->read(now);
      device->write({});
    }
    return reading;
  }
  void push(unsigned code, int value) {
    input.axis(code, value);
    input.report();
  }
  Vec3 way() const { return device->true_position() - begun; }
  std::string refusal(std::string_view kind) {
    try {
      JoystickDevice(node(), kind,
                     {.spec = builtin_device("simulated_6dof"), .hand = {}, .steering = {}});
    } catch (const std::exception& error) {
      return error.what();
    }
    return "none";
  }

  stand_in::InputDevice input;
  std::optional<JoystickDevice> device;
  Nanoseconds now = std::chrono::seconds(7);
  Vec3 begun = Vec3::Zero();
};

}  // namespace feltwire::testing
