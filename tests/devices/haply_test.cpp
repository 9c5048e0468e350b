// Tests the driver of Haply's devices against a substitute of their service.

#include "client/drivers/haply/haply.hpp"

#include <gmock/gmock.h>

#include <cmath>

#include "client/drivers/haply/haply_messages.hpp"
#include "client/servo/servo.hpp"
#include "protocol/net/clock.hpp"
#include "tests/devices/haply_stand_in.hpp"
#include "tests/devices/stand_in_session.hpp"
#include "tests/support/allocation_counter.hpp"
#include "tests/support/eventually.hpp"

namespace feltwire::haply_test {
namespace {

using stand_in::HaplyService;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using testing::PacedSession;
using ::testing::Values;
using Json = HaplyService::Json;

OpenedDevice open(const HaplyService& service, const std::string& id = "") {
  DeviceRequest request;
  request.name = id + "@" + std::to_string(service.port());
  request.spec.damping = service.mass.damping;
  request.spec.mass = service.mass.mass;
  return open_haply(request);
}
std::string refusal_of(const std::string& name) {
  DeviceRequest request;
  request.name = name;
  try {
    open_haply(request);
  } catch (const std::exception& error) {
    return error.what();
  }
  return "none";
}
std::string refusal(const HaplyService& service, const std::string& id = "") {
  return refusal_of(id + "@" + std::to_string(service.port()));
}
Servo servo_of(const OpenedDevice& opened, std::string_view mode = kUnbounded) {
  SessionParameters parameters = testing::session_of(*opened.device);
  parameters.mode = mode;
  return Servo(opened.device->spec(), parameters, {});
}

/// Runs each test in each dialect of the service's JSON.
struct HaplyDialect : ::testing::TestWithParam<Json> {
  void feel(Device& device, Servo& servo) {
    session.run(device, servo, [&] { return service.force > 0.5; });
  }
  /// Returns the excess [J] of the true motion's energy over the dissipated energy, in four seconds
  /// at a late wall.
  double made(std::string_view mode) {
    const double kTicks = 1e3 * testing::session_seconds(4.0);
    if (!testing::measures())
      session.patience = std::chrono::seconds(10);  // A busy machine is no fault of the service.
    OpenedDevice opened = open(service);
    Servo servo = servo_of(opened, mode);
    session.run(*opened.device, servo, [&] { return service.commands >= kTicks; });
    statistics = servo.statistics();
    opened.device.reset();
    service.stop();
    session.tell("haply", servo, service.mass.largest_force, service.mass.most_made);
    EXPECT_GT(service.mass.largest_force, 0.3);  // The hand must touch the wall.
    EXPECT_EQ(service.misunderstood, 0);
    return service.mass.most_made;
  }

