// Tests every method over a user's scene and link. Passive methods must make no energy, but other
// methods make energy.

#include "sim/studies/network/methods_over_link.hpp"

#include <gmock/gmock.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

namespace feltwire::methods_over_link_test {
namespace {

using ::testing::HasSubstr;

Scene wall() {
  Object object{.name = "wall", .shape = Plane{}, .pose = {}, .material = {.stiffness = 1000.0}};
  return Scene("wall", {object});
}

OverLinkTask bad_link() {
  return {.hand = press_at_start(wall(), 3.0),
          .link = parse_link("delay=15,loss=2,seed=4"),
          .device = builtin_device("simulated"),
          .duration = 2.0};
}
const std::vector<OverLinkRow>& rows() {
  static const auto all = run_over_link(wall(), bad_link());
  return all;
}
const OverLinkRow& row(std::string_view label) {
  return *std::ranges::find(rows(), label, &OverLinkRow::label);
}

TEST(MethodsOverLink, OnlyWhatIsNotBoundedMakesEnergy) {
  EXPECT_GT(row("none").energy_made, 0.1);  // [J] The hand oscillates.
  EXPECT_GT(row("none").oscillation, 1e-4);
  for (const char* passive : {"per_axis", "per_axis_projected", "contact_frame",
                              "contact_frame + local model", "energy_tank"}) {
    EXPECT_EQ(row(passive).energy_made, 0.0) << passive;
    EXPECT_LT(row(passive).oscillation, 1e-5) << passive;
  }
}

TEST(MethodsOverLink, TheReferenceIsTheSceneItself) {
  EXPECT_EQ(rows().front().label, "reference");
  EXPECT_NEAR(row("reference").felt, 1.0, 0.01);
  EXPECT_LT(row("reference").error, 0.05);  // [N] of 3 N: one sample of delay
  EXPECT_LT(row("contact_frame + local model").error, row("contact_frame").error);
}

TEST(MethodsOverLink, TheSameEveryTime) {
  const auto again = run_over_link(wall(), bad_link());
  ASSERT_EQ(again.size(), rows().size());
  for (std::size_t i = 0; i < again.size(); ++i) {
    EXPECT_EQ(again[i].label, rows()[i].label);
    EXPECT_EQ(again[i].oscillation, rows()[i].oscillation);
    EXPECT_EQ(again[i].error, rows()[i].error);
  }
}

TEST(MethodsOverLink, ThePressIsWhatWasAskedFor) {
  // At rest the arm's spring and the wall's spring are in equilibrium with 3 N each.
  const HandTask task = press_at_start(wall(), 3.0);
  const double stiffness = Hand{}.stiffness;
  EXPECT_NEAR(task.depth * stiffness * 1000.0 / (stiffness + 1000.0), 3.0, 1e-12);
}

TEST(MethodsOverLink, RefusesWhatItCannotRun) {
  OverLinkTask task = bad_link();
  task.rate = 1.0;
  EXPECT_THROW(run_over_link(wall(), task), std::invalid_argument);
  task = bad_link();
  task.duration = 0.0;
  EXPECT_THROW(run_over_link(wall(), task), std::invalid_argument);
}

TEST(MethodsOverLink, TableAndFilesHaveEveryRow) {
  const std::string table = over_link_table(rows());
  for (const OverLinkRow& r : rows()) EXPECT_THAT(table, HasSubstr("\n" + r.label));
  EXPECT_THAT(table, HasSubstr("energy_tank (research)"));
  const auto folder = std::filesystem::path(::testing::TempDir()) /
                      ("feltwire_methods_over_link_" + std::to_string(::getpid()));
  write_over_link(folder, rows());
  const auto json = nlohmann::json::parse(std::ifstream(folder / "methods_over_link.json"));
  ASSERT_EQ(json.size(), rows().size());
  EXPECT_EQ(json[1].at("method"), "none");
  EXPECT_EQ(json[1].at("energy_made_j"), rows()[1].energy_made);
  std::ifstream csv(folder / "methods_over_link.csv");
  const std::ptrdiff_t lines =
      std::count(std::istreambuf_iterator<char>(csv), std::istreambuf_iterator<char>(), '\n');
  EXPECT_EQ(static_cast<std::size_t>(lines), rows().size() + 1);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace feltwire::methods_over_link_test
