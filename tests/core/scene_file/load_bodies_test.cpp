// Tests bodies and MJCF models from files.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <set>

#include "core/base/json_document.hpp"
#include "core/dynamics/world.hpp"
#include "core/scene/mechanism.hpp"
#include "core/scene_file/load_scene.hpp"
#include "tests/core/moving.hpp"
#include "tests/core/scene_text.hpp"

namespace feltwire::load_bodies_test {
namespace {

using test::error_of;

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

/// Returns a scene's text with some lines replaced.
std::string scene_text(const std::string& bodies, const std::string& more = "",
                       const std::string& object = R"("body": "b")") {
  return "{ \"name\": \"s\", \"materials\": [{ \"name\": \"m\", \"stiffness\": 900 }],\n" + more +
         "\n\"bodies\": [" + bodies +
         "],\n\"objects\": [\n{ \"name\": \"ball\", \"sphere\": { \"radius\": 0.1 }, \"material\": "
         "\"m\", \"position\": [1, 0, 0], " +
         object + " },\n{ \"name\": \"floor\", \"plane\": {}, \"material\": \"m\" }] }";
}

TEST(LoadBodies, PlacesObjectsInTheFrameOfTheirBody) {
  const Scene scene = parse_scene(
      scene_text(
          R"({ "name": "b", "mass": 2, "position": [0, 0, 3], "orientation": [1, 0, 0, 1] })",
          R"("gravity": [0, 0, -1], "tick": 0.002,)"),
      "s.json");
  ASSERT_NE(scene.mechanism(), nullptr);
  EXPECT_EQ(scene.mechanism()->parts().size(), 1u);
  EXPECT_EQ(World(scene).tick(), 0.002);
  ASSERT_EQ(scene.mechanism()->still(), 1u);
  EXPECT_EQ(scene.objects()[0].name, "floor");
  EXPECT_EQ(scene.objects()[1].name, "ball");
  EXPECT_NEAR((scene.objects()[1].pose.position - Vec3(0, 1, 3)).norm(), 0.0, 1e-12);
  World world(scene);
  EXPECT_NEAR((world.objects()[1].pose.position - Vec3(0, 1, 3)).norm(), 0.0, 1e-12);
  world.step();
  EXPECT_NEAR(world.momentum().z(), -2.0 * 0.002, 1e-12);
}

TEST(LoadBodies, AFixedBodyIsAFrameForWhatStands) {
  const Scene scene = parse_scene(
      scene_text(R"({ "name": "b", "joint": "fixed", "position": [0, 0, 3] })"), "s.json");
  EXPECT_EQ(scene.mechanism(), nullptr);
  EXPECT_EQ(scene.objects()[0].pose.position, Vec3(1, 0, 3));
}

TEST(LoadBodies, AnAngleThatMayBeDegreesIsWarnedOf) {
  const auto warnings = [](const std::string& hinge) {
    return parse_scene(scene_text(R"({ "name": "b", "mass": 2, "joint": "hinge", )" + hinge + " }"),
                       "s.json")
        .warnings();
  };
  EXPECT_THAT(warnings(R"("range": [0, 90])"),
              ::testing::Contains(AllOf(HasSubstr("body 'b': range: 90 rad are 14.3 turns"),
                                        HasSubstr("in degrees, give 1.57 rad"))));
  EXPECT_THAT(warnings(R"("range": [-45, 0])"), ::testing::Contains(HasSubstr("give -0.785 rad")));
  EXPECT_THAT(warnings(R"("rest": 30, "stiffness": 0.1)"),
              ::testing::Contains(HasSubstr("rest: 30 rad are 4.77 turns")));
  for (const char* sane : {R"("range": [-6.28, 6.28])", R"("stiffness": 0.1)"})
    EXPECT_THAT(warnings(sane), ::testing::Not(::testing::Contains(HasSubstr("turns"))));
  const auto slide =
      parse_scene(scene_text(R"({ "name": "b", "mass": 2, "joint": "slide", "range": [0, 90] })"),
                  "s.json")
          .warnings();
  EXPECT_THAT(slide, ::testing::Not(::testing::Contains(HasSubstr("turns"))));
}

TEST(LoadBodies, NamesFileLineFieldAndRemedy) {
  const std::string good = R"({ "name": "b", "mass": 2, "position": [0, 0, 3] })";
  EXPECT_EQ(error_of(scene_text(good)), "no error");
  EXPECT_EQ(error_of(scene_text(R"({ "name": "b", "mass": -2 })")),
            "s.json:3: bodies[0].mass: must lie from 1e-06 to 1e+06 [kg], is -2; check the unit");
  EXPECT_THAT(error_of(scene_text(R"({ "name": "b" })")),
              StartsWith("s.json:3: bodies[0].mass: is missing; give mass [kg] or density"));
  EXPECT_THAT(error_of(scene_text(good + "," + good)),
              StartsWith("s.json:3: bodies[1].name: 'b' is the name of bodies[0] too"));
  EXPECT_THAT(error_of(scene_text(good, "", R"("body": "c")")),
              StartsWith("s.json:5: objects[0].body: there is no body 'c'"));
  EXPECT_THAT(error_of(scene_text(good, "\"tick\": 1,")),
              StartsWith("s.json:2: tick: must lie from 1e-04 to 0.01 [s], is 1"));
  EXPECT_THAT(error_of(scene_text(R"({ "name": "b", "mass": 2 }, { "name": "c", "mass": 2 })")),
              HasSubstr("body 'c': objects: it has none"));
  EXPECT_THAT(error_of(scene_text(R"({ "name": "b", "mass": 2, "joint": "ball" })")),
              StartsWith("s.json:3: bodies[0].joint: must be one of: free, hinge, slide, fixed"));
}

TEST(LoadBodies, TheWorkshopIsSound) {
  const Scene scene = load_scene(std::string(FELTWIRE_SOURCE_DIR) + "/scenes/workshop.json");
  ASSERT_NE(scene.mechanism(), nullptr);
  std::set<int> bodies;
  for (const Mechanism::Part& part : scene.mechanism()->parts()) bodies.insert(part.body);
  EXPECT_EQ(bodies.size(), 6u);
  EXPECT_THAT(scene.mechanism()->warnings(), ::testing::IsEmpty());
  // Without contact everything must stay at its position.
  World world(scene);
  const auto before = world.objects();
  for (int n = 0; n < 1000; ++n) ASSERT_TRUE(world.step());
  for (std::size_t i = 0; i < before.size(); ++i)
    EXPECT_NEAR((world.objects()[i].pose.position - before[i].pose.position).norm(), 0.0, 3e-4)
        << before[i].name;
}

class Mjcf : public ::testing::Test {
 protected:
  Mjcf() { std::filesystem::create_directories(folder); }
  ~Mjcf() override { std::filesystem::remove_all(folder); }
  void write(const std::string& file, const std::string& text) {
    std::ofstream(folder / file) << text;
  }
  std::string error(const std::string& more = "") {
    try {
      load(more);
    } catch (const FileError& error) {
      return error.what();
    }
    return "no error";
  }
  Scene load(const std::string& more = "") {
    write("s.json", R"({ "name": "s", "materials": [{ "name": "soft", "stiffness": 100 },
      { "name": "hard", "stiffness": 900 }],
      "mjcf": { "file": "room.xml", "material": "soft", "materials": [
        { "name": "steel", "material": "hard" }] }, )" +
                        more + "}");
    return load_scene(folder / "s.json");
  }
  std::filesystem::path folder =
      std::filesystem::path(::testing::TempDir()) /
      ("mjcf_" + std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
};

const char* const kRoom = R"(<mujoco>
  <asset><material name="steel"/></asset>
  <worldbody>
    <geom name="floor" type="plane" size="1 1 1" material="steel"/>
    <geom type="sphere" size="1" contype="0" conaffinity="0"/>
    <body name="cart" pos="0 0 0.5">
      <joint type="slide" axis="1 0 0"/>
      <geom name="cabin" type="box" size="0.1 0.1 0.1" pos="0 0 0.1"/>
      <body name="wheel" pos="0 0.2 0"><joint type="hinge" axis="0 1 0"/>
        <geom type="cylinder" size="0.05 0.01 0.05" euler="90 0 0"/></body>
    </body>
  </worldbody>
</mujoco>)";

