#include "core/scene/scene_cost_report.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "core/scene_file/load_scene.hpp"

namespace feltwire::scene_cost_report_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

Scene scene(const std::string& rest) {
  return parse_scene(R"({"name": "s", "materials": [
      {"name": "bare", "stiffness": 100},
      {"name": "rough", "stiffness": 800, "static_friction": 0.3},
      {"name": "thick", "stiffness": 50, "damping": 1}], )" +
                         rest + "}",
                     "s.json");
}

std::vector<std::string> who_needs(const Scene& s, const std::string& what) {
  for (const FeatureCost& need : feature_costs(s))
    if (need.what == what) return need.needed;
  ADD_FAILURE() << what << " is no need";
  return {};
}

TEST(SceneCosts, NameWhoAsksForThem) {
  const Scene s = scene(R"("objects": [
      {"name": "a", "plane": {}, "material": "bare"},
      {"name": "b", "plane": {}, "material": "rough"},
      {"name": "c", "plane": {}, "material": "thick"}],
      "guides": [{"name": "g", "viscosity": {"damping": 2}, "max_force": 1},
                 {"name": "h", "constant": {"force": [1, 0, 0]}, "max_force": 1}])");
  EXPECT_THAT(who_needs(s, "contact"), ElementsAre("a", "b", "c"));
  EXPECT_THAT(who_needs(s, "stick points"), ElementsAre("b"));
  EXPECT_THAT(who_needs(s, "velocity"), ElementsAre("c", "g"));
  EXPECT_THAT(who_needs(s, "guides"), ElementsAre("g", "h"));
}

TEST(SceneCosts, AgreeWithTheSceneThatIsHosted) {
  for (const char* file : {"room", "plane", "paper_wall", "paper_sphere", "guided"}) {
    const Scene s = load_scene(std::string(FELTWIRE_SOURCE_DIR "/scenes/") + file + ".json");
    EXPECT_EQ(!who_needs(s, "stick points").empty(), s.requirements().friction) << file;
    EXPECT_EQ(!who_needs(s, "velocity").empty(), s.requirements().velocity) << file;
    EXPECT_EQ(!who_needs(s, "guides").empty(), s.requirements().guides) << file;
  }
}

TEST(SceneCosts, AreExplained) {
  const Scene s = scene(R"("objects": [{"name": "a", "plane": {}, "material": "rough"}])");
  const std::string text = describe_costs(s);
  EXPECT_THAT(text, HasSubstr("stick points"));
  EXPECT_THAT(text, HasSubstr("nothing is spent on: velocity, guides"));
  EXPECT_THAT(text,
              HasSubstr("800 N/m. A device of 0.4 N s/m and more renders all of it at 1 kHz by its "
                        "damping alone"));
}

TEST(SceneCosts, ManyNamesAreCounted) {
  std::string objects;
  for (int i = 0; i < 9; ++i)
    objects += std::string(i == 0 ? "" : ",") + R"({"name": "o)" + std::to_string(i) +
               R"(", "plane": {}, "material": "bare"})";
  EXPECT_THAT(describe_costs(scene("\"objects\": [" + objects + "]")),
              HasSubstr("o0, o1, o2, o3, o4 and 4 more"));
}

TEST(SceneCosts, SizesAreShown) {
  const std::string text = describe_costs(scene(R"("objects": [
      {"name": "wall", "plane": {}, "material": "bare"},
      {"name": "part", "box": {"size": [104, 0.2, 0.03]}, "position": [0, 5, 0], "material": "bare"},
      {"name": "bead", "sphere": {"radius": 0.004}, "position": [0, 5, 9], "material": "bare"}])"));
  EXPECT_THAT(text, HasSubstr("size of wall: endless\n"));
  EXPECT_THAT(text, HasSubstr("size of part: 104 x 0.2 x 0.03 m\n"));
  EXPECT_THAT(text, HasSubstr("size of bead: 0.008 x 0.008 x 0.008 m\n"));
  EXPECT_THAT(text, Not(HasSubstr("lies inside")));
}

TEST(SceneCosts, AStartInsideAnObjectIsSaid) {
  const auto text = [](const std::string& start) {
    return describe_costs(scene(R"("start": {"position": )" + start + R"(}, "objects": [
        {"name": "box", "box": {"size": [0.1, 0.1, 0.1]}, "material": "bare"},
        {"name": "ball", "sphere": {"radius": 0.05}, "position": [0.3, 0, 0], "material": "bare"}])"));
  };
  EXPECT_THAT(text("[0, 0, 0.04]"), HasSubstr("lies inside box, 0.01 m deep"));
  EXPECT_THAT(text("[0.3, 0, 0.02]"), HasSubstr("lies inside ball, 0.03 m deep"));
  for (const char* outside : {"[0, 0, 0.05]", "[0, 0, 0.06]", "[0.15, 0, 0]", "[0.3, 0.05, 0]"})
    EXPECT_THAT(text(outside), Not(HasSubstr("lies inside"))) << outside;
}

TEST(SceneCosts, NoStartOfAShippedSceneLiesInside) {
  for (const auto& file : std::filesystem::directory_iterator(FELTWIRE_SOURCE_DIR "/scenes")) {
    if (file.path().extension() != ".json" || file.path().filename() == "peg.json") continue;
    const auto inside = start_inside(load_scene(file.path()));
    EXPECT_FALSE(inside) << file.path() << ": " << inside->object << " " << inside->depth;
  }
}

}  // namespace
}  // namespace feltwire::scene_cost_report_test
