// Runs hand and arm as separate programs over UDP and emulated links, with a round trip of 0 to 200
// ms, loss and interruptions. The hand is simulated, and then replayed from its recording.

#include <gmock/gmock.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/base/csv.hpp"
#include "core/base/pending_file.hpp"
#include "tests/client/loopback.hpp"
#include "tests/client/temporary_folder.hpp"
#include "tests/support/program.hpp"

namespace feltwire::arm_over_links_test {
namespace {

using nlohmann::json;
using test::Outcome;
using test::Program;
using testing::text_of;

const std::string kTable = FELTWIRE_SOURCE_DIR "/scenes/arm/table.xml";
constexpr double kLate = 50e3;  // [us] A machine that pauses longer gives no result about a link.

/// The emulated links (--link) of the hand and of the robot.
struct Link {
  std::string hand, robot;
};

struct Ended {
  json hand, robot;
  std::vector<std::string> states;  // states between hand and robot, in order
  bool late() const { return hand["servo_wakeup_late_us"]["max"].get<double>() > kLate; }
  bool has(const char* state) const { return std::ranges::find(states, state) != states.end(); }
  /// Returns true if a program paused for a tenth of a second. Such a pause ends the engagement.
  bool disturbed() const { return late() || has("hold") || has("fault"); }
};

/// A server with a scene per link. Each scene has only an arm over a table.
class ArmOverLinks : public ::testing::Test {
 protected:
  void serve(std::size_t scenes) {
    std::vector<Scene> all;
    std::vector<Token> tokens;
    for (std::size_t i = 0; i < scenes; ++i) {
      Scene& scene = all.emplace_back(name(i), testing::floor_scene().objects());
      scene.set_seats({RemoteSeat{}});
      for (const Role role : {Role::operator_, Role::follower}) {
        const IssuedToken issued = issue_token(name(i), name(i), role, std::nullopt);
        replace_file(file(i, std::string(feltwire::name(role))), issued.text.text(), kPrivate);
        tokens.push_back(issued.token);
      }
    }
    server_ =
        std::make_unique<Server>(testing::any_ports(), std::move(all), test::security(tokens));
  }
  static std::string name(std::size_t i) { return "scene" + std::to_string(i); }
  std::filesystem::path file(std::size_t i, const std::string& what) const {
    return folder_ / (name(i) + "." + what);
  }
  std::vector<std::string> words(std::size_t i, Role role, const std::string& link,
                                 const std::string& kept) const {
    return {"--connect",     "127.0.0.1:" + std::to_string(server_->control_port()),
            "--token-file",  file(i, std::string(feltwire::name(role))),
            "--fingerprint", to_string(server_->fingerprint()),
            "--scene",       name(i),
            "--link",        link,
            "--record",      file(i, kept + ".csv"),
            "--report",      file(i, kept + ".json")};
  }
  /// Runs all links at the same time. `hand` has the options of each link's hand.
  std::vector<Ended> run(const std::vector<Link>& links, const std::vector<std::string>& hand) {
    std::vector<std::unique_ptr<Program>> robots, hands;
    for (std::size_t i = 0; i < links.size(); ++i) {
      auto of_robot = words(i, Role::follower, links[i].robot, "robot");
      of_robot.insert(of_robot.end(), {"--arm", kTable, "--at", "0.45,0,0.31"});
      robots.push_back(std::make_unique<Program>(FELTWIRE_FOLLOWER_PROGRAM, of_robot));
    }
    for (const auto& robot : robots)
      EXPECT_THAT(robot->error_until("the robot's seat"), ::testing::HasSubstr("the robot's seat"));
    for (std::size_t i = 0; i < links.size(); ++i) {
      auto of_hand = words(i, Role::operator_, links[i].hand, "hand");
      of_hand.insert(of_hand.end(), hand.begin(), hand.end());
      hands.push_back(std::make_unique<Program>(FELTWIRE_CLIENT_PROGRAM, of_hand));
    }
    std::vector<Ended> ended(links.size());
    for (std::size_t i = 0; i < links.size(); ++i) {
      const Outcome outcome = hands[i]->finish();
      EXPECT_EQ(outcome.status, 0) << outcome.error;
      robots[i]->signal(SIGINT);
      EXPECT_EQ(robots[i]->finish().status, 0);
      ended[i].hand = json::parse(text_of(file(i, "hand.json")));
      ended[i].robot = json::parse(text_of(file(i, "robot.json")));
      for (const json& change : ended[i].hand["robot"]["changes"])
        ended[i].states.push_back(change["state"]);
    }
    return ended;
  }
  /// Repeats the run after a pause of the machine, up to three runs. Returns nothing if the last
  /// run paused too.
  std::vector<Ended> run_in_time(const std::vector<Link>& links,
                                 const std::vector<std::string>& hand) {
    std::vector<Ended> ended = run(links, hand);
    for (int more = 2; more > 0 && !HasFailure(); --more) {
      if (std::ranges::none_of(ended, &Ended::disturbed)) return ended;
      ended = run(links, hand);
    }
    return std::ranges::any_of(ended, &Ended::late) ? std::vector<Ended>{} : ended;
  }

