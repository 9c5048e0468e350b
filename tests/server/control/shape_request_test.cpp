// The answers to clients that draw a scene. The wire and the rights are tested from outside
// (tests/conformance/checks_shapes.py).

#include <gtest/gtest.h>

#include <asio/io_context.hpp>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/grid/distance_grid.hpp"
#include "core/grid/signed_distance.hpp"
#include "core/mesh/mesh_surface.hpp"
#include "core/mesh/tessellation.hpp"
#include "core/tool/body_tool.hpp"
#include "server/control/shape_requests.hpp"
#include "tests/support/eventually.hpp"

namespace feltwire::shape_request_test {
namespace {

using control::GetShape;
using control::Refused;
using control::ShapeGroup;
using control::ShapePart;

/// A server's scene in memory.
SceneInView::CurrentScene current(Scene scene, std::uint32_t version = 1) {
  return {
      .scene = std::make_shared<const Scene>(std::move(scene)), .version = version, .gravity = {}};
}

Object sphere(const std::string& name) {
  Object object;
  object.name = name;
  object.shape = Sphere{0.05};
  object.material_name = "wood";
  return object;
}

TEST(ShapeRequest, AManyObjectSceneComesInParts) {
  constexpr std::uint32_t kObjects = 250;
  std::vector<Object> objects;
  for (std::uint32_t i = 0; i < kObjects; ++i) objects.push_back(sphere("s" + std::to_string(i)));
  Scene many("many", std::move(objects));
  many.describe("balls");
  const auto scene = current(std::move(many), 3);
  std::vector<std::string> names;
  std::vector<std::size_t> sizes;
  for (;;) {
    const auto list = described_shapes(
        scene, {"many", ShapeGroup::objects, static_cast<std::uint32_t>(names.size())});
    EXPECT_EQ(list.version, 3u);
    EXPECT_EQ(list.scene, "balls");
    EXPECT_EQ(list.count, kObjects);
    if (list.shapes.empty()) break;
    sizes.push_back(list.shapes.size());
    for (const auto& shape : list.shapes) {
      names.push_back(shape.name);
      EXPECT_EQ(shape.shape, "sphere");
      EXPECT_EQ(shape.lengths, std::vector<double>{0.05});
      EXPECT_EQ(shape.material, "wood");
      EXPECT_FALSE(shape.parts);
    }
  }
  EXPECT_EQ(sizes, (std::vector<std::size_t>{100, 100, 50}));
  EXPECT_EQ(names.back(), "s249");
  EXPECT_TRUE(described_shapes(scene, {"many", ShapeGroup::guides, 0}).shapes.empty());
  EXPECT_EQ(described_shapes(scene, {"many", ShapeGroup::tools, 0}).shapes.at(0).shape, "point");
}

TEST(ShapeRequest, ALongNameIsCut) {
  Object object = sphere("ball");
  object.material_name = std::string(1000, 'x');
  const auto list =
      described_shapes(current(Scene("room", {object})), {"room", ShapeGroup::objects, 0});
  const std::string told = list.shapes.at(0).material;
  EXPECT_EQ(told.size(), control::kMaxName);
  EXPECT_TRUE(told.ends_with("x [...]"));
}

/// The parts of shapes, and the thread that gives them out.
struct Service {
  asio::io_context io{};
  ShapeParts parts{io};

