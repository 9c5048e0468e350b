#include "core/scene/scene_cost_report.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/scene_file/load_scene.hpp"

namespace feltwire::scene_cost_report_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

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
              HasSubstr("800 N/m, rendered undiminished while pressed by a device of 0.4 N s/m"));
}

TEST(SceneCosts, ManyNamesAreCounted) {
  std::string objects;
  for (int i = 0; i < 9; ++i)
    objects += std::string(i == 0 ? "" : ",") + R"({"name": "o)" + std::to_string(i) +
               R"(", "plane": {}, "material": "bare"})";
  EXPECT_THAT(describe_costs(scene("\"objects\": [" + objects + "]")),
              HasSubstr("o0, o1, o2, o3, o4 and 4 more"));
}

}  // namespace
}  // namespace feltwire::scene_cost_report_test
