#include "core/device/device_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "core/base/file_error.hpp"
#include "core/device/spec_text.hpp"

namespace feltwire::device_file_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class DeviceFile : public ::testing::Test {
 protected:
  ~DeviceFile() override { std::filesystem::remove(file_); }

  DeviceSpec load(const std::string& text) {
    std::ofstream(file_) << text;
    return load_sourced_spec(file_).spec;
  }
  std::string error(const std::string& text) {
    try {
      load(text);
    } catch (const FileError& found) {
      return found.what();
    }
    return "none";
  }

  // Other tests run in parallel, so the name contains the process number.
  const std::filesystem::path file_ = std::filesystem::path(::testing::TempDir()) /
                                      ("feltwire_" + std::to_string(::getpid()) + "_device.json");
};

TEST_F(DeviceFile, SaysEverythingThatABuiltInDeviceSays) {
  const DeviceSpec spec = load(R"({
    "name": "mine", "translation_dof": 3, "rotation_sensed": 3, "rotation_actuated": 3,
    "damping": [0.1, 0.2, 0.3], "rotational_damping": [0.002], "apparent_mass": 0.05,
    "coulomb_friction": 0.1, "position_resolution": 2e-5, "max_force": 9, "continuous_force": 2,
    "max_torque": 0.5, "workspace": [0.2, 0.3, 0.4],
    "least_mass": 0.04, "least_friction": 0.06, "hand_force": 15, "hand_speed": 2, "late_ticks": 1,
    "rotational_resolution": 1e-4, "least_inertia": 2e-5, "hand_torque": 0.4})");
  EXPECT_EQ(spec.name, "mine");
  EXPECT_EQ(spec.rotation_actuated, 3);
  EXPECT_EQ(spec.damping, Damping(Vec3(0.1, 0.2, 0.3)));
  EXPECT_EQ(spec.rotational_damping, 0.002);
  EXPECT_EQ(spec.apparent_mass, 0.05);
  EXPECT_EQ(spec.coulomb_friction, 0.1);
  EXPECT_EQ(spec.position_resolution, 2e-5);
  EXPECT_EQ(spec.max_force, 9.0);
  EXPECT_EQ(spec.continuous_force, 2.0);
  EXPECT_EQ(spec.max_torque, 0.5);
  EXPECT_EQ(spec.workspace, Vec3(0.2, 0.3, 0.4));
  EXPECT_EQ(spec.least_mass, 0.04);
  EXPECT_EQ(spec.least_friction, 0.06);
  EXPECT_EQ(spec.hand_force, 15.0);
  EXPECT_EQ(spec.hand_speed, 2.0);
  EXPECT_EQ(spec.actuation.late_ticks, 1);
  EXPECT_EQ(spec.rotation.resolution, 1e-4);
  EXPECT_EQ(spec.rotation.least_inertia, 2e-5);
  EXPECT_EQ(spec.rotation.hand_torque, 0.4);
}

TEST_F(DeviceFile, TellsTheLagOfItsMotorAndItsKind) {
  const auto with = [](const std::string& fields) {
    return R"({"name": "mine", "damping": [1], "max_force": 3, "workspace": [1, 1, 1],)" + fields +
           "}";
  };
  const DeviceSpec filter = load(with(R"("actuation_lag": 3e-4, "actuation_kind": "filter")"));
  EXPECT_EQ(filter.actuation.lag, 3e-4);
  EXPECT_EQ(filter.actuation.kind, LagKind::filter);
  EXPECT_EQ(load(with(R"("actuation_lag": 3e-4)")).actuation.kind, LagKind::delay);
  EXPECT_THAT(error(with(R"("actuation_kind": "fast")")),
              AllOf(HasSubstr("actuation_kind: is 'fast'"), HasSubstr("delay filter")));
  const DeviceSpec late = load(with(R"("actuation_lag": 3e-4, "late_ticks": 1)"));
  EXPECT_EQ(late.actuation.lag, 3e-4);
  EXPECT_EQ(late.actuation.late_ticks, 1);
}

