// Tests feltwire-client admin as a program.

#include <gmock/gmock.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "core/base/pending_file.hpp"
#include "core/recording/mcap_reader.hpp"
#include "tests/client/loopback.hpp"
#include "tests/client/temporary_folder.hpp"
#include "tests/support/program.hpp"

namespace feltwire::admin_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

class AdminProgram : public ::testing::Test {
 protected:
  AdminProgram() {
    std::vector<Scene> scenes;
    scenes.push_back(testing::floor_scene());
    ServerConfig config = testing::any_ports();
    config.recording.flight_folder = folder_ / "flights";
    config.recording.folder = folder_ / "recordings";
    server_ = std::make_unique<Server>(config, std::move(scenes), test::security({anna_.token}));
    access_ = test::access(server_->control_port());
  }
  test::Outcome admin(std::vector<std::string> words, const Secret& token) {
    const std::string file = folder_ / "token";
    replace_file(file, token.text(), kPrivate);
    words.insert(words.begin(), "admin");
    words.insert(words.end(), {"--connect", to_string(access_.endpoint), "--token-file", file,
                               "--fingerprint", to_string(server_->fingerprint())});
    return test::Program(FELTWIRE_CLIENT_PROGRAM, words).finish();
  }
  test::Outcome admin(const std::vector<std::string>& words) {
    return admin(words, test::admin_token().text);
  }

  testing::TemporaryFolder folder_;
  IssuedToken anna_ = issue_token("anna", "*", Role::operator_, std::nullopt);
  std::unique_ptr<Server> server_;
  ServerAccess access_;
};

TEST_F(AdminProgram, ListsChangesAndEvictsAHand) {
  testing::Client hand(access_, "t,x,y,z\n0,0.25,0,0.125\n1000,0.25,0,0.125\n", {}, "floor");
  hand.start();
  hand.next_tick("an answer", [](const TickRecord& row) { return row.age >= 0.0; });

  const test::Outcome listed = admin({"sessions", "--json"});
  EXPECT_EQ(listed.status, 0) << listed.error;
  const nlohmann::json sessions = nlohmann::json::parse(listed.out);
  ASSERT_EQ(sessions.size(), 1u);
  EXPECT_EQ(sessions[0]["scene"], "floor");
  EXPECT_EQ(sessions[0]["number"], 1);
  EXPECT_EQ(sessions[0]["role"], "operator");
  EXPECT_THAT(admin({"sessions"}).out,
              AllOf(StartsWith("scene  number  client"), HasSubstr("contact_frame")));

  const test::Outcome softer = admin({"set", "--object", "floor", "--stiffness", "123.5"});
  EXPECT_EQ(softer.status, 0) << softer.error;
  EXPECT_THAT(softer.out, AllOf(StartsWith("scene floor: object 'floor': stiffness "),
                                HasSubstr("-> 123.5 [N/m]")));
  EXPECT_EQ(sessions[0]["lead_share"], 0.0);
  const test::Outcome lead = admin({"set", "--session", "1", "--lead-share", "0.5"});
  EXPECT_EQ(lead.status, 1);
  EXPECT_THAT(lead.error, HasSubstr("scene 'floor' has no seat for a robot"));
  const test::Outcome both =
      admin({"set", "--session", "1", "--lead-share", "0.5", "--mode", "none"});
  EXPECT_EQ(both.status, 2);
  EXPECT_THAT(both.error, HasSubstr("in a second command"));
  const test::Outcome bound = admin({"set", "--session", "1", "--mode", "none"});
  EXPECT_EQ(bound.status, 1);
  EXPECT_THAT(bound.error, HasSubstr("takes no other law"));

  EXPECT_THAT(admin({"scenes"}).out, AllOf(StartsWith("scene  "), HasSubstr("\nfloor  ")));
  EXPECT_EQ(nlohmann::json::parse(admin({"scenes", "--json"}).out)[0]["clients"], 1);
  const test::Outcome softest = admin({"set", "--object", "floor", "--stiffness", "99", "--json"});
  EXPECT_EQ(nlohmann::json::parse(softest.out),
            nlohmann::json(
                {{"scene", "floor"}, {"change", "object 'floor': stiffness 123.5 -> 99 [N/m]"}}));

  const test::Outcome counted = admin({"stats", "--json"});
  EXPECT_EQ(counted.status, 0) << counted.error;
  const nlohmann::json stats = nlohmann::json::parse(counted.out);
  EXPECT_EQ(stats["scenes"][0]["scene"], "floor");
  EXPECT_EQ(stats["scenes"][0]["sessions_served"], 1);
  EXPECT_GE(stats["control"]["connections"], 5);

  const test::Outcome recorded = admin({"record"});
  EXPECT_EQ(recorded.status, 0) << recorded.error;
  ASSERT_THAT(recorded.out,
              StartsWith("scene floor: flight record: " + (folder_ / "flights").string()));
  EXPECT_TRUE(std::filesystem::exists(recorded.out.substr(
      std::string("scene floor: flight record: ").size(),
      recorded.out.find('\n') - std::string("scene floor: flight record: ").size())));

  EXPECT_EQ(nlohmann::json::parse(admin({"record", "--json"}).out)[0]["scene"], "floor");

  EXPECT_EQ(admin({"recording"}).out, "scene floor: no recording runs\n");
  const test::Outcome begun = admin({"recording", "--start"});
  EXPECT_EQ(begun.status, 0) << begun.error;
  EXPECT_THAT(begun.out, StartsWith("scene floor: records to " +
                                    (folder_ / "recordings/recording-").string()));
  const test::Outcome twice = admin({"recording", "--start"});
  EXPECT_EQ(twice.status, 1);
  EXPECT_THAT(twice.error, HasSubstr("runs already"));
  const auto kept = nlohmann::json::parse(admin({"recording", "--stop", "--json"}).out)[0]["kept"];
  ASSERT_EQ(kept.size(), 1u);
  const std::filesystem::path made = folder_ / "recordings" / kept[0]["name"].get<std::string>();
  EXPECT_EQ(std::filesystem::file_size(made), kept[0]["bytes"]);

  const test::Outcome evicted = admin({"evict", "1"});
  EXPECT_EQ(evicted.status, 0) << evicted.error;
  EXPECT_THAT(evicted.out, HasSubstr("is evicted"));
  hand.stop.set();
}

