// Connects servo and session in one process by encoded datagrams. Tests devices that sense six
// degrees of freedom but actuate three, and devices that connect inside an object.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "client/servo/servo.hpp"
#include "protocol/wire/codec.hpp"
#include "server/scene/session.hpp"

namespace feltwire::sensed_orientation_test {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr Nanoseconds kPeriod = std::chrono::milliseconds(1);
const Vec3 kAxis = Vec3(2, -1, 2) / 3.0;

Scene floor_scene() {
  Object plane;
  plane.name = "floor";
  plane.shape = Plane{};
  plane.material = {.stiffness = 2000.0};
  return Scene("floor", {plane});
}

/// Runs a client and a server with their datagrams, tick by tick.
struct Pair {
  DeviceSpec spec;
  Scene scene = floor_scene();
  Session session;
  Servo servo;
  Nanoseconds now{0};
  SampleBatch received;  // the server's copy
  Reply reply;           // the client's copy

  Pair(const DeviceSpec& device, const SessionParameters& parameters,
       const ServoOptions& options = {})
      : spec(device),
        session({"tester", "floor", device, parameters}, scene),
        servo(device, parameters, options) {}

  Command tick(const Pose& pose) {
    const Command given = servo.render({.pose = pose, .jumped = false}, now += kPeriod);
    SampleBatch sent;
    sent.samples[0] = *servo.hold(given);
    sent.count = 1;
    sent.rotation = spec.rotation_sensed > 0;
    const Bytes bytes = encoder_.samples(sent);
    EXPECT_EQ(decode(bytes, received), DropReason::none);
    const BatchResult taken = session.take(received, now);
    EXPECT_EQ(taken.drop, DropReason::none);
    const Bytes answer = encoder_.reply(taken.reply);
    EXPECT_EQ(decode(answer, reply), DropReason::none);
    servo.take(reply, now);
    return given;
  }

 private:
  Encoder encoder_;
};

/// A tool that turns about kAxis.
struct Turning {
  std::mt19937_64 random{7};
  double angle = kPi - 0.05;  // [rad]
  Quaternion exact = at(angle);