TEST_F(Mjcf, GeomsBecomeObjects) {
  write("room.xml", kRoom);
  const Scene scene = load();
  ASSERT_EQ(scene.objects().size(), 3u);  // A geom without collision is only visual.
  EXPECT_EQ(scene.objects()[0].name, "floor");
  EXPECT_EQ(scene.objects()[0].material.stiffness, 900);
  EXPECT_EQ(scene.objects()[1].name, "cabin");
  EXPECT_EQ(scene.objects()[1].material.stiffness, 100);
  EXPECT_NEAR((scene.objects()[1].pose.position - Vec3(0, 0, 0.6)).norm(), 0.0, 1e-12);
  EXPECT_TRUE(std::holds_alternative<Cylinder>(scene.objects()[2].shape));
  EXPECT_EQ(scene.mechanism()->still(), 1u);

  // The hand pushes the cart away.
  World world(scene);
  test::Hand hand(world);
  for (int n = 0; n < 100; ++n) hand.step({-0.099, 0, 0.6});
  EXPECT_GT(world.objects()[1].pose.position.x(), 1e-5);
  EXPECT_NEAR(world.objects()[2].pose.position.x(), world.objects()[1].pose.position.x(), 1e-12);
}

/// MuJoCo resets everything in each step. Nothing would ever move.
TEST_F(Mjcf, ASceneThatBreaksAtItsFirstStepIsWarnedOf) {
  const auto warnings = [&](const std::string& spring) {
    write("room.xml", R"(<mujoco><asset><material name="steel"/></asset><worldbody>
      <body name="cart" pos="0 0 0.5"><joint type="slide" axis="1 0 0" springref="1" stiffness=")" +
                          spring + R"("/>
        <geom name="cabin" type="box" size="0.1 0.1 0.1" material="steel"/></body>
    </worldbody></mujoco>)");
    return load().warnings();
  };
  EXPECT_THAT(warnings("1e13"),
              ::testing::Contains(AllOf(HasSubstr("the simulation breaks at its step 1"),
                                        HasSubstr("acceleration of object 'cabin'"),
                                        HasSubstr("softer springs"))));
  EXPECT_THAT(warnings("10"), ::testing::IsEmpty());
}

