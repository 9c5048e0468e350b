// Tests the packets and the geometry of a Falcon.

#include "client/drivers/novint/falcon_board.hpp"

#include <gtest/gtest.h>

#include <numbers>
#include <random>
#include <string>

namespace feltwire::falcon_board_test {
namespace {

using namespace falcon;

constexpr double kDegree = std::numbers::pi / 180.0;

Packet packet(const std::string& text) {
  Packet bytes{};
  std::copy_n(text.begin(), bytes.size(), bytes.begin());
  return bytes;
}

Vec3 any_place(std::mt19937& random) {
  std::uniform_real_distribution<double> aside(-0.035, 0.035), ahead(0.085, 0.155);
  return {aside(random), aside(random), ahead(random)};
}

/// Numbers are nibbles in little-endian order. Each is a letter from 'A'.
TEST(FalconBoard, RequestsAreAsPublished) {
  EXPECT_EQ(request({}, Light::none, false), packet("<AAAAAAAAAAAAAA>"));
  EXPECT_EQ(request({1, -1, 0x1234}, Light::green, true), packet("<BAAAPPPPEDCBFA>"));
  EXPECT_EQ(request({-32768, 32767, -2}, Light::red, false), packet("<AAAIPPPHOPPPCA>"));
}

TEST(FalconBoard, AnswersAreReadBack) {
  const auto one = parse_reply(packet("<BAAAPPPPEDCBAA>"));
  ASSERT_TRUE(one);
  EXPECT_EQ(one->encoders, (Counts{1, -1, 0x1234}));
  Packet homed = packet("<AAAAAAAAAAAAAA>");
  homed[13] = 'A' + 0x5A;
  ASSERT_TRUE(parse_reply(homed));
  EXPECT_EQ(parse_reply(homed)->buttons, 0xAu);
  EXPECT_EQ(parse_reply(homed)->homed, (std::array{true, false, true}));
  std::mt19937 random(1);
  for (int n = 0; n < 1000; ++n) {
    Counts counts{};
    for (int& one_of : counts) one_of = static_cast<std::int16_t>(random());
    EXPECT_EQ(parse_reply(request(counts, Light::none, false))->encoders, counts);
  }
}

/// A wrong digit or frame byte at any position must make the answer invalid.
TEST(FalconBoard, WhatIsNoAnswerIsNone) {
  const Packet good = packet("<ABCDABCDABCDAA>");
  ASSERT_TRUE(parse_reply(good));
  for (const std::size_t at : {0u, 1u, 5u, 12u, 15u})
    for (const int byte : {0, int{'@'}, int{'Q'}, 255}) {
      Packet bad = good;
      bad[at] = static_cast<std::uint8_t>(byte);
      EXPECT_FALSE(parse_reply(bad)) << at << " " << byte;
    }
  Packet bad = good;
  bad[13] = 'A' + 0x80;
  EXPECT_FALSE(parse_reply(bad));
}

TEST(FalconBoard, AnAnswerMayComeInPiecesButNotWithMore) {
  const Packet good = packet("<ABCDABCDABCDAA>");
  Answer answer;
  answer.add(std::span(good).first(5));
  EXPECT_FALSE(answer.whole() || answer.garbled());
  answer.add(std::span(good).subspan(5));
  EXPECT_TRUE(answer.whole());
  EXPECT_EQ(answer.packet(), good);
  answer.add(std::span(good).first(1));
  EXPECT_TRUE(answer.garbled());
  answer.clear();
  answer.add(std::span(good).subspan(1));
  EXPECT_TRUE(answer.garbled());
}

/// On the axis the three legs are equal. The wrist is at (u, z) with u = -r + c, and the law of
/// cosines gives the length of the shin.
TEST(FalconBoard, OnItsAxisTheAngleIsThatOfATriangle) {
  for (const double z : {0.09, 0.10, 0.12, 0.15}) {
    const auto angles = arm_angles({0, 0, z});
    ASSERT_TRUE(angles);
    const double u = -0.0400 + 0.01443, v = 0.02309 - 0.025, arm = 0.060;
    const double shin = 2.0 * 0.01125 + std::sqrt(0.1025 * 0.1025 - v * v);
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR((*angles)[i], (*angles)[0], 1e-12);
      EXPECT_NEAR(std::hypot(u - arm * std::cos((*angles)[i]), z - arm * std::sin((*angles)[i])),
                  shin, 1e-12);
    }
    // Three equal angles move the tool along its axis. The triangle gives the distance.
    const auto tool = tool_point(*angles, {0.001, -0.002, z + 0.01});
    ASSERT_TRUE(tool);
    EXPECT_NEAR((tool->position - Vec3(0, 0, z)).norm(), 0.0, 1e-12);
    const double t = (*angles)[0];
    const double slope = arm * (z * std::cos(t) - u * std::sin(t)) / (z - arm * std::sin(t));
    EXPECT_NEAR(tool->jacobian.row(2).sum(), slope, 1e-9);
    EXPECT_NEAR(tool->jacobian.topRows<2>().rowwise().sum().norm(), 0.0, 1e-9);
  }
}

/// Forward and inverse kinematics must agree. The iteration starts some distance away.
TEST(FalconBoard, PlacesAreFoundAgain) {
  std::mt19937 random(2);
  for (int n = 0; n < 2000; ++n) {
    const Vec3 place = any_place(random);
    const auto angles = arm_angles(place);
    ASSERT_TRUE(angles);
    for (const Vec3& near : {kMiddle, Vec3(place + Vec3(0.005, -0.005, 0.005))}) {
      const auto tool = tool_point(*angles, near);
      ASSERT_TRUE(tool) << place.transpose();
      EXPECT_NEAR((tool->position - place).norm(), 0.0, 1e-11);
    }
  }
}

TEST(FalconBoard, TheJacobianIsTheSlopeOfThePlaces) {
  constexpr double kSmall = 1e-6;
  std::mt19937 random(3);
  for (int n = 0; n < 200; ++n) {
    const Vec3 place = any_place(random), angles = *arm_angles(place);
    const auto tool = tool_point(angles, place);
    ASSERT_TRUE(tool);
    for (int i = 0; i < 3; ++i) {
      const Vec3 turn = kSmall * Vec3::Unit(i);
      const Vec3 slope = (tool_point(angles + turn, place)->position -
                          tool_point(angles - turn, place)->position) /
                         (2.0 * kSmall);
      EXPECT_NEAR((tool->jacobian.col(i) - slope).norm(), 0.0, 1e-7);
    }
  }
}

/// Motor torque times rotation must equal force times movement for all values.
TEST(FalconBoard, MotorsAndToolHaveTheSamePower) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> part(-5.0, 5.0);
  for (int n = 0; n < 500; ++n) {
    const Vec3 place = any_place(random), angles = *arm_angles(place);
    const auto tool = tool_point(angles, place);
    const Vec3 force(part(random), part(random), part(random));
    const Vec3 turning(part(random), part(random), part(random));
    const Counts motors = motors_of(*tool, force, 1 << 15);
    const Vec3 torque = Vec3(motors[0], motors[1], motors[2]) / -10000.0;
    EXPECT_NEAR(torque.dot(turning), force_of(*tool, motors).dot(tool->jacobian * turning), 1e-9);
    // Rounding to whole counts changes each value by less than one count.
    EXPECT_NEAR((tool->jacobian.transpose() * force - torque).cwiseAbs().maxCoeff(), 0.0, 1e-4);
  }
}

