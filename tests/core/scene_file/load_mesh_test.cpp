#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <random>

#include "core/local_model_extraction/extract.hpp"
#include "core/mesh/mesh_contact.hpp"
#include "core/mesh/mesh_file.hpp"
#include "core/scene_file/load_scene.hpp"
#include "tests/core/support.hpp"
#include "tests/support/allocation_counter.hpp"
#include "tests/support/meshes.hpp"

namespace feltwire::load_mesh_test {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// Makes a separate folder for the files of a test.
class LoadMesh : public ::testing::Test {
 protected:
  LoadMesh()
      : folder_(std::filesystem::temp_directory_path() /
                ("feltwire_" + std::to_string(std::random_device{}()))) {
    std::filesystem::create_directory(folder_);
  }
  ~LoadMesh() override { std::filesystem::remove_all(folder_); }

  void write(const std::string& name, const std::string& bytes) {
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
  }
  Scene scene(const std::string& mesh, const std::string& more = "") {
    return parse_scene(R"({"name": "s", "materials": [{"name": "m", "stiffness": 1000}],
  "objects": [{"name": "o", "material": "m",
    "mesh": {)" + mesh + "}" +
                           more + "}]}",
                       (folder_ / "s.json").string());
  }
  std::string error_of(const std::string& mesh) {
    try {
      scene(mesh);
    } catch (const FileError& error) {
      return error.what();
    }
    return "no error";
  }

  std::filesystem::path folder_;
};

TEST_F(LoadMesh, UnitAndScaleSayHowLargeItIs) {
  write("ball.obj", obj_text(test::icosphere(50.0, 3)));
  for (const std::string size : {R"("unit": "mm")", R"("scale": 0.001)"}) {
    const Scene s = scene(R"("file": "ball.obj", )" + size, R"(, "position": [1, 0, 0])");
    TouchMemory memory = s.memory();
    s.touch({Vec3(1, 0, 0.06), Vec3::Zero()}, memory);
    EXPECT_NEAR(s.touch({Vec3(1, 0, 0.048), Vec3::Zero()}, memory).elastic.z(), 2.0, 0.2);
    EXPECT_TRUE(s.warnings().empty());
  }
}

TEST_F(LoadMesh, WrongFieldsAreNamedWithTheRemedy) {
  write("ball.obj", obj_text(test::icosphere(50.0, 1)));
  write("sheet.obj", obj_text(test::sheet(1.0)));
  write("torn.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n");
  write("flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
  write("empty.obj", "");
  const std::string ball = R"("file": "ball.obj", )";
  EXPECT_THAT(error_of(R"("file": "ball.obj")"),
              AllOf(HasSubstr("s.json:3: objects[0].mesh.scale"), HasSubstr("give either scale")));
  EXPECT_THAT(error_of(ball + R"("scale": 1, "unit": "m")"),
              HasSubstr("objects[0].mesh.unit: give either"));
  EXPECT_THAT(error_of(ball + R"("unit": "parsec")"),
              HasSubstr("must be one of: m, cm, mm, um, in, ft; is 'parsec'"));
  EXPECT_THAT(error_of(ball + R"("scale": -1)"), HasSubstr("mesh.scale: must be above zero"));
  EXPECT_THAT(error_of(ball + R"("scale": 1e5)"), HasSubstr("check scale or unit"));
  EXPECT_THAT(error_of(ball + R"("unit": "m", "radius": -1)"), HasSubstr("mesh.radius"));
  EXPECT_THAT(error_of(ball + R"("unit": "m", "grain": {"amplitude": 1e-4})"),
              HasSubstr("mesh.grain.wavelength"));
  EXPECT_THAT(error_of(ball + R"("unit": "m", "colour": 1)"), HasSubstr("is no field here"));
  EXPECT_THAT(
      error_of(R"("file": "none.obj", "unit": "m")"),
      AllOf(HasSubstr("objects[0].mesh.file"),
            HasSubstr("none.obj: cannot be opened: No such file or directory; check the path")));
  EXPECT_THAT(error_of(R"("file": ".", "unit": "m")"), HasSubstr("objects[0].mesh.file"));
  EXPECT_THAT(error_of(R"("file": "", "unit": "m")"), HasSubstr("names no file"));
  EXPECT_THAT(error_of(R"("file": "torn.obj", "unit": "m")"),
              HasSubstr("torn.obj:4: face: vertex 9 does not exist"));
  EXPECT_THAT(error_of(R"("file": "flat.obj", "unit": "m")"),
              HasSubstr("none with an area is left"));
  EXPECT_THAT(error_of(R"("file": "empty.obj", "unit": "m")"),
              HasSubstr("there is no triangle in it"));
  EXPECT_THAT(error_of(R"("file": "sheet.obj", "unit": "m", "closed": true)"),
              HasSubstr("sheet.obj is not closed: 4 open edges, 1 hole 2"));
  EXPECT_THAT(error_of(ball + R"("unit": "m", "weld": -1)"), HasSubstr("mesh.weld: must be"));
  // The file or the scale makes coordinates beyond single precision.
  write("far.obj", "v 0 0 0\nv 1e40 0 0\nv 0 1 0\nf 1 2 3\n");
  write("large.obj", "v 0 0 0\nv 1e38 0 0\nv 0 1 0\nf 1 2 3\n");
  EXPECT_THAT(error_of(R"("file": "far.obj", "unit": "m")"),
              HasSubstr("far.obj:2: vertex 2: x: must lie within 1e+06 m"));
  EXPECT_THAT(error_of(R"("file": "large.obj", "scale": 1000)"),
              HasSubstr("large.obj:2: vertex 2: x: must lie within 1e+06 m"));
}

TEST_F(LoadMesh, AHeightMapIsReadBesideIt) {
  write("sheet.obj", obj_text(test::sheet(0.1)));
  write("stripes.pgm", "P2 4 1 1 1 1 0 0\n");
  write("torn.pgm", "P5 4 4 255 ab");
  const std::string mesh = R"("file": "sheet.obj", "unit": "m", "height_map": )";
  const Scene s = scene(mesh + R"({"file": "stripes.pgm", "amplitude": 1e-3, "size": 0.04})");
  TouchMemory memory = s.memory();
  const auto force = [&](double x) {
    s.touch({Vec3(x, 0, 0.01), Vec3::Zero()}, memory);
    return s.touch({Vec3(x, 0, -0.002), Vec3::Zero()}, memory).elastic.z();
  };
  EXPECT_NEAR(force(0.005), 2.0,
              1e-6);  // between two white pixels with centres at 0 and 1 cm
  EXPECT_NEAR(force(0.015), 1.5, 1e-6);
  EXPECT_NEAR(force(0.025), 1.0, 1e-6);
  const auto error = [&](const std::string& map) { return error_of(mesh + map); };
  EXPECT_THAT(error(R"({"file": "stripes.pgm", "size": 1})"),
              HasSubstr("s.json:3: objects[0].mesh.height_map.amplitude: is not given"));
  EXPECT_THAT(error(R"({"file": "stripes.pgm", "amplitude": 1, "size": -1})"),
              HasSubstr("objects[0].mesh.height_map.size: must be above zero"));
  EXPECT_THAT(error(R"({"file": "none.pgm", "amplitude": 1, "size": 1})"),
              AllOf(HasSubstr("objects[0].mesh.height_map.file: "),
                    HasSubstr("none.pgm: cannot be opened")));
  EXPECT_THAT(error(R"({"file": "torn.pgm", "amplitude": 1, "size": 1})"),
              HasSubstr("torn.pgm: byte 13: it ends before its pixels do"));
}

TEST_F(LoadMesh, WhatIsStrangeButCanBeTouchedIsSaid) {
  TriangleSoup soup = test::icosphere(0.05, 3);
  for (Triangle& t : soup.triangles) std::swap(t[0], t[1]);
  soup.triangles.push_back(soup.triangles[0]);
  soup.triangles.push_back({0, 0, 1});
  write("inward.obj", obj_text(soup));
  const Scene s = scene(R"("file": "inward.obj", "unit": "m", "closed": true)");
  EXPECT_THAT(s.warnings(), ElementsAre(HasSubstr("1 triangles have no area"),
                                        HasSubstr("1 triangles stand twice"),
                                        HasSubstr("the surface was turned")));
  TouchMemory memory = s.memory();
  s.touch({Vec3(0, 0, 0.06), Vec3::Zero()}, memory);
  EXPECT_NEAR(s.touch({Vec3(0, 0, 0.048), Vec3::Zero()}, memory).elastic.z(), 2.0, 0.2);

  write("sheet.obj", obj_text(test::sheet(0.1)));
  EXPECT_THAT(scene(R"("file": "sheet.obj", "unit": "m")").warnings(),
              ElementsAre(HasSubstr("the surface has holes")));
  EXPECT_TRUE(
      scene(R"("file": "sheet.obj", "unit": "m", "double_sided": true)").warnings().empty());
}

TEST_F(LoadMesh, AWrongUnitIsSaidWithTheScaleThatHelps) {
  write("part.obj", obj_text(test::icosphere(52.0, 2)));
  const auto said = [&](const std::string& size) {
    return scene(R"("file": "part.obj", )" + size).warnings();
  };
  for (const std::string size : {R"("unit": "m")", R"("scale": 1)"})
    EXPECT_THAT(said(size),
                ElementsAre(AllOf(HasSubstr("part.obj: is 104 m large with a scale of 1"),
                                  HasSubstr("give a scale of"),
                                  HasSubstr("0.001 if its file is in mm (then it is 0.104 m)"))));
  EXPECT_THAT(said(R"("unit": "mm")"), ElementsAre());
  write("tiny.obj", obj_text(test::icosphere(0.00002, 2)));
  EXPECT_THAT(scene(R"("file": "tiny.obj", "unit": "m")").warnings(),
              ElementsAre(HasSubstr("tiny.obj: is 4e-05 m large")));
  // Grids and tools must give the warning too.
  const Scene grid = parse_scene(R"({"name": "s", "materials": [{"name": "m", "stiffness": 1000}],
      "objects": [{"name": "o", "material": "m",
                   "grid": {"file": "part.obj", "scale": 1, "resolution": 2}}],
      "tool": {"body": {"file": "part.obj", "scale": 1, "points": 100}}})",
                                 (folder_ / "s.json").string());
  EXPECT_THAT(grid.warnings(), ElementsAre(HasSubstr("part.obj: is 104 m large"),
                                           HasSubstr("part.obj: is 104 m large")));
}

TEST_F(LoadMesh, ADoubledShellThatMovesIsASolid) {
  const TriangleSoup ball = test::icosphere(0.02, 2);
  TriangleSoup doubled{ball.vertices, {}};
  for (const Triangle& t : ball.triangles) {
    doubled.triangles.push_back({t[0], t[2], t[1]});
    doubled.triangles.push_back(t);
  }
  write("doubled.obj", obj_text(doubled));
  const std::string mesh = R"("file": "doubled.obj", "unit": "m")";
  EXPECT_THAT(scene(mesh).warnings(), ::testing::Contains(HasSubstr("felt from both sides")));
  EXPECT_EQ(error_of(mesh + R"(, "closed": true)"), "no error");
  EXPECT_NO_THROW(parse_scene(R"({"name": "s", "materials": [{"name": "m", "stiffness": 1000}],
      "bodies": [{"name": "b", "mass": 1}],
      "objects": [{"name": "o", "material": "m", "body": "b", "mesh": {)" +
                                  mesh + R"(}}]})",
                              (folder_ / "s.json").string()));
}

TEST_F(LoadMesh, ACornerInTheMiddleOfAnEdgeDoesNotOpenASurface) {
  write("slit.obj",
        "v 0 0 0\nv 20 0 0\nv 20 20 0\nv 0 20 0\nv 0 0 20\nv 20 0 20\nv 20 20 20\nv 0 20 20\n"
        "v 10 0 20\nv 10 20 20\nf 1 4 3 2\nf 5 9 10 8\nf 9 6 7 10\nf 1 2 6 5\nf 2 3 7 6\n"
        "f 3 4 8 7\nf 4 1 5 8\n");
  const std::string mesh = R"("file": "slit.obj", "unit": "mm")";
  EXPECT_EQ(error_of(mesh + R"(, "closed": true)"), "no error");
  EXPECT_THAT(scene(mesh).warnings(), ElementsAre(HasSubstr("were split there")));
  for (const std::string& rest :
       {R"("bodies": [{"name": "b", "mass": 1}], "objects": [{"name": "o", "material": "m",
           "body": "b", "mesh": {)" +
            mesh + "}}]",
        std::string(R"("objects": [{"name": "o", "material": "m",
           "grid": {"file": "slit.obj", "scale": 0.001, "resolution": 0.001}}])")})
    EXPECT_NO_THROW(parse_scene(
        R"({"name": "s", "materials": [{"name": "m", "stiffness": 1000}], )" + rest + "}",
        (folder_ / "s.json").string()))
        << rest;
}

TEST_F(LoadMesh, EndsOfOpenEdgesAreJoinedAsFarApartAsTheSceneSays) {
  // The two halves of a box of 1 m are a tenth of a millimetre apart.
  TriangleSoup soup = test::box(Vec3(0.5, 0.5, 0.5), 2);
  for (std::size_t i = 0; i < soup.vertices.size(); i += 4) {
    const bool upper = (soup.vertices[i] + soup.vertices[i + 2]).x() > 0.0;
    for (std::size_t k = i; upper && k < i + 4; ++k) soup.vertices[k].x() += 1e-4;
  }
  write("box.obj", obj_text(soup));
  const std::string mesh = R"("file": "box.obj", "unit": "m")";
  EXPECT_THAT(scene(mesh).warnings(), ElementsAre(HasSubstr("the surface has holes, 2 holes")));
  EXPECT_THAT(scene(mesh + R"(, "weld": 2e-4)").warnings(),
              ElementsAre(HasSubstr("8 vertices of open edges were joined with one that is at most "
                                    "0.0002 m away; the farthest was 0.0001 m away")));
  EXPECT_NO_THROW(scene(mesh + R"(, "weld": 2e-4, "closed": true)"));
}

TEST_F(LoadMesh, AFileOfManyObjectsIsReadOnce) {
  write("ball.obj", obj_text(test::icosphere(0.05, 2)));
  std::string objects;
  for (int i = 0; i < 20; ++i)
    objects +=
        (i ? ", " : "") + (R"({"name": "o)" + std::to_string(i) +
                           R"(", "material": "m", "mesh": {"file": "ball.obj", "unit": "m"}})");
  const Scene s =
      parse_scene(R"({"name": "s", "materials": [{"name": "m", "stiffness": 1000}], "objects": [)" +
                      objects + "]}",
                  (folder_ / "s.json").string());
  for (const Object& o : s.objects())
    EXPECT_EQ(std::get<Mesh>(o.shape).surface, std::get<Mesh>(s.objects()[0].shape).surface);
}

TEST_F(LoadMesh, AModelHasTheMesh) {
  write("ball.obj", obj_text(test::icosphere(0.05, 3)));
  const Scene s = scene(R"("file": "ball.obj", "unit": "m")");
  const LocalModel near = local_model(s, Vec3(0.08, 0, 0), s.memory());
  EXPECT_EQ(near.count, 1);
  EXPECT_GT(near.reach, 0.04);
  EXPECT_NEAR(local_model(s, Vec3(0.5, 0, 0), s.memory()).reach, kModelReach, 1e-12);
}

TEST(BunnyScene, IsTouchedWhereItsStartSays) {
  const Scene s = load_scene(FELTWIRE_SOURCE_DIR "/scenes/bunny.json");
  TouchMemory memory = s.memory();
  const Vec3 p = s.start().position, n = s.start().normal;
  EXPECT_EQ(s.touch({p + 0.01 * n, Vec3::Zero()}, memory), Command{});
  EXPECT_EQ(s.touch({p + 0.0005 * n, Vec3::Zero()}, memory), Command{});
  // The force is the material's stiffness times the distance to the nearest surface point, for any
  // tree of the mesh.
  const Object& bunny = s.objects()[1];
  const auto to_surface = [&](const Vec3& from) {
    const Vec3 own = bunny.pose.orientation.conjugate() * (from - bunny.pose.position);
    const TriangleMesh& mesh = std::get<Mesh>(bunny.shape).surface->mesh();
    Vec3 shortest = Vec3::Constant(1.0);
    for (std::uint32_t t = 0; t < mesh.triangles().size(); ++t) {
      const Vec3 way =
          mesh.origin() + nearest_on_triangle(mesh.corners(t), own - mesh.origin()).point - own;
      if (way.norm() < shortest.norm()) shortest = way;
    }
    return Vec3(bunny.pose.orientation * shortest);
  };
  const Vec3 inside = p - 0.002 * n;
  const Command c = s.touch({inside, Vec3::Zero()}, memory);
  const Vec3 expected = bunny.material.stiffness * to_surface(inside);
  EXPECT_GT(expected.dot(n), 1.0);
  EXPECT_NEAR(c.elastic.norm(), expected.norm(), 1e-6);
  // "smooth" changes the direction, but not the magnitude.
  EXPECT_LT(test::angle(c.elastic, expected), 0.1);
  // A fingertip touches a radius earlier, on equal triangles.
  const ToolView& finger = *s.view("finger");
  const double radius = finger.tool().radius;
  TouchMemory of_finger = finger.memory();
  EXPECT_EQ(finger.touch({p + (radius + 0.001) * n, Vec3::Zero()}, of_finger), Command{});
  const Command d = finger.touch({p + (radius - 0.002) * n, Vec3::Zero()}, of_finger);
  const Vec3 middle = p + (radius - 0.002) * n, way = to_surface(middle);
  const double depth = radius - way.norm();
  EXPECT_GT(depth, 0.001);
  EXPECT_NEAR(d.elastic.norm(), bunny.material.stiffness * depth, 1e-6);
  EXPECT_LT(test::angle(d.elastic, -way), 0.1);
}

std::vector<Object> crowd(int count) {
  const auto mesh = std::make_shared<MeshSurface>(TriangleMesh(test::icosphere(0.03, 2)));
  test::Random random(4);
  std::vector<Object> objects;
  for (int i = 0; i < count; ++i) {
    Object o;
    o.name = "o" + std::to_string(i);
    o.pose.position =
        Vec3(random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3));
    o.pose.orientation = Quaternion(Eigen::AngleAxisd(random.uniform(0, 3), random.direction()));
    o.material.static_friction = 0.3;
    const std::array<Shape, 5> shapes = {Shape(Mesh{mesh}), Sphere{0.02},
                                         Box{Vec3(0.02, 0.01, 0.03)}, Capsule{0.01, 0.02},
                                         Cylinder{0.02, 0.01}};
    o.shape = shapes[static_cast<std::size_t>(i) % shapes.size()];
    objects.push_back(o);
  }
  objects[3].shape = Plane{};
  objects[3].pose.position = Vec3(0, 0, -0.25);
  objects[5].shape = Box{Vec3(0.32, 0.32, 0.32)};
  objects[5].pose = {};
  objects[5].felt_from = Side::inside;
  return objects;
}

