#include "core/device/device_spec.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <set>

namespace feltwire::device_spec_test {
namespace {

TEST(DeviceSpec, BuiltInDevicesAreValidAndFoundByName) {
  std::set<std::string> names;
  for (const DeviceSpec& device : builtin_devices()) {
    EXPECT_NO_THROW(validate(device)) << device.name;
    EXPECT_EQ(&builtin_device(device.name), &device);
    EXPECT_GT(device.damping.least(), 0.0)
        << device.name << " could render nothing under the bound";
    EXPECT_TRUE(names.insert(device.name).second);
  }
  EXPECT_THAT(names,
              ::testing::UnorderedElementsAre(
                  "simulated", "impulse_engine_2000", "phantom_premium_1.5", "touch", "omega.7",
                  "sigma.7", "virtuose_6d", "phantom_premium_1.5_6dof", "simulated_6dof", "delta.3",
                  "lambda.7", "falcon", "inverse3", "hapi_2dof"));
}

TEST(DeviceSpec, DegreesOfFreedom) {
  EXPECT_EQ(builtin_device("impulse_engine_2000").translation_dof, 2);
  EXPECT_EQ(builtin_device("phantom_premium_1.5").translation_dof, 3);
  EXPECT_EQ(builtin_device("touch").rotation_sensed, 3);
  EXPECT_EQ(builtin_device("touch").rotation_actuated, 0);
  EXPECT_EQ(builtin_device("omega.7").rotation_sensed, 3);
}

TEST(DeviceSpec, WhatActuatesTorqueCanRenderItUnderEveryBoundAndBehindTheAccount) {
  for (const char* name :
       {"sigma.7", "virtuose_6d", "phantom_premium_1.5_6dof", "simulated_6dof"}) {
    const DeviceSpec& d = builtin_device(name);
    EXPECT_EQ(d.rotation_actuated, 3) << name;
    EXPECT_GT(d.rotational_damping.least(), 0.0) << name;
    EXPECT_GT(d.rotation.least_inertia, 0.0) << name;
    EXPECT_GT(d.rotation.inertia, 0.0) << name << " could not be simulated unheld";
    EXPECT_GT(d.rotation.hand_torque, d.max_torque)
        << name << ": a hand can hold the motors' torque";
    EXPECT_GT(d.rotation.resolution, 0.0) << name;
  }
}

TEST(DeviceSpec, TheSimulatedDeviceIsTheOneOfTheMeasurements) {
  const DeviceSpec& d = builtin_device("simulated");
  EXPECT_EQ(d.damping, 0.5);
  EXPECT_EQ(d.apparent_mass, 0.05);
  EXPECT_EQ(d.coulomb_friction, 0.1);
  EXPECT_EQ(d.position_resolution, 23e-6);
}

TEST(DeviceSpec, UnknownDeviceListsThoseThereAre) {
  try {
    builtin_device("novint");
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(),
                 "unknown device 'novint'; choose one of: simulated impulse_engine_2000 "
                 "phantom_premium_1.5 touch omega.7 sigma.7 virtuose_6d phantom_premium_1.5_6dof "
                 "simulated_6dof delta.3 lambda.7 falcon inverse3 hapi_2dof");
  }
}

TEST(DeviceSpec, EveryBrokenFieldIsNamed) {
  const double nan = std::nan(""), infinity = std::numeric_limits<double>::infinity();
  using Break = std::function<void(DeviceSpec&)>;
  const std::vector<std::pair<std::string, Break>> broken = {
      {"name", [](DeviceSpec& d) { d.name.clear(); }},
      {"name", [](DeviceSpec& d) { d.name.assign(101, 'x'); }},
      {"translation_dof", [](DeviceSpec& d) { d.translation_dof = 1; }},
      {"translation_dof", [](DeviceSpec& d) { d.translation_dof = 4; }},
      {"rotation_sensed", [](DeviceSpec& d) { d.rotation_sensed = 2; }},
      {"rotation_actuated", [](DeviceSpec& d) { d.rotation_actuated = -3; }},
      // The rotation is not sensed.
      {"rotation_actuated", [](DeviceSpec& d) { d.rotation_actuated = 3; }},
      {"damping", [&](DeviceSpec& d) { d.damping = nan; }},
      {"damping", [](DeviceSpec& d) { d.damping = -0.1; }},
      {"damping", [](DeviceSpec& d) { d.damping = 1e300; }},
      {"rotational_damping", [&](DeviceSpec& d) { d.rotational_damping = infinity; }},
      {"apparent_mass", [](DeviceSpec& d) { d.apparent_mass = -1; }},
      {"coulomb_friction", [&](DeviceSpec& d) { d.coulomb_friction = nan; }},
      // The value is in um instead of m.
      {"position_resolution", [](DeviceSpec& d) { d.position_resolution = 23; }},
      {"max_force", [](DeviceSpec& d) { d.max_force = d.continuous_force = 0; }},
      {"max_force", [&](DeviceSpec& d) { d.max_force = infinity; }},
      {"continuous_force", [](DeviceSpec& d) { d.continuous_force = 2 * d.max_force; }},
      {"max_torque", [](DeviceSpec& d) { d.max_torque = 1; }},  // The torque is not actuated.
      {"max_torque", [](DeviceSpec& d) { d.rotation_sensed = d.rotation_actuated = 3; }},
      {"least_mass", [](DeviceSpec& d) { d.least_mass = 2 * d.apparent_mass; }},
      {"least_mass", [](DeviceSpec& d) { d.least_mass = -0.1; }},
      {"least_friction", [](DeviceSpec& d) { d.least_friction = 2 * d.coulomb_friction; }},
      {"least_friction", [&](DeviceSpec& d) { d.least_friction = nan; }},
      {"hand_force", [](DeviceSpec& d) { d.hand_force = 0; }},
      {"hand_force", [&](DeviceSpec& d) { d.hand_force = infinity; }},
      {"hand_speed", [](DeviceSpec& d) { d.hand_speed = -1; }},
      {"late_ticks", [](DeviceSpec& d) { d.actuation.late_ticks = 5; }},
      {"late_ticks", [](DeviceSpec& d) { d.actuation.late_ticks = -1; }},
      {"rotational_resolution", [](DeviceSpec& d) { d.rotation.resolution = 1; }},
      {"hand_torque", [](DeviceSpec& d) { d.rotation.least_inertia = 1e-5; }},
      {"least_inertia", [](DeviceSpec& d) { d.rotation.hand_torque = 1; }},
      {"apparent_inertia", [&](DeviceSpec& d) { d.rotation.inertia = nan; }},
      {"rotational_friction", [](DeviceSpec& d) { d.rotation.friction = -1; }},
      {"least_inertia",
       [](DeviceSpec& d) {
         d.rotation.least_inertia = 2e-5;
         d.rotation.hand_torque = 0.1;
         d.rotation.inertia = 1e-5;
       }},
      {"workspace.y", [&](DeviceSpec& d) { d.workspace.y() = nan; }},
  };
  for (const auto& [field, make] : broken) {
    DeviceSpec spec = builtin_device("simulated");
    make(spec);
    try {
      validate(spec);
      ADD_FAILURE() << field << " was let through";
    } catch (const std::invalid_argument& error) {
      EXPECT_THAT(error.what(), ::testing::HasSubstr("': " + field + ": "));
    }
  }
}

TEST(DeviceSpec, OnlyWhatIsActuatedIsCommanded) {
  const Command command{Vec3(1, 2, 3), Vec3(4, 5, 6), Vec3(7, 8, 9)};
  const Command flat = actuated(builtin_device("impulse_engine_2000"), command);
  EXPECT_EQ(flat.elastic, Vec3(1, 2, 0));
  EXPECT_EQ(flat.frictional, Vec3(4, 5, 0));
  EXPECT_EQ(flat.torque, Vec3::Zero());
  const Command touch = actuated(builtin_device("touch"), command);
  EXPECT_EQ(touch.force(), command.force());
  EXPECT_EQ(touch.torque, Vec3::Zero());
  DeviceSpec six = builtin_device("touch");
  six.rotation_actuated = 3;
  six.max_torque = 0.2;
  EXPECT_NO_THROW(validate(six));
  EXPECT_EQ(actuated(six, command).torque, command.torque);
}

}  // namespace
}  // namespace feltwire::device_spec_test
