// Tests the claims of docs/lab/frontier.md about the account and shaping, on the decisive cases.

#include "sim/studies/bound/frontier.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "sim/studies/bound/over_hands.hpp"
#include "tests/support/temporary_folder.hpp"

namespace feltwire::frontier_test {
namespace {

std::vector<FrontierRow> over_all_hands(FrontierCase c) {
  std::vector<FrontierCase> cases;
  for (const NamedHand& hand : kEightHands) {
    c.hand = hand;
    cases.push_back(c);
  }
  return run_frontier(cases);
}
FrontierRow row(const FrontierCase& c) { return run_frontier({c}).front(); }

/// Returns the median over hands of the displayed share. For a hand that oscillates the share is
/// zero.
double median_share(const std::vector<FrontierRow>& rows) {
  return over_hands(rows, [](const FrontierCase&) { return true; }).median;
}

FrontierCase near(const char* task, double damping) {
  return {.task = task, .law = "midpoint", .need = Need::inertia_friction, .damping = damping};
}

TEST(Frontier, AFirstPressOnACableDrivenDeviceIsFeltInFullByEveryHand) {
  for (const double damping : {0.005, 0.05, 0.5}) {
    FrontierCase c = near("press", damping);
    c.device = kFrontierDevices[1];
    c.wall = 5e3;
    for (const FrontierRow& r : over_all_hands(c)) {
      EXPECT_GT(r.displayed, 0.95) << damping << ' ' << r.made.hand.name;
      EXPECT_LT(r.oscillation, kCalm) << damping << ' ' << r.made.hand.name;
      EXPECT_EQ(r.energy_made, 0.0) << damping << ' ' << r.made.hand.name;
    }
    c.law = "contact_frame";
    c.need = Need::no_account;
    EXPECT_NEAR(row(c).displayed * c.wall, 2.0 * damping / 1e-3, 0.05 * 2.0 * damping / 1e-3);
  }
}

TEST(Frontier, ThePapersWallIsFeltAfterTwoSecondsInTheAir) {
  for (const double damping : {0.5, 2.0, 8.0}) {
    FrontierCase c = near("wall", damping);
    c.cold = false;
    const FrontierRow usual = row(c);
    EXPECT_GT(usual.displayed, 0.95) << damping;
    EXPECT_LT(usual.oscillation, kCalm) << damping;
    c.hand = kEightHands[7];
    ASSERT_EQ(c.hand.name, "undamped");
    EXPECT_LT(row(c).oscillation, kCalm) << damping;
  }
}

TEST(Frontier, LateForcesShowTwiceWhatTheContactFrameShows) {
  for (const auto& [delay, times] : {std::pair{0.0, 2.5}, {5e-3, 2.5}, {20e-3, 2.0}}) {
    FrontierCase c{.task = "press", .law = "credited", .need = Need::inertia_friction};
    c.delay = delay;
    const FrontierRow credited = row(c);
    c.law = "contact_frame";
    c.need = Need::no_account;
    EXPECT_GT(credited.displayed, times * row(c).displayed) << delay;
    EXPECT_LT(credited.oscillation, kCalm) << delay;
  }
}

TEST(Frontier, NothingBehindAnAccountMakesEnergy) {
  // A step by a prime number visits all methods, hands, walls and delays.
  const auto all = frontier_cases();
  std::vector<FrontierCase> some;
  for (std::size_t i = 0; i < all.size(); i += 211)
    if (all[i].need != Need::no_account && all[i].task != "tremor") some.push_back(all[i]);
  ASSERT_GT(some.size(), 50u);
  double displayed = 0.0;
  for (const FrontierRow& r : run_frontier(some)) {
    EXPECT_EQ(r.energy_made, 0.0) << r.made.task << ' ' << r.made.law << ' ' << r.made.hand.name;
    EXPECT_EQ(r.excess, 0u);
    displayed += r.displayed;
  }
  EXPECT_GT(displayed, 5.0) << "an account that renders nothing proves nothing";
}

TEST(Frontier, WithoutTheAccountThatIsNotSo) {
  FrontierCase c{.task = "press", .law = "none", .damping = 0.05};
  EXPECT_GT(row(c).energy_made, 1e-3);
  c.law = "credited";
  c.hand = kEightHands[3];
  ASSERT_EQ(c.hand.name, "tether");
  EXPECT_GT(row(c).energy_made, 1e-6) << "shaping alone is no bound";
}

TEST(Frontier, ThePapersOfOthersCalmASoftWallWhereNoBoundDoesNot) {
  FrontierCase c{.task = "wall", .damping = 0.05};
  c.wall = 5e3;
  const auto calm = [&](const char* name) {
    c.law = name;
    const auto rows = over_all_hands(c);
    return std::count_if(rows.begin(), rows.end(),
                         [](const FrontierRow& r) { return r.oscillation < kCalm; });
  };
  EXPECT_EQ(calm("none"), 4);
  EXPECT_EQ(calm("tdpc_exact"), 8);
  EXPECT_EQ(calm("position_memory"), 8);
}

TEST(Frontier, TheVirtualCouplingShowsTwoDampingsOverThePeriod) {
  FrontierCase c{.task = "wall", .law = "virtual_coupling"};
  EXPECT_NEAR(row(c).displayed * c.wall, 2.0 * c.damping / 1e-3, 50.0);
}

TEST(Frontier, TheTableOfPapersNamesEveryLawAtEveryPlace) {
  std::vector<FrontierCase> some;
  for (const FrontierCase& c : published_cases())
    if (c.hand.name == kEightHands[0].name && c.damping == 0.5) some.push_back(c);
  const std::string table = published_table(run_frontier(some));
  for (const char* name :
       {"tdpc_exact", "bounded_output", "force_augmentation", "with its transient",
        "position_memory", "two_layer_tank", "virtual_coupling"}) {
    int lines = 0;
    for (auto at = table.find(name); at != std::string::npos; at = table.find(name, at + 1))
      ++lines;
    EXPECT_EQ(lines, 8) << name;
  }
}

TEST(Frontier, LearningTheHandsForceHelpsTapsOfAHardlyDampedDevice) {
  std::vector<FrontierCase> taps;
  for (const FrontierCase& c : learning_cases())
    if (c.task == "tap" && c.damping == 0.005 && c.wall == 5e3) taps.push_back(c);
  const auto rows = run_frontier(taps);
  const auto worst = [&](bool learns) {
    return over_hands(rows,
                      [&](const FrontierCase& c) {
                        return c.learns == learns && c.hand_force == kHandForce;
                      })
        .worst;
  };
  EXPECT_GT(worst(true), 1.3 * worst(false));
  for (const FrontierRow& row : rows) EXPECT_EQ(row.excess, 0u) << row.made.hand.name;
  EXPECT_NE(learning_table(rows).find("learns"), std::string::npos);
}

TEST(Frontier, WritesEveryRowWithItsKeysAndThePictures) {
  const test::TemporaryFolder temporary;
  const auto directory = temporary / "out";
  std::vector<FrontierCase> cases;
  for (const char* law : {"contact_frame", "midpoint"})
    for (const bool cold : {true, false})
      cases.push_back({.task = "press",
                       .law = law,
                       .need = law[0] == 'm' ? Need::inertia_friction : Need::no_account,
                       .cold = cold});
  const auto rows = write_frontier(directory, cases);
  const auto again = run_frontier(cases);
  std::ifstream file(directory / "frontier.json");
  const auto json = nlohmann::json::parse(file);
  ASSERT_EQ(json.size(), cases.size());
  for (std::size_t i = 0; i < json.size(); ++i) {
    for (const char* key :
         {"task", "law", "b", "mass", "wall", "delay_ms", "hand", "need", "cold", "oscillation_um",
          "displayed_share", "direction_error_deg", "energy_made_j", "excess_count", "cost_ns"})
      EXPECT_TRUE(json[i].contains(key)) << key;
    EXPECT_EQ(json[i]["displayed_share"], rows[i].displayed);
    EXPECT_EQ(again[i].displayed, rows[i].displayed) << "the same each time";
  }
  for (const char* picture : {"frontier_warm.png", "frontier_cold.png", "frontier_late.png"})
    EXPECT_GT(std::filesystem::file_size(directory / picture), 5000u) << picture;
  EXPECT_NE(frontier_table(rows).find("round trip 5 ms"), std::string::npos);
}

// Tests of the goals of docs/lab/frontier.md for each hand.

TEST(FrontierHands, MostHandsFeelThePapersWall) {
  for (const double damping : {0.5, 2.0, 8.0}) {
    FrontierCase c{.law = "midpoint", .need = Need::inertia_friction, .damping = damping};
    c.cold = false;
    const std::vector<FrontierRow> rows = over_all_hands(c);
    EXPECT_GT(median_share(rows), 0.9) << damping;
    for (const FrontierRow& r : rows) {
      EXPECT_EQ(r.energy_made, 0.0) << r.made.hand.name;
      EXPECT_LT(r.oscillation, 1.2 * kCalm) << r.made.hand.name << ' ' << damping;
      EXPECT_GT(r.displayed, 0.35) << r.made.hand.name << ' ' << damping;
    }
    c.law = "contact_frame";
    EXPECT_LT(median_share(over_all_hands(c)), 0.9) << "the goal says nothing if this law meets it";
  }
}

TEST(FrontierHands, NoHandFeelsLessOfALatePressThanWithTheContactFrame) {
  for (const double delay : {0.0, 5e-3, 20e-3, 50e-3}) {
    FrontierCase c{.task = "press", .law = "credited", .need = Need::inertia_friction};
    c.delay = delay;
    const std::vector<FrontierRow> ours = over_all_hands(c);
    c.law = "contact_frame";
    c.need = Need::no_account;
    const std::vector<FrontierRow> theirs = over_all_hands(c);
    for (std::size_t i = 0; i < ours.size(); ++i)
      EXPECT_GT(ours[i].displayed, 0.95 * theirs[i].displayed)
          << delay << ' ' << ours[i].made.hand.name;
  }
}

TEST(FrontierHands, ALateCornerIsFelt) {
  FrontierCase c{
      .task = "corner", .law = "credited", .need = Need::inertia_friction, .damping = 2.0};
  c.delay = 5e-3;
  const FrontierRow ours = row(c);
  EXPECT_GT(ours.displayed, 0.65);
  EXPECT_LT(ours.oscillation, kCalm);
  EXPECT_EQ(ours.energy_made, 0.0);
}

TEST(FrontierHands, TapsOnAStiffWallAreFelt) {
  FrontierCase c{.task = "tap", .law = "midpoint", .need = Need::inertia_friction};
  EXPECT_GT(row(c).displayed * c.wall, 20e3);
  c.law = "contact_frame";
  c.need = Need::no_account;
  EXPECT_LT(row(c).displayed * c.wall, 5e3);
}

TEST(FrontierHands, ATremorDoesNotDrainAPressForHalfAMinute) {
  for (const double damping : {0.5, 2.0, 8.0}) {
    FrontierCase c{
        .task = "tremor", .law = "midpoint", .need = Need::inertia_friction, .damping = damping};
    c.cold = false;
    const FrontierRow r = row(c);
    EXPECT_GT(r.displayed, 0.9) << damping;
    EXPECT_EQ(r.energy_made, 0.0) << damping;
  }
}

TEST(FrontierHands, MassAloneCarriesAFirstPress) {
  FrontierCase c{
      .task = "press", .law = "midpoint", .need = Need::inertia, .device = kFrontierDevices[1]};
  c.damping = 0.5;
  c.wall = 5e3;
  EXPECT_GT(row(c).displayed, 0.9);
  c.damping = 0.005;
  c.wall = 1e3;
  EXPECT_GT(row(c).displayed, 0.99);
}

/// If the client has the surfaces, a slow network must give the result of a run without a network.
TEST(FrontierSessions, AreFeltOverSlowNetworksAsInProcess) {
  std::vector<FrontierCase> cases;
  for (FrontierCase c : session_cases())
    if (c.hand.name == kEightHands[0].name) cases.push_back(c);
  ASSERT_EQ(cases.size(), 12u);
  double in_process = 0.0;
  for (const FrontierRow& r : run_frontier(cases)) {
    EXPECT_EQ(r.energy_made, 0.0) << r.made.task << ' ' << r.made.delay;
    EXPECT_EQ(r.excess, 0u) << r.made.task << ' ' << r.made.delay;
    if (r.made.delay == 0.0) in_process = r.displayed;
    EXPECT_GT(r.displayed, 0.9) << r.made.task << ' ' << r.made.delay;
    EXPECT_NEAR(r.displayed, in_process, 0.05 * in_process) << r.made.task << ' ' << r.made.delay;
  }
}

}  // namespace
}  // namespace feltwire::frontier_test