/// Other authors have published these figures for the middle of the workspace.
TEST(FalconBoard, TheFiguresAreThePublishedOnes) {
  const auto tool = tool_point(*arm_angles(kMiddle), kMiddle);
  EXPECT_NEAR(kCount / kDegree, 0.03643, 1e-5);
  EXPECT_NEAR(arm_angle(0) / kDegree, 35.0, 1e-12);
  EXPECT_NEAR(tool->jacobian.row(2).sum() * kCount, 43e-6, 6e-6);
  EXPECT_NEAR(-motors_of(*tool, Vec3::UnitZ())[0], 240, 20);
  for (const double z : {0.09, 0.10, 0.11, 0.13, 0.14, 0.15}) {
    const auto there = tool_point(*arm_angles({0, 0, z}), kMiddle);
    EXPECT_LE(there->jacobian.row(2).sum() * kCount, 49e-6);
    EXPECT_GE(there->jacobian.row(2).sum() * kCount, 28e-6);
  }
}

TEST(FalconBoard, TooMuchForceIsCutInItsDirection) {
  const auto tool = tool_point(*arm_angles(kMiddle), kMiddle);
  const Vec3 force(30.0, -10.0, 40.0);
  const Counts motors = motors_of(*tool, force);
  int largest = 0;
  for (const int motor : motors) largest = std::max(largest, std::abs(motor));
  EXPECT_EQ(largest, kMostMotor);
  const Vec3 real = force_of(*tool, motors);
  EXPECT_LT(real.norm(), force.norm());
  EXPECT_NEAR(real.normalized().dot(force.normalized()), 1.0, 1e-6);
}

