#include "core/scene_file/load_scene.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <random>

#include "tests/core/scene_text.hpp"
#include "tests/support/seeds.hpp"

namespace feltwire::load_scene_test {
namespace {

using test::error_of;

using ::testing::HasSubstr;
using ::testing::StartsWith;

const std::string kScenes = std::string(FELTWIRE_SOURCE_DIR) + "/scenes/";

// The text is stored by lines, so the tests below can name the line of an error.
const std::vector<std::string> kGood = {
    R"({)",                                                                  // 1
    R"(  "name": "s",)",                                                     // 2
    R"(  "materials": [)",                                                   // 3
    R"(    { "name": "wood", "stiffness": 900, "static_friction": 0.4 },)",  // 4
    R"(    { "name": "ice", "stiffness": 1200 })",                           // 5
    R"(  ],)",                                                               // 6
    R"(  "objects": [)",                                                     // 7
    R"(    { "name": "desk", "plane": {}, "material": "wood" },)",           // 8
    R"(    {)",                                                              // 9
    R"(      "name": "ball",)",                                              // 10
    R"(      "sphere": { "radius": 0.05 },)",                                // 11
    R"(      "position": [0, 0, 0.1],)",                                     // 12
    R"(      "material": "ice")",                                            // 13
    R"(    })",                                                              // 14
    R"(  ])",                                                                // 15
    R"(})",                                                                  // 16
};

std::string text_with(int line, const std::string& changed) {
  std::string text;
  for (int i = 1; i <= static_cast<int>(kGood.size()); ++i)
    text += (i == line ? changed : kGood[i - 1]) + "\n";
  return text;
}

TEST(LoadScene, ReadsEveryField) {
  const Scene scene = parse_scene(R"({
    name: "all", description: "unquoted keys, comments /* too */ and a last comma",
    materials: [{ name: "m", stiffness: 1e3, damping: 1, static_friction: 0.5,
                  dynamic_friction: 0.25, viscous_friction: 2.5, }],  // here
    objects: [
      { name: "1", plane: {}, material: "m" },
      { name: "2", sphere: { radius: 0.5 }, felt_from: "inside", material: "m" },
      { name: "3", box: { size: [2, 4, 6] }, position: [1, 2, 3], material: "m" },
      { name: "4", box: { size: { z: 6, y: 4, x: 2 } }, material: "m" },
      { name: "5", capsule: { radius: 0.5, length: 2 }, orientation: [0, 0, 0, 2], material: "m" },
      { name: "6", cylinder: { radius: 0.5, length: 3 }, material: "m" },
      { name: "7", cone: { radius: 0.5, length: 3 }, material: "m" },
      { name: "8", torus: { major_radius: 0.5, minor_radius: 0.1 }, material: "m" },
    ] })",
                                  "all.json");
  EXPECT_EQ(scene.name(), "all");
  const auto& o = scene.objects();
  ASSERT_EQ(o.size(), 8u);
  EXPECT_TRUE(std::holds_alternative<Plane>(o[0].shape));
  EXPECT_EQ(o[0].felt_from, Side::outside);
  EXPECT_EQ(o[0].pose.position, Vec3::Zero());
  EXPECT_EQ(o[0].pose.orientation.coeffs(), Quaternion::Identity().coeffs());
  EXPECT_EQ(std::get<Sphere>(o[1].shape).radius, 0.5);
  EXPECT_EQ(o[1].felt_from, Side::inside);
  EXPECT_EQ(std::get<Box>(o[2].shape).half_extents, Vec3(1, 2, 3));
  EXPECT_EQ(o[2].pose.position, Vec3(1, 2, 3));
  EXPECT_EQ(std::get<Box>(o[3].shape).half_extents, Vec3(1, 2, 3));
  EXPECT_EQ(std::get<Capsule>(o[4].shape).half_length, 1.0);
  EXPECT_EQ(o[4].pose.orientation.z(), 1.0);  // The loader normalizes the orientation.
  EXPECT_EQ(std::get<Cylinder>(o[5].shape).half_length, 1.5);
  EXPECT_EQ(std::get<Cylinder>(o[5].shape).radius, 0.5);
  EXPECT_EQ(std::get<Cone>(o[6].shape).half_length, 1.5);
  EXPECT_EQ(std::get<Cone>(o[6].shape).radius, 0.5);
  EXPECT_EQ(std::get<Torus>(o[7].shape).major_radius, 0.5);
  EXPECT_EQ(std::get<Torus>(o[7].shape).minor_radius, 0.1);
  const Material& m = o[5].material;
  EXPECT_EQ(m.stiffness, 1000);
  EXPECT_EQ(m.damping, 1);
  EXPECT_EQ(m.static_friction, 0.5);
  EXPECT_EQ(m.dynamic_friction, 0.25);
  EXPECT_EQ(m.viscous_friction, 2.5);
}

