// Tests the parts of a reply besides the command: rates and a local model.

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <vector>

#include "flatbuffers/flatbuffers.h"
#include "protocol/wire/datagram_generated.h"
#include "tests/protocol/make.hpp"

namespace feltwire::model_codec_test {
namespace {

using test::float_vector;
using test::Generator;

double single(Generator& random, double most) {
  return static_cast<float>(test::uniform(random, 0.0, most));
}

/// Returns positions relative to a center that are exact in float32, as on the wire.
SurfacePatch random_patch(Generator& random, const Vec3& center) {
  SurfacePatch p;
  p.point = center + float_vector(random, 0.1);
  p.normal = Vec3::Unit(static_cast<Eigen::Index>(random() % 3));
  if (random() % 2 == 0) p.axis = Vec3::Unit(static_cast<Eigen::Index>(random() % 3));
  p.velocity = float_vector(random, 1);
  p.anchor = center + float_vector(random, 0.1);
  p.curvature = (random() % 2 == 0 ? -1 : 1) * single(random, 25);
  p.radius = single(random, 0.1);
  p.material.stiffness = single(random, 1e4);
  p.material.damping = single(random, 10);
  p.material.dynamic_friction = single(random, 0.5);
  p.material.static_friction = 0.5;
  p.material.viscous_friction = single(random, 10);
  p.object = static_cast<std::uint16_t>(random());
  p.feature = static_cast<std::uint32_t>(random());
  p.touching = random() % 2 == 0;
  p.slipping = random() % 2 == 0;
  p.joined = random() % 2 == 0;
  p.faceted = random() % 2 == 0;
  p.rough = random() % 2 == 0;
  p.whole = random() % 2 == 0;
  return p;
}

Reply random_reply(Generator& random, int patches) {
  Reply reply;
  reply.sample_index = 7;
  reply.withheld = random();
  reply.predicted = random() % 2 == 0;
  if (reply.predicted)
    reply.rates = {float_vector(random, 100), float_vector(random, 10), float_vector(random, 1)};
  reply.modelled = true;
  reply.model.center = Vec3(0.25, -0.5, 0.125);
  reply.model.reach = single(random, 0.1);
  reply.model.scene = static_cast<std::uint32_t>(random());
  reply.model.surfaces = 1 + static_cast<std::uint32_t>(random() % 1000);
  reply.model.count = patches;
  for (SurfacePatch& p : reply.model.patches) p = random_patch(random, reply.model.center);
  if (random() % 2 == 0) reply.model.patches[1].offset = single(random, 0.01);
  return reply;
}

void expect_same(const SurfacePatch& a, const SurfacePatch& b) {
  constexpr double kHalfUlp = 1e-8;  // [m] half an ulp of 0.1 m as float32
  EXPECT_TRUE(a.point.isApprox(b.point, kHalfUlp));
  EXPECT_EQ(a.normal, b.normal);
  EXPECT_EQ(a.axis, b.axis);
  EXPECT_EQ(a.velocity, b.velocity);
  EXPECT_TRUE(a.anchor.isApprox(b.anchor, kHalfUlp));
  EXPECT_EQ(a.curvature, b.curvature);
  EXPECT_EQ(a.radius, b.radius);
  EXPECT_EQ(a.material.stiffness, b.material.stiffness);
  EXPECT_EQ(a.material.damping, b.material.damping);
  EXPECT_EQ(a.material.static_friction, b.material.static_friction);
  EXPECT_EQ(a.material.dynamic_friction, b.material.dynamic_friction);
  EXPECT_EQ(a.material.viscous_friction, b.material.viscous_friction);
  EXPECT_EQ(a.object, b.object);
  EXPECT_EQ(a.feature, b.feature);
  EXPECT_EQ(a.touching, b.touching);
  EXPECT_EQ(a.slipping, b.slipping);
  EXPECT_EQ(a.joined, b.joined);
  EXPECT_EQ(a.faceted, b.faceted);
  EXPECT_EQ(a.rough, b.rough);
  EXPECT_EQ(a.whole, b.whole);
  EXPECT_EQ(a.offset, b.offset);
}

DropReason verdict(const Reply& reply, Reply& out) {
  Encoder encoder;
  return decode(encoder.reply(reply), out);
}

// A scene may have these numbers. A drop of the reply would leave the hand without any force.
TEST(ModelCodec, NumbersBeyondFloat32AreTheEndsOfItsRange) {
  Generator random(5);
  Reply sent = random_reply(random, 1), received;
  SurfacePatch& patch = sent.model.patches[0];
  patch.material.stiffness = 1e-300;
  patch.curvature = -1e300;
  ASSERT_EQ(verdict(sent, received), DropReason::none);
  EXPECT_GT(received.model.patches[0].material.stiffness, 0.0);
  EXPECT_LT(received.model.patches[0].material.stiffness, 1e-44);
  EXPECT_EQ(received.model.patches[0].curvature, -std::numeric_limits<float>::max());
  // An infinity is none of these numbers.
  patch.curvature = std::numeric_limits<double>::infinity();
  EXPECT_EQ(verdict(sent, received), DropReason::not_finite);
}

TEST(ModelCodec, RoundTrip) {
  Generator random(11);
  Encoder encoder;
  Reply received;
  for (int round = 0; round < 500; ++round) {
    const int patches = static_cast<int>(random() % 4);
    const Reply sent = random_reply(random, patches);
    const Bytes payload = encoder.reply(sent);
    EXPECT_LE(payload.size() + kOverhead, 640u);
    ASSERT_EQ(decode(payload, received), DropReason::none);
    EXPECT_EQ(received.withheld, sent.withheld);
    EXPECT_EQ(received.predicted, sent.predicted);
    EXPECT_EQ(received.rates, sent.rates);
    ASSERT_TRUE(received.modelled);
    EXPECT_EQ(received.model.center, sent.model.center);
    EXPECT_EQ(received.model.reach, sent.model.reach);
    EXPECT_EQ(received.model.scene, sent.model.scene);
    ASSERT_EQ(received.model.count, patches);
    for (std::size_t i = 0; i < sent.model.view().size(); ++i)
      expect_same(received.model.patches[i], sent.model.patches[i]);
  }
}

TEST(ModelCodec, ReplyWithoutAModelBringsNone) {
  Generator random(12);
  Reply sent = random_reply(random, 2), received = random_reply(random, 2);
  sent.modelled = false;
  ASSERT_EQ(verdict(sent, received), DropReason::none);
  EXPECT_FALSE(received.modelled);
}

TEST(ModelCodec, ModelsThatAreNoneAreDropped) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  const std::vector<std::function<void(Reply&)>> spoils = {
      [=](Reply& r) { r.model.center.y() = nan; },
      [=](Reply& r) { r.model.reach = nan; },
      [](Reply& r) { r.model.reach = -1e-3; },
      [=](Reply& r) { r.model.patches[1].point.x() = inf; },
      [](Reply& r) { r.model.patches[1].normal *= 1.01; },
      [](Reply& r) { r.model.patches[1].normal.setZero(); },
      [](Reply& r) {
        r.model.patches[1].axis = {0, 0, 0.5};
      },
      [=](Reply& r) { r.model.patches[1].velocity.z() = nan; },
      [=](Reply& r) { r.model.patches[1].anchor.z() = nan; },
      [=](Reply& r) { r.model.patches[1].curvature = inf; },
      [](Reply& r) { r.model.patches[1].radius = -1; },
      [=](Reply& r) { r.model.patches[1].offset = nan; },
      [](Reply& r) { r.model.patches[1].material.stiffness = 0; },
      [=](Reply& r) { r.model.patches[1].material.stiffness = inf; },
      [](Reply& r) { r.model.patches[1].material.damping = -1; },
      [](Reply& r) { r.model.patches[1].material.dynamic_friction = 0.6; },
      [=](Reply& r) { r.model.patches[1].material.static_friction = inf; },
      [=](Reply& r) { r.model.patches[1].material.viscous_friction = nan; },
      [=](Reply& r) { r.predicted = true, r.rates.elastic.x() = nan; },
  };
  Generator random(13);
  Reply out;
  for (std::size_t which = 0; which < spoils.size(); ++which) {
    Reply reply = random_reply(random, 2);
    ASSERT_EQ(verdict(reply, out), DropReason::none);
    spoils[which](reply);
    EXPECT_EQ(verdict(reply, out), DropReason::not_finite) << "spoil " << which;
  }
}

ContactNormals walls(std::initializer_list<Vec3> normals) {
  ContactNormals n;
  for (const Vec3& normal : normals) n.unit[static_cast<std::size_t>(n.count++)] = normal;
  return n;
}

TEST(ModelCodec, TheNormalsOfTwoWallsOrThreeTravel) {
  Generator random(16);
  Encoder encoder;
  Reply sent = random_reply(random, 0), received;
  sent.modelled = false;
  const std::size_t without = encoder.reply(sent).size();
  sent.normals = walls({Vec3::UnitZ()});
  EXPECT_EQ(encoder.reply(sent).size(), without) << "one wall says nothing";
  const Vec3 oblique = Vec3(1.0, 2.0, 3.0).normalized();
  for (const ContactNormals& normals :
       {walls({Vec3::UnitX(), Vec3::UnitZ()}), walls({oblique, -Vec3::UnitX(), Vec3::UnitY()})}) {
    sent.normals = normals;
    const Bytes payload = encoder.reply(sent);
    EXPECT_LE(payload.size(), without + 48u);
    ASSERT_EQ(decode(payload, received), DropReason::none);
    ASSERT_EQ(received.normals.count, normals.count);
    for (std::size_t i = 0; i < 3; ++i) {
      if (static_cast<int>(i) >= normals.count) continue;
      EXPECT_LT((received.normals.unit[i] - normals.unit[i]).norm(), 1e-7);
      EXPECT_NEAR(received.normals.unit[i].squaredNorm(), 1.0, 1e-15);
    }
  }
  sent.normals = {};
  ASSERT_EQ(verdict(sent, received), DropReason::none);
  EXPECT_EQ(received.normals.count, 0) << "none of the reply before";
}

TEST(ModelCodec, NormalsThatAreNoneAreDropped) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Generator random(17);
  Reply sent = random_reply(random, 1), received;
  for (const Vec3& bad : {Vec3(nan, 0, 0), Vec3(0, 0, 1.01), Vec3(Vec3::Zero())}) {
    sent.normals = walls({Vec3::UnitX(), bad});
    EXPECT_EQ(verdict(sent, received), DropReason::not_finite);
  }
  // A normal nearly equal to another is no error of the sender. Such a normal must not count as a
  // separate wall.
  sent.normals = walls({Vec3::UnitX(), Vec3::UnitX(), Vec3::UnitZ()});
  ASSERT_EQ(verdict(sent, received), DropReason::none);
  EXPECT_EQ(received.normals.count, 2);
}

