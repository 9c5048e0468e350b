// Tests the plugin ABI with a substitute device of known true motion.

#include <dlfcn.h>
#include <gmock/gmock.h>

#include <limits>
#include <thread>

#include "client/drivers/plugin/plugin_device.hpp"
#include "client/servo/servo_thread.hpp"
#include "tests/client/peer.hpp"
#include "tests/devices/plugin_stand_in.hpp"
#include "tests/devices/stand_in_session.hpp"
#include "tests/support/allocation_counter.hpp"
#include "tests/support/eventually.hpp"

namespace feltwire::plugin_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::WallSession;

struct Plugin : ::testing::Test {
  Plugin() : library(::dlopen(FELTWIRE_PLUGIN_STAND_IN, RTLD_NOW | RTLD_LOCAL)) {
    stand_in = reinterpret_cast<NewStandIn*>(::dlsym(library, "stand_in_new"))();
  }
  ~Plugin() override { ::dlclose(library); }

  static OpenedDevice open(const std::string& name = FELTWIRE_PLUGIN_STAND_IN,
                           const SpecRequest& spec = {}) {
    DeviceRequest request;
    request.name = name;
    request.spec = spec;
    return open_plugin(request);
  }
  static std::string refusal(const std::string& name = FELTWIRE_PLUGIN_STAND_IN) {
    try {
      open(name);
    } catch (const std::exception& error) {
      return error.what();
    }
    return "none";
  }

  void* library;
  stand_in::Plugin* stand_in;
};

TEST_F(Plugin, SaysWhatItIs) {
  const OpenedDevice opened = open();
  EXPECT_EQ(opened.device->spec().name, "stand_in");
  EXPECT_EQ(opened.device->spec().damping, 0.5);
  EXPECT_EQ(opened.device->spec().least_mass, 0.1);
  EXPECT_EQ(opened.device->spec().hand_force, 10.0);
  EXPECT_EQ(opened.device->longest_tick(), std::chrono::milliseconds(1));
  // The plugin does not report the lag of its motors.
  EXPECT_EQ(opened.device->spec().actuation.lag, 0.5e-3);
  EXPECT_THAT(
      opened.notes,
      ::testing::ElementsAre(
          HasSubstr("is an assumption for a connection that the driver does not"),
          HasSubstr("transmission_stiffness 3000 N/m is an assumption for a drive that is")));
  stand_in->source = nullptr;
  EXPECT_THAT(open().notes, ::testing::Contains(HasSubstr("damping 0.5 N s/m is an assumption")));
  const OpenedDevice told =
      open(FELTWIRE_PLUGIN_STAND_IN, {.name_or_file = {}, .damping = 0.2, .mass = {}});
  EXPECT_EQ(told.device->spec().damping, 0.2);
  EXPECT_EQ(told.device->spec().name, "stand_in");
  EXPECT_EQ(open(FELTWIRE_PLUGIN_STAND_IN, {.name_or_file = "touch", .damping = {}, .mass = {}})
                .device->spec()
                .name,
            "touch");
}

TEST_F(Plugin, TellsLatenessButtonsAndLever) {
  stand_in->late_ticks = 2;
  stand_in->stiffness = 0.0;
  const OpenedDevice opened = open();
  Device& device = *opened.device;
  EXPECT_EQ(device.spec().actuation.late_ticks, 2);
  EXPECT_EQ(device.spec().actuation.lag, 0.0);
  EXPECT_THAT(opened.notes, IsEmpty());
  const auto read = [&] {
    device.await_tick(Nanoseconds(0));
    return device.read(Nanoseconds(0));
  };
  EXPECT_EQ(read().buttons, 0u);
  EXPECT_FALSE(read().gripper);
  stand_in->buttons = 0b101;
  EXPECT_EQ(read().buttons, 0b101u);
  EXPECT_TRUE(read().deadman);
  EXPECT_FALSE(read().clutch);
  stand_in->buttons = 0b010;
  EXPECT_FALSE(read().deadman);
  EXPECT_TRUE(read().clutch);
  stand_in->lever = 0.04;
  EXPECT_EQ(read().gripper, std::optional(0.04));
  stand_in->late_ticks = 5;
  EXPECT_THAT(refusal(), HasSubstr("late_ticks"));
}