TEST_F(Mjcf, MeshGeomsAreFelt) {
  // For a wedge of 0.2 m, MuJoCo moves the frame to the centre of mass.
  write("room.xml", R"(<mujoco>
  <asset><material name="steel"/><mesh name="wedge" vertex="0 0 0 0.2 0 0 0 0.2 0 0 0 0.2"
    face="0 2 1 0 1 3 0 3 2 1 2 3"/></asset>
  <worldbody><body name="cart" pos="0 0 0.5"><joint type="slide" axis="1 0 0"/>
    <geom name="wedge" type="mesh" mesh="wedge" material="steel"/></body></worldbody>
</mujoco>)");
  const Scene scene = load();
  ASSERT_EQ(scene.objects().size(), 1u);
  World world(scene);
  test::Hand hand(world);
  EXPECT_EQ(hand.touch({-0.001, 0.05, 0.55}), Command{});
  const Command felt = hand.step({0.001, 0.05, 0.55});
  // The mesh has single precision.
  EXPECT_NEAR((felt.elastic - Vec3(-0.9, 0.0, 0.0)).norm(), 0.0, 1e-4);
  for (int n = 0; n < 100; ++n) hand.step({0.001, 0.05, 0.55});
  EXPECT_GT(world.objects()[0].pose.position.x(), 0.0502);  // The hand pushes the cart away.
}

const char* const kWedge =
    "v 0 0 0\nv 0.2 0 0\nv 0 0.2 0\nv 0 0 0.2\n"
    "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

/// Returns a model that includes a file and names a mesh beside the scene's folder.
std::string room_of_files(const std::string& mesh) {
  return R"(<mujoco>
  <asset><material name="steel"/><mesh name="wedge" file=")" +
         mesh + R"("/></asset>
  <worldbody><include file="parts/cart.xml"/></worldbody>
</mujoco>)";
}
const char* const kCart = R"(<mujoco><body name="cart" pos="0 0 0.5">
  <joint type="slide" axis="1 0 0"/><geom name="wedge" type="mesh" mesh="wedge"/></body></mujoco>)";