TEST(LoadScene, StartIsWhereAHandBegins) {
  const auto with_start = [](const std::string& start) {
    return R"({"name": "s", )" + start + R"(
      "materials": [{"name": "m", "stiffness": 1}],
      "objects": [{"name": "p", "plane": {}, "material": "m"}]})";
  };
  EXPECT_EQ(parse_scene(with_start(""), "s.json").start().position, Vec3::Zero());
  EXPECT_EQ(parse_scene(with_start(""), "s.json").start().normal, Vec3::UnitZ());
  const Start start =
      parse_scene(with_start(R"("start": {"position": [1, 2, 3], "normal": [0, -4, 0]},)"),
                  "s.json")
          .start();
  EXPECT_EQ(start.position, Vec3(1, 2, 3));
  EXPECT_EQ(start.normal, Vec3(0, -1, 0));
  EXPECT_THAT(error_of(with_start("\n\"start\": {\n\"normal\": [0, 0, 0]},")),
              ::testing::StartsWith("s.json:3: start.normal: has no direction"));
  EXPECT_THAT(error_of(with_start("\n\"start\": {\n\"position\": [0, 2e6, 0]},")),
              ::testing::StartsWith("s.json:3: start.position.y: must lie within"));
}

TEST(LoadScene, EveryMistakeIsNamedWithLineAndField) {
  ASSERT_EQ(error_of(text_with(0, "")), "no error");
  struct Mistake {
    int line;             // line to change
    std::string changed;  // new text of the line
    std::string error;    // beginning of the error
  };
  const std::vector<Mistake> mistakes = {
      // Errors in the meaning.
      {11, R"("sphere": { "radius": -1 },)",
       "s.json:11: objects[1].sphere.radius: must be above zero [m], is -1; give a larger"},
      {11, R"("sphere": { "radius": 0 },)", "s.json:11: objects[1].sphere.radius: must be above"},
      {11, R"("sphere": {},)",
       "s.json:11: objects[1].sphere.radius: is not given; give a number above zero [m]"},
      {11, R"("box": { "size": [1, 1, 0] },)", "s.json:11: objects[1].box.size.z: must be above"},
      {11, R"("box": {},)", "s.json:11: objects[1].box.size: is missing; give [x, y, z]"},
      {11, R"("capsule": { "radius": 1 },)", "s.json:11: objects[1].capsule.length: is not given"},
      {11, R"("cylinder": { "length": 1 },)",
       "s.json:11: objects[1].cylinder.radius: is not given"},
      {11, R"("cylinder": { "radius": 1, "length": 0 },)",
       "s.json:11: objects[1].cylinder.length: must be above zero"},
      {11, R"("torus": { "major_radius": 1, "minor_radius": 1.5 },)",
       "s.json:11: objects[1].torus.minor_radius: must be at most 1 [m], is 1.5"},
      {11, "", "s.json:9: objects[1]: has no shape; give exactly one of plane, sphere, box, "},
      {11, R"("sphere": { "radius": 1 }, "plane": {},)",
       "s.json:11: objects[1].sphere: is a second shape beside plane; keep exactly one of"},
      {12, R"("position": [0, 0, 1e7],)", "s.json:12: objects[1].position.z: must lie within"},
      {12, R"("orientation": [0, 0, 0, 0],)", "s.json:12: objects[1].orientation: is no rotation"},
      {13, R"("material": "glass")",
       "s.json:13: objects[1].material: there is no material 'glass'; those of this scene are: "
       "wood, ice"},
      {10, R"("name": "desk",)",
       "s.json:10: objects[1].name: 'desk' is the name of objects[0] too; rename one"},
      {12, "\"position\": [0,\n0,\n1e7],", "s.json:14: objects[1].position.z: must lie within"},
      {13, R"("material": "")", "s.json:13: objects[1].material: must be 1 to 100 bytes long"},
      {10, R"("name": "a\nb",)", "s.json:10: objects[1].name: holds a line break"},
      {10, R"("name": "",)", "s.json:10: objects[1].name: must be 1 to 100 bytes long, is 0"},
      {2, R"("name": "",)", "s.json:2: name: must be 1 to 100 bytes"},
      {5, R"({ "name": "wood", "stiffness": 1200 })",
       "s.json:5: materials[1].name: 'wood' is the name of materials[0] too"},
      {5, R"({ "name": "ice" })",
       "s.json:5: materials[1].stiffness: is not given; give a number above zero"},
      {5, R"({ "name": "ice", "stiffness": 1e12 })",
       "s.json:5: materials[1].stiffness: must be at most 1e+09 [N/m], is 1e+12; check the unit"},
      {5, R"({ "name": "ice", "stiffness": -5 })",
       "s.json:5: materials[1].stiffness: must be above"},
      {5, R"({ "name": "ice", "stiffness": 5, "damping": -1 })",
       "s.json:5: materials[1].damping: must be at least zero [N s/m], is -1; "},
      {5, R"({ "name": "ice", "stiffness": 5, "dynamic_friction": 0.1 })",
       "s.json:5: materials[1].dynamic_friction: must not exceed static_friction = 0, is 0.1; "},
      // Errors against the schema.
      {5, R"({ "name": "ice", "stifness": 5 })",
       "s.json:5: materials[1].'stifness': is no field here; the fields are: name, stiffness, "},
      {10, R"("name": "floor", "plane": { "normal": [0, 0, 1] },)",
       "s.json:10: objects[1].plane.'normal': is no field here; write { } without fields"},
      {5, R"({ "stiffness": 5 })", "s.json:5: materials[1].name: is missing; add it"},
      {5, R"({ "name": "ice", "stiffness": "5" })",
       "s.json:5: materials[1].stiffness: must be a number, is the text '5'; "},
      {5, R"({ "name": "ice", "stiffness": nan })",
       "s.json:5: materials[1].stiffness: must be a number, is 'nan'; "},
      {5, R"({ "name": "ice", "stiffness": null })", "s.json:5: materials[1].stiffness: must be a"},
      {5, R"({ "name": 7, "stiffness": 1 })",
       "s.json:5: materials[1].name: must be a text, is '7'; put it in quotes"},
      {5, R"([ "ice", 1200 ])", "s.json:5: materials[1]: must be an object, is a list of 2; "},
      {10, R"("name": "ball", "felt_from": "within",)",
       "s.json:10: objects[1].felt_from: must be one of: outside, inside; is the text 'within'"},
      {10, R"("name": "ball", "felt_from": 1,)", "s.json:10: objects[1].felt_from: must be one of"},
      {12, R"("position": [0, 0],)",
       "s.json:12: objects[1].position: must have 3 elements, is a list of 2; give [x, y, z]"},
      {12, R"("position": { "x": 1, "y": 2 },)", "s.json:12: objects[1].position.z: is missing"},
      {12, R"("position": [0, "1", 0],)", "s.json:12: objects[1].position.y: must be a number"},
      {13, "", "s.json:9: objects[1].material: is missing; add it"},
      // Errors in the JSON.
      {12, R"("position": [0, 0, 1e999],)",
       "s.json:12: objects[1].position[2]: the number '1e999' is too large or too small"},
      {12, R"("position": [0, 0, 0x10],)",
       "s.json:12: objects[1].position[2]: a number is followed"},
      {12, R"("position": [0, 0, 01],)", "s.json:12: objects[1].position[2]: a number begins with"},
      {12, R"("position": [0, 0, .5],)", "s.json:12: objects[1].position[2]: expected a value"},
      {12, R"("position": [0, 0, rad(180)],)",
       "s.json:12: objects[1].position: expected ',' or ']'"},
      {12, R"("position": [0, 0, 0.1)", "s.json:13: objects[1].position: expected ',' or ']', "},
      {12, R"("position" [0, 0, 0.1],)", "s.json:12: objects[1].position: expected ':' after"},
      {10, R"("name": "ball", "name": "ball",)", "s.json:10: objects[1].name: stands twice here"},
      {10, R"("name": "ball)", "s.json:10: objects[1].name: a text in quotes is not closed"},
      {10, R"("name": "b\q",)", "s.json:10: objects[1].name: a text holds an unknown escape"},
      {10, R"("name": "b\u00",)", "s.json:10: objects[1].name: \\u in a text needs four"},
      {10, "\"name\": \"b\xC3\",", "s.json:10: objects[1].name: a text is not UTF-8"},
      {10, R"("name": "b\uD800",)",
       "s.json:10: objects[1].name: illegal Unicode sequence (unpaired high surrogate); correct"},
      {10, R"("name": "\uD800b",)",
       "s.json:10: objects[1].name: illegal Unicode sequence (unpaired high surrogate); correct"},
      {10, R"("name": "\uD800\u0041",)",
       "s.json:10: objects[1].name: illegal Unicode sequence (unpaired high surrogate); correct"},
      {10, R"("name": "\uD800\uD800",)",
       "s.json:10: objects[1].name: illegal Unicode sequence (multiple high surrogates); correct"},
      {10, R"("name": "b\uDC00",)",
       "s.json:10: objects[1].name: illegal Unicode sequence (unpaired low surrogate); correct"},
      {10, R"(,"name": "ball")", "s.json:10: objects[1]: expected a field name, found ','"},
      {16, "",
       "s.json:17: document: the file ends before the '}' to the bracket of line 1; add it"},
      {16, "} x", "s.json:16: document: text goes on after the document has ended; remove it"},
      {16, "} /* for ever", "s.json:16: document: a comment /* is never closed"},
  };
  for (const Mistake& m : mistakes)
    EXPECT_THAT(error_of(text_with(m.line, m.changed)), StartsWith(m.error)) << m.changed;
}

