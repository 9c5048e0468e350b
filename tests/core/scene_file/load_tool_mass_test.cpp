// Tests the mass of a tool in a scene file.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <numbers>

#include "core/mesh/mesh_file.hpp"
#include "core/mesh/tessellation.hpp"
#include "core/tool/body_tool.hpp"
#include "tests/core/scene_text.hpp"
#include "tests/support/meshes.hpp"

namespace feltwire::load_tool_mass_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

/// Returns a scene with the tool's body on line 4 and its fields on lines 5 and 6.
std::string text(const std::string& solid, const std::string& fields,
                 const std::string& scene = "") {
  return "{ \"name\": \"s\", \"materials\": [{ \"name\": \"m\", \"stiffness\": 1000 }],\n" + scene +
         "\"objects\": [{ \"name\": \"o\", \"material\": \"m\", \"plane\": {} }],\n\"tool\": {\n"
         "\"body\": {\n" +
         solid + ", \"points\": 100,\n" + fields + " } } }";
}

ToolInertia read(const std::string& solid, const std::string& fields,
                 const std::string& scene = "") {
  return parse_scene(text(solid, fields, scene), "s.json").tool().body->inertia();
}

const std::string kBox = R"("box": { "size": [0.06, 0.04, 0.02] })";

TEST(LoadToolMass, OfABoxInClosedForm) {
  const ToolInertia by_mass = read(kBox, R"("mass": 0.3)");
  EXPECT_NEAR(by_mass.mass, 0.3, 1e-15);
  EXPECT_EQ(by_mass.center, Vec3::Zero());
  const Vec3 moments =
      0.3 / 12.0 *
      Vec3(0.04 * 0.04 + 0.02 * 0.02, 0.06 * 0.06 + 0.02 * 0.02, 0.06 * 0.06 + 0.04 * 0.04);
  EXPECT_LT((by_mass.inertia - moments.asDiagonal().toDenseMatrix()).norm(), 1e-15);
  EXPECT_EQ(by_mass.gravity, Vec3(0.0, 0.0, -9.81));
  EXPECT_EQ(by_mass.integration, ToolIntegration::implicit);
  EXPECT_EQ(by_mass.damping, 0.0);
  EXPECT_EQ(by_mass.rotational_damping, 0.0);
  const double volume = 0.06 * 0.04 * 0.02;
  EXPECT_NEAR(read(kBox, R"("density": 7800)").mass, 7800 * volume, 1e-12);
}

TEST(LoadToolMass, PlacedBesideTheHandAndTurned) {
  const ToolInertia tool = read(kBox, R"("mass": 0.3, "integration": "midpoint",
      "position": [0.01, 0, 0.02], "orientation": [0.7071067811865476, 0, 0, 0.7071067811865476],
      "coupling": { "damping": 3, "rotational_damping": 0.01 })",
                                R"("gravity": [1, 2, 3],)");
  EXPECT_LT((tool.center - Vec3(0.01, 0.0, 0.02)).norm(), 1e-15);
  EXPECT_NEAR(tool.inertia(0, 0), 0.3 / 12.0 * (0.06 * 0.06 + 0.02 * 0.02), 1e-12) << "turned";
  EXPECT_EQ(tool.gravity, Vec3(1.0, 2.0, 3.0));
  EXPECT_EQ(tool.integration, ToolIntegration::midpoint);
  EXPECT_EQ(tool.damping, 3.0);
  EXPECT_EQ(tool.rotational_damping, 0.01);
}

TEST(LoadToolMass, WithoutItThereIsNone) {
  EXPECT_EQ(read(kBox, R"("contact_area": 0)").mass, 0.0);
}

TEST(LoadToolMass, OfAMeshThatIsASolid) {
  const auto folder = std::filesystem::path(::testing::TempDir()) / "feltwire_load_tool_mass";
  std::filesystem::create_directories(folder);
  const TriangleSoup ball = icosphere(0.03, 4);
  std::ofstream(folder / "ball.obj") << obj_text(ball);
  TriangleSoup open = ball;
  open.triangles.pop_back();
  std::ofstream(folder / "open.obj") << obj_text(open);
  const auto load = [&](const std::string& file, const std::string& fields) {
    std::ofstream(folder / "s.json") << text("\"file\": \"" + file + "\", \"scale\": 1", fields);
    return load_scene(folder / "s.json");
  };
  const ToolInertia tool = load("ball.obj", R"("density": 1000)").tool().body->inertia();
  const double mass = 1000.0 * 4.0 / 3.0 * std::numbers::pi * 0.03 * 0.03 * 0.03;
  EXPECT_NEAR(tool.mass, mass, 0.01 * mass);
  EXPECT_NEAR(tool.inertia(1, 1), 0.4 * mass * 0.03 * 0.03, 0.02 * 0.4 * mass * 0.03 * 0.03);
  EXPECT_NO_THROW(load("open.obj", R"("contact_area": 0)"));
  try {
    load("open.obj", R"("density": 1000)");
    ADD_FAILURE() << "an open mesh has no mass";
  } catch (const FileError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("s.json:6"), HasSubstr("tool.body.density"),
                                    HasSubstr("close it")));
  }
  std::filesystem::remove_all(folder);
}

TEST(LoadToolMass, ErrorsNameTheFieldAndTheRemedy) {
  const auto error = [](const std::string& fields) { return test::error_of(text(kBox, fields)); };
  EXPECT_THAT(error(R"("mass": 0)"), AllOf(HasSubstr("s.json:6: tool.body.mass: must be 1e-06"),
                                           HasSubstr("leave it out")));
  EXPECT_THAT(error(R"("mass": -1)"), HasSubstr("tool.body.mass"));
  EXPECT_THAT(error(R"("mass": 2000)"), HasSubstr("is 2000"));
  EXPECT_THAT(error(R"("density": 0)"), HasSubstr("tool.body.density"));
  EXPECT_THAT(error(R"("density": 0.005)"), HasSubstr("of the whole tool"));
  EXPECT_THAT(error(R"("mass": 1, "density": 1000)"),
              AllOf(HasSubstr("tool.body.density"), HasSubstr("keep one of the two")));
  EXPECT_THAT(error(R"("integration": "midpoint")"),
              AllOf(HasSubstr("tool.body.integration"), HasSubstr("give its mass")));
  EXPECT_THAT(error(R"("coupling": { "damping": 1 })"),
              AllOf(HasSubstr("tool.body.coupling.damping"), HasSubstr("give its mass")));
  EXPECT_THAT(error(R"("mass": 1, "coupling": { "damping": -1 })"),
              HasSubstr("tool.body.coupling.damping"));
  EXPECT_THAT(error(R"("mass": 1, "coupling": { "rotational_damping": 1e9 })"),
              HasSubstr("tool.body.coupling.rotational_damping"));
  EXPECT_THAT(error(R"("mass": 1, "integration": "euler")"), HasSubstr("euler"));
}

}  // namespace
}  // namespace feltwire::load_tool_mass_test
