// Identification must stop on faults and release the force. It writes its result as a device file.

#include "client/identify/identification.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <thread>

#include "client/identify/identified_spec.hpp"
#include "client/identify/measure.hpp"
#include "core/device/spec_text.hpp"
#include "tests/client/identify/simulated_handle.hpp"

namespace feltwire::identification_test {
namespace {

using identify_test::HandleTruth;
using identify_test::SimulatedHandle;
using State = Identification::State;

constexpr double kPeriod = 1e-3;

DeviceSpec spec() { return builtin_device("simulated"); }

/// An identification that has moved a free handle for three seconds.
struct Led {
  Identification identification{spec(), identify_limits(spec()), kPeriod};
  SimulatedHandle handle{HandleTruth{}};
  double time = 0.0;
  Vec3 position = Vec3::Zero();

  Led() {
    while (time < 3.0) go_on();
  }
  Vec3 go_on() { return go_on_at(handle.read()); }
  Vec3 go_on_at(const Vec3& read) {
    position = read;
    const Vec3 force = identification.step(time, read);
    identification.held(force);
    handle.hold(force, kPeriod);
    time += kPeriod;
    return force;
  }
};

TEST(Identification, LeadsAFreeHandleWithinItsLimits) {
  Led led;
  const IdentifyLimits limits = identify_limits(spec());
  for (int n = 0; n < 5000; ++n) {
    EXPECT_LE(led.go_on().norm(), limits.force * (1.0 + 1e-12));
    EXPECT_LE(led.position.norm(), limits.travel);
  }
  EXPECT_EQ(led.identification.state(), State::measuring);
  EXPECT_GT(led.identification.largest_force(), 0.0);
}

TEST(Identification, BeginsWithoutAKick) {
  Identification identification(spec(), identify_limits(spec()), kPeriod);
  EXPECT_EQ(identification.step(5.0, Vec3(0.01, 0.02, 0.03)), Vec3(Vec3::Zero()));
}

TEST(Identification, GivesUpWhereTheHandleIsPulledAway) {
  Led led;
  Vec3 force;
  for (int n = 0; n < 1000 && led.identification.state() == State::measuring; ++n)
    force = led.go_on_at(led.position + Vec3(1e-4, 0.0, 0.0));
  EXPECT_EQ(led.identification.state(), State::gave_up);
  EXPECT_NE(led.identification.why().find("left the room"), std::string_view::npos);
  EXPECT_EQ(force, Vec3(Vec3::Zero()));
}

TEST(Identification, GivesUpOnAJumpALateReadingAndNonsense) {
  Led jump;
  EXPECT_EQ(jump.go_on_at(jump.position + Vec3(0.01, 0.0, 0.0)), Vec3(Vec3::Zero()));
  EXPECT_NE(jump.identification.why().find("too fast"), std::string_view::npos);

  Led late;
  late.time += 0.06;
  EXPECT_EQ(late.go_on(), Vec3(Vec3::Zero()));
  EXPECT_NE(late.identification.why().find("too late"), std::string_view::npos);

  Led nonsense;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(nonsense.go_on_at(Vec3(nan, 0.0, 0.0)), Vec3(Vec3::Zero()));
  EXPECT_EQ(nonsense.identification.state(), State::gave_up);
}

TEST(Identification, GivenUpItStaysSo) {
  Led led;
  led.identification.give_up("it was asked to stop");
  for (int n = 0; n < 10; ++n) EXPECT_EQ(led.go_on(), Vec3(Vec3::Zero()));
  EXPECT_EQ(led.identification.why(), "it was asked to stop");
}

TEST(Identification, AForceBeyondTheDeviceIsRefused) {
  EXPECT_THROW(identify_limits(spec(), 0.0), std::invalid_argument);
  EXPECT_THROW(identify_limits(spec(), 0.009 * spec().max_force), std::invalid_argument);
  EXPECT_NO_THROW(identify_limits(spec(), 0.011 * spec().max_force));
  EXPECT_THROW(identify_limits(spec(), std::nan("")), std::invalid_argument);
  EXPECT_THROW(identify_limits(spec(), 1.01 * spec().continuous_force), std::invalid_argument);
}

/// A device with faults from reading 200 on.
class FaultyDevice final : public Device {
 public:
  const DeviceSpec& spec() const override { return spec_; }
  DeviceReading read(Nanoseconds) noexcept override {
    return {.pose = {.position = handle_.read()}, .ok = ++readings_ < 200};
  }
  Command write(const Command& on_hand) noexcept override {
    last_ = on_hand.force();
    handle_.hold(last_, kMeasurePeriod);
    return on_hand;
  }
  void release() noexcept override { ++released; }