TEST(LoadScene, DocumentsThatAreNone) {
  EXPECT_EQ(error_of(""), "s.json:1: document: there is nothing in it; write an object { ... }");
  EXPECT_THAT(error_of("\n\n// only a comment\n"),
              StartsWith("s.json:4: document: there is nothing"));
  EXPECT_THAT(error_of("[]"), StartsWith("s.json:1: document: must be an object, is a list of 0"));
  EXPECT_THAT(error_of("{}"), StartsWith("s.json:1: name: is missing"));
  EXPECT_THAT(error_of(R"({"name": "s", "materials": [], "objects": []})"),
              StartsWith("s.json:1: objects: there is none to touch"));
  EXPECT_THAT(error_of(std::string("{\"name\": \"s\",\0 ", 15)),
              HasSubstr("expected a field name"));
  EXPECT_THAT(error_of(std::string(100000, '[')), HasSubstr("nested deeper than 32 levels"));
  EXPECT_THAT(error_of(std::string(40, '[') + std::string(40, ']')), HasSubstr("nested deeper"));
  EXPECT_EQ(error_of("\xEF\xBB\xBF" + text_with(0, "")), "no error");  // byte order mark
}

TEST(LoadScene, FilesThatCannotBeRead) {
  EXPECT_THROW(load_scene(kScenes + "no_such.json"), FileError);
  EXPECT_THROW(load_scene(kScenes), FileError);  // a directory
  EXPECT_THROW(load_scene("/dev/zero"), FileError);
  try {
    load_scene(kScenes + "no_such.json");
  } catch (const FileError& error) {
    EXPECT_EQ(error.what(),
              kScenes +
                  "no_such.json: cannot be opened: No such file or directory; check the path "
                  "and your right to read it");
  }
}

