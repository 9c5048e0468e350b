#pragma once
// Control messages for tests.

#include <gtest/gtest.h>

#include <cstdint>
#include <variant>
#include <vector>

#include "protocol/wire/control.hpp"

namespace feltwire::test {

/// The frame without its length, as decode() expects it.
inline Bytes body(const std::vector<std::uint8_t>& frame) {
  return Bytes(frame).subspan(control::kFrameLengthSize);
}

/// The value after encode() and decode().
template <class Value>
Value round_trip(const Value& value) {
  const auto frame = control::encode(value);
  EXPECT_EQ(control::frame_length(std::span<const std::uint8_t, control::kFrameLengthSize>(
                frame.data(), control::kFrameLengthSize)),
            body(frame).size());
  const auto message = control::decode(body(frame));
  EXPECT_TRUE(message.has_value());
  return std::get<Value>(message.value());
}

/// Every value differs from its default.
inline SessionParameters unusual_parameters() {
  SessionParameters p;
  p.mode = "per_axis_projected";
  p.projection = Projection::joint;
  p.storage = Storage::elastic;
  p.side = BoundingSide::client;
  p.servo_period = 2.5e-4;
  p.redundancy = 7;
  p.operator_damping = 0.25;
  p.velocity_cutoff = 120;
  p.hold_time = 0.05;
  p.c1 = 900;
  p.c2 = 450;
  p.reference = PassivityReference::following;
  p.coupling_stiffness = 300;
  p.coupling_damping = 0.2;
  p.tool_mass = 0.07;
  p.packet_interval = 300;
  p.batch = 2;
  p.position_deadband = 0.05;
  p.force_deadband = 0.1;
  p.predictor = Predictor::linear;
  p.keep_alive = 0.015;
  p.local_model = true;
  return p;
}

inline control::JoinRequest request() {
  control::JoinRequest r{"someone", "room", {}, unusual_parameters()};
  r.device.name = "omega.7";
  r.device.translation_dof = 2;
  r.device.rotation_sensed = 3;
  r.device.rotation_actuated = 3;
  r.device.damping = 0.1;
  r.device.rotational_damping = 0.2;
  r.device.apparent_mass = 0.3;
  r.device.coulomb_friction = 0.4;
  r.device.position_resolution = 0.5;
  r.device.max_force = 0.6;
  r.device.continuous_force = 0.7;
  r.device.max_torque = 0.8;
  r.device.workspace = {0.9, 1.0, 1.1};
  r.role = Role::observer;
  r.aes_256_gcm = true;
  return r;
}

}  // namespace feltwire::test