/// The latest of several motors counts, and the softest of several directions.
TEST_F(DeviceFile, TellsLagsOfEachMotorAndAMatrixOfTheTransmission) {
  const auto with = [](const std::string& fields) {
    return R"({"name": "mine", "damping": [1], "max_force": 3, "workspace": [1, 1, 1],)" + fields +
           "}";
  };
  EXPECT_EQ(load(with(R"("actuation_lags": [1e-4, 3e-4, 2e-4])")).actuation.lag, 3e-4);
  EXPECT_EQ(load(with(R"("actuation_lags": [1e-4, 3e-4, 2e-4, 0, 5e-4, 0])")).actuation.lag, 5e-4);
  EXPECT_TRUE(sourced_spec(file_.string()).tells_lag);
  EXPECT_THAT(error(with(R"("actuation_lags": [1e-4])")), HasSubstr("three numbers"));
  EXPECT_THAT(error(with(R"("actuation_lags": [1e-4, 0, -1e-4])")), HasSubstr("zero or more"));
  EXPECT_THAT(error(with(R"("actuation_lag": 1e-4, "actuation_lags": [1e-4, 0, 0])")),
              HasSubstr("give one of the two"));
  const DeviceSpec soft = load(with(R"("transmission_stiffness_matrix": [8e3, 5e3, 9e3])"));
  EXPECT_EQ(soft.transmission.stiffness, 5e3);
  EXPECT_TRUE(sourced_spec(file_.string()).tells_transmission);
  const DeviceSpec turned =
      load(with(R"("transmission_stiffness_matrix": [6e3, 2e3, 0, 2e3, 6e3, 0, 0, 0, 9e3])"));
  EXPECT_NEAR(turned.transmission.stiffness, 4e3, 1e-6);
}

TEST_F(DeviceFile, TellsTheTransmissionAndTheSideOfTheEncoder) {
  const auto with = [](const std::string& fields) {
    return R"({"name": "mine", "damping": [1], "max_force": 3, "workspace": [1, 1, 1])" + fields +
           "}";
  };
  load(with(R"(, "transmission_stiffness": 8e3, "encoder_side": "handle")"));
  const SourcedSpec told = sourced_spec(file_.string());
  EXPECT_TRUE(told.tells_transmission);
  EXPECT_EQ(told.spec.transmission.stiffness, 8e3);
  EXPECT_EQ(told.spec.transmission.encoder_side, EncoderSide::handle);
  EXPECT_THAT(assumptions(told), ::testing::ElementsAre(HasSubstr("encoder is at the handle")));
  EXPECT_THAT(spec_table(told), AllOf(HasSubstr("transmission_stiffness 8000"),
                                      HasSubstr("encoder_side           handle")));
  load(with(R"(, "transmission_stiffness": 0)"));
  EXPECT_TRUE(sourced_spec(file_.string()).tells_transmission);
  load(with(""));
  const SourcedSpec silent = sourced_spec(file_.string());
  EXPECT_FALSE(silent.tells_transmission);
  EXPECT_EQ(silent.spec.transmission.encoder_side, EncoderSide::motor);
  EXPECT_THAT(spec_table(silent), ::testing::Not(HasSubstr("encoder_side")));
  EXPECT_THAT(error(with(R"(, "encoder_side": "gearbox")")),
              AllOf(HasSubstr("encoder_side: is 'gearbox'"), HasSubstr("motor handle")));
  EXPECT_THAT(error(with(R"(, "transmission_stiffness": -1)")),
              HasSubstr("transmission_stiffness: must be from 0"));
}

