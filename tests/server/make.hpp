#pragma once
// A scene, a device and a hand for server tests.

#include <cmath>

#include "core/scene/scene.hpp"
#include "protocol/wire/control.hpp"
#include "server/app/server_config.hpp"
#include "tests/protocol/make.hpp"

namespace feltwire::test {

/// A stiff, damped floor with friction, and a ball of 20 mm radius on it.
inline Scene room(double damping = 2.0) {
  Object floor;
  floor.name = "floor";
  floor.shape = Plane{};
  floor.material = {.stiffness = 2000.0,
                    .damping = damping,
                    .static_friction = 0.6,
                    .dynamic_friction = 0.4,
                    .viscous_friction = 1.0};
  Object ball;
  ball.name = "ball";
  ball.shape = Sphere{0.02};
  ball.pose.position = {0.05, 0, 0.01};
  ball.material = {.stiffness = 1500.0};
  return Scene("room", {floor, ball}, {.position = {0.01, 0, 0}, .normal = {0, 0, 2}});
}

inline DeviceSpec device() {
  DeviceSpec spec;
  spec.name = "test arm";
  spec.damping = 0.5;
  spec.apparent_mass = 0.05;
  spec.position_resolution = 1e-5;
  spec.max_force = 20.0;
  spec.continuous_force = 5.0;
  spec.workspace = {0.3, 0.3, 0.3};
  return spec;
}

/// Turns on the server's bound, which these tests need.
inline SessionParameters server_bounds() {
  SessionParameters parameters;
  parameters.side = BoundingSide::both;
  return parameters;
}

inline control::JoinRequest join_request(const SessionParameters& parameters = server_bounds()) {
  return {"tester", "room", device(), parameters};
}

/// A hand that dips into the floor while it slides: the client's sample `index`.
inline Sample hand(std::uint64_t index, double period = 1e-3) {
  const double t = static_cast<double>(index) * period;
  Sample sample;
  sample.index = index;
  sample.client_time = Nanoseconds(static_cast<std::int64_t>(index) * 1'000'000);
  sample.pose.position = {0.04 * std::sin(3 * t), 0.03 * std::sin(5 * t + 1),
                          0.002 * std::sin(11 * t)};
  sample.held.elastic = Vec3(0, 0, 0.5);
  return sample;
}

/// The samples of a datagram: `newest` and up to `redundancy` earlier samples.
inline SampleBatch hand_batch(std::uint64_t newest, int redundancy = 0) {
  SampleBatch batch;
  while (batch.count <= redundancy && newest - static_cast<std::uint64_t>(batch.count) > 0) {
    batch.samples[static_cast<std::size_t>(batch.count)] =
        hand(newest - static_cast<std::uint64_t>(batch.count));
    ++batch.count;
  }
  batch.previous = newest - static_cast<std::uint64_t>(batch.count);
  return batch;
}

/// A server without log output, on free ports.
inline ServerConfig any_port() {
  ServerConfig config;
  config.port = 0;
  config.log.level = "off";
  return config;
}

}  // namespace feltwire::test
