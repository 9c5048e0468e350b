// Tests a scene with several tools.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "core/grid/distance_grid.hpp"
#include "core/local_model_extraction/extract.hpp"
#include "core/mesh/mesh_file.hpp"
#include "core/scene/scene_cost_report.hpp"
#include "core/scene_file/load_scene.hpp"
#include "tests/core/held_tools.hpp"
#include "tests/core/moving.hpp"
#include "tests/core/scene_text.hpp"
#include "tests/core/support.hpp"
#include "tests/support/allocation_counter.hpp"
#include "tests/support/meshes.hpp"

namespace feltwire::tools_test {
namespace {

using test::body;
using test::error_of;
using test::kBall;
using test::kRough;
using test::kWeightless;
using test::mesh_object;
using test::moving;
using test::object;
using test::placed;
using test::Wanderer;
using ::testing::AllOf;
using ::testing::HasSubstr;

std::shared_ptr<const BodyTool> brick(std::size_t points = 400) {
  return std::make_shared<const BodyTool>(
      point_shell(tessellate(Box{Vec3(0.03, 0.02, 0.01)}, 3), points), ToolCoupling{}, 2.4e-3);
}

/// Returns a ring of triangles without gravity, for a point, a ball and a brick as tools.
Scene ring_for_all() {
  Scene scene =
      moving({object("ring", mesh_object(test::torus(0.05, 0.008, 40, 14)).shape, kRough)}, {0},
             {body("ring", 0.4)}, kWeightless);
  scene.set_tools({{.radius = 0.0, .body = nullptr, .name = "tip"},
                   {.radius = kBall, .body = nullptr, .name = "ball"},
                   {.radius = 0.0, .body = brick(), .name = "brick"}});
  return scene;
}

// Three hands hold three tools. The ring must get the opposite of the sum of their forces, up to
// rounding.
TEST(Tools, OfManyKindsMoveOneMesh) {
  const Scene scene = ring_for_all();
  World world(scene);
  const ToolView &ball_view = *scene.view("ball"), &brick_view = *scene.view("brick");
  TouchMemory tip = scene.memory(), ball = ball_view.memory();
  BodyMemory block;
  BodyContactState by_tip = world.contact_state(), by_ball = world.contact_state(ball_view),
                   by_brick = world.contact_state(brick_view);
  std::array<double, 3> pushed{};  // [N s]
  Vec3 given = Vec3::Zero();
  std::size_t allocated = 0;
  for (int n = 0; n < 1500; ++n) {
    const Pose& ring = world.objects()[0].pose;
    const double t = kDefaultTick * n;
    const auto in_ring = [&](const Vec3& own) {
      return Vec3(ring.position + ring.orientation * own);
    };
    const Vec3 at_tip =
        in_ring({0.0575 + 1e-3 * std::sin(40 * t), 0.004 * std::sin(17 * t), 0.001});
    const Vec3 at_ball =
        in_ring({-0.0615 + 1e-3 * std::sin(31 * t), 0.003 * std::sin(11 * t), -0.001});
    const Pose at_brick{in_ring({0.002 * std::sin(9 * t), 0.076 + 5e-4 * std::sin(23 * t), 0}),
                        ring.orientation};
    const std::size_t before = test::allocations();
    const std::array<Command, 3> felt = {
        world.touch({at_tip, Vec3::Zero()}, tip, by_tip),
        world.touch({at_ball, Vec3::Zero()}, ball, by_ball),
        world.touch(at_brick, Vec3::Zero(), kDefaultTick, block, by_brick)};
    world.push(by_tip, tip, 1.0);
    world.push(by_ball, ball, 1.0);
    world.push(by_brick, block, 1.0);
    ASSERT_TRUE(world.step());
    allocated += test::allocations() - before;
    for (std::size_t i = 0; i < felt.size(); ++i) {
      if (i == 2 && block.contact.touching == 0) continue;  // The tool still moves to the hand.
      given += kDefaultTick * felt[i].force();
      pushed[i] += kDefaultTick * felt[i].force().norm();
    }
  }
  for (const double each : pushed) EXPECT_GT(each, 0.1);
  EXPECT_NEAR((world.momentum() + given).norm(), 0.0, 1e-12 * (pushed[0] + pushed[1] + pushed[2]));
  EXPECT_EQ(world.objects(2)[0].pose.position, world.objects()[0].pose.position);
  EXPECT_TRUE(std::holds_alternative<Grid>(world.objects(2)[0].shape));
#ifndef FELTWIRE_SANITIZED
  EXPECT_EQ(allocated, 0u);
#else
  static_cast<void>(allocated);
#endif
}

TEST(Tools, AHandFeelsASceneOfItsToolAlone) {
  const std::vector<Object> objects = {
      placed(mesh_object(test::box({0.05, 0.04, 0.004}, 3), {}, kRough), "box", {0.0, 0.01, 0.0})};
  Scene scene("s", objects), ball("s", objects), block("s", objects);
  scene.set_tools({{.radius = kBall, .body = nullptr, .name = "ball"},
                   {.radius = 0.0, .body = nullptr, .name = "tip"},
                   {.radius = 0.0, .body = brick(), .name = "brick"}});
  ball.set_tool({.radius = kBall, .body = nullptr});
  block.set_tool({.radius = 0.0, .body = brick()});
  const Scene point("s", objects);
  EXPECT_EQ(scene.view(""), &scene.views().front());
  EXPECT_EQ(scene.view("ball"), scene.view(""));
  EXPECT_EQ(scene.view("key"), nullptr);
  EXPECT_EQ(point.view(""), &point.views().front());
  EXPECT_EQ(point.view("ball"), nullptr);
  const std::array<std::pair<const ToolView*, const ToolView*>, 2> points = {
      {{scene.view("ball"), ball.view("")}, {scene.view("tip"), point.view("")}}};
  for (const auto& [one, alone] : points) {
    EXPECT_FALSE(one->requirements().rotation);
    TouchMemory a = one->memory(), b = alone->memory();
    Wanderer hand(5, 0.08, 0.01);
    for (int n = 0; n < 500; ++n) {
      const Tool tool = hand.step();
      ASSERT_EQ(one->touch(tool, a), alone->touch(tool, b));
    }
  }
  const ToolView& held = *scene.view("brick");
  EXPECT_TRUE(held.requirements().rotation);
  BodyMemory a, b;
  Wanderer hand(6, 0.09, 0.02);
  for (int n = 0; n < 300; ++n) {
    const Pose at{hand.step().position, Quaternion::Identity()};
    ASSERT_EQ(held.touch(at, Vec3::Zero(), 1e-3, a), block.touch(at, Vec3::Zero(), 1e-3, b));
  }
  // Each tool has its own local model. The model of a body has another form (body_model.hpp).
  const Vec3 above(0.0, 0.01, 0.02);
  const TouchMemory memory = scene.view("tip")->memory();
  const LocalModel tip = local_model(*scene.view("tip"), above, memory);
  const LocalModel of_ball = local_model(scene, above, memory);
  EXPECT_GT(tip.reach, 0.0);
  EXPECT_EQ(tip.patches[0].offset, 0.0);
  EXPECT_GT(of_ball.reach, 0.0);
  EXPECT_EQ(of_ball.patches[0].offset, kBall);
  EXPECT_EQ(local_model(*scene.view("brick"), above, scene.view("brick")->memory()).reach, 0.0);
}

TEST(Tools, ShareWhatIsLarge) {
  const Object mesh = mesh_object(test::box({0.05, 0.04, 0.004}, 3));
  Scene scene("s", {mesh});
  scene.set_tools({{.radius = 0.0, .body = brick(), .name = "large"},
                   {.radius = kBall, .body = nullptr, .name = "ball"},
                   {.radius = 0.0, .body = brick(100), .name = "small"}});
  const auto surface = [](const ToolView& s) {
    return std::get<Mesh>(s.objects()[0].shape).surface;
  };
  const auto field = [](const ToolView& s) { return std::get<Grid>(s.objects()[0].shape).field; };
  EXPECT_EQ(surface(*scene.view("ball")), std::get<Mesh>(mesh.shape).surface);
  EXPECT_EQ(field(*scene.view("small")), field(scene));
  EXPECT_EQ(&scene.view("small")->objects(), &scene.objects());
  EXPECT_EQ(&scene.view("ball")->guides(), &scene.guides());
  EXPECT_EQ(scene.views().front().sampled().size(), 1u);
}

TEST(Tools, ThatCannotBeAreRefusedAndChangeNothing) {
  TriangleSoup open = test::icosphere(0.05, 1);
  open.triangles.pop_back();
  Object hollow = object("hollow", Sphere{0.02});
  hollow.felt_from = Side::inside;
  Scene scene("s", {mesh_object(open), hollow});
  scene.set_tool({.radius = kBall, .body = nullptr});
  const auto error = [&](std::vector<HandTool> tools) {
    try {
      scene.set_tools(std::move(tools));
    } catch (const std::invalid_argument& refused) {
      return std::string(refused.what());
    }
    return std::string("let through");
  };
  const HandTool tip{.radius = 0.0, .body = nullptr, .name = "tip"};
  EXPECT_THAT(error({}), HasSubstr("tools: must be 1 to 64, are 0"));
  EXPECT_THAT(error(std::vector<HandTool>(65, tip)), HasSubstr("are 65; name fewer"));
  EXPECT_THAT(error({tip, tip}), HasSubstr("tool 'tip': name: stands twice"));
  EXPECT_THAT(error({{.radius = 0.0, .body = nullptr}}), HasSubstr("name: must be 1 to 100 bytes"));
  EXPECT_THAT(error({tip, {.radius = 0.05, .body = nullptr, .name = "ball"}}),
              HasSubstr("tool 'ball': sphere.radius: is 0.05 m, too large for object 'hollow'"));
  EXPECT_THAT(error({tip, {.radius = 0.0, .body = brick(), .name = "brick"}}),
              HasSubstr("object 'mesh': mesh: is touched by a body, as a grid of distances"));
  EXPECT_EQ(scene.tool().radius, kBall);
  EXPECT_EQ(scene.views().size(), 1u);
  EXPECT_TRUE(scene.views().front().sampled().empty());
  EXPECT_EQ(error({tip}), "let through");
}

/// Returns a scene with tools on lines 3, 4 and 5 of its file.
std::string with_tools(const std::string& first, const std::string& second,
                       const std::string& shape = R"("plane": {})", const std::string& more = "") {
  return "{\"name\": \"s\", \"materials\": [{\"name\": \"m\", \"stiffness\": 1000}],\n\"tools\": "
         "[\n" +
         first + ",\n" + second + "],\n" + more +
         "\"objects\": [{\"name\": \"o\", \"material\": \"m\", \"felt_from\": \"inside\",\n" +
         shape + "}]}";
}

TEST(Tools, AreReadFromAFile) {
  const Scene scene = parse_scene(
      with_tools(R"({"name": "finger", "sphere": {"radius": 0.008}})",
                 R"({"name": "brick", "body": {"box": {"size": [0.06, 0.04, 0.02]}, "points": 300}},
                    {"name": "tip"})"),
      "s.json");
  EXPECT_EQ(scene.tool().name, "finger");
  EXPECT_EQ(scene.tool().radius, 0.008);
  ASSERT_NE(scene.view("brick"), nullptr);
  EXPECT_EQ(scene.view("brick")->tool().body->shell().points.size(), 300u);
  ASSERT_NE(scene.view("tip"), nullptr);
  EXPECT_EQ(scene.view("tip")->tool().radius, 0.0);
  EXPECT_THAT(describe_costs(scene),
              AllOf(HasSubstr("  tools: finger (a ball of 0.008 m; of hands that ask for none), "
                              "brick (a body of 300 points), tip (a point)\n"),
                    HasSubstr("a ball in the hand (edges and corners rounded): finger\n"),
                    HasSubstr("a body in the hand (points, orientation and torque): brick\n")));
}

TEST(Tools, EveryMistakeInAFileIsNamed) {
  const std::string tip = R"({"name": "tip"})";
  const auto second = [&](const std::string& tool) { return error_of(with_tools(tip, tool)); };
  EXPECT_THAT(second("{}"), HasSubstr("s.json:4: tools[1].name: is missing"));
  EXPECT_THAT(second(tip), HasSubstr("s.json:4: tools[1].name: 'tip' is the name of tools[0] too"));
  EXPECT_THAT(second(R"({"name": ""})"), HasSubstr("s.json:4: tools[1].name: must be 1 to 100"));
  EXPECT_THAT(second(R"({"name": "a", "sphere": {"radius": -1}})"),
              HasSubstr("s.json:4: tools[1].sphere.radius: must be above zero [m], is -1"));
  EXPECT_THAT(
      second(R"({"name": "a", "sphere": {"radius": 1}, "body": {"sphere": {"radius": 1}}})"),
      HasSubstr("s.json:4: tools[1].sphere: is a second tool beside body"));
  EXPECT_THAT(second(R"({"name": "a", "body": {"sphere": {"radius": 1}, "points": 0}})"),
              HasSubstr("s.json:4: tools[1].body: points: must be 1 to 1000000, are 0"));
  EXPECT_THAT(second(R"({"name": "a", "bal": {}})"),
              HasSubstr("the fields are: name, sphere, body"));
  EXPECT_THAT(error_of(with_tools(tip, R"({"name": "a", "sphere": {"radius": 0.2}})",
                                  R"("sphere": {"radius": 0.1})")),
              HasSubstr("s.json:4: tools[1].sphere.radius: is 0.2 m, too large for object 'o'"));
  EXPECT_THAT(error_of(with_tools(tip, R"({"name": "b"})", R"("plane": {})",
                                  "\"tool\": {\"sphere\": {\"radius\": 0.01}},")),
              HasSubstr("s.json:2: tools: stand beside tool; keep one of the two"));
  EXPECT_THAT(error_of(R"({"name": "s", "materials": [{"name": "m", "stiffness": 1}], "tools": [],
                           "objects": [{"name": "o", "plane": {}, "material": "m"}]})"),
              HasSubstr("tools: must be 1 to 64, are 0; name one, or leave them out"));
}

TEST(Tools, OfAFileShareItsMeshes) {
  const auto folder = std::filesystem::path(::testing::TempDir()) / "feltwire_tools";
  std::filesystem::create_directories(folder);
  TriangleSoup lens = icosphere(30.0, 3), open = icosphere(30.0, 1);
  for (Vec3& v : lens.vertices) v.z() *= 0.1;
  open.triangles.pop_back();
  std::ofstream(folder / "lens.obj") << obj_text(lens);
  std::ofstream(folder / "open.obj") << obj_text(open);
  const auto text = [](const std::string& file) {
    return "{\"name\": \"s\", \"materials\": [{\"name\": \"m\", \"stiffness\": 1000}],\n"
           "\"objects\": [{\"name\": \"o\", \"material\": \"m\", \"mesh\": {\"file\": \"" +
           file + "\", \"unit\": \"mm\"}}],\n" +
           R"("tools": [{"name": "ball", "sphere": {"radius": 0.002}},
                        {"name": "block", "body": {"sphere": {"radius": 0.01}, "points": 200}}]})";
  };
  std::ofstream(folder / "s.json") << text("lens.obj");
  std::ofstream(folder / "open.json") << text("open.obj");
  const Scene scene = load_scene(folder / "s.json");
  TouchMemory memory = scene.memory();
  scene.touch({Vec3(0, 0, 0.01), Vec3::Zero()}, memory);
  EXPECT_NEAR(scene.touch({Vec3(0, 0, 0.004), Vec3::Zero()}, memory).elastic.z(), 1.0, 0.2);
  EXPECT_THAT(describe_costs(scene),
              AllOf(HasSubstr("triangles about a ball (distances to all that are "
                              "near): o\n"),
                    HasSubstr("distance grids (bricks of distances about a "
                              "surface): o\n"),
                    HasSubstr("grid of distances for the tool's body: mesh o")));
  try {
    load_scene(folder / "open.json");
    ADD_FAILURE() << "an open mesh has no inside";
  } catch (const FileError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("open.json:3: tools: object 'o'"),
                                    HasSubstr("is open at 3 edges")));
  }
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace feltwire::tools_test
