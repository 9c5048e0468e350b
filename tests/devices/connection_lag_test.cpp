// Tests the assumed lag of a device without a specified lag.

#include "client/device/connection_lag.hpp"

#include <gmock/gmock.h>

#include <fstream>

#include "client/device/assumed_transmission.hpp"
#include "client/drivers/drivers.hpp"
#include "core/bounding/device_account.hpp"
#include "core/device/spec_text.hpp"
#include "tests/support/temporary_folder.hpp"

namespace feltwire::connection_test {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

/// Returns the specification from a device file with these fields and the required fields.
SourcedSpec file_with(const std::string& fields) {
  const test::TemporaryFolder folder;
  std::ofstream(folder / "mine.json")
      << R"({"name": "mine", "damping": [1], "max_force": 3, "workspace": [1, 1, 1])" << fields
      << "}";
  return load_sourced_spec(folder / "mine.json");
}

TEST(AssumedLag, IsThatOfTheConnectionAndSaysSo) {
  for (const Connection& connection :
       {kMappedConnection, kUsbConnection, kFullSpeedUsbConnection, kUnknownConnection}) {
    SourcedSpec described = file_with("");
    assume_lag(described, connection);
    EXPECT_EQ(described.spec.actuation.lag, connection.lag);
    EXPECT_EQ(described.spec.actuation.kind, LagKind::delay);
    EXPECT_THAT(described.sources.at("actuation_lag"), ::testing::StartsWith("assumption"));
    EXPECT_THAT(assumptions(described),
                Contains(AllOf(HasSubstr("actuation_lag 0.00"),
                               HasSubstr("is an assumption for " + std::string(connection.name)),
                               HasSubstr("give yours as actuation_lag in a device file"))));
    EXPECT_NO_THROW(validate(described.spec));
    EXPECT_NO_THROW(PortAccount(account_config(described.spec, 1e-3)));
  }
  // A bus can only add to the amplifier's lag.
  EXPECT_LT(kMappedConnection.lag, kUsbConnection.lag);
  EXPECT_LT(kUsbConnection.lag, kFullSpeedUsbConnection.lag);
  EXPECT_GE(kUnknownConnection.lag, kUsbConnection.lag);
}

TEST(AssumedLag, ASpecificationThatTellsItStaysAsItIs) {
  const auto assumed = [](const std::string& fields) {
    SourcedSpec described = file_with(fields);
    assume_lag(described, kUsbConnection);
    EXPECT_EQ(described.sources.count("actuation_lag"), 0u) << fields;
    return described.spec;
  };
  EXPECT_EQ(assumed(R"(, "actuation_lag": 0)").actuation.lag, 0.0);
  const DeviceSpec told = assumed(R"(, "actuation_lag": 2e-4, "actuation_kind": "filter")");
  EXPECT_EQ(told.actuation.lag, 2e-4);
  EXPECT_EQ(told.actuation.kind, LagKind::filter);
  const DeviceSpec late = assumed(R"(, "late_ticks": 1)");
  EXPECT_EQ(late.actuation.lag, 0.0);
  EXPECT_EQ(late.actuation.late_ticks, 1);
}

/// identify writes late_ticks 0, but a force may still be late within its tick.
TEST(AssumedLag, NoLateTicksSayNothingOfIt) {
  SourcedSpec described = file_with(R"(, "late_ticks": 0)");
  assume_lag(described, kUsbConnection);
  EXPECT_EQ(described.spec.actuation.lag, kUsbConnection.lag);
}

/// A simulated device has exactly its specification, and a gamepad has no motor.
TEST(AssumedLag, NothingIsAssumedOfASimulatedDevice) {
  for (const char* spec : {"simulated", "omega.7", "phantom_premium_1.5"}) {
    DeviceRequest request;
    request.spec.name_or_file = spec;
    const OpenedDevice opened = chosen_driver("simulated").driver->open(request);
    EXPECT_EQ(opened.device->spec().actuation.lag, 0.0) << spec;
    EXPECT_THAT(opened.notes, Not(Contains(HasSubstr("actuation_lag")))) << spec;
    EXPECT_EQ(opened.device->spec().transmission.stiffness, 0.0) << spec;
  }
}

/// Few makers tell the transmission of a device either.
TEST(AssumedTransmission, IsThatOfTheDriveAndSaysSo) {
  for (const Drive& drive : {kCableDrive, kSmallCableDrive, kUnknownDrive}) {
    SourcedSpec described = file_with("");
    assume_transmission(described, drive);
    EXPECT_EQ(described.spec.transmission.stiffness, drive.stiffness);
    EXPECT_EQ(described.spec.transmission.encoder_side, EncoderSide::motor);
    EXPECT_THAT(
        assumptions(described),
        Contains(AllOf(HasSubstr("transmission_stiffness"),
                       HasSubstr("is an assumption for " + std::string(drive.name)),
                       HasSubstr("give yours as transmission_stiffness in a device file"))));
    EXPECT_NO_THROW(validate(described.spec));
  }
}

TEST(AssumedTransmission, ASpecificationThatTellsItStaysAsItIs) {
  const auto assumed = [](const std::string& fields) {
    SourcedSpec described = file_with(fields);
    assume_transmission(described, kCableDrive);
    EXPECT_EQ(described.sources.count("transmission_stiffness"), 0u) << fields;
    return described.spec.transmission.stiffness;
  };
  EXPECT_EQ(assumed(R"(, "transmission_stiffness": 9e3)"), 9e3);
  EXPECT_EQ(assumed(R"(, "transmission_stiffness": 0)"), 0.0);
  EXPECT_EQ(assumed(R"(, "encoder_side": "handle")"), 0.0);
}

/// At a rate that is impossible with this lag, the account must name a possible rate.
TEST(AssumedLag, ARateThatItMakesImpossibleIsNamed) {
  SourcedSpec described = file_with(R"(, "least_mass": 0.1)");
  assume_lag(described, kUsbConnection);
  EXPECT_NO_THROW(PortAccount(account_config(described.spec, 1.0 / 12000.0)));
  try {
    PortAccount(account_config(described.spec, 1.0 / 12500.0));
    FAIL() << "the lag was reckoned with";
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("at most 12000 Hz"), HasSubstr("actuation_lag"),
                                    HasSubstr("device file (--spec)")));
  }
}

}  // namespace
}  // namespace feltwire::connection_test