TEST_F(Mjcf, KeptFilesAreReadAgainWithoutTheDisk) {
  const std::filesystem::path all = folder;
  folder = all / "scene";
  std::filesystem::create_directories(folder / "parts");
  std::filesystem::create_directories(all / "meshes");
  write("room.xml", room_of_files("../meshes/wedge.obj"));
  write("parts/cart.xml", kCart);
  write("../meshes/wedge.obj", kWedge);
  load();  // This call writes s.json.
  const Scene scene = load_scene_and_keep(folder / "s.json");
  ASSERT_NE(scene.files(), nullptr);
  std::vector<std::string> names;
  for (const auto& [name, bytes] : scene.files()->files) names.push_back(name);
  EXPECT_THAT(
      names, ::testing::ElementsAre("../meshes/wedge.obj", "parts/cart.xml", "room.xml", "s.json"));
  std::filesystem::remove_all(all);
  const Scene again = load_kept_scene(*scene.files());
  ASSERT_EQ(again.objects().size(), 1u);
  EXPECT_EQ(again.objects()[0].pose.position, scene.objects()[0].pose.position);
  // Both scenes must give equal forces bitwise.
  World first(scene), second(again);
  test::Hand one(first), other(second);
  for (int n = 0; n < 50; ++n)
    EXPECT_EQ(one.step({0.001, 0.05, 0.55}), other.step({0.001, 0.05, 0.55}));
  EXPECT_EQ(first.objects()[0].pose.position, second.objects()[0].pose.position);
}

TEST_F(Mjcf, KeptFilesReachNothingElseOnTheDisk) {
  std::filesystem::create_directories(folder / "parts");
  write("room.xml", room_of_files("wedge.obj"));
  write("parts/cart.xml", kCart);
  write("wedge.obj", kWedge);
  load();
  const Scene scene = load_scene_and_keep(folder / "s.json");
  const auto wrong_with = [](const CapturedFiles& files) -> std::string {
    try {
      load_kept_scene(files);
      return "no error";
    } catch (const FileError& error) {
      return error.what();
    }
  };
  CapturedFiles files = *scene.files();
  EXPECT_EQ(wrong_with(files), "no error");
  // The author of a recording tries to read other files of this disk.
  const std::string place = (folder / "wedge.obj").string();
  files.files["room.xml"] = room_of_files(place);
  EXPECT_THAT(wrong_with(files), HasSubstr("was not kept, name the scene's own file"));
  files.files[place] = kWedge;
  EXPECT_THAT(wrong_with(files), HasSubstr("from the root of the file system"));
  // The author tries to write to the disk.
  files.files.erase(place);
  const std::filesystem::path target = folder / "written";
  files.files["../../../../../../../.." + target.string()] = "x";
  files.files["parts/../../../../../.." + target.string()] = "x";
  wrong_with(files);
  EXPECT_FALSE(std::filesystem::exists(target));
  files = *scene.files();
  files.files.erase("wedge.obj");
  EXPECT_THAT(wrong_with(files), HasSubstr("was not kept, name the scene's own file"));
}

TEST_F(Mjcf, ErrorsNameWhatIsWrong) {
  EXPECT_THAT(error(), AllOf(HasSubstr("s.json:3: mjcf.file: "), HasSubstr("room.xml: cannot be")));
  write("room.xml",
        "<mujoco>\n<worldbody>\n<geom type=\"sphere\" size=\"-1\"/>\n</worldbody></mujoco>");
  EXPECT_THAT(error(), AllOf(HasSubstr("room.xml: "), HasSubstr("sizes must be positive"),
                             HasSubstr("line = 3")));
  write("room.xml", "<mujoco>\n<worldbodyy/></mujoco>");
  EXPECT_THAT(error(), AllOf(HasSubstr("worldbodyy"), HasSubstr("line 2")));
  write("room.xml",
        std::string(kRoom).replace(std::string(kRoom).find("cylinder"), 8, "ellipsoid"));
  EXPECT_THAT(error(),
              HasSubstr("of body 'wheel': only plane, sphere, capsule, cylinder, box and mesh"));
  write("room.xml",
        "<mujoco><asset><mesh name='m' vertex='0 0 0 1e30 0 0 0 1e30 0 0 0 1e30'/></asset>"
        "<worldbody><geom type='mesh' mesh='m'/></worldbody></mujoco>");
  EXPECT_NE(error(), "no error");  // The process must not end.
  write("room.xml", "<mujoco><worldbody/></mujoco>");
  EXPECT_THAT(error(), HasSubstr("has no geom and no material 'steel'"));
  write("room.xml", kRoom);
  EXPECT_THAT(error(R"("bodies": [{ "name": "b", "mass": 1 }])"),
              HasSubstr("bodies: stand beside an mjcf"));
  EXPECT_EQ(error(), "no error");
}

}  // namespace
}  // namespace feltwire::load_bodies_test