// For many objects, the tree and a loop over all objects must give bitwise equal forces.
TEST(BroadPhase, ACrowdIsFeltAsItIsOneByOne) {
  const Scene scene("crowd", crowd(400));
  for (const double step : {0.002, 0.01}) {
    TouchMemory memory = scene.memory();
    std::vector<ContactMemory> one_by_one(scene.objects().size());
    test::Random random(7);
    Vec3 p(0.31, 0.31, 0.31), v = Vec3::Zero();
    int touched = 0;
    for (int n = 0; n < 4000; ++n) {
      v = 0.95 * v + 0.3 * step * random.direction() - 0.02 * step * p / 0.3;
      p += v;
      const Tool tool{p, Vec3::Zero()};
      const Command found = scene.touch(tool, memory);
      Command sum;
      for (std::size_t i = 0; i < one_by_one.size(); ++i) {
        const Command part = touch(scene.objects()[i], tool, one_by_one[i]);
        sum.elastic += part.elastic;
        sum.frictional += part.frictional;
      }
      ASSERT_EQ(found, sum) << step << " " << n;
      touched += sum.elastic.norm() > 0.0;
    }
    EXPECT_GT(touched, 200);
  }
}

TEST(BroadPhase, TenThousandObjectsLoadAndNoTouchAllocates) {
  const Scene scene("crowd", crowd(10000));
  TouchMemory memory = scene.memory();
  const std::size_t before = test::allocations();
  double felt = 0.0;
  for (int n = 0; n < 2000; ++n)
    felt +=
        scene
            .touch({Vec3(0.3 * std::sin(0.01 * n), 0.3 * std::cos(0.013 * n), 0.0), Vec3::Zero()},
                   memory)
            .elastic.norm();
  EXPECT_GT(felt, 0.0);
  EXPECT_EQ(test::allocations(), before);
}

}  // namespace
}  // namespace feltwire::load_mesh_test
