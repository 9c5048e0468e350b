// A client has the complete meshes. The client's local model must equal the scene, for any tool
// position and age of the model.

#include "core/prefetched_geometry/mesh_surfaces.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/local_model/local_contact.hpp"
#include "core/local_model_extraction/extract.hpp"
#include "core/mesh/mesh_surface.hpp"
#include "core/mesh/tessellation.hpp"
#include "core/scene/scene.hpp"
#include "tests/support/allocation_counter.hpp"

namespace feltwire::mesh_surfaces_test {
namespace {

constexpr std::uint32_t kVersion = 7;
constexpr double kTick = 1e-3;  // [s]

Object ring(const MeshOptions& options = {}) {
  Object object;
  object.name = "ring";
  object.shape =
      Mesh{std::make_shared<MeshSurface>(TriangleMesh(tessellate(Torus{0.05, 0.02}, 24)), options)};
  object.pose = {Vec3(0.01, -0.02, 0.03), Quaternion(Eigen::AngleAxisd(0.4, Vec3::UnitX()))};
  object.material = {.stiffness = 1000.0, .static_friction = 0.5, .dynamic_friction = 0.3};
  return object;
}

Scene of(const Object& object) { return Scene("scene", {object}); }

/// Returns the surfaces as after the transfer, from the objects' data.
std::shared_ptr<const PrefetchedSurfaces> surfaces_of(const Scene& scene) {
  std::vector<SurfaceData> all;
  for (std::size_t i = 0; i < scene.objects().size(); ++i)
    if (can_travel(scene.objects()[i]))
      all.push_back(surface_data_with_triangles(scene.objects()[i], static_cast<std::uint16_t>(i),
                                                scene.tool().radius));
  return mesh_surfaces(kVersion, all);
}

LocalModel model_at(const Scene& scene, const Vec3& position, const TouchMemory& memory) {
  LocalModel model = local_model(scene, position, memory, KnownSurfaces{true});
  model.surfaces = kVersion;
  return model;
}

/// Returns a path around the ring, in and out, over many facets.
Vec3 way(const Object& object, double t) {
  const double round = 2.0 * t, over = 9.0 * t, off = 0.02 + 0.004 * std::cos(31.0 * t);
  const Vec3 local((0.05 + off * std::cos(over)) * std::cos(round),
                   (0.05 + off * std::cos(over)) * std::sin(round), off * std::sin(over));
  return object.pose.position + object.pose.orientation * local;
}

void expect_felt_as_the_scene(const Scene& scene) {
  const auto surfaces = surfaces_of(scene);
  TouchMemory memory = scene.memory();
  LocalContact local;
  local.use(surfaces.get());
  LocalModel told;  // a model that is 100 ms old
  std::vector<LocalModel> on_the_way;
  double felt = 0.0;
  for (int n = 0; n < 3000; ++n) {
    const Vec3 position = way(scene.objects()[0], n * kTick);
    const Tool tool{position, Vec3::Zero()};
    const Command truth = scene.touch(tool, memory);
    on_the_way.push_back(model_at(scene, position, memory));
    if (n < 100) continue;
    local.take(on_the_way[static_cast<std::size_t>(n) - 100]);
    const LocalForce force = local.touch(tool, 0.1, kTick);
    ASSERT_EQ(force.weight, 1.0) << n;
    if (n == 100) continue;  // The contact state is 100 ms old.
    EXPECT_LT((force.command.elastic - truth.elastic).norm(), 1e-6) << n;
    felt = std::max(felt, truth.elastic.norm());
  }
  EXPECT_GT(felt, 3.0);
}

TEST(MeshSurfaces, AreFeltAsInTheScene) {
  Object smooth = ring(), rough = ring({.grain = {.amplitude = 2e-4, .wavelength = 3e-3}});
  smooth.material.static_friction = smooth.material.dynamic_friction = 0.0;
  expect_felt_as_the_scene(of(smooth));
  expect_felt_as_the_scene(of(ring({.smooth = true})));
  expect_felt_as_the_scene(of(rough));
}

TEST(MeshSurfaces, AreFeltByABallAsInTheScene) {
  Object smooth = ring({.radius = 1e-3});  // The tool's radius is added to this radius.
  smooth.material.static_friction = smooth.material.dynamic_friction = 0.0;
  Scene scene = of(smooth);
  scene.set_tool({.radius = 3e-3, .body = nullptr});
  expect_felt_as_the_scene(scene);
}

TEST(MeshSurfaces, TheirFrictionIsTheScenes) {
  const Scene scene = of(ring());
  const auto surfaces = surfaces_of(scene);
  TouchMemory memory = scene.memory();
  LocalContact local;
  local.use(surfaces.get());
  local.take(model_at(scene, way(scene.objects()[0], 0.0) + Vec3(0, 0, 0.05), memory));
  scene.touch({way(scene.objects()[0], 0.0) + Vec3(0, 0, 0.05), Vec3::Zero()}, memory);
  double most = 0.0;
  for (int n = 0; n < 2000; ++n) {
    const Tool tool{way(scene.objects()[0], n * kTick), Vec3::Zero()};
    const Command truth = scene.touch(tool, memory), here = local.touch(tool, 0.0, kTick).command;
    if (n < 10) continue;
    EXPECT_LT((here.frictional - truth.frictional).norm(), 1e-6) << n;
    most = std::max(most, truth.frictional.norm());
  }
  EXPECT_GT(most, 0.5);
}

/// A session gets its surfaces while the hand presses. The session must continue with the server's
/// contact.
TEST(MeshSurfaces, AContactThatTheServerHoldsIsTakenUp) {
  for (const double side : {1.0, -1.0}) {
    Object object = ring({.double_sided = true});
    const Scene scene = of(object);
    const auto surfaces = surfaces_of(scene);
    TouchMemory memory = scene.memory();
    Command truth;
    Tool tool;
    // 5 mm into the outer side, or from inside out through the same side
    for (int n = 0; n <= 50; ++n) {
      const double out = 0.07 + side * (0.002 - 0.00014 * n);
      const Vec3 local(out * std::cos(0.3), out * std::sin(0.3), 1e-3 + 1e-5 * n);
      tool = {object.pose.position + object.pose.orientation * local, Vec3::Zero()};
      truth = scene.touch(tool, memory);
    }
    ASSERT_GT(truth.elastic.norm(), 3.0);
    ASSERT_GT(truth.frictional.norm(), 0.1);
    LocalContact late;
    late.use(surfaces.get());
    late.take(model_at(scene, tool.position, memory));
    const Command here = late.touch(tool, 0.0, kTick).command;
    EXPECT_LT((here.elastic - truth.elastic).norm(), 1e-6);
    EXPECT_LT((here.frictional - truth.frictional).norm(), 0.02 * truth.frictional.norm());
  }
}

TEST(MeshSurfaces, ReachFarWherePatchesDoNot) {
  const Scene scene = of(ring());
  TouchMemory memory = scene.memory();
  const Vec3 over = way(scene.objects()[0], 0.0) + Vec3(0, 0, 0.01);
  EXPECT_LT(local_model(scene, over, memory).reach, 0.02);
  const LocalModel whole = model_at(scene, over, memory);
  EXPECT_EQ(whole.reach, kModelReach);
  ASSERT_EQ(whole.count, 1);
  EXPECT_TRUE(whole.patches[0].whole);
}

TEST(MeshSurfaces, WithoutThemTheModelIsNotValid) {
  const Scene scene = of(ring());
  const auto surfaces = surfaces_of(scene);
  TouchMemory memory = scene.memory();
  const Tool tool{way(scene.objects()[0], 0.0), Vec3::Zero()};
  scene.touch(tool, memory);
  LocalModel model = model_at(scene, tool.position, memory);
  LocalContact local;
  local.take(model);
  EXPECT_EQ(local.touch(tool, 0.0, kTick).weight, 0.0);
  local.use(surfaces.get());
  EXPECT_EQ(local.touch(tool, 0.0, kTick).weight, 1.0);
  model.surfaces = kVersion + 1;  // a version of another scene
  local.take(model);
  EXPECT_EQ(local.touch(tool, 0.0, kTick).weight, 0.0);
  EXPECT_EQ(local.touch(tool, 0.0, kTick).command, Command{});
}

TEST(MeshSurfaces, OnlyMeshesWithoutAHeightMapTravel) {
  Object plane;
  plane.shape = Plane{};
  EXPECT_FALSE(can_travel(plane));
  EXPECT_FALSE(surface_data(plane, 0, 0.0));
  EXPECT_TRUE(can_travel(ring()));
}

TEST(MeshSurfaces, WhatNoSceneCanHaveIsRefused) {
  SurfaceData data = surface_data_with_triangles(ring(), 3, 0.0);
  EXPECT_NO_THROW(mesh_surfaces(1, {data}));
  EXPECT_TRUE(mesh_surfaces(1, {data})->has(3));
  EXPECT_FALSE(mesh_surfaces(1, {data})->has(2));
  EXPECT_FALSE(mesh_surfaces(1, {data})->has(4));
  SurfaceData outside = data;
  outside.triangles[5][1] = static_cast<std::uint32_t>(outside.vertices.size());
  EXPECT_THROW(mesh_surfaces(1, {outside}), std::invalid_argument);
  SurfaceData flat = data;
  flat.triangles[5][1] = flat.triangles[5][0];
  EXPECT_THROW(mesh_surfaces(1, {flat}), std::invalid_argument);
  SurfaceData wild = data;
  wild.vertices[0].x() = std::nan("");
  EXPECT_THROW(mesh_surfaces(1, {wild}), std::invalid_argument);
}

TEST(MeshSurfaces, ATouchDoesNotAllocate) {
  const Scene scene = of(ring());
  const auto surfaces = surfaces_of(scene);
  TouchMemory memory = scene.memory();
  LocalContact local;
  const LocalModel model = model_at(scene, way(scene.objects()[0], 0.0), memory);
  const std::uint64_t before = test::allocations();
  local.use(surfaces.get());
  local.take(model);
  for (int n = 0; n < 500; ++n)
    local.touch({way(scene.objects()[0], n * kTick), Vec3::Zero()}, 0.0, kTick);
  EXPECT_EQ(test::allocations(), before);
}

}  // namespace
}  // namespace feltwire::mesh_surfaces_test