  /// The answer, which may come later.
  control::Message part(const SceneInView::CurrentScene& scene, const GetShape& request) {
    std::optional<control::Message> found;
    parts.part(0, scene, request, [&](control::Message answer) { found = std::move(answer); });
    test::eventually("the answer", [&] {
      io.restart();
      io.poll();
      return found.has_value();
    });
    return *std::move(found);
  }
};

/// Fetches all parts of a shape.
TriangleSoup fetch(Service& parts, const SceneInView::CurrentScene& scene, GetShape request) {
  TriangleSoup soup;
  for (;;) {
    request.version = scene.version;
    request.vertices = static_cast<std::uint32_t>(soup.vertices.size());
    request.triangles = static_cast<std::uint32_t>(soup.triangles.size());
    const auto part = std::get<ShapePart>(parts.part(scene, request));
    soup.vertices.insert(soup.vertices.end(), part.vertices.begin(), part.vertices.end());
    soup.triangles.insert(soup.triangles.end(), part.triangles.begin(), part.triangles.end());
    if (part.vertices.empty() && part.triangles.empty()) {
      EXPECT_EQ(soup.vertices.size(), part.all_vertices);
      EXPECT_EQ(soup.triangles.size(), part.all_triangles);
      return soup;
    }
    EXPECT_LE(part.vertices.size(), control::kMaxPart);
    EXPECT_LE(part.triangles.size(), control::kMaxPart);
  }
}

Object ball_of_mesh(const TriangleMesh& mesh) {
  Object object;
  object.name = "mesh";
  object.shape = Mesh{std::make_shared<MeshSurface>(mesh)};
  return object;
}

TEST(ShapeRequest, AMeshIsAMeshForEveryTool) {
  const TriangleMesh mesh(icosphere(0.05, 4));  // 5120 triangles in five parts
  for (const bool body : {false, true}) {
    Scene scene("room", {ball_of_mesh(mesh)});
    if (body)  // it feels a grid of the mesh
      scene.set_tool({.body = std::make_shared<const BodyTool>(
                          point_shell(tessellate(Box{Vec3(0.03, 0.02, 0.01)}, 3), 2500),
                          ToolCoupling{}, 0.0)});
    const auto now = current(std::move(scene));
    const auto list = described_shapes(now, {"room", ShapeGroup::objects, 0});
    EXPECT_EQ(list.shapes.at(0).shape, "mesh");
    EXPECT_TRUE(list.shapes.at(0).parts);
    Service parts;
    const TriangleSoup soup = fetch(parts, now, {.scene = "room", .group = ShapeGroup::objects});
    EXPECT_EQ(soup.triangles, mesh.triangles());
    ASSERT_EQ(soup.vertices.size(), mesh.vertices().size());
    for (std::size_t i = 0; i < soup.vertices.size(); ++i)
      EXPECT_EQ(soup.vertices[i], mesh.vertices()[i] + mesh.origin());
    if (!body) continue;
    const TriangleSoup tool = fetch(parts, now, {.scene = "room", .group = ShapeGroup::tools});
    EXPECT_EQ(tool.vertices, now.scene->tool().body->shell().points);
    EXPECT_TRUE(tool.triangles.empty());
  }
}

Object grid_of_ball(double radius) {
  Object object;
  object.name = "grid";
  object.shape = Grid{std::make_shared<DistanceGrid<float>>(solid_of(Sphere{radius}),
                                                            GridOptions{.resolution = 4e-3})};
  return object;
}

TEST(ShapeRequest, AGridIsItsSurfaceOfTheVersionInForce) {
  Service parts;
  constexpr double kCell = 4e-3;
  std::uint32_t version = 0;
  for (const double radius : {0.05, 0.08}) {
    const auto now = current(Scene("room", {grid_of_ball(radius)}), ++version);
    EXPECT_EQ(described_shapes(now, {"room", ShapeGroup::objects, 0}).shapes.at(0).shape, "grid");
    const TriangleSoup soup = fetch(parts, now, {.scene = "room", .group = ShapeGroup::objects});
    EXPECT_GT(soup.triangles.size(), 1000u);
    for (const Vec3& vertex : soup.vertices) EXPECT_NEAR(vertex.norm(), radius, kCell);
  }
}

TEST(ShapeRequest, TheTrianglesOfAGridDoNotHoldUpTheControlThread) {
  Service service;
  const auto now = current(Scene("room", {grid_of_ball(0.05)}));
  int answers = 0;
  const auto ask = [&] {
    service.parts.part(0, now, {"room", 1, ShapeGroup::objects, 0, 0, 0},
                       [&](const control::Message& answer) {
                         EXPECT_TRUE(std::holds_alternative<ShapePart>(answer));
                         ++answers;
                       });
  };
  ask();
  ask();  // the same triangles, which are made once
  EXPECT_EQ(answers, 0) << "only the control thread answers, and it did not run yet";
  EXPECT_EQ(service.parts.grids(), 1u);
  service.parts.forget_others(0, 2);
  EXPECT_EQ(service.parts.grids(), 1u) << "somebody waits for them";
  test::eventually("both answers", [&] {
    service.io.restart();
    service.io.poll();
    return answers == 2;
  });
  ask();
  EXPECT_EQ(answers, 3) << "at once";
}

TEST(ShapeRequest, TheTrianglesOfAnOldVersionAreFreed) {
  Service service;
  const GetShape request{"room", 1, ShapeGroup::objects, 0, 0, 0};
  service.part(current(Scene("room", {grid_of_ball(0.05)})), request);
  EXPECT_EQ(service.parts.grids(), 1u);
  service.parts.forget_others(1, 2);  // another scene
  service.parts.forget_others(0, 1);
  EXPECT_EQ(service.parts.grids(), 1u);
  service.parts.forget_others(0, 2);
  EXPECT_EQ(service.parts.grids(), 0u);
}

TEST(ShapeRequest, WhatIsNotThereIsRefused) {
  Service parts;
  const auto now = current(Scene("room", {sphere("s")}), 2);
  const auto code = [&](const GetShape& request) {
    return std::get<Refused>(parts.part(now, request)).code;
  };
  using control::RefusalCode;
  EXPECT_EQ(code({"room", 1, ShapeGroup::objects, 0, 0, 0}), RefusalCode::bad_scene);
  EXPECT_EQ(std::get<Refused>(parts.part(now, {"room", 1, ShapeGroup::objects, 0, 0, 0})).reason,
            "the scene has no version 1 any more; list its shapes again");
  EXPECT_EQ(code({"room", 2, ShapeGroup::objects, 0, 0, 0}), RefusalCode::bad_parameters);
  EXPECT_EQ(code({"room", 2, ShapeGroup::objects, 1, 0, 0}), RefusalCode::bad_parameters);
  EXPECT_EQ(code({"room", 2, ShapeGroup::guides, 0, 0, 0}), RefusalCode::bad_parameters);
  EXPECT_EQ(code({"room", 2, ShapeGroup::tools, 0, 0, 0}), RefusalCode::bad_parameters);
}

}  // namespace
}  // namespace feltwire::shape_request_test
