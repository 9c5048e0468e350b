// The cases of the trade study on scenes must be complete, and the compared methods must give equal
// answers.

#include "sim/studies/scene/trade_scene.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>

#include "core/scene/scene_cost_report.hpp"
#include "sim/measure/glide.hpp"

namespace feltwire::trade_scene_test {
namespace {

std::set<std::string> needed_by(const Scene& scene) {
  std::set<std::string> found;
  for (const FeatureCost& need : feature_costs(scene))
    if (!need.needed.empty()) found.insert(need.what);
  return found;
}

TEST(TradeScene, EveryCaseNeedsWhatItSaysAndEveryNeedHasACase) {
  std::set<std::string> measured = {"contact"};
  for (const SceneCase& c : scene_cases()) {
    std::set<std::string> said(c.needs.begin(), c.needs.end());
    measured.insert(said.begin(), said.end());
    said.insert("contact");
    EXPECT_EQ(needed_by(c.make()), said) << c.what;
  }
  std::set<std::string> all;
  for (const FeatureCost& need : feature_costs(scene_cases().front().make())) all.insert(need.what);
  EXPECT_EQ(measured, all);
}

TEST(TradeScene, TheBareAnswerHasTheSameBits) {
  const Scene scene = scene_cases().front().make();
  TouchMemory contacts = scene.memory();
  std::vector<ContactMemory> bare(scene.objects().size());
  std::size_t felt = 0;
  for (const double radius : {kGlideBall - kGlideDepth, 0.3, kGlideBall, 0.22}) {
    for (const Vec3& position : glide(radius)) {
      const Tool tool{position, Vec3::UnitX()};
      const Command command = scene.touch(tool, contacts);
      ASSERT_EQ(bare_touch(scene.objects(), tool, bare), command) << position.transpose();
      felt += command.elastic.isZero(0.0) ? 0 : 1;
    }
  }
  EXPECT_GT(felt, glide().size());
}

TEST(TradeScene, IsWrittenWithARowACase) {
  // The test uses few and small cases. The measured times depend on the machine, so the test does
  // not check them.
  auto cases = scene_cases();
  std::erase_if(cases, [](const SceneCase& c) {
    return c.what.find("327680") != std::string::npos ||
           c.what.find("10000") != std::string::npos || c.what == "1000 bodies" ||
           c.what.find("grid") != std::string::npos;
  });
  const auto cells = run_trade_scene(cases, 1);
  ASSERT_EQ(cells.size(), cases.size());
  EXPECT_EQ(cells.front().ratio, 1.0);
  for (const SceneCell& c : cells) {
    EXPECT_GT(c.sample_ns, 0.0) << c.what;
    EXPECT_GT(c.p99_ns, 0.0) << c.what;
    EXPECT_EQ(c.tick_ns > 0.0, c.what.find("bod") != std::string::npos) << c.what;
#ifndef FELTWIRE_SANITIZED  // Sanitizers use their own heap.
    EXPECT_GT(c.session_bytes, 1000.0) << c.what;
#endif
  }
  const auto directory = std::filesystem::path(::testing::TempDir()) / "feltwire_trade_scene";
  write_trade_scene(directory, cells, run_bare(1));
  std::ifstream csv(directory / "trade_scene.csv");
  std::size_t lines = 0;
  for (std::string line; std::getline(csv, line);) ++lines;
  EXPECT_EQ(lines, 1 + cases.size());
  EXPECT_TRUE(std::filesystem::exists(directory / "trade_scene.png"));
  std::filesystem::remove_all(directory);
}

}  // namespace
}  // namespace feltwire::trade_scene_test