TEST(LoadScene, AllExamplesLoad) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(kScenes)) {
    if (entry.path().extension() != ".json") continue;
    ++count;
    EXPECT_NO_THROW({
      const Scene scene = load_scene(entry.path());
      EXPECT_EQ(scene.name(), entry.path().stem().string());
    }) << entry.path();
  }
  EXPECT_GE(count, 4);
}

TEST(LoadScene, PaperScenesAreThePapers) {
  const Scene wall = load_scene(kScenes + "paper_wall.json");
  TouchMemory memory = wall.memory();
  const Command pressed = wall.touch({Vec3(0.01, -1e-4, 0), Vec3(0.2, 0, 0)}, memory);
  EXPECT_NEAR((pressed.elastic - Vec3(0, 4, 0)).norm(), 0.0, 1e-12);      // 40 kN/m, normal +y
  EXPECT_NEAR((pressed.frictional - Vec3(-2, 0, 0)).norm(), 0.0, 1e-12);  // 10 N s/m along x
  EXPECT_EQ(wall.touch({Vec3(0.01, 1e-4, 0), Vec3(0.2, 0, 0)}, memory).force(), Vec3::Zero());
  EXPECT_FALSE(wall.requirements().friction);
  EXPECT_TRUE(wall.requirements().velocity);

  const Scene sphere = load_scene(kScenes + "paper_sphere.json");
  memory = sphere.memory();
  const Command c = sphere.touch({Vec3(0, 0.089, 0), Vec3(1, 0, 0)}, memory);
  EXPECT_NEAR((c.elastic - Vec3(0, 5, 0)).norm(), 0.0, 1e-12);  // 5 kN/m, 90 mm
  EXPECT_EQ(c.frictional, Vec3::Zero());
}

