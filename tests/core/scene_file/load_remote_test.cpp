// Tests a robot in a scene file, and its workspace.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <string>

#include "core/dynamics/world.hpp"
#include "core/scene_file/load_scene.hpp"
#include "tests/core/scene_text.hpp"

namespace feltwire::load_remote_test {
namespace {

using test::error_of;
using ::testing::HasSubstr;

TEST(LoadRemote, ARobotMayFollow) {
  const auto scene = [](const std::string& remote) {
    return R"({"name": "s", "materials": [{"name": "m", "stiffness": 100}],
      "objects": [{"name": "o", "plane": {}, "material": "m"}])" +
           remote + "}";
  };
  EXPECT_TRUE(parse_scene(scene(""), "s.json").seats().empty());
  const Scene usual = parse_scene(scene(R"(, "remote": {})"), "s.json");
  ASSERT_EQ(usual.seats().size(), 1u);
  EXPECT_EQ(usual.seats()[0].name, "");
  EXPECT_EQ(usual.seats()[0].scale, 1.0);
  EXPECT_EQ(usual.seats()[0].force_scale, 1.0);
  const Scene told =
      parse_scene(scene(R"(, "remote": {"scale": 0.5, "speed": 1, "force": 10})"), "s.json");
  EXPECT_EQ(told.seats()[0].scale, 0.5);
  EXPECT_EQ(told.seats()[0].speed, 1.0);
  EXPECT_EQ(told.seats()[0].force, 10.0);
  EXPECT_THAT(error_of(scene(R"(, "remote": {"scale": 0})")),
              HasSubstr("remote.scale: is 0; give a number above 0, at most 100"));
  EXPECT_THAT(error_of(scene(R"(, "remote": {"speed": -1})")), HasSubstr("remote.speed"));
  EXPECT_FALSE(told.seats()[0].aligned);
  EXPECT_EQ(parse_scene(scene(R"(, "remote": {"aligned": {}})"), "s.json").seats()[0].aligned->gate,
            0.26);
  const Alignment aligned =
      *parse_scene(scene(R"(, "remote": {"aligned": {"gate": 0.5, "orientation": [0, 0, 3, 0]}})"),
                   "s.json")
           .seats()[0]
           .aligned;
  EXPECT_EQ(aligned.gate, 0.5);
  EXPECT_EQ(aligned.offset.coeffs(), Eigen::Vector4d(0, 1, 0, 0)) << "unit";
  for (const char* gate : {"0", "-1", "3.1"})
    EXPECT_THAT(error_of(scene(R"(, "remote": {"aligned": {"gate": )" + std::string(gate) + "}}")),
                HasSubstr("remote.aligned.gate: is " + std::string(gate) +
                          "; give an angle above 0, at most 3 rad"));
  EXPECT_THAT(error_of(scene(R"(, "remote": {"aligned": {"orientation": [0, 0, 0, 0]}})")),
              HasSubstr("remote.aligned.orientation: is no rotation"));
  EXPECT_THAT(
      error_of(scene(R"(, "remote": {"aligned": {}, "workspace": {"lock": ["rotation"]}})")),
      HasSubstr("remote.aligned: has no meaning where workspace.lock has \"rotation\""));
  EXPECT_THAT(error_of(scene(R"(, "remote": {"force": 1e9})")), HasSubstr("remote.force"));
  EXPECT_EQ(
      parse_scene(scene(R"(, "remote": {"force_scale": 2})"), "s.json").seats()[0].force_scale,
      2.0);
  EXPECT_THAT(error_of(scene(R"(, "remote": {"force_scale": 0})")),
              HasSubstr("remote.force_scale: is 0; give a number above 0, at most 100"));
}

TEST(LoadRemote, SeveralRobotsMayFollowEachOnASeatWithAName) {
  const auto scene = [](const std::string& remotes) {
    return R"({"name": "s", "materials": [{"name": "m", "stiffness": 100}],
      "objects": [{"name": "o", "plane": {}, "material": "m"}], )" +
           remotes + "}";
  };
  const Scene two = parse_scene(scene(R"("remotes": [{"name": "left", "scale": 0.5},
      {"name": "right", "workspace": {"lock": ["z"]}}])"),
                                "s.json");
  ASSERT_EQ(two.seats().size(), 2u);
  EXPECT_EQ(two.seats()[0].name, "left");
  EXPECT_EQ(two.seats()[0].scale, 0.5);
  EXPECT_EQ(two.seats()[1].name, "right");
  EXPECT_TRUE(two.seats()[1].workspace.locked[2]);
  EXPECT_THAT(error_of(scene(R"("remotes": [{"name": "a"}, {"name": "a"}])")),
              HasSubstr("remotes[1].name: 'a' is the name of remotes[0]"));
  EXPECT_THAT(error_of(scene(R"("remotes": [{"name": "a"}, {}])")),
              HasSubstr("remotes[1].name: is missing"));
  EXPECT_THAT(error_of(scene(R"("remotes": [])")), HasSubstr("remotes: has 0 seats; give 1 to 4"));
  EXPECT_THAT(error_of(scene(R"("remotes": [{"name": "a"}, {"name": "b"}, {"name": "c"},
      {"name": "d"}, {"name": "e"}])")),
              HasSubstr("remotes: has 5 seats; give 1 to 4"));
  EXPECT_THAT(error_of(scene(R"("remotes": [{"name": "a"}], "remote": {})")),
              HasSubstr("remotes: stands beside remote; put all seats into remotes"));
  EXPECT_THAT(error_of(scene(R"("remote": {"name": "a"})")),
              HasSubstr("remote.name: the only seat has no name"));
  EXPECT_THAT(error_of(scene(R"("remotes": [{"name": "a", "speed": -1}])")),
              HasSubstr("remotes[0].speed: is -1"));
  EXPECT_THAT(error_of(scene(R"("remotes": [{"name": "a", "workspace": {"low": [0, 0, 0]}}])")),
              HasSubstr("remotes[0].workspace.high: is missing"));
}

