// How a client gets surfaces in full, over TLS: what is listed, that the parts make up the mesh,
// and who may ask.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/mesh/mesh_surface.hpp"
#include "core/mesh/tessellation.hpp"
#include "server/app/server.hpp"
#include "tests/server/resting_hand.hpp"

namespace feltwire::surface_request_test {
namespace {

using control::RefusalCode;
using control::Refused;
using test::ControlClient;

const TriangleMesh& ball() {
  static const TriangleMesh mesh(icosphere(0.05, 4));  // 5120 triangles: five parts
  return mesh;
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
                     {.radius = 0.004, .body = nullptr, .name = "ball"}});
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

/// The tool of the session that asks decides.
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

TEST_F(SurfaceRequest, WhatIsNotThereIsRefused) {
  test::RestingHand hand(admin_);
  const auto refused = [&](const control::Message& request) {
    return admin_.ask<Refused>(request).code;
  };
  EXPECT_EQ(refused(control::GetSurface{hand.session(), 1, 0, 0, 0}), RefusalCode::bad_parameters);
  EXPECT_EQ(refused(control::GetSurface{hand.session(), 1, 3, 0, 0}), RefusalCode::bad_parameters);
  EXPECT_EQ(refused(control::GetSurface{hand.session(), 2, 2, 0, 0}), RefusalCode::bad_scene);
  EXPECT_EQ(refused(control::ListSurfaces{hand.session() ^ 0x100}), RefusalCode::unknown_session);
  // Behind the end there is nothing.
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
        control::Message(control::TakeSurfaces{hand.session(), 1, {2}})})
    EXPECT_EQ(other.ask<Refused>(request).code, RefusalCode::unknown_session);
}

}  // namespace
}  // namespace feltwire::surface_request_test
