// A position jump beyond the speed of any hand is a device fault.

#include <gtest/gtest.h>

#include <fstream>
#include <random>
#include <sstream>

#include "client/device/mapped_device.hpp"
#include "client/hands/replay_device.hpp"
#include "core/base/numeric.hpp"
#include "tests/client/servo_bench.hpp"

namespace feltwire::jump_test {
namespace {

using namespace testing::servo;

constexpr double kRates[] = {10000.0, 4000.0, 1000.0, 500.0, 250.0};  // [Hz]

SessionParameters usual(double rate) {
  SessionParameters p = usual_parameters();
  p.servo_period = 1.0 / rate;
  return p;
}

/// A servo with the default method and the default protection. A plane z = 0 of 600 N/m answers
/// each sample at once.
struct Hand {
  explicit Hand(double rate, DeviceSpec of_device = builtin_device("simulated"), double scale = 1.0)
      : spec(std::move(of_device)), parameters(usual(rate)), servo(spec, parameters, [&] {
          ServoOptions options = protect_hand(parameters);
          options.motion_scale = scale;
          return options;
        }()) {}

  Command tick(const DeviceReading& reading, double late = 0.0) {
    now += seconds(parameters.servo_period + late);
    const Command given = servo.render(reading, now);
    const Sample* sample = servo.hold(given);
    most = std::max(most, given.force().norm());
    if (sample == nullptr) return given;
    Reply r =
        reply(sample->index, elastic(0, 0, 600.0 * std::max(0.0, -sample->pose.position.z())));
    r.modelled = true;
    SurfacePatch& patch = r.model.patches[0];
    patch.point = Vec3(sample->pose.position.x(), sample->pose.position.y(), 0.0);
    patch.normal = Vec3::UnitZ();
    patch.radius = r.model.reach = 1.0;
    patch.material.stiffness = 600.0;
    r.model.center = sample->pose.position;
    r.model.count = 1;
    servo.take(r, now);
    return given;
  }
  Command rest(const Vec3& place, double time) {
    Command last;
    for (double t = 0.0; t < time; t += parameters.servo_period)
      last = tick(at(place.x(), place.y(), place.z()));
    return last;
  }
  double balance() const { return servo.account()->balance(); }