/// The admin changes the bounding method and the link of a client in another process. The client's
/// report and recording must show the changes.
TEST_F(AdminProgram, ChangesTheLawAndTheLinkOfARunningClient) {
  const std::string token = folder_ / "hand", report = folder_ / "report.json";
  replace_file(token, anna_.text.text(), kPrivate);
  const auto hand = [&](std::vector<std::string> more) {
    std::vector<std::string> words = {"--connect",     to_string(access_.endpoint),
                                      "--token-file",  token,
                                      "--fingerprint", to_string(server_->fingerprint()),
                                      "--scene",       "floor",
                                      "--mode",        "shaped"};
    words.insert(words.end(), more.begin(), more.end());
    return std::make_unique<test::Program>(FELTWIRE_CLIENT_PROGRAM, words);
  };
  const auto session = [&](std::uint32_t number) {
    nlohmann::json found;
    test::eventually("a session that runs", [&] {
      for (const nlohmann::json& one : nlohmann::json::parse(admin({"sessions", "--json"}).out))
        if (one["number"] == number && one["samples"] > 100) found = one;
      return !found.is_null();
    });
    return found;
  };
  const std::string recording = folder_ / "hand.mcap";
  auto client =
      hand({"--link", "delay=0", "--report", report, "--record", recording, "--changes", "any"});
  EXPECT_EQ(session(1)["laws_taken"], "any");
  EXPECT_EQ(session(1)["link_taken"], true);
  const test::Outcome law =
      admin({"set", "--session", "1", "--mode", "contact_frame", "--storage", "elastic"});
  EXPECT_EQ(law.status, 0) << law.error;
  EXPECT_THAT(law.out, HasSubstr("taken the change: mode shaped -> contact_frame"));
  EXPECT_EQ(session(1)["mode"], "contact_frame");
  const test::Outcome link =
      admin({"set", "--session", "1", "--delay", "12.5", "--loss", "25", "--jitter", "1"});
  EXPECT_EQ(link.status, 0) << link.error;
  const test::Outcome below = admin({"set", "--session", "1", "--mode", "per_axis"});
  EXPECT_EQ(below.status, 1);
  EXPECT_THAT(below.error, HasSubstr("bounds forces from below"));
  ::kill(client->process(), SIGTERM);
  const test::Outcome ended = client->finish();
  EXPECT_EQ(ended.status, 0) << ended.error;
  EXPECT_THAT(ended.error,
              HasSubstr("an admin changes this session: mode shaped -> contact_frame"));
  std::ifstream file(report);
  const nlohmann::json said = nlohmann::json::parse(file);
  ASSERT_EQ(said["changes"].size(), 2u);
  EXPECT_GT(said["changes"][1]["time_s"], said["changes"][0]["time_s"]);
  EXPECT_TRUE(said["changes"][0]["refused"].is_null());
  EXPECT_EQ(said["parameters"]["mode"], "contact_frame");
  EXPECT_NEAR(said["link"]["up"]["delay_ms"], 12.5, 1e-5);  // The wire carries a float32.
  EXPECT_DOUBLE_EQ(said["link"]["down"]["loss_percent"], 25.0);
  EXPECT_GT(said["link"]["up"]["lost"], 0);
  std::vector<std::map<std::string, std::string>> noted;
  std::ifstream in(recording, std::ios::binary);
  mcap::Reader reader(in, recording);
  while (reader.next()) continue;
  for (const mcap::Metadata& metadata : reader.metadata())
    if (metadata.name == "change") noted.push_back(metadata.values);
  ASSERT_EQ(noted.size(), 2u);
  EXPECT_THAT(noted[0]["what"], StartsWith("mode shaped -> contact_frame"));
  EXPECT_EQ(noted[0]["answer"], "taken");
  EXPECT_THAT(noted[1]["what"], HasSubstr("12.5"));
  EXPECT_LT(std::stoll(noted[0]["time"]), std::stoll(noted[1]["time"]));

  auto fixed = hand({"--link", "delay=0"});  // The owner of this client allowed no changes.
  EXPECT_EQ(session(2)["laws_taken"], "none");
  EXPECT_THAT(admin({"set", "--session", "2", "--mode", "contact_frame"}).error,
              HasSubstr("takes no other law"));
  EXPECT_THAT(admin({"set", "--session", "2", "--delay", "1"}).error,
              HasSubstr("no emulated link to change"));
}

