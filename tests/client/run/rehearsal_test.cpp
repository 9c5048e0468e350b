// The start line predicts the forces that a hand will feel.

#include "client/run/rehearsal.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace feltwire::rehearsal_test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

SessionParameters session(std::string_view mode = "shaped") {
  SessionParameters p;
  p.mode = mode;
  p.side = BoundingSide::client;
  p.local_model = true;
  return p;
}

Rehearsal rehearsed(const DeviceSpec& spec, const SessionParameters& parameters = session()) {
  return rehearse(spec, parameters, protect_hand(parameters), 0.0).value();
}

/// A device with much damping displays the usual walls completely. Lag reduces the stiff walls.
TEST(Rehearsal, ADeviceWithDampingFeelsItsWalls) {
  DeviceSpec spec = builtin_device("omega.7");
  const Rehearsal quick = rehearsed(spec);
  EXPECT_EQ(quick.scene.wall, 1000.0);
  EXPECT_NEAR(quick.scene.share, 1.0, 0.02);
  EXPECT_TRUE(quick.scene.calm());
  EXPECT_TRUE(quick.mass_known);
  EXPECT_FALSE(quick.swings);
  EXPECT_GE(quick.whole.wall, 10e3);
  spec.actuation.lag = 0.5e-3;
  const Rehearsal late = rehearsed(spec);
  EXPECT_LT(late.most.stiffness(), 0.6 * quick.most.stiffness());
  EXPECT_LE(late.whole.wall, quick.whole.wall);
}

/// The hand feels the transmission and the wall in series: k_t / (k_t + k) of what the encoder
/// shows.
TEST(Rehearsal, BehindATransmissionTheHandleFeelsLessThanTheEncoderShows) {
  DeviceSpec spec = builtin_device("omega.7");
  spec.transmission.stiffness = 3e3;
  const Rehearsal soft = rehearsed(spec);
  EXPECT_EQ(soft.transmission, 3e3);
  EXPECT_NEAR(soft.scene.share_at_encoder, 1.0, 0.02);
  EXPECT_NEAR(soft.scene.share, 3.0 / 4.0, 0.03);
  EXPECT_TRUE(soft.scene.calm());
  EXPECT_LT(soft.most.stiffness(), 3e3);
  EXPECT_LT(soft.whole.wall, 1e3);
  EXPECT_THAT(rehearsal_text(soft), HasSubstr(" of a wall of 1000 N/m behind a transmission of "
                                              "3000 N/m (1.00 at the encoder)"));
  spec.transmission.stiffness = 0.0;
  EXPECT_THAT(rehearsal_text(rehearsed(spec)), Not(HasSubstr("transmission")));
}

/// An encoder at the handle does not see the motor, so a stiff wall swings on the transmission.
TEST(Rehearsal, AnEncoderAtTheHandleSwingsEarlier) {
  DeviceSpec spec = builtin_device("omega.7");
  spec.transmission.stiffness = 10e3;
  const Rehearsal at_motor = rehearsed(spec);
  spec.transmission.encoder_side = EncoderSide::handle;
  const Rehearsal at_handle = rehearsed(spec);
  EXPECT_EQ(at_handle.scene.share, at_handle.scene.share_at_encoder);
  EXPECT_LT(at_handle.calm.wall, at_motor.calm.wall);
}

/// The bounding method assumes no mass if the device file has none. The line must name the remedy.
TEST(Rehearsal, ADeviceWithoutAMassFeelsLittle) {
  DeviceSpec spec = builtin_device("lambda.7");
  ASSERT_EQ(spec.least_mass, 0.0);
  const Rehearsal without = rehearsed(spec);
  EXPECT_LT(without.scene.share, 0.2);
  EXPECT_FALSE(without.mass_known);
  EXPECT_THAT(rehearsal_text(without), HasSubstr("no least_mass"));
  spec.apparent_mass = 0.2;
  spec.least_mass = 0.15;
  const Rehearsal with = rehearsed(spec);
  EXPECT_GT(with.scene.share, 0.9);
  EXPECT_THAT(rehearsal_text(with), Not(HasSubstr("least_mass")));
}

/// Without a bounding method, a light hand oscillates on a wall that is too stiff for its device.
TEST(Rehearsal, AHandSwingsWithoutALaw) {
  DeviceSpec spec = builtin_device("simulated");
  spec.damping = 0.01;
  spec.coulomb_friction = spec.least_friction = 0.0;
  const Rehearsal none = rehearsed(spec, session("none"));
  EXPECT_TRUE(none.swings);
  EXPECT_LT(none.calm.wall, 10e3);
  EXPECT_THAT(rehearsal_text(none), HasSubstr("a hand swings"));
  EXPECT_GT(rehearsed(spec).calm.wall, none.calm.wall);
}

/// A handle that only sinks does not oscillate, because its own damping slows it.
TEST(Rehearsal, AHandleThatSinksDoesNotSwing) {
  DeviceSpec spec = builtin_device("simulated");
  spec.damping = 500.0;
  EXPECT_TRUE(rehearsed(spec).scene.calm());
}

/// Some device files have only a largest force. A coarse encoder must not give a share above 1.
TEST(Rehearsal, OddDevicesGetPossibleNumbers) {
  DeviceSpec spec = builtin_device("touch");
  spec.continuous_force = 0.0;
  const Rehearsal found = rehearsed(spec);
  EXPECT_EQ(found.force, 3.0);
  EXPECT_LE(found.most.share, 1.0);
  EXPECT_LE(found.whole.share, 1.0);
}

TEST(Rehearsal, TheSameAgain) {
  const DeviceSpec& spec = builtin_device("touch");
  EXPECT_EQ(rehearsal_text(rehearsed(spec)), rehearsal_text(rehearsed(spec)));
}

/// The client cannot predict the bounding method of a server, or of the site of a remote robot.
TEST(Rehearsal, NothingIsSaidOfALawThatIsNotKnown) {
  const DeviceSpec& spec = builtin_device("simulated");
  SessionParameters p = session();
  ServoOptions options = protect_hand(p);
  options.leads.emplace();
  EXPECT_FALSE(rehearse(spec, p, options, 0.0));
  options = protect_hand(p);
  p.local_model = false;
  EXPECT_FALSE(rehearse(spec, p, options, 0.0));
  p.side = BoundingSide::server;
  EXPECT_FALSE(rehearse(spec, p, options, 0.0));
}

TEST(Rehearsal, ARunThatEndsDoesNotWaitForIt) {
  const SessionParameters p = session();
  RehearsalThread thread(builtin_device("simulated"), p, protect_hand(p), 0.0);
  thread.finish();  // The thread may already have a result or not.
  int looks = 0;
  const auto goes_on = [&looks] { return ++looks < 3; };
  EXPECT_FALSE(rehearse(builtin_device("simulated"), p, protect_hand(p), 0.0, goes_on));
  EXPECT_EQ(looks, 3);
}

}  // namespace
}  // namespace feltwire::rehearsal_test
