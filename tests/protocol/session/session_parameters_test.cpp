#include "protocol/session/session_parameters.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>

namespace feltwire::session_parameters_test {
namespace {

using ::testing::HasSubstr;

struct Wrong {
  const char* field;
  std::function<void(SessionParameters&)> spoil;
};

TEST(SessionParameters, DefaultsAndLimitsAreGood) {
  EXPECT_NO_THROW(validate(SessionParameters{}));
  EXPECT_EQ(SessionParameters{}.side, BoundingSide::client);
  SessionParameters p;
  p.servo_period = 1e-5;
  p.redundancy = 8;
  p.operator_damping = 100;
  p.hold_time = 1e-5;
  p.c1 = 500;
  p.c2 = 500;
  EXPECT_NO_THROW(validate(p));
  p.servo_period = 0.1;
  p.hold_time = 1.0;
  p.redundancy = 0;
  EXPECT_NO_THROW(validate(p));
}

TEST(SessionParameters, TrafficAtItsLimitsIsGood) {
  SessionParameters p;
  p.packet_interval = 100;
  p.batch = 6;
  EXPECT_NO_THROW(validate(p));
  p.packet_interval = 50;
  p.position_deadband = 0.5;
  p.keep_alive = 0.05;
  EXPECT_NO_THROW(validate(p));
  p.hold_time = 0.2;
  p.force_deadband = 0.5;
  EXPECT_NO_THROW(validate(p));
  p.predictor = Predictor::linear;
  p.local_model = true;
  EXPECT_NO_THROW(validate(p));
}

TEST(SessionParameters, EachFaultNamesItsField) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  const std::vector<Wrong> wrongs = {
      {"servo_period", [](auto& p) { p.servo_period = 0.9e-5; }},
      {"servo_period", [](auto& p) { p.servo_period = 0.11; }},
      {"servo_period", [=](auto& p) { p.servo_period = nan; }},
      {"redundancy", [](auto& p) { p.redundancy = -1; }},
      {"redundancy", [](auto& p) { p.redundancy = 9; }},
      {"operator_damping", [](auto& p) { p.operator_damping = -1e-9; }},
      {"operator_damping", [](auto& p) { p.operator_damping = 101; }},
      {"velocity_cutoff", [=](auto& p) { p.velocity_cutoff = inf; }},
      {"velocity_cutoff", [](auto& p) { p.velocity_cutoff = -1; }},
      {"hold_time", [](auto& p) { p.hold_time = 0.9e-3; }},
      {"hold_time", [](auto& p) { p.hold_time = 1.1; }},
      {"c1", [=](auto& p) { p.c1 = inf; }},
      {"c2", [](auto& p) { p.c2 = -1; }},
      {"c2", [](auto& p) { p.c1 = 1, p.c2 = 2; }},
      {"unknown bounding mode 'no_such_method'; choose one of: none ",
       [](auto& p) { p.mode = "no_such_method"; }},
      {"side", [](auto& p) { p.side = static_cast<BoundingSide>(3); }},
      {"reference", [](auto& p) { p.reference = static_cast<PassivityReference>(2); }},
      {"coupling_stiffness", [=](auto& p) { p.coupling_stiffness = inf; }},
      {"coupling_damping", [](auto& p) { p.coupling_damping = -1; }},
      {"tool_mass", [](auto& p) { p.tool_mass = 0; }},
      {"packet_interval", [](auto& p) { p.packet_interval = 0; }},
      {"packet_interval", [](auto& p) { p.packet_interval = 1001; }},
      {"packet_interval", [](auto& p) { p.packet_interval = 101; }},  // longer than the hold time
      {"batch", [](auto& p) { p.batch = 0; }},
      {"batch", [](auto& p) { p.batch = 2; }},  // The interval has only one sample.
      // too many together with 3 repeated samples
      {"batch", [](auto& p) { p.packet_interval = 10, p.batch = 7; }},
      {"position_deadband", [](auto& p) { p.position_deadband = -0.1; }},
      {"position_deadband", [](auto& p) { p.position_deadband = 0.6; }},
      {"force_deadband", [=](auto& p) { p.force_deadband = nan; }},
      {"keep_alive", [](auto& p) { p.keep_alive = 1.1; }},
      {"keep_alive", [](auto& p) { p.keep_alive = -1e-9; }},
      {"keep_alive", [=](auto& p) { p.keep_alive = nan; }},
      {"keep_alive", [](auto& p) { p.force_deadband = 0.1, p.keep_alive = 0.051; }},
      {"keep_alive", [](auto& p) { p.position_deadband = 0.1, p.packet_interval = 30; }},
      {"keep_alive",
       [](auto& p) { p.position_deadband = p.force_deadband = 0.1, p.keep_alive = 0.026; }},
      {"predictor", [](auto& p) { p.predictor = static_cast<Predictor>(2); }},
      {"predictor linear",
       [](auto& p) { p.position_deadband = 0.1, p.predictor = Predictor::linear; }},
      {"local_model", [](auto& p) { p.local_model = true, p.side = BoundingSide::server; }},
      {"the mode shaped", [](auto& p) { p.mode = "shaped", p.side = BoundingSide::server; }},
      {"the mode credited", [](auto& p) { p.mode = "credited", p.side = BoundingSide::both; }},
      {"the mode virtual_coupling", [](auto& p) { p.mode = "virtual_coupling"; }},
      {"the mode passivity_control_parallel",
       [](auto& p) { p.mode = "passivity_control_parallel"; }},
  };
  for (const Wrong& wrong : wrongs) {
    SessionParameters p;
    wrong.spoil(p);
    try {
      validate(p);
      ADD_FAILURE() << wrong.field << " was let through";
    } catch (const std::invalid_argument& error) {
      EXPECT_THAT(error.what(), ::testing::StartsWith(wrong.field));
    }
  }
}

TEST(SessionParameters, NumbersInAFaultAreShort) {
  const auto fault = [](const std::function<void(SessionParameters&)>& spoil) -> std::string {
    SessionParameters p;
    spoil(p);
    try {
      validate(p);
      return {};
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
  };
  EXPECT_THAT(fault([](SessionParameters& p) { p.servo_period = 5e-6; }),
              HasSubstr("servo_period = 5e-06 is not within 1e-05 to 0.1 s; "));
  EXPECT_THAT(fault([](SessionParameters& p) { p.redundancy = -1; }),
              HasSubstr("redundancy = -1 is not within 0 to 8 samples; "));
  EXPECT_THAT(fault([](SessionParameters& p) { p.force_deadband = 0.51; }),
              HasSubstr("force_deadband = 0.51 is not within 0 to 0.5; "));
}

TEST(SessionParameters, BoundCreditsTheOperator) {
  DeviceSpec device;
  device.damping = 0.5;
  device.rotational_damping = 0.01;
  device.max_force = 12;
  device.max_torque = 0.3;
  device.rotation_actuated = 3;
  SessionParameters p;
  p.mode = "per_axis";
  p.servo_period = 2e-3;
  p.operator_damping = 1.5;
  p.c1 = 700;
  const BoundingConfig bound = bounding_config(p, device);
  EXPECT_EQ(bound.mode, "per_axis");
  EXPECT_EQ(bound.period, 2e-3);
  EXPECT_EQ(bound.damping, 2.0);
  EXPECT_EQ(bound.rotational_damping, 0.01);
  EXPECT_EQ(bound.c1, 700);
  EXPECT_FALSE(bound.c2);
  EXPECT_EQ(bound.max_force, 12);
  EXPECT_EQ(bound.max_torque, 0.3);
  EXPECT_TRUE(bound.rotation);
}

TEST(SessionParameters, PredictorsHaveNames) {
  for (const auto p : {Predictor::level, Predictor::linear}) EXPECT_EQ(predictor(name(p)), p);
  EXPECT_THROW(predictor("cubic"), std::invalid_argument);
}

TEST(SessionParameters, SidesHaveNames) {
  for (const auto side : {BoundingSide::server, BoundingSide::client, BoundingSide::both})
    EXPECT_EQ(bounding_side(name(side)), side);
  EXPECT_THROW(bounding_side("neither"), std::invalid_argument);
}

}  // namespace
}  // namespace feltwire::session_parameters_test