TEST_F(AdminProgram, SaysWhatIsWrongInOneLine) {
  const auto fails = [&](const test::Outcome& outcome, int status, const char* says) {
    EXPECT_EQ(outcome.status, status) << says;
    EXPECT_THAT(outcome.error, AllOf(StartsWith("feltwire-client admin: "), HasSubstr(says)));
    EXPECT_EQ(std::ranges::count(outcome.error, '\n'), 1) << outcome.error;
  };
  fails(admin({"stats"}, anna_.text), 1, "this is for admins");
  fails(admin({"set", "--object", "floor", "--stiffness", "-1"}), 1,
        "stiffness: must be above zero [N/m], is -1");
  fails(admin({"set", "--object", "flor", "--stiffness", "1"}), 1, "name one of: floor");
  fails(admin({"set", "--gravity", "0,0,-1"}), 1, "nothing moves in scene 'floor'");
  fails(admin({"set"}), 2, "give one of --object, --gravity and --session");
  fails(admin({"set", "--stiffness", "1"}), 2, "--object is required");
  fails(admin({"set", "--object", "floor", "--gravity", "0,0,1"}), 2, "give one of");
  fails(admin({"evict", "7"}), 2, "there is no session 7");
  fails(admin({"reload", "attic"}), 1, "there is no scene 'attic'");
  fails(admin({"record", "--scene", "attic"}), 1, "there is no scene 'attic'");
  fails(admin({"recording", "--start", "--stop"}), 2, "exclude each other");
  fails(admin({"recording", "--stop"}), 1, "no recording of the scene runs");
  fails(admin({"sesions"}), 2, "see --help");
}

}  // namespace
}  // namespace feltwire::admin_test