  HaplyService service{GetParam()};
  PacedSession session;
  ServoStatistics statistics;
};
INSTANTIATE_TEST_SUITE_P(In, HaplyDialect, Values(Json::v3_1, Json::v3_5));

TEST_P(HaplyDialect, SaysWhatItIs) {
  service.second = true;
  DeviceRequest request;
  request.name = "@" + std::to_string(service.port());
  const OpenedDevice opened = open_haply(request);
  EXPECT_EQ(opened.device->spec().name, "inverse3");
  EXPECT_EQ(opened.device->spec().actuation.late_ticks, 1);
  EXPECT_GE(opened.device->longest_tick(), std::chrono::microseconds(1250));
  EXPECT_THAT(opened.notes, Contains(HasSubstr("damping 0.05 N s/m is an assumption")));
  EXPECT_THAT(opened.notes, Contains(HasSubstr("first of 2 devices")));
  EXPECT_THAT(opened.notes, Contains(HasSubstr("gravity compensation is on")));
  EXPECT_EQ(service.sessions, GetParam() == Json::v3_5 ? 1 : 0);
  EXPECT_EQ(service.misunderstood, 0);
}

TEST_P(HaplyDialect, WhatIsWrongIsSaid) {
  EXPECT_THAT(refusal(service, "FFFF"), AllOf(HasSubstr("no device 'FFFF'"), HasSubstr("Hub")));
  service.calibrated = false;
  EXPECT_THAT(refusal(service), HasSubstr("not calibrated"));
  service.calibrated = true;
  service.permutation = "ZYX";
  EXPECT_THAT(refusal(service), HasSubstr("reset basis and mount"));
  service.permutation = "XYZ";
  service.scale = 2.0;
  EXPECT_THAT(refusal(service), HasSubstr("reset basis and mount"));
  service.scale = 1.0;
  service.damping = 3.0;  // Only the configuration of a session reports this value.
  EXPECT_THAT(refusal(service),
              HasSubstr(GetParam() == Json::v3_5 ? "set its damping to 0" : "none"));
  service.damping = 0.0;
  service.ready = false;
  EXPECT_THAT(refusal(service), HasSubstr("not ready"));
  service.ready = true;
  service.plugged = false;
  EXPECT_THAT(refusal(service), HasSubstr("no Inverse3"));
  service.speaks = false;
  EXPECT_THAT(refusal(service), HasSubstr("is not a WebSocket service"));
}

TEST_P(HaplyDialect, WhatIsOddIsNoted) {
  service.power_supply = false;
  service.in_use = true;
  service.handedness = "left";
  const OpenedDevice opened = open(service);
  EXPECT_THAT(opened.notes, Contains(HasSubstr("power supply is not there")));
  EXPECT_THAT(opened.notes, Contains(HasSubstr("another program uses")));
  EXPECT_THAT(opened.notes, Contains(HasSubstr("left-handed")));
}

TEST_P(HaplyDialect, TheSecondOfTwoIsTheSecond) {
  service.second = true;
  const OpenedDevice opened = open(service, "0B1A");
  ASSERT_TRUE(opened.device->await_tick(monotonic_now() + std::chrono::seconds(10)));
  EXPECT_TRUE(opened.device->read({}).ok);
  EXPECT_GT(service.for_second, 0);
  EXPECT_EQ(service.for_second, service.commands);
}

TEST_P(HaplyDialect, AxesAndForcesAreOurs) {
  service.mass.position = {0.01, 0.02, 0.03};
  service.mass.stiffness = service.mass.hand_damping = service.mass.friction = 0.0;
  const OpenedDevice opened = open(service);
  Device& device = *opened.device;
  const auto tick = [&] {
    ASSERT_TRUE(device.await_tick(monotonic_now() + std::chrono::seconds(10)));
  };
  tick();
  EXPECT_NEAR((device.read({}).pose.position - Vec3(0.01, 0.02, 0.03)).norm(), 0.0, 2e-5);
  EXPECT_FALSE(device.read({}).deadman);
  EXPECT_FALSE(device.read({}).clutch);
  service.button = service.second_button = true;
  device.write({.elastic = Vec3(0.2, -0.1, 0.3)});
  tick();
  EXPECT_TRUE(device.read({}).deadman);
  EXPECT_TRUE(device.read({}).clutch);
  // The device holds this force until the next answer.
  EXPECT_EQ(device.write({}).force(), Vec3(0.2, -0.1, 0.3));
  tick();
  EXPECT_FALSE(device.read({}).held);
  service.stop();
  const auto& v = service.mass.velocity;
  const Vec3 moved = Vec3(v[0], v[1], v[2]).normalized();
  EXPECT_NEAR((moved - Vec3(0.2, -0.1, 0.3).normalized()).norm(), 0.0, 1e-6);
}

/// A rotation about the service's y axis, away from the user, is a rotation about our -x axis.
TEST_P(HaplyDialect, TheToolTurnsAsTheGrip) {
  EXPECT_EQ(open(service).device->spec().rotation_sensed, 0);
  service.grip_turns = true;
  service.away_turn = 0.3;
  const OpenedDevice opened = open(service);
  Device& device = *opened.device;
  EXPECT_EQ(device.spec().rotation_sensed, 3);
  EXPECT_THAT(opened.notes, Contains(HasSubstr("turns as the grip")));
  const auto turn = [&] {
    EXPECT_TRUE(device.await_tick(monotonic_now() + std::chrono::seconds(10)));
    const Eigen::AngleAxisd turned(device.read({}).pose.orientation);
    device.write({});
    return Vec3(turned.angle() * turned.axis());
  };
  EXPECT_NEAR((turn() - Vec3(-0.3, 0.0, 0.0)).norm(), 0.0, 1e-5);
  // With a sleeping grip or an invalid orientation, the last orientation must stay.
  service.wrong_length = true;
  service.away_turn = 0.5;
  turn();
  EXPECT_NEAR((turn() - Vec3(-0.3, 0.0, 0.0)).norm(), 0.0, 1e-5);
}

TEST_P(HaplyDialect, MakesNoEnergy) {
  EXPECT_LE(made(kSessionMethod), 1e-12);
  EXPECT_GT(statistics.samples, 3900u);
  EXPECT_EQ(statistics.device.faults, 0u);
}
/// Without a bound the wall must make energy. This shows that the measurement can fail.
TEST_P(HaplyDialect, TheWallAloneWouldMakeEnergy) { EXPECT_GT(made(kUnbounded), 0.005); }

/// The service reduces the force. The account must use the force that the service reports.
TEST_P(HaplyDialect, MakesNoneWhereTheForceIsCut) {
  service.gate = 0.6;
  EXPECT_LE(made(kSessionMethod), 1e-12);
  EXPECT_GT(statistics.device.forces_corrected, 100u);
}

/// Answers arrive in fragments, with pings in between.
TEST_P(HaplyDialect, MakesNoneWhereAnswersComeInPieces) {
  service.fragments = 1000;
  EXPECT_LE(made(kSessionMethod), 1e-12);
  EXPECT_EQ(service.pongs, 1000);
  EXPECT_EQ(statistics.device.faults, 0u);
}

TEST_P(HaplyDialect, ATickDoesNotTouchTheHeap) {
  const OpenedDevice opened = open(service);
  Servo servo = servo_of(opened);
  const auto ticks = [&](int count) {
    for (int n = 0; n < count; ++n)
      if (opened.device->await_tick(monotonic_now() + std::chrono::milliseconds(25)))
        servo.tick(*opened.device, monotonic_now());
  };
  ticks(1);
  service.fragments = 100;
  const std::size_t before = test::allocations();
  ticks(500);
  EXPECT_EQ(test::allocations() - before, 0u);
}

TEST_P(HaplyDialect, ReleaseTakesTheForceOffForGood) {
  const OpenedDevice opened = open(service);
  Servo servo = servo_of(opened);
  feel(*opened.device, servo);
  opened.device->release();
  test::eventually("it is let go", [&] { return service.force == 0.0; });
  const std::uint64_t samples = servo.statistics().samples;
  session.run(*opened.device, servo, [&] { return servo.statistics().samples > samples + 20; });
  EXPECT_EQ(service.force, 0.0);
}

TEST_P(HaplyDialect, AnotherThreadMayLetItGo) {
  const OpenedDevice opened = open(service);
  Servo servo = servo_of(opened);
  feel(*opened.device, servo);
  session.run_released(*opened.device, servo, [&] { return service.force == 0.0; });
}

/// After any fault of an answer the force must end and return later.
struct Fault {
  const char* name;
  std::atomic<int> HaplyService::*count;
};
struct HaplyFault : ::testing::TestWithParam<Fault> {};

TEST_P(HaplyFault, LetsTheForceGoAndIsOver) {
  HaplyService service(Json::v3_5);
  PacedSession session;
  const OpenedDevice opened = open(service);
  Servo servo = servo_of(opened);
  session.run(*opened.device, servo, [&] { return service.force > 0.5; });
  session.suffer(*opened.device, servo, service.edge, service.*GetParam().count);
  EXPECT_EQ(servo.given(), Command{});
  session.run(*opened.device, servo, [&] { return service.edge.ended(); });
  session.expect_let_go("haply", GetParam().name, service.edge);
  session.run(*opened.device, servo, [&] { return service.force > 0.5; });
}
INSTANTIATE_TEST_SUITE_P(Of, HaplyFault,
                         Values(Fault{"ADroppedAnswer", &HaplyService::drops},
                                Fault{"ALateAnswer", &HaplyService::late},
                                Fault{"BrokenJson", &HaplyService::breaks},
                                Fault{"AHugeAnswer", &HaplyService::huge},
                                Fault{"AnAnswerTwice", &HaplyService::repeats},
                                Fault{"NoPosition", &HaplyService::homeless}),
                         [](const auto& fault) { return std::string(fault.param.name); });

struct HaplyLoss : ::testing::Test {
  /// Sets `lost`, a lasting fault, during a force. The force must end.
  template <class Value>
  void expect_let_go(std::atomic<Value>& lost, Value value) {
    const OpenedDevice opened = open(service);
    Servo servo = servo_of(opened);
    session.run(*opened.device, servo, [&] { return service.force > 0.5; });
    const std::uint64_t faults = servo.statistics().device.faults;
    session.strike(service.edge);
    lost = value;
    session.run(*opened.device, servo, [&] { return servo.statistics().device.faults > faults; });
    if (!service.blocks) {
      test::eventually("it is let go", [&] { return service.edge.ended(); });
      session.expect_let_go("haply", "a loss", service.edge);
    }
    session.run(*opened.device, servo,
                [&] { return servo.statistics().device.faults > faults + 3; });
    EXPECT_EQ(servo.given(), Command{});
    EXPECT_EQ(servo.no_force(), ZeroForceReason::device_fault);
    service.blocks = false;
    test::eventually("it is let go", [&] { return service.force == 0.0; });
  }
  HaplyService service{Json::v3_5};
  PacedSession session;
};

TEST_F(HaplyLoss, AServiceThatHangsUpIsAFaultForGood) { expect_let_go(service.hangs_up, true); }
TEST_F(HaplyLoss, AServiceThatHangsNeverHoldsTheServoUp) { expect_let_go(service.blocks, true); }
TEST_F(HaplyLoss, AServiceThatMasksItsFramesIsNoService) { expect_let_go(service.masks, true); }
/// Such a bit means compression, for example, but the client did not request it.
TEST_F(HaplyLoss, AServiceThatSetsReservedBitsIsNoService) {
  expect_let_go(service.odd_bits, 0x40U);
}
TEST_F(HaplyLoss, ADeviceThatLosesItsCalibrationIsAFault) {
  expect_let_go(service.calibrated, false);
}

TEST_F(HaplyLoss, ADeviceThatIsNotReadyAnyMoreIsAFault) { expect_let_go(service.ready, false); }
/// The service continues, but its messages no longer contain the device.
TEST_F(HaplyLoss, ADeviceThatIsPulledOutIsAFault) { expect_let_go(service.plugged, false); }

/// Another program adds a force. The account then has no value for the force on the hand.
TEST_F(HaplyLoss, AForceOfSomebodyElseIsAFault) {
  session.patience = std::chrono::seconds(10);  // This session must have no other fault.
  const OpenedDevice opened = open(service);
  Servo servo = servo_of(opened);
  session.run(*opened.device, servo, [&] { return service.force > 0.5; });
  const std::uint64_t faults = servo.statistics().device.faults;
  session.strike(service.edge);
  service.pushes = 1.0;
  session.run(*opened.device, servo, [&] { return service.edge.ended(); });
  session.expect_let_go("haply", "another's force", service.edge);
  session.run(*opened.device, servo, [&] { return servo.statistics().device.faults > faults + 3; });
  EXPECT_EQ(servo.given(), Command{});
}

TEST(Haply, TheOldestJsonIsRefused) {
  const HaplyService service(Json::v3_0);
  EXPECT_THAT(refusal(service), AllOf(HasSubstr("3.0"), HasSubstr("port 10001"),
                                      HasSubstr("haply-inverse-service 3.1")));
}
TEST(Haply, AnOlderServiceIsRefused) {
  HaplyService service(Json::v3_1);
  service.old_json = true;
  EXPECT_THAT(refusal(service), AllOf(HasSubstr("2.x"), HasSubstr("install")));
}
/// The doctor must query the service and send no command.
TEST(Haply, TheServiceSaysWhatItHas) {
  HaplyService service(Json::v3_5);
  service.second = true;
  EXPECT_THAT(haply_service(service.port()), HasSubstr("first device 049D of 2"));
  service.calibrated = false;
  EXPECT_THAT(haply_service(service.port()), HasSubstr("not calibrated"));
  service.plugged = service.second = false;
  EXPECT_THAT(haply_service(service.port()), HasSubstr("no device"));
  service.speaks = false;
  EXPECT_THROW(haply_service(service.port()), std::runtime_error);
  EXPECT_EQ(service.commands, 0);
}
TEST(Haply, NamesAreChecked) {
  for (const char* name : {"04 9D", "049D@", "@0", "@65536", "@1x", "a\"b"})
    EXPECT_THAT(refusal_of(name), HasSubstr("write haply, haply:ID")) << name;
  std::uint16_t port = 0;
  {
    const HaplyService gone(Json::v3_5);
    port = gone.port();
  }
  EXPECT_THAT(refusal_of("@" + std::to_string(port)),
              AllOf(HasSubstr("no service listens"), HasSubstr("haply-inverse-service")));
}

TEST(HaplyMessages, TellOneDeviceFromAnother) {
  const std::string_view text =
      R"({"inverse3": [{"state": {"cursor_position": {"x": 1, "y": 2, "z": 3}}, "device_id": "A"},
          {"device_id": "B", "state": {"cursor_position": {"x": -1e-1, "y": 0, "z": 0.5}}}]})";
  EXPECT_EQ(haply::read_message(text, "B")->told.position, Vec3(-0.1, 0.0, 0.5));
  EXPECT_EQ(haply::read_message(text, "")->told.id, "A");
  EXPECT_EQ(haply::read_message(text, "")->devices, 2u);
  EXPECT_FALSE(haply::read_message(text, "C"));
  for (const char* broken :
       {"", "{", "[]", R"({"inverse3": [{"device_id": "A"}]} x)",
        R"({"inverse3": [{"device_id": "A"},]})",
        R"({"inverse3": [{"device_id": "A" "state": 1}]})",
        R"({"inverse3": [{"device_id": "A", "state": {"cursor_position": {"x": 1e999}}}]})"})
    EXPECT_FALSE(haply::read_message(broken, "")) << broken;
  EXPECT_FALSE(haply::read_message(std::string(1000, '['), ""));
  // A position with a missing coordinate is no position.
  const auto part = haply::read_message(
      R"({"inverse3": [{"device_id": "A", "state": {"cursor_position": {"x": 1, "y": 2}}}]})", "");
  ASSERT_TRUE(part);
  EXPECT_FALSE(part->told.position);
}

}  // namespace
}  // namespace feltwire::haply_test
