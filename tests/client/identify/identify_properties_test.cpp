// identify must never report more damping, friction or mass than a device has.

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <sstream>
#include <vector>

#include "tests/client/identify/measured_handle.hpp"
#include "tests/support/seeds.hpp"

namespace feltwire::identify_test {
namespace {

/// Returns a number from 0 to count - 1. The range does not grow with the test size.
int any_of(int count) { return *rc::gen::resize(rc::kNominalSize, rc::gen::inRange(0, count)); }
/// Returns a log-uniform value between `least` and `most`.
double between(double least, double most) {
  return least * std::pow(most / least, any_of(1001) / 1000.0);
}
/// Returns zero in one of four cases, or a log-uniform value.
double sometimes(double least, double most) { return any_of(4) == 0 ? 0.0 : between(least, most); }

HandleTruth random_handle() {
  HandleTruth truth;
  const double damping = between(0.02, 3.0), mass = between(0.04, 0.4);
  const Vec3 axes(between(0.5, 2.0), between(0.5, 2.0), between(0.5, 2.0));
  truth.damping = (damping * axes).asDiagonal();
  if (any_of(3) == 0) {  // coupled axes
    const Vec3 turn(between(0.1, 1.0), between(0.1, 1.0), between(0.1, 1.0));
    const Mat3 q = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
    truth.damping = q * truth.damping * q.transpose();
  }
  for (int i = 0; i < 3; ++i) truth.mass[i] = mass * between(0.7, 1.4);
  for (int i = 0; i < 3; ++i) truth.friction[i] = sometimes(0.01, 0.4);
  truth.stiction = sometimes(0.005, 0.2);
  truth.stiction_speed = between(1e-3, 2e-2);
  for (int i = 0; i < 3; ++i) truth.gravity[i] = sometimes(0.02, 0.5);
  truth.cogging = sometimes(0.005, 0.1);
  truth.cogging_pitch = between(0.5e-3, 8e-3);
  truth.quantum = sometimes(1e-6, 60e-6);
  truth.noise = sometimes(1e-6, 20e-6);
  truth.force_delay = any_of(4);
  truth.reading_delay = any_of(4);
  truth.seed = static_cast<unsigned>(any_of(1 << 30));
  return truth;
}

double least_eigenvalue(const Mat3& m) {
  return Eigen::SelfAdjointEigenSolver<Mat3>(m, Eigen::EigenvaluesOnly).eigenvalues()[0];
}

class IdentifyProperty : public ::testing::TestWithParam<int> {};

/// Tests 250 devices in five parts. Another 250 devices with a new seed may reveal rare dangerous
/// devices. RC_PARAMS does not change the number of devices.
TEST_P(IdentifyProperty, NeverReportsMoreThanTheDeviceHas) {
#ifdef FELTWIRE_SANITIZED
  constexpr int kDevices = 2;  // Sanitizers are fifty times as slow.
#else
  constexpr int kDevices = 50;
#endif
  rc::detail::TestParams params = rc::detail::configuration().testParams;
  params.maxSuccess = kDevices;
  params.seed += static_cast<std::uint64_t>(GetParam());
  params.disableShrinking = true;  // A shrunk input would be another device.
  int measured_well = 0, with_damping = 0;
  const auto result = rc::detail::checkTestable(
      [&] {
        const HandleTruth truth = random_handle();
        const Identification run = measured(truth, spec_of(12.0), 3.0);
        // Identification gave up and reports nothing.
        if (run.state() != Identification::State::done) return;
        const DeviceEstimate found = run.estimate();
        if (!found.doubts.empty()) return;
        ++measured_well;
        if (found.damping_bound.maxCoeff() > 0.0) ++with_damping;
        const Mat3 left = truth.damping - Mat3(found.damping_bound.asDiagonal());
        RC_LOG() << "damping\n"
                 << truth.damping << "\nreported " << found.damping_bound.transpose()
                 << "\nfriction " << truth.friction.transpose() << " reported "
                 << found.friction_bound << "\nmass " << truth.mass.transpose() << " reported "
                 << found.mass_bound << "\n";
        RC_ASSERT(least_eigenvalue(left) >= -1e-12);
        RC_ASSERT(found.friction_bound <= truth.friction.minCoeff());
        RC_ASSERT(found.mass_bound <= truth.mass.minCoeff());
      },
      rc::detail::TestMetadata{}, params);
  std::ostringstream said;
  rc::detail::printResultMessage(result, said);
  ASSERT_TRUE(result.is<rc::detail::SuccessResult>()) << said.str();
  // Most devices must get a result. An identify that reports nothing would pass otherwise.
#ifndef FELTWIRE_SANITIZED
  EXPECT_GT(measured_well, kDevices * 3 / 4);
  EXPECT_GT(with_damping, kDevices / 3);
#endif
}
INSTANTIATE_TEST_SUITE_P(Parts, IdentifyProperty, ::testing::Range(0, test::rounds(5)));

TEST(Identify, AHandThatHoldsItIsDoubted) {
  HandleTruth truth;
  truth.hand_stiffness = 60.0;
  truth.hand_damping = 2.0;
  const Identification run = measured(truth, spec_of(12.0), 3.0);
  ASSERT_EQ(run.state(), Identification::State::done) << run.why();
  const DeviceEstimate found = run.estimate();
  ASSERT_FALSE(found.doubts.empty());
  EXPECT_NE(found.doubts.front().find("does somebody hold it"), std::string::npos);
}

/// Some device firmware adds damping only while a force is on. Sweeps cannot separate this damping
/// from the device's own, but the decay test can.
TEST(Identify, ADampingThatComesWithTheForceIsSeenByTheDecay) {
  HandleTruth truth;
  truth.friction = Vec3::Constant(0.02);
  truth.quantum = 10e-6;
  const Identification free = measured(truth, spec_of(12.0), 3.0);
  ASSERT_EQ(free.state(), Identification::State::done) << free.why();
  EXPECT_TRUE(free.estimate().doubts.empty());
  for (const auto& decay : free.estimate().decay) EXPECT_NEAR(decay.value(), 0.5, 0.05);
  // The decay shows a third less damping than the sweeps. identify must report a doubt.
  truth.servo_damping = 1.0;
  const DeviceEstimate doubted = measured(truth, spec_of(12.0), 3.0).estimate();
  ASSERT_FALSE(doubted.doubts.empty());
  EXPECT_NE(doubted.doubts.front().find("the decay only"), std::string::npos);
  // The decay shows slightly less damping. identify must lower the reported number.
  truth.servo_damping = 0.1;
  const DeviceEstimate lowered = measured(truth, spec_of(12.0), 3.0).estimate();
  EXPECT_TRUE(lowered.doubts.empty());
  EXPECT_GT(lowered.damping.minCoeff(), 0.55);
  EXPECT_LT(lowered.damping_bound.maxCoeff(), 0.8 * 0.55);
}

/// For clean devices (encoder of 10 um, no other effect), half of the reports must reach these
/// shares of the true values.
TEST(Identify, ReportsAGoodShareOfACleanDevice) {
#ifdef FELTWIRE_SANITIZED
  GTEST_SKIP() << "a figure, which takes fifty times as long here";
#endif
  std::vector<double> dampings, frictions, masses;
  int n = 0;
  for (const double damping : {0.1, 0.3, 1.0, 3.0})
    for (const double friction : {0.05, 0.2})
      for (const double mass : {0.05, 0.2}) {
        HandleTruth truth;
        truth.damping = damping * Mat3::Identity();
        truth.friction = Vec3::Constant(friction);
        truth.mass = Vec3::Constant(mass);
        truth.quantum = 10e-6;
        truth.seed = static_cast<unsigned>(++n);
        const Identification run = measured(truth, spec_of(12.0), 3.0);
        ASSERT_EQ(run.state(), Identification::State::done) << run.why();
        const DeviceEstimate found = run.estimate();
        ASSERT_TRUE(found.doubts.empty()) << found.doubts.front();
        for (const double b : found.damping_bound) dampings.push_back(b / damping);
        frictions.push_back(found.friction_bound / friction);
        masses.push_back(found.mass_bound / mass);
        EXPECT_NEAR(found.quantum, truth.quantum, 1e-9);
      }
  const auto median = [](std::vector<double>& shares) {
    std::sort(shares.begin(), shares.end());
    return shares[shares.size() / 2];
  };
  EXPECT_GT(median(dampings), 0.7);
  EXPECT_GT(median(frictions), 0.3);
  EXPECT_GT(median(masses), 0.7);
  EXPECT_LE(std::max({dampings.back(), frictions.back(), masses.back()}), 1.0);
}

}  // namespace
}  // namespace feltwire::identify_test
