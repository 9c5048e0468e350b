// Tests grids and tools in scene files.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "core/grid/distance_grid.hpp"
#include "core/local_model_extraction/extract.hpp"
#include "core/mesh/mesh_file.hpp"
#include "core/mesh/tessellation.hpp"
#include "core/scene/scene_cost_report.hpp"
#include "core/scene_file/load_scene.hpp"
#include "core/tool/body_tool.hpp"
#include "tests/core/scene_text.hpp"
#include "tests/support/allocation_counter.hpp"
#include "tests/support/meshes.hpp"

namespace feltwire::field_scene_test {
namespace {

using test::error_of;

using ::testing::HasSubstr;

/// Returns a scene of one object, with its shape on line 4 and the scene's tool on line 5.
std::string scene_text(const std::string& shape, const std::string& tool = "") {
  return "{\n\"name\": \"s\", \"materials\": [{ \"name\": \"m\", \"stiffness\": 1000 }],\n"
         "\"objects\": [{ \"name\": \"o\", \"material\": \"m\",\n" +
         shape + " }]" + (tool.empty() ? "" : ",\n\"tool\": " + tool) + "\n}";
}

TEST(FieldScene, AGridOfABallIsFeltAsTheBall) {
  const Scene exact = parse_scene(scene_text(R"("sphere": { "radius": 0.03 })"), "s.json");
  const Scene sampled = parse_scene(
      scene_text(R"("grid": { "sphere": { "radius": 0.03 }, "resolution": 1e-3 })"), "s.json");
  EXPECT_FALSE(sampled.requirements().rotation);
  TouchMemory a = exact.memory(), b = sampled.memory();
  for (int i = 0; i < 1000; ++i) {
    const Vec3 p = Vec3(0.001 * i - 0.5, 0.2, 0.3).normalized() * (0.028 + 2e-6 * i);
    EXPECT_LT(
        (exact.touch({p, Vec3::Zero()}, a).elastic - sampled.touch({p, Vec3::Zero()}, b).elastic)
            .norm(),
        5e-3)
        << i;
  }
  for (const double z : {0.029, 0.033}) {
    const LocalModel near = local_model(sampled, Vec3(0, 0, z), b);
    ASSERT_EQ(near.count, 1);
    EXPECT_NEAR(near.patches[0].point.z(), 0.03, 1e-4);
    EXPECT_GT(near.reach, 0.01);
  }
}

TEST(FieldScene, AGridOfAMeshFile) {
  const auto folder = std::filesystem::path(::testing::TempDir()) / "feltwire_field_scene";
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "ball.obj") << obj_text(icosphere(30.0, 3));
  std::ofstream(folder / "s.json")
      << scene_text(R"("grid": { "file": "ball.obj", "scale": 0.001, "resolution": 2e-3 })",
                    R"({ "body": { "file": "ball.obj", "scale": 1e-4, "points": 500 } })");
  const Scene scene = load_scene(folder / "s.json");
  TouchMemory memory = scene.memory();
  EXPECT_NEAR(scene.touch({Vec3(0, 0, 0.028), Vec3::Zero()}, memory).elastic.z(), 2.0, 0.3);
  ASSERT_TRUE(scene.tool().body);
  EXPECT_NEAR(scene.tool().body->shell().radius, 0.003, 1e-4);
  EXPECT_TRUE(scene.requirements().rotation);
  EXPECT_THAT(
      error_of(scene_text(R"("grid": { "file": "none.obj", "scale": 1, "resolution": 1 })")),
      HasSubstr("none.obj"));
  std::filesystem::remove_all(folder);
}

TEST(FieldScene, ABodyGivesForceAndTorque) {
  const Scene scene =
      parse_scene(scene_text(R"("plane": {})", R"({ "body": { "box": { "size": [0.06, 0.04, 0.02] },
        "position": [0.03, 0, 0], "points": 5000, "contact_area": 0.0024,
        "coupling": { "stiffness": 2000, "max_force": 5 } } })"),
                  "s.json");
  EXPECT_EQ(scene.tool().body->coupling().stiffness, 2000.0);
  EXPECT_EQ(scene.tool().body->coupling().max_force, 5.0);
  BodyMemory memory;
  scene.touch({Vec3(0, 0, 0.02), Quaternion::Identity()}, Vec3::Zero(), 1e-3, memory);
  Command c;
  for (int i = 0; i < 20; ++i)
    c = scene.touch({Vec3(0, 0, 0.0095), Quaternion::Identity()}, Vec3::Zero(), 1e-3, memory);
  // The hand holds the box at its end. The floor lifts the middle of the box and causes a torque.
  EXPECT_GT(c.elastic.z(), 0.05);
  EXPECT_LT(c.torque.y(), -1e-4);
  EXPECT_NEAR(c.torque.x(), 0.0, 1e-4);
  TouchMemory contacts = scene.memory();
  EXPECT_EQ(local_model(scene, Vec3(0, 0, 0.01), contacts).reach, 0.0);
}