TEST_F(Plugin, TellsHowLateItsMotorsFollow) {
  stand_in->lag = 2e-4;
  stand_in->stiffness = 0.0;
  for (const LagKind kind : {LagKind::delay, LagKind::filter, LagKind::mixed}) {
    stand_in->lag_kind = static_cast<int>(kind);
    const OpenedDevice opened = open();
    EXPECT_EQ(opened.device->spec().actuation.lag, 2e-4);
    EXPECT_EQ(opened.device->spec().actuation.kind, kind);
    EXPECT_THAT(opened.notes, IsEmpty());
  }
  stand_in->source = nullptr;
  EXPECT_THAT(open().notes,
              ::testing::Contains(HasSubstr("actuation_lag 0.0002 s is an assumption")));
  stand_in->lag_kind = 3;
  EXPECT_THAT(refusal(), HasSubstr("the kind 3; set FELTWIRE_LAG_DELAY"));
  stand_in->lag_kind = 0;
  stand_in->lag = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(refusal(), HasSubstr("actuation_lag"));
  stand_in->lag = 0.0;
  EXPECT_EQ(open().device->spec().actuation.lag, 0.0);
}

TEST_F(Plugin, TellsWhatStandsBeforeItsHandle) {
  stand_in->lag = 0.0;
  stand_in->stiffness = 8e3;
  const OpenedDevice opened = open();
  EXPECT_EQ(opened.device->spec().transmission.stiffness, 8e3);
  EXPECT_EQ(opened.device->spec().transmission.encoder_side, EncoderSide::motor);
  EXPECT_THAT(opened.notes, IsEmpty());
  stand_in->encoder_side = 1;
  EXPECT_EQ(open().device->spec().transmission.encoder_side, EncoderSide::handle);
  EXPECT_THAT(open().notes, ::testing::ElementsAre(HasSubstr("the encoder is at the handle")));
  stand_in->encoder_side = 2;
  EXPECT_THAT(refusal(), HasSubstr("the encoder's side 2; set FELTWIRE_ENCODER_MOTOR"));
  stand_in->encoder_side = 0;
  stand_in->stiffness = 2e9;
  EXPECT_THAT(refusal(), HasSubstr("transmission_stiffness"));
  stand_in->stiffness = 0.0;  // It tells that it is rigid.
  EXPECT_EQ(open().device->spec().transmission.stiffness, 0.0);
  stand_in->stiffness = -1.0;
  EXPECT_EQ(open().device->spec().transmission.stiffness, 3e3);
}

/// The header got these functions later, one after the other.
TEST_F(Plugin, OfAnOlderHeaderIsLoaded) {
  stand_in->lag = 2e-4;
  stand_in->stiffness = 8e3;
  stand_in->missing_bytes = sizeof(void*);
  EXPECT_EQ(open().device->spec().actuation.lag, 2e-4);
  EXPECT_EQ(open().device->spec().transmission.stiffness, 3e3);
  stand_in->missing_bytes += sizeof(void*);
  EXPECT_EQ(open().device->spec().actuation.lag, 0.5e-3);
  stand_in->missing_bytes += 1;
  EXPECT_THAT(refusal(), HasSubstr("set size to sizeof(feltwire_device_v1)"));
}

TEST_F(Plugin, TorqueGoesOutAndWhatIsHeldOfItComesBack) {
  stand_in->turns = true;
  const OpenedDevice opened = open();
  EXPECT_EQ(opened.device->spec().rotation_actuated, 3);
  EXPECT_EQ(opened.device->spec().max_torque, 0.2);
  const Command turn{.elastic = Vec3(0, 0, 1), .torque = Vec3(0.01, 0.02, 0.03)};
  EXPECT_EQ(opened.device->write(turn), turn);
  EXPECT_EQ(stand_in->torque, (stand_in::Three{0.01, 0.02, 0.03}));
  stand_in->turns_at_most = 0.5 * turn.torque.norm();
  const Command held = opened.device->write(turn);
  EXPECT_NEAR((held.torque - 0.5 * turn.torque).norm(), 0.0, 1e-15);
  EXPECT_EQ(held.force(), turn.force());
}

