// A client may have the complete geometry of some surfaces. Tests the list of these surfaces, the
// right to fetch them, and their effect on the session's replies.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/mesh/mesh_surface.hpp"
#include "core/mesh/tessellation.hpp"
#include "tests/server/make.hpp"
#include "tests/server/sample_exchange.hpp"

namespace feltwire::surface_session_test {
namespace {

using control::RefusalCode;
using ::testing::HasSubstr;

constexpr std::uint64_t kId = 0x100, kOther = 0x200;

/// Returns a ball of triangles above a floor.
Scene ball_room() {
  Object floor, ball;
  floor.name = "floor";
  floor.shape = Plane{};
  floor.pose.position.z() = -0.3;
  ball.name = "ball";
  ball.shape = Mesh{std::make_shared<MeshSurface>(TriangleMesh(icosphere(0.05, 3)))};
  return Scene("room", {floor, ball});
}

control::JoinRequest modelled() {
  control::JoinRequest request = test::join_request({});
  request.parameters.side = BoundingSide::client;
  request.parameters.local_model = true;
  return request;
}

struct SurfaceSession : ::testing::Test {
  SurfaceSession() { join(kId); }
  void join(std::uint64_t id) {
    ASSERT_TRUE(std::holds_alternative<control::JoinAccepted>(
        exchange.sessions.answer(modelled(), id, test::keys(id), exchange.now)));
  }
  control::Message take(const std::vector<std::uint16_t>& objects, std::uint32_t version = 1) {
    return exchange.sessions.answer(control::TakeSurfaces{kId, version, objects}, 0, {},
                                    exchange.now);
  }
  control::Refused refused(const std::vector<std::uint16_t>& objects, std::uint32_t version = 1) {
    return std::get<control::Refused>(take(objects, version));
  }
  LocalModel model(std::uint64_t id = kId) {
    Sample sample;
    sample.pose.position = {0.049, 0.0, 0.02};
    Reply reply;
    EXPECT_EQ(decode(exchange.send(id, sample, false), reply), DropReason::none);
    EXPECT_TRUE(reply.modelled);
    return reply.model;
  }

  test::SampleExchange exchange{ball_room()};
};

TEST_F(SurfaceSession, AreMarkedFromTheNextSampleOn) {
  const LocalModel before = model();
  EXPECT_EQ(before.surfaces, 0u);
  EXPECT_LT(before.reach, 0.09);
  ASSERT_TRUE(std::holds_alternative<control::SurfacesTaken>(take({1})));
  const LocalModel after = model();
  EXPECT_EQ(after.surfaces, 1u);
  EXPECT_FLOAT_EQ(static_cast<float>(after.reach), 0.1F);
  ASSERT_EQ(after.count, 1);
  EXPECT_TRUE(after.patches[0].whole);
  EXPECT_EQ(after.patches[0].object, 1);
  EXPECT_EQ(after.patches[0].material.stiffness, before.patches[0].material.stiffness);
  // The mark must apply to this session only.
  join(kOther);
  EXPECT_EQ(model(kOther).surfaces, 0u);
  // The mark must end when the client has no surfaces.
  ASSERT_TRUE(std::holds_alternative<control::SurfacesTaken>(take({})));
  const LocalModel none = model();
  EXPECT_EQ(none.surfaces, 0u);
  EXPECT_EQ(none.reach, before.reach);
}

TEST_F(SurfaceSession, AnotherSceneForgetsThem) {
  take({1});
  ASSERT_EQ(model().surfaces, 1u);
  const Scene again = ball_room();
  exchange.sessions.enter(again, exchange.now);
  EXPECT_EQ(model().surfaces, 0u);
  EXPECT_THAT(refused({1}).reason, HasSubstr("list its surfaces again"));
  EXPECT_EQ(refused({1}).code, RefusalCode::bad_scene);
  ASSERT_TRUE(std::holds_alternative<control::SurfacesTaken>(take({1}, 2)));
  EXPECT_EQ(model().surfaces, 2u);
  exchange.sessions.shut_down();  // The sessions end before their scene.
}

TEST_F(SurfaceSession, AnotherMaterialLeavesThem) {
  take({1});
  const auto changed =
      exchange.sessions.change(MaterialChange{.object = "ball", .stiffness = 321.0}, exchange.now);
  ASSERT_TRUE(std::holds_alternative<Changed>(changed));
  const LocalModel told = model();
  EXPECT_EQ(told.surfaces, 1u);
  EXPECT_EQ(told.patches[0].material.stiffness, 321.0);
  exchange.sessions.shut_down();
}

TEST_F(SurfaceSession, WhatIsNoSuchSurfaceIsRefused) {
  EXPECT_EQ(refused({0}).code, RefusalCode::bad_parameters);
  EXPECT_THAT(refused({0}).reason, HasSubstr("object 0 has no surface"));
  EXPECT_EQ(refused({2}).code, RefusalCode::bad_parameters);
  EXPECT_EQ(refused({1, 65535}).code, RefusalCode::bad_parameters);
  EXPECT_EQ(model().surfaces, 0u);
  const control::Message unknown =
      exchange.sessions.answer(control::TakeSurfaces{kOther, 1, {1}}, 0, {}, exchange.now);
  EXPECT_EQ(std::get<control::Refused>(unknown).code, RefusalCode::unknown_session);
}

TEST_F(SurfaceSession, ItsModelDoesNotAllocate) {
  take({1});
  model();
  exchange.allocated = 0;
  for (int i = 0; i < 10; ++i) model();
  EXPECT_EQ(exchange.allocated, 0u);
}

/// A mark means a complete surface. Another mark on this surface must not count as a change.
TEST(ReplyDeadband, AWholeSurfaceIsDescribedByAnyMark) {
  LocalModel sent, now;
  sent.reach = now.reach = 0.1;
  sent.count = now.count = 1;
  sent.surfaces = now.surfaces = 1;
  sent.patches[0].whole = now.patches[0].whole = true;
  now.patches[0].point = Vec3(0.02, 0.0, 0.03);
  EXPECT_TRUE(describes(sent, now, 0.0, 0.01));
  now.surfaces = 2;
  EXPECT_FALSE(describes(sent, now, 0.0, 0.01));
  now.surfaces = 1;
  sent.patches[0].whole = false;
  EXPECT_FALSE(describes(sent, now, 0.0, 0.01));
}

}  // namespace
}  // namespace feltwire::surface_session_test
