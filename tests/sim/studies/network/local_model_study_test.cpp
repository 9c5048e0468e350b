// With a local model a delay must have almost no effect. Tests the criteria of the laboratory's
// table on a quick part of the table.

#include "sim/studies/network/local_model_study.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/text_of.hpp"

namespace feltwire::local_model_test {
namespace {

using test::text_of;

constexpr double kMilli = 1e-3;

const std::vector<LocalModelCell>& cells() {
  static const auto all = run_local_model({.round_trips = {0.0, kUsualRoundTrip}, .rates = {4e3}});
  return all;
}
const LocalModelCell& cell(const char* task, double round_trip, bool modelled, double rate = 1e3) {
  return *std::find_if(cells().begin(), cells().end(), [&](const LocalModelCell& c) {
    return c.task == task && c.round_trip == round_trip && c.modelled == modelled && c.rate == rate;
  });
}

TEST(LocalModelRun, TheForceIsThatOfTheTruePositionWhateverTheDelay) {
  for (const LocalModelCell& c : cells()) EXPECT_EQ(c.violations, 0u) << c.task;
  for (const char* task : {"press", "taps", "ball", "mesh", "ball_mesh", "grid", "friction", "edge",
                           "ball_edge", "corner", "room", "grain", "relief"}) {
    const LocalModelCell& forces = cell(task, kUsualRoundTrip, false);
    const LocalModelCell& model = cell(task, kUsualRoundTrip, true);
    EXPECT_LT(5.0 * model.error, forces.error) << task;
    EXPECT_LT(model.error, 0.05 * model.felt) << task;
    EXPECT_GT(model.from_model, 0.95) << task;
    // The error must not exceed the error of forces without any delay.
    EXPECT_LE(model.error, 1.05 * cell(task, 0.0, false).error) << task;
    EXPECT_LE(cell(task, 0.0, true).error, 1.05 * cell(task, 0.0, false).error) << task;
    EXPECT_EQ(forces.from_model, 0.0);
  }
}

TEST(LocalModelRun, TheWallFeelsAsWithoutDelay) {
  const LocalModelCell& near = cell("press", 0.0, false);
  const LocalModelCell& far = cell("press", kUsualRoundTrip, true);
  EXPECT_NEAR(far.displayed, near.displayed, 0.01 * near.displayed);
  EXPECT_LE(far.onset, near.onset);
  EXPECT_NEAR(far.oscillation, near.oscillation, 2e-6);
  EXPECT_LT(cell("press", kUsualRoundTrip, false).displayed, 0.9 * near.displayed);
  EXPECT_LE(cell("taps", kUsualRoundTrip, true).onset, 2.0 * kMilli);
  EXPECT_GE(cell("taps", kUsualRoundTrip, false).onset, 0.9 * kUsualRoundTrip);
}

TEST(LocalModelRun, FourKilohertzWithTwoHundredDatagramsASecond) {
  const LocalModelCell& forces = cell("ball", kUsualRoundTrip, false, 4e3);
  const LocalModelCell& model = cell("ball", kUsualRoundTrip, true, 4e3);
  EXPECT_NEAR(model.datagrams, kThinRate, 1.0);
  EXPECT_LT(5.0 * model.error, forces.error);
  EXPECT_LT(model.error, 0.05 * model.felt);
  EXPECT_LE(model.error, 1.1 * cell("ball", 0.0, false, 4e3).error);
}

TEST(LocalModelRun, TheSameBytesEveryTime) {
  const auto directory = std::filesystem::path(::testing::TempDir()) / "feltwire_local_model_test";
  const LocalModelGrid grid{.round_trips = {0.0, 2e-3}, .rates = {1e3}};
  for (const char* turn : {"a", "b"}) write_local_model(directory / turn, run_local_model(grid));
  for (const char* file : {"local_model.csv", "local_model.json", "local_model.png"}) {
    const std::string text = text_of(directory / "a" / file);
    EXPECT_GT(text.size(), 500u) << file;
    EXPECT_EQ(text, text_of(directory / "b" / file)) << file;
  }
  std::filesystem::remove_all(directory);
}

}  // namespace
}  // namespace feltwire::local_model_test