TEST_F(Plugin, ErrorsNameTheFileAndTheRemedy) {
  EXPECT_THAT(refusal("not_there.so"), AllOf(HasSubstr("not_there.so"), HasSubstr("plugin:")));
  EXPECT_THAT(refusal(__FILE__), HasSubstr("cannot be loaded"));
  EXPECT_THAT(refusal(FELTWIRE_EMPTY_LIBRARY), HasSubstr("exports no function feltwire_device()"));
  stand_in->version = 7;
  EXPECT_THAT(refusal(),
              AllOf(HasSubstr("version 7 of the ABI, this client 1"), HasSubstr("build it")));
  stand_in->version = 1;
  stand_in->null_function = "write";
  EXPECT_THAT(refusal(), HasSubstr("its function write is null"));
  stand_in->null_function = "wait";
  EXPECT_THAT(refusal(), HasSubstr("its function wait is null"));
  EXPECT_EQ(stand_in->closes, 1);  // The plugin was open.
  stand_in->null_function = "";
  stand_in->open_error = "no device on the bus";
  EXPECT_THAT(refusal(std::string(FELTWIRE_PLUGIN_STAND_IN) + ":bus 3"),
              HasSubstr("no device on the bus (bus 3)"));
  stand_in->open_error = "";
  stand_in->mass.damping = -1.0;
  EXPECT_THAT(refusal(), HasSubstr("damping"));
}

/// A minute of taps and slides against a wall of 2 kN/m that answers 20 ms late.
struct PluginSession : Plugin {
  double made(std::string_view mode = kSessionMethod) {
    const OpenedDevice opened = open();
    SessionParameters parameters = testing::session_of(*opened.device);
    parameters.mode = mode;
    Servo servo(opened.device->spec(), parameters, {});
    WallSession session{.period = stand_in->period};
    session.run(*opened.device, servo, 60.0);
    statistics = servo.statistics();
    EXPECT_GT(stand_in->mass.largest_force, 0.5);  // The hand must touch the wall.
    return stand_in->mass.most_made;
  }
  ServoStatistics statistics;
};

TEST_F(PluginSession, MakesNoEnergy) {
  EXPECT_LE(made(), 1e-12);
  EXPECT_EQ(statistics.device.stale_readings, 0u);
}

/// Without a bound the wall must make energy. This shows that the other tests can fail.
TEST_F(PluginSession, TheWallAloneWouldMakeEnergy) { EXPECT_GT(made(kUnbounded), 0.01); }

/// The account does not cover a late force that the plugin hides. The motion of the mass shows this
/// energy.
TEST_F(PluginSession, ALateForceThatIsNotToldOfIsNotAccounted) {
  stand_in->late = 1.0;
  const auto margin = [&] {
    const OpenedDevice opened = open();
    Servo servo(opened.device->spec(), testing::session_of(*opened.device), {});
    WallSession session{.period = stand_in->period};
    session.run(*opened.device, servo, 5.0);
    return std::abs(servo.port().delivered().total() - stand_in->mass.delivered);
  };
  const double told = margin();
  stand_in->mass = {};
  stand_in->tells_late = false;
  EXPECT_GT(margin(), 10.0 * told);
}

/// The account must first cover the forces that the device did not apply yet.
TEST_F(PluginSession, MakesNoneWhereEachForceIsATickLateAndThePluginSaysSo) {
  stand_in->late = 1.0;
  stand_in->tells_late = false;
  stand_in->late_ticks = 1;
  EXPECT_LE(made(), 1e-12);
}

TEST_F(PluginSession, MakesNoneWithStaleReadings) {
  stand_in->stale_every = 7;
  EXPECT_LE(made(), 1e-12);
  EXPECT_EQ(statistics.device.stale_readings, 8571u);  // 60 000 / 7
}

TEST_F(PluginSession, MakesNoneWhereTheForceIsCut) {
  stand_in->saturates_at = 0.7;
  EXPECT_LE(made(), 1e-12);
  EXPECT_LE(statistics.max_force, 0.7 + 1e-12);
}

TEST_F(PluginSession, MakesNoneWithTicksThatComeSooner) {
  stand_in->jitter = 0.6e-3;
  EXPECT_LE(made(), 1e-12);
}