TEST(LoadRemote, ARobotsTargetMayHaveAWorkspace) {
  const auto scene = [](const std::string& workspace) {
    return R"({"name": "s", "materials": [{"name": "m", "stiffness": 100}],
      "objects": [{"name": "o", "plane": {}, "material": "m"}],
      "remote": {"workspace": {)" +
           workspace + "}}}";
  };
  EXPECT_FALSE(parse_scene(scene(""), "s.json").seats()[0].workspace.limits());
  const RemoteSeat seat = parse_scene(scene(R"("low": [-0.1, -0.2, 0], "high": [0.1, 0.2, 0.3],
      "walls": [{"position": [0, 0, 0.25], "normal": [0, 3, -4]}, {}],
      "keep_out": [{"position": [0.1, 0, 0], "radius": 0.03},
                   {"size": [0.2, 0.02, 0], "orientation": [0, 0, 0, 2]}], "lock": ["y", "rotation"],
      "stiffness": 500, "depth": 0.002)"),
                                      "s.json")
                              .seats()[0];
  const Workspace& w = seat.workspace;
  ASSERT_EQ(w.count, 8u);
  EXPECT_LE((nearest_in_front(Vec3(1, 1, -1), w.view().first(6)) - Vec3(0.1, 0.2, 0.0)).norm(),
            1e-12);
  EXPECT_LE((w.walls[6].normal - Vec3(0.0, 0.6, -0.8)).norm(), 1e-15);
  EXPECT_NEAR(w.walls[6].distance, -0.2, 1e-15);
  EXPECT_EQ(w.walls[7].normal, Vec3(0.0, 0.0, 1.0));
  EXPECT_EQ(w.locked, (std::array<bool, 3>{false, true, false}));
  EXPECT_TRUE(w.turning_locked);
  ASSERT_EQ(w.body_count, 2u);
  EXPECT_EQ(w.bodies[0].pose.position, Vec3(0.1, 0.0, 0.0));
  EXPECT_EQ(w.bodies[0].half, Vec3::Zero()) << "a ball";
  EXPECT_EQ(w.bodies[0].radius, 0.03);
  EXPECT_EQ(w.bodies[1].half, Vec3(0.1, 0.01, 0.0));
  EXPECT_EQ(w.bodies[1].radius, 0.01);
  EXPECT_EQ(w.bodies[1].pose.orientation.coeffs(), Eigen::Vector4d(0, 0, 1, 0)) << "unit";
  EXPECT_EQ(seat.wall_stiffness, 500.0);
  EXPECT_EQ(seat.wall_depth, 0.002);

  const std::string box = R"("low": [0, 0, 0], "high": [1, 1, 1])";
  const auto expect = [&](const std::string& workspace, const std::string& part) {
    EXPECT_THAT(error_of(scene(workspace)), HasSubstr("s.json:3: remote.workspace" + part));
  };
  expect(R"("low": [0, 0, 0])", ".high: is missing; a box has both corners");
  expect(R"("high": [0, 0, 0])", ".low: is missing; a box has both corners");
  expect(R"("low": [0, 0, 0], "high": [1, 0, 1])", ".high: must be above low on each axis");
  expect(R"("low": [0, 0, -1e4], "high": [1, 1, 1])", ".low: is farther than 1000 m");
  expect(R"("walls": [{}, {"normal": [0, 0, 0]}])", ".walls[1].normal: has no direction");
  expect(R"("walls": [{"position": [0, 0, 2000]}])", ".walls[0].position: is farther than 1000 m");
  expect(box + R"(, "stiffness": 0)", ".stiffness: is 0; give a number above 0");
  expect(box + R"(, "depth": 0.2)", ".depth: is 0.2; give a number above 0, at most 0.1");
  expect(R"("low": [0, 0, 0], "high": [1, 1, 0.009])", ": leaves no place that is 0.005 m");
  expect(R"("walls": [{"normal": [0, 0, 1]}, {"normal": [0, 0, -1]}])", ": leaves no place");
  std::string many = box + R"(, "walls": [{})";
  for (int i = 0; i < 10; ++i) many += ", {}";
  expect(many + "]", ".walls: has more than 16 walls");
  expect(R"("keep_out": [{}, {"radius": 0}])", ".keep_out[1].radius: is 0; give 0.001 to 1000 m");
  expect(R"("keep_out": [{"size": [1, -1, 0]}])", ".keep_out[0].size.y: ");
  expect(R"("keep_out": [{"position": [0, 2000, 0]}])",
         ".keep_out[0].position: is farther than 1000 m from the robot's origin");
  expect(R"("keep_out": [{"orientation": [0, 0, 0, 0]}])",
         ".keep_out[0].orientation: is no rotation");
  expect(R"("keep_out": [{}, {}, {}, {}, {}, {}, {}, {}, {}])",
         ".keep_out: has more than 8 bodies");
  expect(R"("low": [0, 0, 0], "high": [0.1, 0.1, 0.1], "keep_out": [{"radius": 0.2}])",
         ": leaves no place that is 0.005 m (depth times scale) inside of all its walls and "
         "outside of all that it keeps out of");
  EXPECT_THAT(error_of(scene(R"("lock": ["w"])")), HasSubstr("remote.workspace.lock"));
}

/// The robot may be an arm in the scene's own MJCF file.
TEST(LoadRemote, TheRobotMayBeAnArmOfTheScene) {
  const std::string file = FELTWIRE_SOURCE_DIR "/scenes/arm/s.json";
  const auto scene = [](const std::string& rest) {
    return R"({"name": "s", "materials": [{"name": "m", "stiffness": 100}],
      "mjcf": {"file": "workcell.xml", "material": "m"}, )" +
           rest + "}";
  };
  const auto place = [](const Scene& of, const char* object) {
    return std::ranges::find(of.objects(), object, &Object::name)->pose.position;
  };
  const Scene none = parse_scene(scene(R"("remote": {})"), file);
  EXPECT_FALSE(none.seats()[0].arm);
  const Scene told = parse_scene(
      scene(R"("remote": {"arm": {"stiffness": 500, "gripper": 0.02, "seed": 7}})"), file);
  const ArmControl arm = told.seats()[0].arm.value();
  EXPECT_EQ(arm.stiffness, 500.0);
  EXPECT_EQ(arm.gripper, 0.02);
  EXPECT_EQ(arm.seed, 7u);
  EXPECT_EQ(arm.prefix, "");
  EXPECT_EQ(arm.turning_stiffness, ArmControl{}.turning_stiffness);
  // The robot must begin at home with its gripper open as specified, in the file and in the world.
  EXPECT_GT(place(none, "palm").z(), 0.8) << "all angles zero: upright";
  const Vec3 home(0.306891, 0.0, 0.559);
  EXPECT_LT((place(told, "palm") - home).norm(), 0.01);
  const World world(told);
  EXPECT_LT((std::ranges::find(world.objects(), "palm", &Object::name)->pose.position -
             place(told, "palm"))
                .norm(),
            1e-12);

  EXPECT_THAT(error_of(scene(R"("remote": {"arm": {"stiffness": 0}})"), file),
              HasSubstr("remote.arm.stiffness: is 0; give a finite number above 0"));
  EXPECT_THAT(
      error_of(scene(R"("remote": {"arm": {"prefix": "left_"}})"), file),
      HasSubstr("mjcf.file: " FELTWIRE_SOURCE_DIR
                "/scenes/arm/workcell.xml: has no joint 'left_joint1'; an arm has the hinge "
                "joints left_joint1 to left_joint7"));
  EXPECT_THAT(
      error_of(scene(R"("remotes": [{"name": "a", "arm": {}}, {"name": "b", "arm": {}}])"), file),
      HasSubstr("remotes[1].arm.prefix: is '' as for the seat 'a'; an arm has one seat"));
  EXPECT_THAT(error_of(R"({"name": "s", "materials": [{"name": "m", "stiffness": 100}],
      "objects": [{"name": "o", "plane": {}, "material": "m"}], "remote": {"arm": {}}})"),
              HasSubstr("remote.arm: is an arm of the scene's MJCF file, and the scene has none; "
                        "give it an mjcf, or leave out the arm: then a robot may join"));
}

}  // namespace
}  // namespace feltwire::load_remote_test