/// If a number depends on the direction, the account uses the smallest.
TEST_F(DeviceFile, OfAMatrixTheLeastEigenvalueIsTaken) {
  const std::string rest = R"("name": "mine", "max_force": 3, "workspace": [1, 1, 1], )";
  // The eigenvalues of [[0.05, 0.01], [0.01, 0.05]] are 0.04 and 0.06.
  const DeviceSpec spec = load("{" + rest + R"("damping": [0.5, 0.1, 0, 0.1, 0.5, 0, 0, 0, 0.7],
      "least_mass_matrix": [0.05, 0.01, 0, 0.01, 0.05, 0, 0, 0, 0.09],
      "least_inertia_matrix": [3e-5, 2e-5, 4e-5], "hand_torque": 0.4})");
  EXPECT_NEAR(spec.damping.least(), 0.4, 1e-12);
  EXPECT_NEAR(spec.least_mass, 0.04, 1e-12);
  EXPECT_NEAR(spec.rotation.least_inertia, 2e-5, 1e-16);
  const auto with = [&](const std::string& field) {
    return error("{" + rest + "\"damping\": [1],\n" + field + "}");
  };
  EXPECT_THAT(with(R"("least_mass_matrix": [1, 2])"),
              AllOf(HasSubstr(":2: least_mass_matrix: "), HasSubstr("nine")));
  EXPECT_THAT(with(R"("least_mass_matrix": [1, 2, 0, 2, 1, 0, 0, 0, 1])"),
              AllOf(HasSubstr(":2: least_mass_matrix: "), HasSubstr("positive definite")));
  EXPECT_THAT(with(R"("least_mass_matrix": [1, 0.5, 0, 0.2, 1, 0, 0, 0, 1])"),
              HasSubstr("symmetric"));
  EXPECT_THAT(with(R"("least_mass": 1, "least_mass_matrix": [1, 1, 1])"),
              HasSubstr("give one of the two"));
  EXPECT_THAT(with(R"("least_inertia": 1e-5)"),
              AllOf(HasSubstr("hand_torque: "), HasSubstr("together")));
}

TEST_F(DeviceFile, WhatIsNotGiven) {
  const DeviceSpec spec =
      load(R"({"name": "mine", "damping": [1], "max_force": 3, "workspace": [1, 1, 1]})");
  EXPECT_EQ(spec.damping, 1.0);
  EXPECT_EQ(spec.continuous_force, 3.0);
  EXPECT_EQ(spec.translation_dof, 3);
  EXPECT_EQ(spec.rotation_sensed, 0);
  EXPECT_EQ(spec.max_torque, 0.0);
  EXPECT_EQ(spec.least_mass, 0.0);  // unknown
  EXPECT_EQ(spec.least_friction, 0.0);
  EXPECT_EQ(spec.hand_force, 10.0);
  EXPECT_EQ(spec.hand_speed, 0.0);
  EXPECT_EQ(spec.actuation.late_ticks, 0);
  EXPECT_EQ(spec.rotation.least_inertia, 0.0);
}

TEST_F(DeviceFile, ErrorsNameTheLineTheFieldAndTheRemedy) {
  const auto with = [](const std::string& field) {
    return "{\"name\": \"mine\",\n\"max_force\": 3, \"workspace\": [1, 1, 1],\n" + field + "}";
  };
  const std::string at = file_.filename().string() + ":";
  EXPECT_THAT(error(with("\"damping\": [-1]")),
              AllOf(HasSubstr(at + "3: damping: "), HasSubstr("sign")));
  EXPECT_THAT(error(with("\"damping\": [1, 2]")),
              AllOf(HasSubstr(at + "3: damping: "), HasSubstr("three")));
  EXPECT_THAT(error(with("\"damping\": [5000]")),
              AllOf(HasSubstr(at + "3: damping: "), HasSubstr("check the unit")));
  EXPECT_THAT(error(with("\"damping\": [1], \"continuous_force\": 4")),
              AllOf(HasSubstr(at + "3: continuous_force: "), HasSubstr("lower it")));
  EXPECT_THAT(error(with("\"damping\": [1], \"translation_dof\": 1")),
              HasSubstr(at + "3: translation_dof: "));
  EXPECT_THAT(error(with("\"damping\": [1], \"colour\": 1")), HasSubstr(at + "3: "));
  EXPECT_THAT(
      error("{\"name\": \"mine\", \"damping\": [1], \"max_force\": 3,\n\"workspace\": [1]}"),
      HasSubstr(at + "2: workspace: "));
  EXPECT_THAT(error("{\"name\": \"mine\", \"damping\": [1], \"workspace\": [1, 1, 1]}"),
              HasSubstr("max_force: must be above zero"));
  EXPECT_THAT(error("{\"name\": \"mine\"}"), HasSubstr(at));
}

