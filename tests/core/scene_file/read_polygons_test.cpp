// Tests polygonal tools in a scene file.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "core/dynamics/world.hpp"
#include "core/mesh/tessellation.hpp"
#include "core/scene/scene_cost_report.hpp"
#include "core/tool/body_tool.hpp"
#include "tests/core/scene_text.hpp"
#include "tests/support/temporary_folder.hpp"

namespace feltwire::read_polygons_test {
namespace {

using test::error_of;
using ::testing::AllOf;
using ::testing::HasSubstr;

std::string scene(const std::string& body,
                  const std::string& shape = R"("box": { "size": [0.2, 0.2, 0.1] })") {
  return R"({ "name": "s", "tool": { "body": { )" + body + R"( } },
    "materials": [{ "name": "m", "stiffness": 1000 }],
    "objects": [{ "name": "o", )" +
         shape + R"(, "material": "m" }] })";
}

const std::string kBrick = R"("box": { "size": [0.06, 0.04, 0.02] })";

TEST(ReadPolygons, AToolOfPolygonsPressesFlatAsItsMaterialSays) {
  const Scene read = parse_scene(
      scene(kBrick +
            R"(, "contact": "polygons", "contact_area": 2.4e-3, "position": [0, 0, 0.01])"),
      "s.json");
  ASSERT_NE(read.tool().body->polygons(), nullptr);
  EXPECT_EQ(read.tool().body->polygons()->parts.size(), 1u);
  EXPECT_TRUE(read.requirements().rotation);
  BodyMemory memory;
  Command command;
  for (int i = 0; i <= 50; ++i)
    command = read.touch({Vec3(0, 0, 0.05 + 1e-3 - 1e-4 * i), Quaternion::Identity()}, Vec3::Zero(),
                         1e-3, memory);
  EXPECT_NEAR(command.force().z(), 500.0 * 4e-3, 1e-3);  // two springs of 1 kN/m in series
  EXPECT_LT(command.torque.norm(), 1e-6);
  // Points are the default.
  EXPECT_EQ(parse_scene(scene(kBrick), "s.json").tool().body->polygons(), nullptr);
}

TEST(ReadPolygons, MeshesAreCutIntoParts) {
  const test::TemporaryFolder folder;
  // The L shape consists of two boxes.
  std::ofstream(folder / "angle.obj")
      << "v 0 0 0\nv 30 0 0\nv 30 10 0\nv 10 10 0\nv 10 30 0\nv 0 30 0\n"
         "v 0 0 20\nv 30 0 20\nv 30 10 20\nv 10 10 20\nv 10 30 20\nv 0 30 20\n"
         "f 4 3 2\nf 4 2 1\nf 4 1 6\nf 4 6 5\nf 10 8 9\nf 10 7 8\nf 10 12 7\nf 10 11 12\n"
         "f 1 2 8 7\nf 2 3 9 8\nf 3 4 10 9\nf 4 5 11 10\nf 5 6 12 11\nf 6 1 7 12\n";
  const std::string angle = R"("mesh": { "file": "angle.obj", "unit": "mm" })";
  const Scene read = parse_scene(
      scene(R"("file": "angle.obj", "scale": 0.001, "contact": "polygons", "position": [1, 0, 0])",
            angle),
      (folder / "s.json").string());
  const PolygonBody& body = *read.tool().body->polygons();
  EXPECT_EQ(body.parts.size(), 2u);
  ASSERT_EQ(body.solids.size(), 1u);
  EXPECT_EQ(body.solids[0].parts.size(), 2u);
  EXPECT_THAT(describe_costs(read),
              HasSubstr("polygons in 2 convex parts with 12 faces, orientation and torque"));
  double volume = 0.0;
  for (const Polyhedron& part : body.parts) {
    EXPECT_EQ(part.planes.size(), 6u);
    EXPECT_GT(part.least.x(), 0.99);  // The part is at its position.
    volume += (part.most - part.least).prod();
  }
  EXPECT_NEAR(volume, 1e-5, 1e-12);
}

/// Writes a ball of many triangles, 0.1 m wide. The pole is moved inwards by `dent` [m].
void write_ball(const std::filesystem::path& file, double dent) {
  TriangleSoup ball = tessellate(Sphere{0.05}, 48);
  std::ranges::max_element(ball.vertices, {}, [](const Vec3& v) { return v.z(); })->z() -= dent;
  std::ofstream out(file);
  out.precision(17);
  for (const Vec3& v : ball.vertices) out << "v " << v.x() << ' ' << v.y() << ' ' << v.z() << '\n';
  for (const auto& [a, b, c] : ball.triangles)
    out << "f " << a + 1 << ' ' << b + 1 << ' ' << c + 1 << '\n';
}

// A part may omit corners that change its shape by less than the tolerance. A convex mesh must be
// exact, so its number of corners has a limit.
TEST(ReadPolygons, FineMeshesHavePartsOfFewCorners) {
  const test::TemporaryFolder folder;
  write_ball(folder / "dented.obj", 0.01);
  const std::string dented =
      R"("mesh": { "file": "dented.obj", "scale": 1, "convex_parts": { "tolerance": 0.008 } })";
  const Scene read = parse_scene(
      scene(
          R"("file": "dented.obj", "scale": 1, "contact": "polygons", "convex_parts": { "tolerance": 0.008 })",
          dented),
      (folder / "s.json").string());
  const PolygonBody& body = *read.tool().body->polygons();
  ASSERT_EQ(body.solids.size(), 1u);
  ASSERT_FALSE(body.parts.empty());
  for (const Polyhedron& part : body.parts) EXPECT_LE(part.vertices.size(), kMostFewCorners);
  for (const SolidPart& part : body.solids[0].parts)
    EXPECT_LE(part.shape.vertices.size(), kMostFewCorners);
  write_ball(folder / "ball.obj", 0.0);
  EXPECT_THAT(test::error_of(scene(R"("file": "ball.obj", "scale": 1, "contact": "polygons")"),
                             (folder / "s.json").string()),
              AllOf(HasSubstr("corners, more than 512"),
                    HasSubstr("simplify the mesh: one that is convex")));
}

// The tool pushes a floating box. The box must get the momentum that the hand gives.
TEST(ReadPolygons, ABoxThatFloatsIsPushed) {
  const Scene read = parse_scene(R"({ "name": "s", "gravity": [0, 0, 0],
    "tool": { "body": { "box": { "size": [0.04, 0.04, 0.04] }, "contact": "polygons", "contact_area": 1e-3 } },
    "materials": [{ "name": "m", "stiffness": 1000, "damping": 2, "static_friction": 0.5, "dynamic_friction": 0.4 }],
    "bodies": [{ "name": "b", "mass": 0.2 }],
    "objects": [{ "name": "o", "box": { "size": [0.06, 0.06, 0.06] }, "body": "b", "material": "m" }] })",
                                 "s.json");
  World world(read);
  BodyMemory memory;
  BodyContactState contacts = world.contact_state();
  Vec3 given = Vec3::Zero();
  double most = 0.0, nearest = 1.0, pushed = 0.0;
  for (int n = 0; n < 400; ++n) {
    const Pose hand{Vec3(0.06 - 2e-4 * n, 0.004, 0.002), Quaternion::Identity()};
    const Vec3 felt = world.touch(hand, Vec3::Zero(), 1e-3, memory, contacts).force();
    world.push(contacts, memory, 1.0);
    given += 1e-3 * felt;
    most = std::max(most, felt.norm());
    ASSERT_TRUE(world.step());
    ASSERT_LT((world.momentum() + given).norm(), 0.02 * given.norm() + 1e-6) << n;
    pushed = -world.objects()[0].pose.position.x();
    nearest = std::min(nearest, memory.pose.position.x() + pushed);
  }
  EXPECT_GT(most, 0.3);
  EXPECT_GT(pushed, 0.02);
  EXPECT_GT(nearest, 0.05 - 4e-3);  // distance of the centres: half of both boxes, minus the depth
}

TEST(ReadPolygons, ErrorsNameTheFieldAndTheRemedy) {
  EXPECT_THAT(error_of(scene(kBrick + R"(, "contact": "polygon")")),
              AllOf(HasSubstr("tool.body.contact"), HasSubstr("points, polygons; is 'polygon'")));
  EXPECT_THAT(error_of(scene(kBrick + R"(, "convex_parts": {})")),
              AllOf(HasSubstr("tool.body.convex_parts"), HasSubstr("leave it out")));
  EXPECT_THAT(
      error_of(scene(
          R"("torus": { "major_radius": 0.02, "minor_radius": 0.005 }, "contact": "polygons")")),
      AllOf(HasSubstr("tool.body.contact"), HasSubstr("take points")));
  EXPECT_THAT(error_of(scene(kBrick + R"(, "contact": "polygons")",
                             R"("grid": { "sphere": { "radius": 0.03 }, "resolution": 0.002 })")),
              AllOf(HasSubstr("tool.body.contact"), HasSubstr("object 'o'"),
                    HasSubstr("take a tool of points")));
}

}  // namespace
}  // namespace feltwire::read_polygons_test
