// Clients fetch complete surfaces and solids over TLS. Tests the list, the parts of a mesh or a
// body, and the right to request them.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/mesh/mesh_surface.hpp"
#include "core/mesh/tessellation.hpp"
#include "core/tool/body_tool.hpp"
#include "server/app/server.hpp"
#include "tests/server/resting_hand.hpp"

namespace feltwire::surface_request_test {
namespace {

using control::RefusalCode;
using control::Refused;
using test::ControlClient;

const TriangleMesh& ball() {
  static const TriangleMesh mesh(icosphere(0.05, 4));  // 5120 triangles in five parts
  return mesh;
}

std::shared_ptr<const BodyTool> body() {
  static const auto tool = std::make_shared<const BodyTool>(
      point_shell(tessellate(Box{Vec3(0.03, 0.02, 0.01)}, 3), 2500), ToolCoupling{}, 0.0);
  return tool;
}

class SurfaceRequest : public ::testing::Test {
 protected:
  SurfaceRequest() : server_(test::any_port(), scenes(), test::security({other_.token})) {}
  static std::vector<Scene> scenes() {
    Scene room = test::room();
    std::vector<Object> objects = room.objects();
    Object mesh;
    mesh.name = "mesh";
    mesh.shape = Mesh{std::make_shared<MeshSurface>(ball())};
    mesh.pose.position = {0.2, 0.1, 0.3};
    objects.push_back(mesh);
    std::vector<Scene> all;
    Scene scene("room", std::move(objects));
    scene.set_tools({{.radius = 0.0, .body = nullptr, .name = "tip"},
                     {.radius = 0.004, .body = nullptr, .name = "ball"},
                     {.radius = 0.0, .body = body(), .name = "body"}});
    all.push_back(std::move(scene));
    return all;
  }

