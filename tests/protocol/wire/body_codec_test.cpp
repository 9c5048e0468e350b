// Tests the local model of a tool with a body: encoding and decoding.

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <functional>
#include <limits>
#include <random>
#include <vector>

#include "protocol/wire/codec.hpp"
#include "protocol/wire/datagram_generated.h"
#include "protocol/wire/seal.hpp"

namespace feltwire::body_codec_test {
namespace {

using Generator = std::mt19937_64;

double number(Generator& random, double most) {
  return std::uniform_real_distribution<double>(-most, most)(random);
}
Vec3 vector(Generator& random, double most) {
  return {number(random, most), number(random, most), number(random, most)};
}

Reply random_reply(Generator& random) {
  Reply reply;
  reply.sample_index = 7;
  reply.rotation = reply.predicted = reply.body_modelled = true;
  BodyModel& m = reply.body;
  m.scene = static_cast<std::uint32_t>(random());
  m.solids = static_cast<std::uint32_t>(random());
  m.tool = {vector(random, 1.0), Quaternion(Eigen::AngleAxisd(1.0, Vec3(1, 2, 3).normalized()))};
  m.reach = 0.03F;
  m.turn = 0.5F;
  m.coupling = {1000.0, 0.5, 8.0, 0.25};
  m.radius = 0.0625;
  m.slipping = random() % 2 == 0;
  m.count = kMaxBodyPoints;
  m.patch_count = kMaxBodyPatches;
  for (BodyPoint& p : m.points) {
    const Vec3 wide = vector(random, 0.01), tall = vector(random, 0.002);
    p = {vector(random, 0.06),
         // a flat distribution with one eigenvalue of zero
         wide * wide.transpose() + tall * tall.transpose(), vector(random, 1.0).normalized(),
         number(random, 0.01), std::abs(number(random, 1000.0)),
         static_cast<std::uint8_t>(random() % kMaxBodyPatches)};
  }
  for (BodyPatch& p : m.patches)
    p = {0.5, 0.25, 1.5, 0.125, vector(random, 0.1), static_cast<std::uint16_t>(random())};
  return reply;
}

DropReason verdict(const Reply& reply, Reply& out) {
  Encoder encoder;
  return decode(encoder.reply(reply), out);
}

TEST(BodyCodec, RoundTrip) {
  Generator random(1);
  Reply received;
  for (int round = 0; round < 200; ++round) {
    const Reply sent = random_reply(random);
    ASSERT_EQ(verdict(sent, received), DropReason::none);
    ASSERT_TRUE(received.body_modelled);
    const BodyModel &a = sent.body, &b = received.body;
    EXPECT_EQ(a.solids, b.solids);
    EXPECT_EQ(a.scene, b.scene);
    EXPECT_EQ(a.tool.position, b.tool.position);
    EXPECT_EQ(a.tool.orientation.coeffs(), b.tool.orientation.coeffs());
    EXPECT_EQ(a.reach, b.reach);
    EXPECT_EQ(a.turn, b.turn);
    EXPECT_EQ(a.coupling.stiffness, b.coupling.stiffness);
    EXPECT_EQ(a.coupling.rotational_stiffness, b.coupling.rotational_stiffness);
    EXPECT_EQ(a.coupling.max_force, b.coupling.max_force);
    EXPECT_EQ(a.coupling.max_torque, b.coupling.max_torque);
    EXPECT_EQ(a.radius, b.radius);
    EXPECT_EQ(a.slipping, b.slipping);
    ASSERT_EQ(b.count, a.count);
    ASSERT_EQ(b.patch_count, a.patch_count);
    const double unit = 2.0 * a.radius / 32767.0;  // [m]
    for (std::size_t i = 0; i < a.view().size(); ++i) {
      const BodyPoint &p = a.points[i], &q = b.points[i];
      EXPECT_LE((p.arm - q.arm).cwiseAbs().maxCoeff(), 0.51 * unit);
      EXPECT_LE((p.normal - q.normal).cwiseAbs().maxCoeff(), 0.51 / 32767.0);
      EXPECT_LE((p.spread - q.spread).norm(), 4.0 * unit * std::sqrt(p.spread.trace()));
      EXPECT_NEAR(p.distance, q.distance, 1e-9);
      EXPECT_NEAR(p.stiffness, q.stiffness, 1e-4);
      EXPECT_EQ(p.patch, q.patch);
    }
    EXPECT_TRUE(a.patches[2].velocity.isApprox(b.patches[2].velocity, 1e-6));
    EXPECT_EQ(a.patches[2].object, b.patches[2].object);
    EXPECT_EQ(a.patches[2].damping_time, b.patches[2].damping_time);
  }
}

// Every root must give a valid covariance, for any bits.
TEST(BodyCodec, EveryRootIsACovariance) {
  Generator random(2);
  Reply received;
  for (int round = 0; round < 200; ++round) {
    Reply sent = random_reply(random);
    for (BodyPoint& p : sent.body.points)
      // This matrix is no covariance.
      p.spread = Mat3::NullaryExpr([&] { return number(random, 1e-3); });
    ASSERT_EQ(verdict(sent, received), DropReason::none);
    for (const BodyPoint& p : received.body.view()) {
      EXPECT_EQ(p.spread, p.spread.transpose());
      const Eigen::SelfAdjointEigenSolver<Mat3> eigen(p.spread, Eigen::EigenvaluesOnly);
      EXPECT_GE(eigen.eigenvalues().minCoeff(), -1e-15);
    }
  }
}

TEST(BodyCodec, TheFullestReplyFitsADatagram) {
  Generator random(3);
  Encoder encoder;
  Reply reply = random_reply(random);
  EXPECT_LE(encoder.reply(reply).size() + kOverhead, kMaxDatagram);
  reply.normals.count = 3;
  reply.normals.unit = {Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()};
  reply.change = ClientChange{.number = 3,
                              .law = LawChoice{MethodName(std::string(64, 'm')), {}, {}},
                              .link = LinkQuality{0.1, 0.01, 0.05}};
  EXPECT_LE(encoder.reply(reply).size() + kOverhead, kMaxDatagram);
}

TEST(BodyCodec, ModelsThatAreNoneAreDropped) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  const std::vector<std::function<void(BodyModel&)>> spoils = {
      [=](BodyModel& m) { m.tool.position.y() = nan; },
      [=](BodyModel& m) { m.tool.position.y() = 2e3; },
      [](BodyModel& m) { m.tool.orientation.w() += 0.1; },
      [=](BodyModel& m) { m.reach = nan; },
      [](BodyModel& m) { m.reach = -1e-3; },
      [=](BodyModel& m) { m.turn = inf; },
      [](BodyModel& m) { m.coupling.stiffness = 0.0; },
      [](BodyModel& m) { m.coupling.rotational_stiffness = -1.0; },
      [=](BodyModel& m) { m.coupling.max_force = inf; },
      [=](BodyModel& m) { m.coupling.max_torque = nan; },
      [](BodyModel& m) { m.radius = 0.0; },
      [=](BodyModel& m) { m.points[1].distance = nan; },
      [=](BodyModel& m) { m.points[1].stiffness = inf; },
      [](BodyModel& m) { m.points[1].stiffness = -1.0; },  // A negative stiffness would pull.
      [](BodyModel& m) { m.points[1].normal *= 0.9; },
      [=](BodyModel& m) { m.points[1].normal.x() = nan; },
      [](BodyModel& m) { m.patches[1].dynamic_friction = 0.6; },
      [=](BodyModel& m) { m.patches[1].static_friction = inf; },
      [](BodyModel& m) { m.patches[1].viscous_friction = -1.0; },
      [](BodyModel& m) { m.patches[1].damping_time = -1.0; },
      [=](BodyModel& m) { m.patches[1].velocity.z() = nan; },
  };
  Generator random(4);
  Reply out;
  for (std::size_t which = 0; which < spoils.size(); ++which) {
    Reply reply = random_reply(random);
    ASSERT_EQ(verdict(reply, out), DropReason::none);
    spoils[which](reply.body);
    EXPECT_EQ(verdict(reply, out), DropReason::not_finite) << "spoil " << which;
  }
}

TEST(BodyCodec, APatchThatIsNotThereIsACountThatIsWrong) {
  Generator random(5);
  Reply reply = random_reply(random), out;
  reply.body.points[3].patch = kMaxBodyPatches;
  EXPECT_EQ(verdict(reply, out), DropReason::count);
  reply.body.points[3].patch = 0;
  reply.body.patch_count = 0;
  EXPECT_EQ(verdict(reply, out), DropReason::count);
}

TEST(BodyCodec, MorePointsThanAModelMayHave) {
  flatbuffers::FlatBufferBuilder builder;
  const std::vector<wire::BodyPoint> points(kMaxBodyPoints + 1);
  const wire::Vec3d zero;
  const wire::Quatd unit(1, 0, 0, 0);
  const wire::BoundingReport report;
  const auto body = wire::CreateBodyModel(builder, 0, &zero, &unit, 0.1F, 0.1F, 1, 1, 1, 1, 1,
                                          false, builder.CreateVectorOfStructs(points));
  builder.Finish(wire::CreateReply(builder, 1, 0, 0, 0, &zero, &zero, nullptr, &report, 0, nullptr,
                                   0, 0, 0, nullptr, 0, 0, body));
  Reply out;
  EXPECT_EQ(decode(Bytes(builder.GetBufferPointer(), builder.GetSize()), out), DropReason::count);
}

}  // namespace
}  // namespace feltwire::body_codec_test