/// The equations of the legs have solutions outside of a Falcon. Near a straight leg, a motor count
/// would correspond to newtons, or an encoder count to millimetres.
TEST(FalconBoard, PlacesThatNoFalconHasAreNone) {
  const Vec3 motor(-0.01242, -0.05088, 0.05878), encoder(0.0812, -0.0322, 0.1305);
  const Vec3 far(0.0549, 0.0628, 0.0337);
  for (const Vec3& place : {motor, encoder, far}) {
    const auto angles = arm_angles(place);
    ASSERT_TRUE(angles);
    EXPECT_FALSE(tool_point(*angles, place)) << place.transpose();
  }
}

/// The maker's workspace is a cube of 100 mm, except the corners that no leg reaches.
TEST(FalconBoard, EveryPlaceOfItsCubeIsOne) {
  constexpr int kSteps = 5;
  int places = 0;
  for (int i = -kSteps; i <= kSteps; ++i)
    for (int j = -kSteps; j <= kSteps; ++j)
      for (int k = -kSteps; k <= kSteps; ++k) {
        const Vec3 place = kMiddle + 0.05 / kSteps * Vec3(i, j, k);
        const auto angles = arm_angles(place);
        if (!angles) continue;
        ++places;
        EXPECT_TRUE(tool_point(*angles, place)) << place.transpose();
      }
  EXPECT_GT(places, 1200);
}

TEST(FalconBoard, AForceThatIsNotFiniteIsNotGiven) {
  const auto tool = tool_point(*arm_angles(kMiddle), kMiddle);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(motors_of(*tool, {nan, 0, 1}), Counts{});
  EXPECT_EQ(motors_of(*tool, {0, 1e308, 1e308}), Counts{});
}

/// The time is an argument. Arms rotate at 60 rad/s at most.
TEST(FalconBoard, AnArmThatCannotHaveMovedSoIsRefused) {
  TrackedTool tool;
  const Nanoseconds start(0);
  ASSERT_TRUE(tool.take({0, 0, 0}, start));
  const Vec3 place = tool.point().position;
  const int most = static_cast<int>(60.0 * 1e-3 / kCount);
  EXPECT_FALSE(tool.take({most + 1, 0, 0}, start + std::chrono::milliseconds(1)));
  EXPECT_EQ(tool.point().position, place);
  EXPECT_TRUE(tool.take({most, 0, 0}, start + std::chrono::milliseconds(1)));
  tool.forget();
  EXPECT_TRUE(tool.take({0, most, 0}, start + std::chrono::milliseconds(1)));
}

TEST(FalconBoard, WhereNoLegReachesThereIsNoPlace) {
  EXPECT_FALSE(arm_angles({0, 0, 0.25}));
  EXPECT_FALSE(arm_angles({0.2, 0, 0.12}));
  EXPECT_FALSE(tool_point(Vec3(3.0, -3.0, 0.5), kMiddle));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(tool_point(Vec3(nan, 0, 0), kMiddle));
  EXPECT_FALSE(arm_angles({nan, 0, 0.12}));
}

}  // namespace
}  // namespace feltwire::falcon_board_test