  DeviceSpec spec;
  SessionParameters parameters;
  Servo servo;
  Nanoseconds now = seconds(100.0);
  double most = 0.0;  // [N] largest force
};

Recording recording(const std::string& rows) {
  std::istringstream in("t,x,y,z\n" + rows);
  return read_recording(in, "r.csv");
}

TEST(Jump, GivesNoForceAndNoCreditAndTheWaitBeginsAnewAtEveryRate) {
  for (const double rate : kRates) {
    for (const double way : {0.02, 0.05, 0.3}) {
      Hand hand(rate);
      hand.rest({0, 0, 0.005}, 0.2);
      const double before = hand.balance();
      EXPECT_EQ(hand.tick(at(0, 0, 0.005 - way)).force(), Vec3::Zero()) << rate;
      EXPECT_EQ(hand.servo.no_force(), ZeroForceReason::jumped);
      EXPECT_EQ(hand.servo.statistics().device.jumps, 1u) << rate << " " << way;
      EXPECT_EQ(hand.servo.statistics().device.faults, 1u);
      EXPECT_LE(hand.balance(), before);
      // After the jump the servo withholds the scene's force, as for a hand that begins in contact.
      hand.rest({0, 0, 0.005 - way}, 0.3);
      EXPECT_LT(hand.most, 1e-9) << rate << " " << way;
      EXPECT_EQ(hand.servo.no_force(), ZeroForceReason::waiting);
      EXPECT_LE(hand.balance(), before);
      EXPECT_EQ(hand.servo.statistics().device.jumps, 1u);
      EXPECT_EQ(hand.servo.port().violations(), 0u);
    }
  }
}

/// The reading alternates between two positions, at each tick or less often.
TEST(Jump, AReadingThatFlickersGivesNoForceAndNoCredit) {
  for (const double rate : kRates) {
    for (const int every : {1, 2, 7}) {
      Hand hand(rate);
      hand.rest({0, 0, 0.005}, 0.2);
      const double before = hand.balance();
      for (int n = 0; n < 400; ++n) hand.tick(at(0, 0, (n / every) % 2 == 0 ? 0.005 : -0.02));
      EXPECT_LT(hand.most, 1e-9) << rate << " " << every;
      EXPECT_LE(hand.balance(), before);
      EXPECT_GT(hand.servo.statistics().device.jumps, 25u);
    }
  }
}

TEST(Jump, OfTheOrientationIsAFaultToo) {
  for (const double rate : kRates) {
    for (const char* device : {"simulated_6dof", "touch"}) {
      Hand hand(rate, builtin_device(device));
      hand.rest({0, 0, 0.005}, 0.1);
      DeviceReading turned = at(0, 0, 0.005);
      turned.pose.orientation = Quaternion(Eigen::AngleAxisd(1.0, Vec3(0.6, 0, 0.8)));
      EXPECT_EQ(hand.tick(turned).force(), Vec3::Zero());
      EXPECT_EQ(hand.servo.statistics().device.jumps, 1u) << rate << " " << device;
      // The quaternions q and -q are the same orientation.
      turned.pose.orientation.coeffs() *= -1.0;
      for (int n = 0; n < 10; ++n) hand.tick(turned);
      EXPECT_EQ(hand.servo.statistics().device.jumps, 1u) << rate << " " << device;
    }
  }
}

/// A hand may move during a stall, but not faster than a hand's largest speed.
TEST(Jump, AfterAStallTheTimeOfTheStallCounts) {
  for (const double rate : kRates) {
    for (const double stall : {0.005, 0.02, 0.08}) {
      Hand honest(rate), lying(rate);
      honest.rest({0, 0, 0.1}, 0.1);
      lying.rest({0, 0, 0.1}, 0.1);
      honest.tick(at(0, 0, 0.1 - 2.0 * stall), stall);  // a speed of 2 m/s
      EXPECT_EQ(honest.servo.statistics().device.jumps, 0u) << rate << " " << stall;
      lying.tick(at(0, 0, 0.1 - 10.5 * (stall + 1.0 / rate)), stall);
      EXPECT_EQ(lying.servo.statistics().device.jumps, 1u) << rate << " " << stall;
      // The tick after a stall has the usual limit again.
      honest.tick(at(0, 0, 0.1 - 2.0 * stall - 0.05));
      EXPECT_EQ(honest.servo.statistics().device.jumps, 1u) << rate << " " << stall;
    }
  }
}

/// The hand strikes a stop at 3 m/s. The velocity limit allows no force at this speed.
TEST(Jump, AFastHandIsNone) {
  for (const double rate : kRates) {
    Hand hand(rate);
    double t = 0.0;
    while (t < 2.0) {
      t += 1.0 / rate;
      // A stop 10 mm below the plane reverses the velocity.
      const double z = std::abs(0.06 * std::cos(50.0 * t) + 0.01) - 0.01;
      hand.tick(at(0, 0.02 * std::sin(30.0 * t), z));
    }
    EXPECT_EQ(hand.servo.statistics().device.jumps, 0u) << rate;
    EXPECT_EQ(hand.servo.statistics().device.faults, 0u) << rate;
    EXPECT_GT(hand.most, 0.1);
  }
}

/// A mapping that scales positions by ten also scales the allowed speed by ten.
TEST(Jump, AMappedToolMayMoveAsFarAsItsMappingSays) {
  for (const double scale : {0.1, 10.0}) {
    const MappedDevice device(
        std::make_unique<ReplayDevice>(recording("0,0,0,0\n"), builtin_device("simulated")),
        {.scale = scale});
    EXPECT_EQ(device.motion_scale(), scale);
    Hand hand(1000.0, device.spec(), device.motion_scale());
    hand.rest({0, 0, 1.0}, 0.01);
    hand.tick(at(0, 0, 1.0 + scale * 2.3e-3));
    EXPECT_EQ(hand.servo.statistics().device.jumps, 0u) << scale;
    hand.rest({0, 0, 2.0}, 0.01);
    const auto jumps = hand.servo.statistics().device.jumps;
    hand.tick(at(0, 0, 2.0 + scale * 2.7e-3));
    EXPECT_EQ(hand.servo.statistics().device.jumps, jumps + 1) << scale;
  }
}

// Tests with recordings.

/// A hand sinks slowly, recorded at 1 kHz. It jumps by `way` [m] after a second.
Recording sinking(double way) {
  std::ostringstream rows;
  for (int n = 0; n < 2500; ++n)
    rows << 1e-3 * n << ",0,0," << 0.005 - 2e-3 * 1e-3 * n - (n > 1000 ? way : 0.0) << "\n";
  return recording(rows.str());
}

TEST(Jump, ARecordingsJumpIsFoundAtEveryRate) {
  for (const double rate : {10000.0, 4000.0, 1000.0, 900.0, 100.0, 50.0}) {
    for (const double way : {0.02, 0.004, -0.02}) {
      ReplayDevice device(sinking(way), builtin_device("simulated"));
      EXPECT_EQ(device.jumps(), 1u);
      Hand hand(rate);
      while (true) {
        const DeviceReading reading = device.read(hand.now + seconds(1.0 / rate));
        if (reading.ended) break;
        hand.tick(reading);
      }
      EXPECT_GE(hand.servo.statistics().device.jumps, 1u) << rate << " " << way;
      EXPECT_LE(hand.servo.statistics().device.jumps, std::ceil(rate / 1000.0) + 1.0) << rate;
      // The hand sinks 3 mm more. The force must match that depth.
      EXPECT_LE(hand.most, 600.0 * 3e-3 + 0.1) << rate << " " << way;
    }
    ReplayDevice device(sinking(0.0), builtin_device("simulated"));
    EXPECT_EQ(device.jumps(), 0u);
  }
}

/// A mouse records irregular rows, 10 to 60 times a second. Its strokes of 4 m/s begin within a
/// row. The servo must accept them as hand movements, even at 10 kHz.
TEST(Jump, ARecordingOfAMouseIsAHandAtEveryRate) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  std::ostringstream rows;
  double t = 0.0;
  Vec3 place(0, 0, 0.002);
  for (int n = 0; n < 600; ++n) {
    rows << t << "," << place.x() << "," << place.y() << "," << place.z() << "\n";
    const double dt = n % 7 == 0 ? 0.1 : 0.015 + 0.001 * std::abs(any(random));
    const double fast = n % 11 == 0 ? 4.0 : 0.3;
    Vec3 way = fast * dt * Vec3(any(random), any(random), 0.0).normalized();
    if ((place + way).norm() > 0.4) way = -fast * dt * place.normalized();
    place += way;
    place.z() = n % 20 < 10 ? -0.002 : 0.002;
    t += dt;
  }
  for (const double rate : {10000.0, 1000.0, 100.0}) {
    ReplayDevice device(recording(rows.str()), builtin_device("simulated"));
    EXPECT_EQ(device.jumps(), 0u);
    Hand hand(rate);
    for (DeviceReading reading; !reading.ended; hand.tick(reading))
      reading = device.read(hand.now + seconds(1.0 / rate));
    EXPECT_EQ(hand.servo.statistics().device.jumps, 0u) << rate;
    EXPECT_GT(hand.most, 0.1) << "it presses";
  }
}

}  // namespace
}  // namespace feltwire::jump_test
