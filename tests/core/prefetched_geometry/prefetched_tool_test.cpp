// A client has a complete tool with a body and the solids. The client's force must equal the
// scene's at every delay.

#include <gtest/gtest.h>

#include <cmath>
#include <deque>
#include <functional>
#include <numbers>
#include <stdexcept>

#include "core/local_model/local_body.hpp"
#include "core/local_model_extraction/body_points.hpp"
#include "core/local_model_extraction/prefetched_tool_data.hpp"
#include "core/mesh/mesh_surface.hpp"
#include "core/mesh/tessellation.hpp"
#include "core/point_shell/shell_surroundings.hpp"
#include "core/prefetched_geometry/make_prefetched_tool.hpp"
#include "tests/core/massive_tool.hpp"
#include "tests/core/support.hpp"
#include "tests/support/allocation_counter.hpp"

namespace feltwire::prefetched_tool_test {
namespace {

constexpr std::uint32_t kVersion = 3;

/// Returns a box as the tool between a ring, a ball and the floor, all with friction and damping.
Scene room(const BodyTool& tool) {
  std::vector<Object> objects = {test::object(Plane{}),
                                 test::object(Torus{0.05, 0.02}, Vec3(0.02, 0.0, 0.01)),
                                 test::object(Sphere{0.03}, Vec3(-0.03, 0.02, 0.0))};
  for (Object& o : objects) {
    o.name = "o" + std::to_string(&o - objects.data());
    o.material.damping = 2.0;
    o.material.static_friction = 0.4;
    o.material.dynamic_friction = 0.3;
    o.material.viscous_friction = 1.0;
  }
  objects[1].pose.orientation = Quaternion(Eigen::AngleAxisd(0.3, Vec3(1, 2, 0).normalized()));
  Scene scene("room", objects);
  scene.set_tool({.body = std::make_shared<BodyTool>(tool)});
  return scene;
}

std::vector<SolidData> solids_of(const ToolView& view, const KnownSurfaces& known) {
  std::vector<SolidData> solids;
  for (std::size_t i = 0; i < known.size(); ++i)
    if (known[i]) solids.push_back(solid_data_with_triangles(view, static_cast<std::uint16_t>(i)));
  return solids;
}

std::shared_ptr<const PrefetchedTool> fetched(const ToolView& view, const KnownSurfaces& known) {
  return make_prefetched_tool(kVersion, body_data(*view.tool().body, std::nullopt),
                              solids_of(view, known));
}

ShellContact of_scene(const ToolView& view, const Pose& tool) {
  return ShellSurroundings(view.tool().body->shell(), view.tool().body->contact_area(),
                           view.objects())
      .contact(tool);
}

TEST(PrefetchedTool, MeetsItsSolidsAsTheSceneDoes) {
  const Scene scene = room(test::tool(1500));
  const auto whole = fetched(scene, {true, true, true});
  EXPECT_EQ(whole->radius, scene.tool().body->shell().radius);
  EXPECT_EQ(whole->coupling.stiffness, scene.tool().body->coupling().stiffness);
  test::Random random(4);
  int touched = 0;
  for (int i = 0; i < 300; ++i) {
    const Pose tool = moved({}, 0.02 * random.direction(), random.direction());
    const ShellContact a = of_scene(scene, tool), b = whole->solids->contact(tool);
    touched += a.touching > 0 ? 1 : 0;
    EXPECT_EQ(a.touching, b.touching);
    EXPECT_LE((a.wrench - b.wrench).norm(), 1e-9 * a.wrench.norm());
    EXPECT_LE((a.stiffness - b.stiffness).norm(), 1e-9 * a.stiffness.norm());
    ASSERT_EQ(a.grip_count, b.grip_count);
    for (std::size_t k = 0; k < a.grip_count; ++k)
      EXPECT_NEAR(a.patches[k].load, b.patches[k].load, 1e-9 * a.patches[k].load);
  }
  EXPECT_GT(touched, 250);
}

// The model must omit points of objects that the client has. Such objects must not limit the valid
// radius.
TEST(PrefetchedTool, ItsModelHasOnlyWhatTheReceiverHasNot) {
  const Scene scene = room(test::tool(1500));
  const Pose device{Vec3(0, 0, 0.008), Quaternion::Identity()};
  BodyMemory memory;
  for (int i = 0; i < 50; ++i) scene.touch(device, Vec3::Zero(), 1e-3, memory);
  const BodyModel planes = body_model(scene, device, memory);
  EXPECT_EQ(planes.solids, 0u);
  EXPECT_GT(planes.patch_count, 1);
  const BodyModel none = body_model(scene, device, memory, kVersion, {true, true, true});
  EXPECT_EQ(none.solids, kVersion);
  EXPECT_EQ(none.count, 0);
  EXPECT_EQ(none.reach, kModelReach);
  const BodyModel some = body_model(scene, device, memory, kVersion, {false, true, true});
  EXPECT_EQ(some.solids, kVersion);
  EXPECT_GT(some.count, 0);
  EXPECT_LE(some.reach, kBodyReach);
  for (const BodyPatch& patch : some.surfaces()) EXPECT_EQ(patch.object, 0);
}

// The client's objects and the planes of the others must add up to the scene at the model's pose.
TEST(PrefetchedTool, AddsThePlanesOfTheRest) {
  const Scene scene = room(test::tool(1500));
  const Pose device{Vec3(0, 0, 0.008), Quaternion(Eigen::AngleAxisd(0.1, Vec3::UnitX()))};
  BodyMemory memory;
  for (int i = 0; i < 50; ++i) scene.touch(device, Vec3::Zero(), 1e-3, memory);
  const ShellContact all = of_scene(scene, memory.pose);
  ASSERT_EQ(all.part_count, 3u);  // The tool touches every object.
  const KnownSurfaces known = {false, true, true};
  const auto whole = fetched(scene, known);
  const BodyModel model = body_model(scene, device, memory, kVersion, known);
  const ShellContact sum =
      ModelledSurroundings(model, 0.0, 1e-3, whole->solids.get()).contact(memory.pose);
  EXPECT_LE((sum.wrench - all.wrench).norm(), 1e-6 * all.wrench.norm());
  ASSERT_EQ(sum.part_count, 3u);
  Vec6 parts = Vec6::Zero();
  for (const ObjectWrench& part : sum.touched()) parts += part.wrench;
  EXPECT_LE((parts - sum.wrench).norm(), 1e-9 * all.wrench.norm());
}

/// Returns the pose of a hand that rocks and slides among the solids.
Pose hand_at(double t) {
  const double a = 2.0 * std::numbers::pi * t;
  return {Vec3(0.01 * std::sin(a), 0.004 * std::cos(2.0 * a), 0.009 + 0.003 * std::sin(3.0 * a)),
          turned(Quaternion::Identity(), 0.3 * Vec3(std::sin(a), std::cos(1.5 * a), 0.2))};
}

/// Errors over 2 s of this movement, with models `delay` ticks late. Each error is the RMS error of
/// the torque divided by the RMS torque: for the late reply, and for the complete body.
struct Errors {
  double late = 0.0, whole = 0.0;
};
Errors followed(const Scene& scene, std::size_t delay) {
  const KnownSurfaces known(scene.objects().size(), true);
  const auto whole = fetched(scene, known);
  LocalBody local;
  local.use(whole.get());
  std::deque<std::pair<Command, BodyModel>> on_the_way;
  BodyMemory memory;
  Errors sum;
  double size = 0.0;
  Command late;
  for (int n = 0; n < 2000; ++n) {
    const Pose device = hand_at(1e-3 * n);
    const Command now = scene.touch(device, Vec3::Zero(), 1e-3, memory);
    on_the_way.emplace_back(now, body_model(scene, device, memory, kVersion, known));
    if (on_the_way.size() > delay) {
      late = on_the_way.front().first;
      local.take(on_the_way.front().second, delay);
      on_the_way.pop_front();
    }
    const BodyForce force = local.touch(device, 1e-3 * static_cast<double>(delay), 1e-3);
    if (n < 300) continue;
    EXPECT_EQ(force.weight, 1.0);
    sum.late += (late.torque - now.torque).squaredNorm();
    sum.whole += (force.command.torque - now.torque).squaredNorm();
    size += now.torque.squaredNorm();
  }
  return {std::sqrt(sum.late / size), std::sqrt(sum.whole / size)};
}

// Planes describe curved solids and edges badly. The remaining error is the history of friction.
TEST(PrefetchedTool, OverADelayIsTheScene) {
  const Scene scene = room(test::tool(600));
  const Errors errors = followed(scene, 50);
  EXPECT_GT(errors.late, 0.3);
  EXPECT_LT(errors.whole, 0.01 * errors.late);
}

TEST(PrefetchedTool, AToolWithMassIsMovedAtTheClient) {
  for (const auto rule : {ToolIntegration::implicit, ToolIntegration::midpoint}) {
    ToolInertia inertia;
    inertia.gravity = Vec3(0, 0, -test::kGravity);
    inertia.damping = 5.0;
    inertia.rotational_damping = 0.002;
    inertia.integration = rule;
    const Scene scene = room(test::massive(0.1, {}, inertia, 600));
    BodyMemory placed;
    placed.placed = true;
    // The local model's valid radius matters only for a client without the body.
    EXPECT_EQ(body_model(scene, {}, placed).reach, 0.0);
    const Errors errors = followed(scene, 50);
    EXPECT_LT(10.0 * errors.whole, errors.late);
  }
}

// A model for another version must have no weight. The reply then gives the force.
TEST(PrefetchedTool, OfAnotherVersionIsNotUsed) {
  const Scene scene = room(test::tool(600));
  const auto whole = fetched(scene, {true, true, true});
  const Pose device{Vec3(0, 0, 0.008), Quaternion::Identity()};
  BodyMemory memory;
  scene.touch(device, Vec3::Zero(), 1e-3, memory);
  LocalBody local;
  local.use(whole.get());
  for (const std::uint32_t version : {kVersion + 1, kVersion}) {
    local.take(body_model(scene, device, memory, version, {true, true, true}));
    EXPECT_EQ(local.has_whole(), version == kVersion);
    EXPECT_EQ(local.touch(device, 0.0, 1e-3).weight, version == kVersion ? 1.0 : 0.0);
  }
  local.use(nullptr);
  EXPECT_EQ(local.touch(device, 0.0, 1e-3).weight, 0.0);
}

TEST(PrefetchedTool, NeverAllocatesOnceItIsMade) {
  const Scene scene = room(test::tool(600));
  const KnownSurfaces known = {true, false, true};
  const auto whole = fetched(scene, known);
  const Pose device{Vec3(0, 0, 0.008), Quaternion::Identity()};
  BodyMemory memory;
  LocalBody local;
  const std::size_t before = test::allocations();
  local.use(whole.get());
  for (int i = 0; i < 100; ++i) {
    scene.touch(device, Vec3::Zero(), 1e-3, memory);
    local.take(body_model(scene, device, memory, kVersion, known), 5);
    local.touch(device, 0.01, 1e-3);
  }
  EXPECT_EQ(test::allocations(), before);
}

// The client must use the server's grid of a mesh.
TEST(PrefetchedTool, MeetsAMeshAsTheSceneDoes) {
  Object bumpy = test::object(Mesh{std::make_shared<MeshSurface>(TriangleMesh(icosphere(0.05, 3)))},
                              Vec3(0.0, 0.0, -0.055));
  bumpy.name = "bumpy";
  bumpy.material.static_friction = bumpy.material.dynamic_friction = 0.3;
  Scene scene("room", {bumpy});
  scene.set_tool({.body = std::make_shared<BodyTool>(test::tool(600))});
  const auto whole = fetched(scene, {true});
  test::Random random(4);
  for (int i = 0; i < 100; ++i) {
    const Pose tool = moved({}, 0.01 * random.direction(), random.direction());
    const ShellContact a = of_scene(scene, tool), b = whole->solids->contact(tool);
    EXPECT_LE((a.wrench - b.wrench).norm(), 1e-5 * a.wrench.norm() + 1e-7) << i;
  }
  const Errors errors = followed(scene, 50);
  EXPECT_LT(20.0 * errors.whole, errors.late);
}

TEST(PrefetchedTool, OnlyABodyOfPointsAmongPrimitivesAndMeshesTravels) {
  const BodyTool points = test::tool(500);
  EXPECT_TRUE(can_travel(points));
  EXPECT_FALSE(can_travel(test::tool(kMostBodyPoints + 1)));
  const BodyTool polygons(test::box_shell(500), {}, test::kFace, {},
                          std::make_shared<PolygonBody>());
  EXPECT_FALSE(can_travel(polygons));
  std::vector<Object> objects = {
      test::object(Box{Vec3(1, 1, 1)}), test::object(test::grid_of(Sphere{0.03}, 0.002)),
      test::object(Mesh{std::make_shared<MeshSurface>(TriangleMesh(icosphere(0.03, 2)))})};
  for (Object& o : objects) o.name = "o" + std::to_string(&o - objects.data());
  Scene scene("room", objects);
  scene.set_tool({.body = std::make_shared<BodyTool>(points)});
  EXPECT_TRUE(can_travel(scene, 0));
  EXPECT_FALSE(can_travel(scene, 1));  // The client has only its samples.
  EXPECT_TRUE(can_travel(scene, 2));
  EXPECT_FALSE(can_travel(scene, 3));
}

// A server may send any number.
TEST(PrefetchedTool, NumbersThatAreNoneOfABodyAreRefused) {
  const double nan = std::nan("");
  const BodyTool tool = test::tool(100);
  const BodyData good = body_data(tool, std::nullopt);
  const SolidData box{.object = 0, .shape = Box{Vec3(1, 1, 1)}, .pose = {}, .material = {}};
  EXPECT_NO_THROW(make_prefetched_tool(1, good, {box}));
  const std::vector<std::function<void(BodyData&)>> spoilt = {
      [](BodyData& b) { b.points.clear(); },
      [=](BodyData& b) { b.points[7].y() = nan; },
      [](BodyData& b) { b.points.assign(3, Vec3::Zero()); },
      [](BodyData& b) { b.area = 0.0; },
      [=](BodyData& b) { b.contact_area = nan; },
      [](BodyData& b) { b.coupling.stiffness = -1.0; },
      [](BodyData& b) { b.coupling.max_torque = 0.0; },
      [](BodyData& b) { b.inertia.mass = -1.0; },
      [](BodyData& b) { b.inertia.mass = 1.0; },  // The inertia is missing.
      [=](BodyData& b) {
        b.inertia.mass = 1.0;
        b.inertia.inertia.setIdentity();
        b.inertia.gravity.z() = nan;
      },
      [](BodyData& b) {
        b.inertia.mass = 1.0;
        b.inertia.inertia.setIdentity();
        b.inertia.damping = -1.0;
      }};
  for (std::size_t i = 0; i < spoilt.size(); ++i) {
    BodyData bad = good;
    spoilt[i](bad);
    EXPECT_THROW(make_prefetched_tool(1, bad, {box}), std::invalid_argument) << i;
  }
  const std::vector<std::function<void(SolidData&)>> solids = {
      [](SolidData& s) { s.shape = Box{Vec3(1, 0, 1)}; },
      [=](SolidData& s) { s.shape = Sphere{nan}; },
      [](SolidData& s) {
        s.shape = Torus{0.01, 0.02};
      },
      [=](SolidData& s) { s.pose.position.x() = nan; },
      [](SolidData& s) { s.material.stiffness = 0.0; },
      [](SolidData& s) { s.material.dynamic_friction = 1.0; },
      [=](SolidData& s) { s.material.damping = nan; },
      [](SolidData& s) { s.shape = test::grid_of(Sphere{0.03}, 0.002); },
      [](SolidData& s) {  // The mesh has a hole.
        s.mesh = icosphere(0.03, 1);
        s.mesh.triangles.pop_back();
      }};
  for (std::size_t i = 0; i < solids.size(); ++i) {
    SolidData bad = box;
    solids[i](bad);
    EXPECT_THROW(make_prefetched_tool(1, good, {bad}), std::invalid_argument) << i;
  }
}

}  // namespace
}  // namespace feltwire::prefetched_tool_test