// A body touches a mesh through a distance grid, which the loader samples.
TEST(FieldScene, ABodyTouchesAMeshAsAGrid) {
  const auto folder = std::filesystem::path(::testing::TempDir()) / "feltwire_body_on_mesh";
  std::filesystem::create_directories(folder);
  // The thin plate has a flat grid with 128 steps across.
  std::ofstream(folder / "plate.obj")
      << obj_text(test::moved(test::box({30.0, 30.0, 3.0}), {0.0, 0.0, 27.0}));
  TriangleSoup open = icosphere(30.0, 1);
  open.triangles.pop_back();
  std::ofstream(folder / "open.obj") << obj_text(open);
  const auto text = [](const std::string& file) {
    return scene_text("\"mesh\": { \"file\": \"" + file + "\", \"unit\": \"mm\" }",
                      R"({ "body": { "sphere": { "radius": 0.01 }, "points": 2000,
                                     "contact_area": 1e-4 } })");
  };
  std::ofstream(folder / "s.json") << text("plate.obj");
  std::ofstream(folder / "open.json") << text("open.obj");
  const Scene scene = load_scene(folder / "s.json");
  ASSERT_EQ(scene.views()[0].sampled().size(), 1u);
  EXPECT_NEAR(scene.views()[0].sampled()[0].resolution, 0.06 / 128.0, 1e-5);
  EXPECT_THAT(describe_costs(scene), HasSubstr("grid of distances for the tool's body: mesh o"));
  BodyMemory memory;
  Command c;
  for (const double z : {0.045, 0.0395, 0.0385, 0.038})
    for (int i = 0; i < 10; ++i)
      c = scene.touch({Vec3(0, 0, z), Quaternion::Identity()}, Vec3::Zero(), 1e-3, memory);
  EXPECT_GT(c.elastic.z(), 0.1);
  EXPECT_LT(c.elastic.head<2>().norm(), 0.05 * c.elastic.z());
  try {
    load_scene(folder / "open.json");
    ADD_FAILURE() << "an open mesh has no inside";
  } catch (const FileError& error) {
    EXPECT_THAT(error.what(), HasSubstr("object 'o'"));
    EXPECT_THAT(error.what(), HasSubstr("is open at 3 edges"));
  }
  std::filesystem::remove_all(folder);
}

TEST(FieldScene, ABallForATool) {
  const Scene scene =
      parse_scene(scene_text(R"("plane": {})", R"({ "sphere": { "radius": 0.005 } })"), "s.json");
  TouchMemory memory = scene.memory();
  EXPECT_NEAR(scene.touch({Vec3(0, 0, 0.003), Vec3::Zero()}, memory).elastic.z(), 2.0, 1e-12);
  const LocalModel model = local_model(scene, Vec3(0, 0, 0.003), memory);
  ASSERT_EQ(model.count, 1);
  // height of the plane below the body's centre
  EXPECT_NEAR(model.patches[0].point.z(), 0.005, 1e-15);
}

TEST(FieldScene, EveryMistakeIsNamed) {
  const auto grid = [](const std::string& fields) {
    return error_of(scene_text("\"grid\": { " + fields + " }"));
  };
  EXPECT_EQ(grid(R"("sphere": { "radius": 1 }, "resolution": 0.1)"), "no error");
  EXPECT_THAT(grid(R"("resolution": 0.1)"),
              HasSubstr("s.json:4: objects[0].grid: has no solid; give exactly one of"));
  EXPECT_THAT(grid(R"("sphere": { "radius": 1 })"),
              HasSubstr("s.json:4: objects[0].grid: resolution: must be above zero"));
  EXPECT_THAT(grid(R"("sphere": { "radius": 1 }, "resolution": 1e-6)"),
              HasSubstr("more than the limit of 1024 MiB; give a larger one"));
  EXPECT_THAT(grid(R"("sphere": { "radius": -1 }, "resolution": 0.1)"),
              HasSubstr("objects[0].grid.sphere.radius: must be above zero"));
  EXPECT_THAT(grid(R"("box": {}, "resolution": 0.1)"),
              HasSubstr("objects[0].grid.box.size: is missing"));
  EXPECT_THAT(grid(R"("sphere": { "radius": 1 }, "capsule": { "radius": 1, "length": 1 },
                      "resolution": 0.1)"),
              HasSubstr("objects[0].grid.capsule: is a second solid beside sphere"));
  EXPECT_THAT(grid(R"("file": "x.stl", "resolution": 0.1)"),
              HasSubstr("objects[0].grid.scale: must be above zero [m per unit of the file]"));
  EXPECT_THAT(error_of(scene_text(R"("plane": {}, "grid": { "sphere": { "radius": 1 },
                                     "resolution": 0.1 })")),
              HasSubstr("objects[0].grid: is a second shape beside plane"));

  const auto tool = [](const std::string& fields) {
    return error_of(scene_text(R"("plane": {})", fields));
  };
  EXPECT_THAT(tool("{}"), HasSubstr("s.json:5: tool: holds nothing"));
  EXPECT_THAT(tool(R"({ "sphere": { "radius": -1 } })"),
              HasSubstr("tool.sphere.radius: must be above zero"));
  EXPECT_THAT(tool(R"({ "sphere": { "radius": 1 }, "body": { "sphere": { "radius": 1 } } })"),
              HasSubstr("is a second tool beside body"));
  EXPECT_THAT(tool(R"({ "body": { "sphere": { "radius": 1 }, "points": 0 } })"),
              HasSubstr("tool.body: points: must be 1 to 1000000, are 0"));
  EXPECT_THAT(tool(R"({ "body": { "sphere": { "radius": 1 }, "contact_area": -1 } })"),
              HasSubstr("tool.body: contact_area: must be above zero"));
  EXPECT_THAT(tool(R"({ "body": { "sphere": { "radius": 1 }, "coupling": { "stiffness": 0 } } })"),
              HasSubstr("tool.body: stiffness: must be above zero"));
  EXPECT_THAT(tool(R"({ "body": { "sphere": { "radius": 1 }, "orientation": [0, 0, 0, 0] } })"),
              HasSubstr("tool.body.orientation: is no rotation"));
  EXPECT_THAT(error_of(scene_text(R"("grid": { "sphere": { "radius": 1 }, "resolution": 0.01 })",
                                  R"({ "sphere": { "radius": 0.1 } })")),
              HasSubstr("too large for object 'o'"));
}

}  // namespace
}  // namespace feltwire::field_scene_test