TEST(LoadScene, TheRoomHoldsTheHandAndItsObjectsDoNotOverlap) {
  const Scene room = load_scene(kScenes + "room.json");
  TouchMemory memory = room.memory();
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {1.0, -1.0}) {
      const Vec3 out = sign * Vec3::Unit(axis);
      EXPECT_GT(-out.dot(room.touch({0.205 * out, Vec3::Zero()}, memory).force()), 4.9);
    }
  std::mt19937 random(5);
  std::uniform_real_distribution<double> along(-0.2, 0.2);
  int touched = 0;
  for (int i = 0; i < 50000; ++i) {
    memory = room.memory();
    room.touch({Vec3(along(random), along(random), along(random)), Vec3::Zero()}, memory);
    int touching = 0;
    for (const ContactMemory& m : memory) touching += m.touching;
    EXPECT_LE(touching, 1);
    touched += touching;
  }
  EXPECT_GT(touched, 300);
}

TEST(LoadScene, RandomBytesNeverCrashAndErrorsPointIntoTheFile) {
  const std::string good = read_text(kScenes + "room.json");
  const long lines = 1 + std::count(good.begin(), good.end(), '\n');
  std::mt19937 random(11);
  const auto pick = [&](std::size_t n) { return random() % n; };
  const std::string alphabet = "{}[]\",:0123456789.eE+-/*\\ntru\n \xC3\xFF";
  int loaded = 0, refused = 0;
  constexpr int kTries = test::rounds(10'000);
  for (int i = 0; i < kTries; ++i) {
    std::string text = good;
    for (std::size_t edits = 1 + pick(4); edits > 0; --edits) {
      const std::size_t at = pick(text.size());
      switch (pick(4)) {
        case 0:
          text[at] = static_cast<char>(random());
          break;
        case 1:
          text[at] = alphabet[pick(alphabet.size())];
          break;
        case 2:
          text.erase(at, 1 + pick(20));
          break;
        default:
          text.insert(at, 1, alphabet[pick(alphabet.size())]);
      }
    }
    if (i % 20 == 0) text.resize(pick(text.size()));
    try {
      parse_scene(text, "room.json");
      ++loaded;
    } catch (const FileError& error) {
      ++refused;
      const std::string what = error.what();
      ASSERT_THAT(what, StartsWith("room.json:"));
      const long line = std::strtol(what.c_str() + 10, nullptr, 10);
      EXPECT_GE(line, 1) << what;
      EXPECT_LE(line, lines + 5) << what;
    }
  }
  EXPECT_GT(loaded, kTries / 100);  // Changes of comments and digits still load.
  EXPECT_GT(refused, kTries / 2);
}

}  // namespace
}  // namespace feltwire::load_scene_test