  int released = 0;
  Vec3 last() const { return last_; }

 private:
  DeviceSpec spec_ = identification_test::spec();
  SimulatedHandle handle_{HandleTruth{}};
  Vec3 last_ = Vec3::Zero();
  int readings_ = 0;
};

TEST(Identification, AFaultEndsItAndTheDeviceIsReleased) {
  FaultyDevice device;
  Identification identification(device.spec(), identify_limits(device.spec()), kMeasurePeriod);
  MeasureStatus status;
  measure(device, identification, status);
  EXPECT_EQ(identification.state(), State::gave_up);
  EXPECT_GT(device.released, 0);
  EXPECT_EQ(device.last(), Vec3(Vec3::Zero()));
  EXPECT_TRUE(status.over.load());
}

SourcedSpec written_and_read(const SourcedSpec& written) {
  const std::filesystem::path file =
      std::filesystem::path(::testing::TempDir()) / "identified_device.json";
  std::ofstream(file) << device_file_text(written);
  return sourced_spec(file.string());
}

TEST(IdentifiedSpec, IsAFileThatTheAccountReads) {
  DeviceEstimate found;
  found.damping = {0.4, 0.5, 0.6};
  found.damping_bound = {0.3, 0.4, 0.5};
  found.friction = 0.1, found.friction_bound = 0.07;
  found.mass = {0.2, 0.2, 0.26};
  found.mass_bound = 0.15;
  found.quantum = 2e-5, found.noise = 1e-6;
  const SourcedSpec written = identified_spec(sourced_spec("omega.7"), found, "2026-11-23");
  const SourcedSpec read = written_and_read(written);
  EXPECT_FALSE(read.tells_lag);
  EXPECT_EQ(read.spec.damping, Damping(Vec3(0.3, 0.4, 0.5)));
  EXPECT_DOUBLE_EQ(read.spec.least_mass, 0.15);
  EXPECT_DOUBLE_EQ(read.spec.apparent_mass, 0.22);
  EXPECT_DOUBLE_EQ(read.spec.least_friction, 0.07);
  EXPECT_DOUBLE_EQ(read.spec.position_resolution, 2e-5);
  EXPECT_EQ(read.spec.rotation_sensed, 3);
  EXPECT_EQ(read.sources, written.sources);
  EXPECT_NE(read.sources.at("damping").find("identify, 2026-11-23: lower bound"),
            std::string::npos);
}

/// A measured lag may be a delay, a first-order lag or both. A lag above one tick becomes a delay.
TEST(IdentifiedSpec, TellsTheLag) {
  DeviceEstimate found;
  found.mass = Vec3::Constant(0.2);
  found.mass_bound = 0.15;
  found.lag = 0.35e-3, found.lag_bound = 0.4e-3;
  const SourcedSpec known = sourced_spec("omega.7");
  const SourcedSpec read = written_and_read(identified_spec(known, found, "2026-11-29"));
  EXPECT_TRUE(read.tells_lag);
  EXPECT_DOUBLE_EQ(read.spec.actuation.lag, 0.4e-3);
  EXPECT_EQ(read.spec.actuation.kind, LagKind::mixed);
  EXPECT_EQ(read.sources.at("actuation_lag"),
            "identify, 2026-11-29: upper bound, of the reading too; estimate 0.00035");
  found.lag_bound = 1.5e-3;
  const DeviceSpec late = identified_spec(known, found, "2026-11-29").spec;
  EXPECT_DOUBLE_EQ(late.actuation.lag, 2e-3);
  EXPECT_EQ(late.actuation.kind, LagKind::delay);
}

/// Without a new value, the old value stays.
TEST(IdentifiedSpec, KeepsWhatWasToldOfTheLag) {
  DeviceEstimate found;
  found.mass = Vec3::Constant(0.2);
  SourcedSpec known = sourced_spec("omega.7");
  known.spec.actuation.lag = 0.7e-3;
  known.spec.actuation.kind = LagKind::filter;
  known.tells_lag = true;
  const SourcedSpec kept = written_and_read(identified_spec(known, found, "2026-11-29"));
  EXPECT_DOUBLE_EQ(kept.spec.actuation.lag, 0.7e-3);
  EXPECT_EQ(kept.spec.actuation.kind, LagKind::filter);
}

/// Late ticks are a part of the measured lag. The rest is the lag beyond them.
TEST(IdentifiedSpec, TellsTheLagBeyondLateTicks) {
  DeviceEstimate found;
  found.mass = Vec3::Constant(0.2);
  found.tick = 1e-3;
  found.lag = 2.25e-3, found.lag_bound = 2.3e-3;
  SourcedSpec known = sourced_spec("omega.7");
  known.spec.actuation.late_ticks = 2;
  const SourcedSpec late = written_and_read(identified_spec(known, found, "2026-11-30"));
  EXPECT_TRUE(late.tells_lag);
  EXPECT_EQ(late.spec.actuation.late_ticks, 2);
  EXPECT_NEAR(late.spec.actuation.lag, 0.3e-3, 1e-12);
  EXPECT_EQ(late.spec.actuation.kind, LagKind::mixed);
  EXPECT_THAT(late.sources.at("actuation_lag"),
              ::testing::EndsWith("estimate 0.00225, less 0.002 s of late_ticks"));
  found.lag_bound = 1.5e-3;  // earlier than the late ticks say
  EXPECT_EQ(identified_spec(known, found, "2026-11-30").spec.actuation.lag, 0.0);
  found.lag_bound.reset();
  EXPECT_FALSE(identified_spec(known, found, "2026-11-30").tells_lag);
}

TEST(ReportedSpec, SaysWhatTheDriverAssumes) {
  DeviceSpec reported = sourced_spec("omega.7").spec;
  reported.transmission.stiffness = 3e3;
  reported.actuation.lag = 0.5e-3;
  for (const char* requested : {"omega.7", "touch"}) {
    const SourcedSpec known = reported_spec(sourced_spec(requested), reported);
    EXPECT_EQ(known.spec.name, "omega.7");
    EXPECT_EQ(known.sources.at("transmission_stiffness"), "assumption of the driver");
    EXPECT_EQ(known.sources.at("encoder_side"), "assumption of the driver");
    EXPECT_EQ(known.sources.at("actuation_lag"), "assumption of the driver");
    EXPECT_EQ(known.sources.at("max_force"), sourced_spec("omega.7").sources.at("max_force"));
    EXPECT_THAT(spec_table(known), ::testing::ContainsRegex("transmission_stiffness .*assumption"));
  }
  SourcedSpec told = sourced_spec("omega.7");
  told.tells_transmission = told.tells_lag = true;
  told.sources["transmission_stiffness"] = "measured";
  EXPECT_EQ(reported_spec(told, reported).sources.at("transmission_stiffness"), "measured");
  reported.name = "a device of its maker";
  EXPECT_TRUE(reported_spec(told, reported).sources.empty());
}

TEST(IdentifiedSpec, TellsTheTransmissionAndWhatIsAssumed) {
  DeviceEstimate found;
  found.mass = Vec3::Constant(0.2);
  const SourcedSpec known = sourced_spec("omega.7");
  EXPECT_FALSE(identified_spec(known, found, "2026-11-30").tells_transmission);
  found.transmission = {.valid = true,
                        .side = EncoderSide::motor,
                        .resonance = 80.0,
                        .stiffness = 9e3,
                        .stiffness_bound = 7e3,
                        .handle_mass = 0.05};
  const SourcedSpec read = written_and_read(identified_spec(known, found, "2026-11-30"));
  EXPECT_TRUE(read.tells_transmission);
  EXPECT_DOUBLE_EQ(read.spec.transmission.stiffness, 7e3);
  EXPECT_EQ(
      read.sources.at("transmission_stiffness"),
      "identify, 2026-11-30: lower bound; first resonance at 80 Hz, estimate 9000 N/m, 0.05 kg "
      "behind it");
  found.transmission->side = EncoderSide::handle;
  const SourcedSpec other = written_and_read(identified_spec(known, found, "2026-11-30"));
  EXPECT_EQ(other.spec.transmission.encoder_side, EncoderSide::handle);
  EXPECT_EQ(other.sources.at("transmission_stiffness"),
            "identify, 2026-11-30: lower bound; first resonance at 80 Hz; a tenth of the mass on "
            "either side of it is assumed");
}

}  // namespace
}  // namespace feltwire::identification_test