  testing::TemporaryFolder folder_;
  std::unique_ptr<Server> server_;
};

/// Checks the conditions for every link.
void expect_sound(const Ended& ended) {
  EXPECT_GE(ended.hand["least_energy_margin_j"], 0.0) << "the hand was given energy";
  EXPECT_EQ(ended.hand["bound_violations"], 0);
  EXPECT_LE(ended.robot["largest_force_n"], 20.0);
  EXPECT_TRUE(ended.has("engaged"));
}

TEST_F(ArmOverLinks, TheTableIsFeltAndARecordedHandIsCutOff) {
  const std::vector<Link> links = {{"delay=0", "delay=0"},
                                   {"delay=12.5", "delay=12.5"},
                                   {"delay=25,loss=2,seed=1", "delay=25,loss=2,seed=2"},
                                   {"delay=50,loss=2,seed=3", "delay=50,loss=2,seed=4"}};
  serve(links.size());
  const std::vector<Ended> pressed = run_in_time(
      links, {"--device", "simulated:center=0,0,0.3,path=taps,frequency=0.25,depth=0.03",
              "--duration", "7", "--lead", "0.3"});
  if (pressed.empty()) GTEST_SKIP() << "this machine pauses for more than 50 ms again and again";
  for (std::size_t i = 0; i < pressed.size(); ++i) {
    SCOPED_TRACE(links[i].hand);
    expect_sound(pressed[i]);
    EXPECT_GE(pressed[i].hand["max_force_n"], 2.0);
    EXPECT_GE(pressed[i].robot["largest_force_n"], 2.0);
    EXPECT_EQ(pressed[i].robot["engagements"], 1);
    EXPECT_EQ(pressed[i].states.back(), "engaged");
  }

  // The recorded hand of the first link is replayed over a link with interruptions of 0.2 s.
  std::filesystem::rename(file(0, "hand.csv"), folder_ / "recorded.csv");
  const std::vector<Link> cut = {{"delay=25,loss=10,burst=200,seed=5", "delay=25,seed=6"}};
  const Ended ended =
      run(cut, {"--device", "replay:" + (folder_ / "recorded.csv").string(), "--lead", "0.3"})
          .front();
  expect_sound(ended);
  EXPECT_TRUE(ended.has("hold") || ended.has("fault"));
  EXPECT_GE(ended.robot["holds"], 1);
  // The switch is still pressed, so the robot must stay where it stopped. The check uses the last
  // second.
  std::istringstream rows(text_of(file(0, "robot.csv")));
  CsvReader reader(rows, "robot.csv", {"cx", "cy", "cz"}, {});
  std::array<double, 3> row{};
  std::vector<Vec3> targets;
  while (reader.next(row)) targets.emplace_back(row[0], row[1], row[2]);
  ASSERT_GT(targets.size(), 2000u);
  for (std::size_t i = targets.size() - 1000; i < targets.size(); ++i)
    ASSERT_LE((targets[i] - targets.back()).norm(), 1e-6);
}

}  // namespace
}  // namespace feltwire::arm_over_links_test