  static Quaternion at(double angle) { return Quaternion(Eigen::AngleAxisd(angle, kAxis)); }
  /// Turns by 0, 1e-4, 1e-2 or nearly half a turn in either direction. Returns the signed angle
  /// [rad].
  double turn() {
    constexpr std::array kSteps = {0.0, 1e-4, 1e-2, -1e-2, kPi - 1e-3, -(kPi - 1e-3)};
    const double step = kSteps[random() % kSteps.size()];
    exact = at(angle += step);
    return step;
  }
  /// Returns the orientation as a driver may report it: either sign, and a norm within `tolerance`
  /// of 1.
  Quaternion told(double tolerance) {
    std::uniform_real_distribution<double> norm(1.0 - tolerance, 1.0 + tolerance);
    Quaternion q = exact;
    q.coeffs() *= (random() % 2 ? 1.0 : -1.0) * norm(random);
    return q;
  }
};

TEST(SensedOrientation, TravelsAndMovesNothing) {
  for (const char* name : {"touch", "omega.7"}) {
    SessionParameters parameters;
    parameters.mode = "none";
    Pair pair(builtin_device(name), parameters);
    ASSERT_EQ(pair.spec.rotation_sensed, 3);
    ASSERT_EQ(pair.spec.rotation_actuated, 0);
    Turning turning;
    const Vec3 pressed(0.01, 0.02, -0.001);  // The fixed position gives 2 N while the tool turns.
    for (int n = 0; n < 3000; ++n) {
      turning.turn();
      const Command given = pair.tick({pressed, turning.told(1e-3)});
      const Pose& sent = pair.servo.sample().pose;
      ASSERT_NEAR(sent.orientation.norm(), 1.0, 1e-15);
      ASSERT_LT(rotation_between(sent.orientation, turning.exact).norm(), 1e-14) << n;
      ASSERT_TRUE(pair.received.rotation);
      ASSERT_EQ(pair.received.samples[0].pose.orientation.coeffs(), sent.orientation.coeffs());
      ASSERT_EQ(pair.received.samples[0].pose.position, pressed);
      // The floor's force does no work, and neither side computes a torque.
      if (n > 0) {
        ASSERT_NEAR(given.force().z(), 2.0, 1e-12);
      }
      ASSERT_EQ(given.torque, Vec3::Zero());
      ASSERT_EQ(pair.reply.command.torque, Vec3::Zero());
      ASSERT_FALSE(pair.reply.rotation);
      ASSERT_EQ(pair.servo.port().delivered().total(), 0.0);
      ASSERT_EQ(pair.servo.port().burned(), 0.0);
      ASSERT_EQ(pair.reply.delivered.total(), 0.0);
    }
    // The servo ignores torque commands of the server.
    for (const std::string_view mode : {"none", "contact_frame"}) {
      parameters.mode = mode;
      Servo servo(pair.spec, parameters);
      for (std::uint64_t n = 1; n < 20; ++n) {
        const Command given = servo.render({.pose = {pressed, turning.told(1e-3)}}, n * kPeriod);
        ASSERT_EQ(given.torque, Vec3::Zero());
        servo.hold(given);
        Reply hostile;
        hostile.sample_index = n;
        hostile.rotation = true;
        hostile.command.torque = Vec3(1, 2, 3);
        servo.take(hostile, n * kPeriod);
      }
    }
  }
}

/// The server integrates the work of a constant torque. This work reveals the rotation that the
/// server assumes at each sample.
TEST(SensedOrientation, TheServerSeesTheTurnAndNothingElse) {
  for (const char* name : {"touch", "omega.7"}) {
    const Scene scene = floor_scene();
    Session session({"tester", "floor", builtin_device(name), {}}, scene);
    Turning turning;
    double last = 0.0;
    for (std::uint64_t n = 1; n <= 5000; ++n) {
      const double turned = turning.turn();
      SampleBatch batch;
      batch.count = 1;
      batch.rotation = true;
      Sample& sample = batch.samples[0];
      sample.index = n;
      sample.client_time = static_cast<std::int64_t>(n) * kPeriod;
      // The protocol allows this error.
      sample.pose = {Vec3(0.01, 0.02, 0.03), turning.told(4e-4)};
      sample.held = {.elastic = Vec3(1, 2, 3), .torque = 2.0 * kAxis};
      const BatchResult taken = session.take(batch, sample.client_time);
      ASSERT_EQ(taken.drop, DropReason::none);
      const ChannelEnergy& work = taken.reply.delivered;
      ASSERT_NEAR(work.torque - last, n > 1 ? 2.0 * turned : 0.0, 1e-9) << n;
      ASSERT_EQ(work.elastic, 0.0);
      last = work.torque;

      // A quaternion with a larger error of its norm is no rotation. The server must drop the
      // sample without a change of state.
      sample.index = n + 1;
      for (const double norm : {1.0 + 1e-3, 1.0 - 1e-3}) {
        sample.pose.orientation.coeffs() = norm * turning.exact.coeffs();
        ASSERT_EQ(session.take(batch, sample.client_time).drop, DropReason::not_finite);
      }
    }
  }
}

/// The client integrates the same work at each sample, with a device that actuates torque.
TEST(SensedOrientation, TheServoSeesTheTurnAndNothingElse) {
  DeviceSpec spec = builtin_device("omega.7");
  spec.rotation_actuated = 3;
  spec.rotational_damping = 1e-3;
  spec.max_torque = 10.0;
  SessionParameters parameters;
  parameters.mode = "none";
  Servo servo(spec, parameters);
  Turning turning;
  double last = 0.0;
  for (std::uint64_t n = 1; n <= 5000; ++n) {
    const double turned = turning.turn();
    const Nanoseconds now = static_cast<std::int64_t>(n) * kPeriod;
    servo.hold(
        servo.render({.pose = {Vec3(0.01, 0.02, 0.03), turning.told(1e-3)}, .jumped = false}, now));
    const double work = servo.port().delivered().torque;
    // The device holds the torque from tick 2 on.
    ASSERT_NEAR(work - last, n > 2 ? 2.0 * turned : 0.0, 1e-9) << n;
    ASSERT_EQ(servo.port().delivered().elastic, 0.0);
    last = work;
    Reply reply;
    reply.sample_index = n;
    reply.command = {.elastic = Vec3(1, 2, 3), .torque = 2.0 * kAxis};
    servo.take(reply, now);
  }
}

/// Returns the largest speed of a free device that connects 4 mm inside the floor. The force of 8 N
/// acts on 50 g.
double fastest_when_let_go(Pair& pair) {
  double z = -0.004, velocity = 0.0, fastest = 0.0;
  for (int n = 0; n < 300; ++n) {
    const double force = pair.tick({.position = Vec3(0, 0, z)}).force().z();
    velocity += 1e-3 / pair.spec.apparent_mass * (force - pair.spec.damping.least() * velocity);
    z += 1e-3 * velocity;
    fastest = std::max(fastest, std::abs(velocity));
  }
  return fastest;
}

TEST(ConnectingInside, GivesNoKick) {
  for (const std::string_view mode : {"none", "contact_frame", "per_axis", "total_energy"}) {
    for (const BoundingSide side :
         {BoundingSide::server, BoundingSide::client, BoundingSide::both}) {
      SessionParameters parameters;
      parameters.mode = mode;
      parameters.side = side;
      Pair pair(builtin_device("simulated"), parameters, protect_hand(parameters));
      EXPECT_EQ(fastest_when_let_go(pair), 0.0) << mode << " " << name(side);
      // A hand moves inside the object. The servo subtracts the force at the smallest depth so far.
      // As the hand travels, the servo returns a part of the subtracted force. After the hand left
      // and touched again, it must feel the complete floor.
      double z = -0.004, least_depth = -z, way = 0.0;
      for (const double by : {-1e-4, 1e-4, 1e-4, -1e-4})
        for (int n = 0; n < 20; ++n) {
          const double force = pair.tick({.position = Vec3(0, 0, z += by)}).force().z();
          way += std::abs(by);
          least_depth = std::min(least_depth, -z);
          // [N] force that returned with the travelled distance, plus the effect of one sample of
          // reply delay
          const double let_in = 0.05 * way / SafetyLimits::kFloorWay + 2000.0 * std::abs(by);
          EXPECT_GE(force, 0.0);
          EXPECT_LE(force, bounding_method(mode).admits_reduction
                               ? 2000.0 * (-z - least_depth) + let_in
                               : 0.0);
        }
      for (int n = 0; n < 100; ++n) pair.tick({.position = Vec3(0, 0, z += 1e-4)});
      EXPECT_GT(z, 0.0);
      double felt = 0.0;
      for (int n = 0; n < 90; ++n)
        felt = std::max(felt, pair.tick({.position = Vec3(0, 0, z -= 1e-4)}).force().z());
      EXPECT_GT(felt, 0.1) << mode << " " << name(side);
    }
  }
}

// Without protection the device must accelerate. Otherwise the test above proves nothing.
TEST(ConnectingInside, UnprotectedItIsThrown) {
  SessionParameters parameters;
  parameters.mode = "none";
  Pair pair(builtin_device("simulated"), parameters);
  EXPECT_GT(fastest_when_let_go(pair), 0.5);
}

}  // namespace
}  // namespace feltwire::sensed_orientation_test