TEST(ModelCodec, OneNormalOrFourAreACountThatIsWrong) {
  for (const std::size_t count : {std::size_t{0}, std::size_t{1}, std::size_t{4}}) {
    flatbuffers::FlatBufferBuilder builder;
    const wire::Vec3d zero;
    const wire::BoundingReport report;
    const std::vector<wire::Vec3f> normals(count, wire::Vec3f(0, 0, 1));
    const auto vector = builder.CreateVectorOfStructs(normals);
    builder.Finish(wire::CreateReply(builder, 1, 0, 0, 0, &zero, &zero, nullptr, &report, 0,
                                     nullptr, 0, 0, vector));
    Reply out;
    EXPECT_EQ(decode(Bytes(builder.GetBufferPointer(), builder.GetSize()), out), DropReason::count);
  }
}

TEST(ModelCodec, AWholePatchNeedsAVersion) {
  Generator random(3);
  Reply sent = random_reply(random, 2), received;
  sent.model.patches[0].whole = false;
  sent.model.patches[1].whole = true;
  ASSERT_EQ(verdict(sent, received), DropReason::none);
  EXPECT_EQ(received.model.surfaces, sent.model.surfaces);
  sent.model.surfaces = 0;
  EXPECT_EQ(verdict(sent, received), DropReason::count);
  sent.model.patches[1].whole = false;
  EXPECT_EQ(verdict(sent, received), DropReason::none);
}