  IssuedToken other_ = issue_token("other", "*", Role::operator_, std::nullopt);
  Server server_;
  ControlClient admin_{server_.control_port()};
};

TEST_F(SurfaceRequest, ItsPartsMakeUpTheMesh) {
  test::RestingHand hand(admin_);
  const auto list = admin_.ask<control::SurfaceList>(control::ListSurfaces{hand.session()});
  EXPECT_EQ(list.version, 1u);
  ASSERT_EQ(list.surfaces.size(), 1u);
  const control::SurfaceEntry& entry = list.surfaces[0];
  EXPECT_EQ(entry.surface.object, 2);
  EXPECT_EQ(entry.surface.pose.position, Vec3(0.2, 0.1, 0.3));
  std::vector<Vec3> vertices;
  std::vector<Triangle> triangles;
  int parts = 0;
  while (vertices.size() < entry.vertices || triangles.size() < entry.triangles) {
    const auto part = admin_.ask<control::SurfacePart>(
        control::GetSurface{hand.session(), 1, 2, static_cast<std::uint32_t>(vertices.size()),
                            static_cast<std::uint32_t>(triangles.size())});
    vertices.insert(vertices.end(), part.vertices.begin(), part.vertices.end());
    triangles.insert(triangles.end(), part.triangles.begin(), part.triangles.end());
    ASSERT_LE(++parts, 5);
  }
  EXPECT_EQ(parts, 5);
  EXPECT_EQ(vertices, ball().vertices());
  EXPECT_EQ(triangles, ball().triangles());
  EXPECT_EQ(
      admin_.ask<control::SurfacesTaken>(control::TakeSurfaces{hand.session(), 1, {2}}).session,
      hand.session());
}

/// The surfaces must have the radius of the session's tool.
TEST_F(SurfaceRequest, ABallsRadiusIsInItsSurfaces) {
  for (const auto& [tool, radius] : {std::pair("tip", 0.0), std::pair("ball", 0.004)}) {
    control::JoinRequest join = test::join_request();
    join.tool = tool;
    const auto joined = admin_.join(join).accepted;
    const auto list = admin_.ask<control::SurfaceList>(control::ListSurfaces{joined.session});
    ASSERT_EQ(list.surfaces.size(), 1u) << tool;
    EXPECT_EQ(list.surfaces[0].surface.radius, radius) << tool;
  }
}

TEST_F(SurfaceRequest, PartsMakeUpTheBody) {
  control::JoinRequest join = test::join_request();
  join.tool = "body";
  const std::uint64_t session = admin_.join(join).accepted.session;
  EXPECT_TRUE(admin_.ask<control::SurfaceList>(control::ListSurfaces{session}).surfaces.empty());
  const auto list = admin_.ask<control::SolidList>(control::ListSolids{session});
  EXPECT_EQ(list.version, 1u);
  ASSERT_TRUE(list.body.has_value());
  EXPECT_EQ(list.body->contact_area, body()->contact_area());
  EXPECT_EQ(list.points, 2500u);
  ASSERT_EQ(list.solids.size(), 3u);
  EXPECT_EQ(list.solids[1].triangles, 0u);
  EXPECT_EQ(list.solids[2].triangles, 5120u);
  const auto first = admin_.ask<control::SurfacePart>(control::GetSurface{session, 1, 2, 0, 0});
  EXPECT_EQ(first.vertices[7], ball().vertices()[7] + ball().origin());
  EXPECT_EQ(first.triangles[7], ball().triangles()[7]);
  EXPECT_EQ(admin_.ask<Refused>(control::GetSurface{session, 1, 0, 0, 0}).code,
            RefusalCode::bad_parameters);
  std::vector<Vec3> points;
  while (points.size() < list.points) {
    const auto part = admin_.ask<control::BodyPoints>(
        control::GetBodyPoints{session, 1, static_cast<std::uint32_t>(points.size())});
    ASSERT_FALSE(part.points.empty());
    points.insert(points.end(), part.points.begin(), part.points.end());
  }
  EXPECT_EQ(points, body()->shell().points);
  EXPECT_TRUE(
      admin_.ask<control::BodyPoints>(control::GetBodyPoints{session, 1, 2500}).points.empty());
  EXPECT_EQ(admin_.ask<Refused>(control::GetBodyPoints{session, 2, 0}).code,
            RefusalCode::bad_scene);
  const auto take = [&](std::uint32_t version, std::vector<std::uint16_t> objects) {
    return control::TakeSurfaces{session, version, std::move(objects)};
  };
  EXPECT_EQ(admin_.ask<Refused>(take(1, {3})).code, RefusalCode::bad_parameters);
  EXPECT_EQ(admin_.ask<control::SurfacesTaken>(take(1, {0, 1, 2})).session, session);
  // The client of the body has the materials. A new material must therefore make a new version.
  admin_.ask<control::SceneChanged>(
      control::SetMaterial{"room", {.object = "floor", .stiffness = 321.0}});
  const auto next = admin_.ask<control::SolidList>(control::ListSolids{session});
  EXPECT_EQ(next.version, 2u);
  EXPECT_EQ(next.solids[0].solid.material.stiffness, 321.0);
  EXPECT_EQ(admin_.ask<Refused>(take(1, {0})).code, RefusalCode::bad_scene);
  EXPECT_EQ(admin_.ask<control::SurfacesTaken>(take(2, {0})).session, session);
}

TEST_F(SurfaceRequest, APointHasNoBodyToHave) {
  test::RestingHand hand(admin_);
  const auto list = admin_.ask<control::SolidList>(control::ListSolids{hand.session()});
  EXPECT_FALSE(list.body.has_value());
  EXPECT_TRUE(list.solids.empty());
  EXPECT_EQ(admin_.ask<Refused>(control::GetBodyPoints{hand.session(), 1, 0}).code,
            RefusalCode::bad_parameters);
}

TEST_F(SurfaceRequest, WhatIsNotThereIsRefused) {
  test::RestingHand hand(admin_);
  const auto refused = [&](const control::Message& request) {
    return admin_.ask<Refused>(request).code;
  };
  EXPECT_EQ(refused(control::GetSurface{hand.session(), 1, 0, 0, 0}), RefusalCode::bad_parameters);
  EXPECT_EQ(refused(control::GetSurface{hand.session(), 1, 3, 0, 0}), RefusalCode::bad_parameters);
  EXPECT_EQ(refused(control::GetSurface{hand.session(), 2, 2, 0, 0}), RefusalCode::bad_scene);
  EXPECT_EQ(refused(control::ListSurfaces{hand.session() ^ 0x100}), RefusalCode::unknown_session);
  // Parts beyond the end must be empty.
  const auto part = admin_.ask<control::SurfacePart>(
      control::GetSurface{hand.session(), 1, 2, 0xFFFFFFFF, 0xFFFFFFFF});
  EXPECT_TRUE(part.vertices.empty());
  EXPECT_TRUE(part.triangles.empty());
}

TEST_F(SurfaceRequest, AreForTheSessionsClientOnly) {
  test::RestingHand hand(admin_);
  ControlClient other(server_.control_port(), AF_INET, other_.text);
  for (const control::Message& request :
       {control::Message(control::ListSurfaces{hand.session()}),
        control::Message(control::GetSurface{hand.session(), 1, 2, 0, 0}),
        control::Message(control::ListSolids{hand.session()}),
        control::Message(control::GetBodyPoints{hand.session(), 1, 0}),
        control::Message(control::TakeSurfaces{hand.session(), 1, {2}})})
    EXPECT_EQ(other.ask<Refused>(request).code, RefusalCode::unknown_session);
}

/// A client that fetches a scene repeatedly must be refused after some 2000 parts. An honest client
/// needs at most 750 parts.
TEST_F(SurfaceRequest, AreNotAnsweredWithoutEnd) {
  test::RestingHand hand(admin_), other(admin_);
  const auto list = admin_.ask<control::SurfaceList>(control::ListSurfaces{hand.session()});
  const auto refused_at = [&](std::uint64_t session, int most) {
    for (int asked = 0; asked < most; ++asked) {
      // Beyond the mesh's end the answers are short.
      admin_.send(control::GetSurface{session, list.version, 2, 1'000'000, 1'000'000});
      const auto answer = admin_.receive();
      if (!answer) return -1;
      if (const auto* refused = std::get_if<Refused>(&*answer)) {
        EXPECT_EQ(refused->code, RefusalCode::too_many) << refused->reason;
        return asked;
      }
    }
    return most;
  };
  const int asked = refused_at(hand.session(), 20'000);
  EXPECT_GT(asked, 750);
  EXPECT_LT(asked, 20'000);
  EXPECT_EQ(refused_at(other.session(), 750), 750);  // Another session must have its own limit.
}

}  // namespace
}  // namespace feltwire::surface_request_test