TEST_F(PluginSession, MakesNoneWhereForcesAreTakenUpLate) {
  stand_in->late = 0.4;
  EXPECT_LE(made(), 1e-12);
  EXPECT_GT(statistics.device.forces_corrected, 100u);
}

TEST_F(PluginSession, ADeviceThatIsUnpluggedHoldsNothing) {
  const OpenedDevice opened = open();
  Servo servo(opened.device->spec(), testing::session_of(*opened.device), {});
  WallSession session{.period = stand_in->period};
  while (!stand_in->pulls) session.tick(*opened.device, servo);
  stand_in->unplugged_at = stand_in->ticks + 1;
  ASSERT_TRUE(session.tick(*opened.device, servo));
  EXPECT_FALSE(session.tick(*opened.device, servo));
  EXPECT_EQ(servo.held(), Command{});
  EXPECT_EQ(servo.no_force(), ZeroForceReason::device_fault);
}

TEST_F(PluginSession, ATickDoesNotTouchTheHeap) {
  const OpenedDevice opened = open();
  Servo servo(opened.device->spec(), testing::session_of(*opened.device), {});
  Nanoseconds now = std::chrono::seconds(3);
  const std::size_t before = test::allocations();
  for (int n = 0; n < 1000; ++n) {
    opened.device->await_tick(now += std::chrono::milliseconds(1));
    servo.tick(*opened.device, now);
  }
  EXPECT_EQ(test::allocations() - before, 0u);
}

/// examples/my_plugin.c has a spring that pulls its mass into the wall.
TEST(MyPlugin, FeelsAWall) {
  DeviceRequest request;
  request.name = std::string(FELTWIRE_MY_PLUGIN) + ":0.3";
  const OpenedDevice opened = open_plugin(request);
  EXPECT_EQ(opened.device->spec().apparent_mass, 0.3);
  EXPECT_EQ(opened.device->longest_tick(), Nanoseconds(0));
  Servo servo(opened.device->spec(), testing::session_of(*opened.device), {});
  WallSession session{.period = 1e-3};
  for (int n = 0; n < 3000; ++n) {
    servo.tick(*opened.device, session.now += std::chrono::milliseconds(1));
    Reply reply;
    reply.sample_index = servo.sample().index;
    reply.command.elastic.z() = 500.0 * std::max(0.0, -servo.sample().pose.position.z());
    servo.take(reply, session.now);
  }
  EXPECT_GT(servo.statistics().max_force, 0.3);
  opened.device->release();
  EXPECT_EQ(opened.device->write({.elastic = Vec3(0, 0, 1)}), Command{});
  request.name = std::string(FELTWIRE_MY_PLUGIN) + ":heavy";
  EXPECT_THROW(open_plugin(request), std::runtime_error);
}

/// A call does not return. Another thread must release the device.
TEST_F(PluginSession, ABlockedCallLetsTheForceGo) {
  testing::ScenePeer peer;
  auto task = std::make_shared<ServoTask>(
      open().device, std::make_shared<Transport>(peer.session(), SessionParameters{}, false),
      [] {
        SessionParameters p;
        p.mode = "none";
        return p;
      }(),
      ServoOptions{});
  task->priority = ServoTask::kNoRealTime;
  // A busy machine must not trigger the release.
  task->let_go_after = SessionParameters{}.hold_time;
  ServoThread thread(task);
  while (!stand_in->pulls) {
    const auto received = peer.receive();
    if (received.kind == DatagramKind::samples)
      peer.send(
          testing::ScenePeer::reply_to(received.batch.samples[0], {.elastic = Vec3(0, 0, 3)}));
  }
  stand_in->edge.strike();
  stand_in->blocks.store(true);
  test::eventually("it is let go", [&] { return stand_in->blocked && !stand_in->pulls; });
  testing::expect_in_time_by_clock("plugin", "a blocked call", stand_in->edge);
  EXPECT_GT(stand_in->releases, 0);
  stand_in->blocks.store(false);
  EXPECT_TRUE(thread.end());
  EXPECT_TRUE(task->result.stood_still);
}

}  // namespace
}  // namespace feltwire::plugin_test