TEST_F(DeviceFile, ACommandLineNamesADeviceOrAFile) {
  EXPECT_EQ(device_spec("touch").name, "touch");
  EXPECT_THROW(device_spec("tuch"), std::invalid_argument);
  EXPECT_THROW(device_spec("not_there.json"), FileError);
  load(R"({"name": "mine", "damping": [1], "max_force": 3, "workspace": [1, 1, 1]})");
  EXPECT_EQ(device_spec(file_.string()).name, "mine");
}

/// Every number of the built-in devices must have a source. Assumed numbers must be marked.
TEST_F(DeviceFile, BuiltInNumbersHaveSources) {
  ASSERT_EQ(sourced_builtin_devices().size(), builtin_devices().size());
  for (const SourcedSpec& described : sourced_builtin_devices()) {
    EXPECT_THAT(spec_table(described), ::testing::Not(HasSubstr("no source told")));
    EXPECT_EQ(described.sources.count("damping"), 1u) << described.spec.name;
  }
  EXPECT_THAT(assumptions(sourced_spec("simulated")), ::testing::IsEmpty());
  EXPECT_THAT(
      assumptions(sourced_spec("touch")),
      ::testing::Contains(
          "damping 0.05 N s/m is an assumption; measure yours with feltwire-client identify"));
}

TEST_F(DeviceFile, AFileSaysItsSources) {
  load(R"({"name": "mine", "damping": [0.2, 0.3, 0.4], "max_force": 3, "workspace": [1, 1, 1],
           "least_mass": 0.01, "sources": {"damping": "identify, 2026-11-23",
                                           "least_mass": "assumption: the maker is silent"}})");
  const SourcedSpec described = sourced_spec(file_.string());
  EXPECT_EQ(described.sources.at("damping"), "identify, 2026-11-23");
  EXPECT_THAT(assumptions(described), ::testing::ElementsAre(HasSubstr("least_mass 0.01 kg")));
  const std::string table = spec_table(described);
  EXPECT_THAT(table, HasSubstr("0.2, 0.3, 0.4"));
  EXPECT_THAT(table, HasSubstr("N s/m     identify, 2026-11-23"));
  EXPECT_THAT(table, HasSubstr("no source told"));  // the source of the largest force
  EXPECT_THAT(error(R"({"name": "mine", "damping": [1], "max_force": 3, "workspace": [1, 1, 1],
"sources": {"colour": "the maker"}})"),
              HasSubstr(":2: "));
}

TEST_F(DeviceFile, ACommandLineOverrulesNumbers) {
  const SourcedSpec usual = requested_spec({}, "touch");
  EXPECT_EQ(usual.spec.name, "touch");
  EXPECT_EQ(usual.spec.damping, 0.05);
  const SourcedSpec told =
      requested_spec({.name_or_file = "omega.7", .damping = 0.4, .mass = 0.2}, "touch");
  EXPECT_EQ(told.spec.name, "omega.7");
  EXPECT_EQ(told.spec.damping, 0.4);
  EXPECT_EQ(told.spec.least_mass, 0.2);
  EXPECT_EQ(told.spec.apparent_mass, 0.2);
  EXPECT_EQ(told.sources.at("least_mass"), "mass of --device");
  // The list must contain only the remaining assumptions.
  EXPECT_THAT(assumptions(told), ::testing::ElementsAre(HasSubstr("least_friction")));
  EXPECT_THROW(requested_spec({.name_or_file = {}, .damping = -1.0, .mass = {}}, "touch"),
               DeviceSpecError);
}

}  // namespace
}  // namespace feltwire::device_file_test