TEST(ModelCodec, MorePatchesThanAModelMayHave) {
  flatbuffers::FlatBufferBuilder builder;
  const std::vector<wire::Patch> patches(kMaxPatches + 1);
  const wire::Vec3d zero;
  const wire::BoundingReport report;
  const auto model =
      wire::CreateLocalModel(builder, &zero, 0.1F, builder.CreateVectorOfStructs(patches));
  builder.Finish(
      wire::CreateReply(builder, 1, 0, 0, 0, &zero, &zero, nullptr, &report, 0, nullptr, model));
  Reply out;
  EXPECT_EQ(decode(Bytes(builder.GetBufferPointer(), builder.GetSize()), out), DropReason::count);
}

TEST(ModelCodec, AnOffsetToEachPatchOrNone) {
  for (const std::size_t offsets : {std::size_t{1}, std::size_t{2}, std::size_t{3}}) {
    flatbuffers::FlatBufferBuilder builder;
    const wire::Vec3d zero;
    const wire::BoundingReport report;
    wire::Patch patch(wire::Vec3f(0, 0, 0), wire::Vec3f(0, 0, 1), wire::Vec3f(0, 0, 0),
                      wire::Vec3f(0, 0, 0), wire::Vec3f(0, 0, 0), 0, 1, 1, 0, 0, 0, 0, 0, 0, 0);
    const std::vector<wire::Patch> patches(2, patch);
    const auto vector = builder.CreateVectorOfStructs(patches);
    const auto model = wire::CreateLocalModel(
        builder, &zero, 0.1F, vector, builder.CreateVector(std::vector<float>(offsets, 0.5F)));
    builder.Finish(
        wire::CreateReply(builder, 1, 0, 0, 0, &zero, &zero, nullptr, &report, 0, nullptr, model));
    Reply out;
    EXPECT_EQ(decode(Bytes(builder.GetBufferPointer(), builder.GetSize()), out),
              offsets == 2 ? DropReason::none : DropReason::count);
  }
}

// A field that no surface needs must take no bytes.
TEST(ModelCodec, WithoutOffsetsAModelIsShorter) {
  Generator random(15);
  Encoder encoder;
  Reply sent = random_reply(random, 3);
  sent.predicted = false;
  sent.model.surfaces = 0;
  for (SurfacePatch& p : sent.model.patches) {
    p.offset = 0.0;
    p.whole = false;
  }
  const std::size_t plain = encoder.reply(sent).size();
  sent.model.patches[2].offset = 1e-3;
  EXPECT_EQ(encoder.reply(sent).size(), plain + 16 + 8);
}

TEST(ModelCodec, WhatTravelledBeforeComesBefore) {
  Generator random(14);
  Encoder encoder;
  SampleBatch batch = test::random_batch(random, 100, 3, false), out;
  batch.previous = 97;
  ASSERT_EQ(decode(encoder.samples(batch), out), DropReason::none);
  EXPECT_EQ(out.previous, 97u);
  batch.previous = 98;
  EXPECT_EQ(decode(encoder.samples(batch), out), DropReason::order);
}

}  // namespace
}  // namespace feltwire::model_codec_test
