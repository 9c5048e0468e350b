// Tests hollow meshes among bodies. Objects must pass through them or stay inside, and their mass
// must be right.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>
#include <sched.h>

#include "core/convex/decomposition.hpp"
#include "core/dynamics/world.hpp"
#include "core/mesh/mesh_surface.hpp"
#include "core/scene/mechanism.hpp"
#include "tests/core/scene_file/parts_scene.hpp"

namespace feltwire::parts_world_test {
namespace {

using test::mesh_text;
using test::torus;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

constexpr double kRing = 0.05, kTube = 0.015;  // [m]
constexpr double kGravity = 9.81;

class PartsWorld : public test::PartsScene {
 protected:
  PartsWorld() {
    write("ring.obj", torus(kRing, kTube, 48, 16));
    write("cup.obj", test::cup());
    write("ball.obj", icosphere(0.02, 2));
  }
};

const Vec3& place(const World& world, std::size_t object) {
  return world.objects()[object].pose.position;
}

// The ball touches nothing, so its movement must be a free fall.
TEST_F(PartsWorld, ABallFallsFreelyThroughARing) {
  const Scene s = scene(
      R"({ "name": "ball", "mass": 0.1, "position": [0, 0, 0.1] })",
      mesh_text("ring", "ring.obj") +
          R"(, { "name": "ball", "sphere": { "radius": 0.03 }, "body": "ball", "material": "m" })");
  EXPECT_THAT(s.warnings(), IsEmpty());
  World world(s);
  constexpr double kTick = 1e-3;
  for (int n = 1; n <= 250; ++n) {
    ASSERT_TRUE(world.step());
    ASSERT_NEAR(place(world, 1).z(), 0.1 - 0.5 * kGravity * kTick * kTick * n * (n + 1), 1e-12);
  }
  EXPECT_LT(place(world, 1).z(), -0.1);
}

// The ring slides down a slope until the rod in its hole holds it.
TEST_F(PartsWorld, ARingOnARodStaysOnIt) {
  constexpr double kRod = 0.012;
  const Scene s = scene(R"({ "name": "ring", "mass": 0.1, "position": [0, 0, 0.03] })",
                        R"({ "name": "floor", "plane": {}, "material": "m" },
  { "name": "rod", "cylinder": { "radius": 0.012, "length": 0.4 }, "material": "m" }, )" +
                            mesh_text("ring", "ring.obj", "", R"(, "body": "ring")"),
                        R"("gravity": [3, 0, -9.81], )");
  EXPECT_THAT(s.warnings(), IsEmpty());
  World world(s);
  const double play = kRing - kTube - kRod, tolerance = kPartTolerance * 2.0 * (kRing + kTube);
  for (int n = 0; n < 2000; ++n) {
    ASSERT_TRUE(world.step());
    ASSERT_LT(place(world, 2).head<2>().norm(), play + 1e-3) << n;
  }
  EXPECT_NEAR(place(world, 2).z(), kTube, tolerance);
  EXPECT_GT(place(world, 2).x(), play - tolerance - 1e-3);
  EXPECT_EQ(world.counters().resets, 0u);
}

// The scene requests a single hull, which has no hole.
TEST_F(PartsWorld, TheHullOfARingHasNoHole) {
  const Scene s = scene(
      R"({ "name": "ball", "mass": 0.1, "position": [0, 0, 0.1] })",
      mesh_text("ring", "ring.obj", R"(, "convex_parts": { "most": 1 })") +
          R"(, { "name": "ball", "sphere": { "radius": 0.03 }, "body": "ball", "material": "m" })");
  EXPECT_THAT(s.warnings(), IsEmpty());  // The scene requested the hull.
  EXPECT_EQ(s.mechanism()->model().ngeom, 2);
  World world(s);
  for (int n = 1; n <= 1000; ++n) ASSERT_TRUE(world.step());
  EXPECT_NEAR(place(world, 1).z(), kTube + 0.03, 1e-3);
  EXPECT_THAT(kept_in(scenes()), IsEmpty());
}

// The ball rolls to and fro as the slope turns. The cup must move with it.
TEST_F(PartsWorld, ACupHoldsABall) {
  constexpr double kBall = 0.02, kTolerance = 0.001;
  const Scene s = scene(
      R"({ "name": "cup", "mass": 0.2 }, { "name": "ball", "mass": 0.05, "position": [0.005, 0, 0.05] })",
      R"({ "name": "floor", "plane": {}, "material": "m" }, )" +
          mesh_text("cup", "cup.obj", R"(, "convex_parts": { "tolerance": 0.001 })",
                    R"(, "body": "cup")") +
          R"(, { "name": "ball", "sphere": { "radius": 0.02 }, "body": "ball", "material": "m" })");
  EXPECT_THAT(s.warnings(), IsEmpty());
  World world(s);
  for (int n = 0; n < 3000; ++n) {
    const double turned = 2e-3 * n;
    world.set_gravity(n < 1000 ? Vec3(0, 0, -kGravity)
                               : Vec3(std::cos(turned), std::sin(turned), -kGravity));
    ASSERT_TRUE(world.step());
    const Pose& cup = world.objects()[1].pose;
    const Vec3 in_cup = cup.orientation.conjugate() * (place(world, 2) - cup.position);
    ASSERT_LT(in_cup.head<2>().norm(), test::kCupInside - kBall + 1e-3) << n;
    if (n == 999) {
      EXPECT_NEAR(in_cup.z(), test::kCupBottom + kBall, kTolerance);
    }
  }
  EXPECT_EQ(world.counters().resets, 0u);
}

// The parts overlap and extend outside. The mass must still be the mass of the mesh.
TEST_F(PartsWorld, MassAndInertiaAreTheMeshs) {
  const auto model = [&](const std::string& parts) {
    const Scene s = scene(R"({ "name": "ring", "density": 2000, "position": [0, 0, 1] })",
                          mesh_text("ring", "ring.obj", parts, R"(, "body": "ring")"));
    const mjModel& m = s.mechanism()->model();
    std::vector<double> numbers{m.body_mass[1]};
    numbers.insert(numbers.end(), m.body_inertia + 3, m.body_inertia + 6);
    numbers.insert(numbers.end(), m.body_ipos + 3, m.body_ipos + 6);
    return std::pair(m.ngeom, numbers);
  };
  const auto whole = model(R"(, "convex_parts": { "most": 1 })"), parts = model("");
  EXPECT_EQ(whole.first, 1);
  EXPECT_GT(parts.first, 4);
  EXPECT_EQ(parts.second, whole.second);
  // The ring has 48 by 16 facets.
  const double volume = 2.0 * M_PI * M_PI * kRing * kTube * kTube;
  EXPECT_NEAR(parts.second[0], 2000 * volume, 0.04 * 2000 * volume);
}

std::vector<Vec3> run(const Scene& s) {
  World world(s);
  std::vector<Vec3> places;
  for (int n = 0; n < 600; ++n) {
    world.step();
    places.push_back(place(world, 1));
  }
  return places;
}

TEST_F(PartsWorld, AreTheSameBitsReadOrComputedOnAnyNumberOfCores) {
  const std::string body = R"({ "name": "ring", "mass": 0.1, "position": [0.02, 0.01, 0.05] })";
  const std::string objects =
      R"({ "name": "floor", "plane": {}, "material": "m" }, )" +
      mesh_text("ring", "ring.obj", "", R"(, "body": "ring", "orientation": [0.9, 0.3, 0.2, 0.1])");
  const Scene computed = scene(body, objects);
  EXPECT_THAT(computed.notes(), Contains(AllOf(HasSubstr("computed in"), HasSubstr("kept in"))));
  const std::vector<Vec3> places = run(computed);
  const Scene read = scene(body, objects);
  EXPECT_THAT(read.notes(), Contains(AllOf(HasSubstr("read from"), Not(HasSubstr("computed")))));
  EXPECT_EQ(run(read), places);
  // The result on a single core must be equal.
  const auto kept = kept_in(scenes());
  ASSERT_EQ(kept.size(), 1u);
  const std::string bytes = test::text_of(kept[0]);
  std::filesystem::remove(kept[0]);
  cpu_set_t all, one;
  CPU_ZERO(&all);
  ASSERT_EQ(sched_getaffinity(0, sizeof all, &all), 0);
  CPU_ZERO(&one);
  for (int cpu = 0; CPU_COUNT(&one) == 0; ++cpu)
    if (CPU_ISSET(cpu, &all)) CPU_SET(cpu, &one);
  ASSERT_EQ(sched_setaffinity(0, sizeof one, &one), 0);
  const Scene alone = scene(body, objects);
  sched_setaffinity(0, sizeof all, &all);
  EXPECT_THAT(alone.notes(), Contains(HasSubstr("computed in")));
  EXPECT_EQ(test::text_of(kept[0]), bytes);
  EXPECT_EQ(run(alone), places);
}

// A recording contains the parts. A replay therefore needs neither the disk nor the computation.
TEST_F(PartsWorld, KeptScenesHaveThem) {
  write("ring.obj", torus(kRing, kTube, 48, 16));
  const auto file =
      write_scene(R"({ "name": "ring", "mass": 0.1, "position": [0.02, 0.01, 0.05] })",
                  R"({ "name": "floor", "plane": {}, "material": "m" }, )" +
                      mesh_text("ring", "ring.obj", "", R"(, "body": "ring")"));
  for (const bool again : {false, true}) {
    const Scene s = load_scene_and_keep(file);
    EXPECT_THAT(s.notes(), Contains(HasSubstr(again ? "read from" : "computed in")));
    CapturedFiles files = *s.files();
    std::vector<std::string> names;
    for (const auto& [name, bytes] : files.files) names.push_back(name);
    EXPECT_THAT(names, ::testing::ElementsAre("ring.obj", "ring.obj.m.auto.64.convex", "s.json"));
    const std::vector<Vec3> places = run(s);
    const Scene replayed = load_kept_scene(files);
    EXPECT_THAT(replayed.notes(), Contains(HasSubstr("read from ring.obj.m.auto.64.convex")));
    EXPECT_EQ(run(replayed), places);
    // The recording is older or damaged. The loader must compute the parts and write nothing.
    files.files["ring.obj.m.auto.64.convex"] = "nonsense";
    const Scene damaged = load_kept_scene(files);
    EXPECT_THAT(damaged.notes(), Contains(HasSubstr("is no file of convex parts")));
    EXPECT_EQ(run(damaged), places);
    files.files.erase("ring.obj.m.auto.64.convex");
    const Scene without = load_kept_scene(files);
    EXPECT_THAT(without.notes(), Contains(AllOf(HasSubstr("computed"), Not(HasSubstr("kept")))));
    EXPECT_EQ(run(without), places);
  }
  EXPECT_EQ(kept_in(scenes()).size(), 1u);
}

// The loader must not decompose a mesh that no body can hit. It must not decompose a convex mesh
// either.
TEST_F(PartsWorld, NothingIsCutThatNobodyRunsInto) {
  const std::string ring = mesh_text("ring", "ring.obj");
  const std::string moved = mesh_text("ring", "ring.obj", "", R"(, "body": "b")");
  const std::string still = R"("name": "b", "mass": 1, "position": [0, 0, 1])";
  EXPECT_THAT(scene("", ring).notes(), IsEmpty());
  EXPECT_THAT(scene("{" + still + R"(, "collides": false })", moved).notes(), IsEmpty());
  EXPECT_THAT(
      scene("{" + still + " }", mesh_text("ball", "ball.obj", "", R"(, "body": "b")")).notes(),
      IsEmpty());
  EXPECT_THAT(
      scene("{" + still + " }", mesh_text("ball", "ball.obj", "", R"(, "body": "b")") + ", " +
                                    mesh_text("ring", "ring.obj", "", R"(, "felt_from": "inside")"))
          .notes(),
      IsEmpty());
  EXPECT_THAT(kept_in(scenes()), IsEmpty());
  EXPECT_THAT(scene("{" + still + " }", moved).notes(), Contains(HasSubstr("object 'ring'")));
}

// Many rings use one mesh. The loader must decompose the mesh once, and MuJoCo must have the parts
// once.
TEST_F(PartsWorld, ObjectsOfOneMeshShareItsParts) {
  std::string bodies, objects;
  for (int i = 0; i < 20; ++i) {
    const std::string n = std::to_string(i);
    bodies += (i == 0 ? "" : ", ") + (R"({ "name": "b)" + n) + R"(", "mass": 0.1, "position": [)" +
              n + ", 0, 0] }";
    objects +=
        (i == 0 ? "" : ", ") + mesh_text("r" + n, "ring.obj", "", R"(, "body": "b)" + n + "\"");
  }
  const Scene s = scene(bodies, objects);
  EXPECT_EQ(s.notes().size(), 1u);
  const mjModel& model = s.mechanism()->model();
  EXPECT_EQ(model.ngeom, 20 * model.nmesh);
  EXPECT_GT(model.nmesh, 4);
}

}  // namespace
}  // namespace feltwire::parts_world_test
