// Tests feltwire-client as a program: its output, its files and its exit status.

#include "tests/support/program.hpp"

#include <gmock/gmock.h>

#include <cstdlib>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/base/pending_file.hpp"
#include "protocol/session/grant.hpp"
#include "protocol/session/session_parameters.hpp"
#include "tests/client/loopback.hpp"
#include "tests/client/peer.hpp"
#include "tests/client/temporary_folder.hpp"
#include "tests/server/raw_socket.hpp"
#include "tests/support/eventually.hpp"

namespace feltwire::program_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using testing::kPatience;
using ::testing::Not;
using ::testing::StartsWith;
using testing::text_of;

/// A server with three tokens in a file: of an operator, of an observer and of the tests.
class ClientProgram : public ::testing::Test {
 protected:
  ClientProgram() {
    change_tokens(tokens_, [&](Tokens& tokens) {
      tokens = {test::admin_token().token, anna_.token, eye_.token};
    });
    std::vector<Scene> scenes;
    scenes.push_back(testing::floor_scene());
    scenes.front().set_tools({{.radius = 0.0, .body = nullptr, .name = "tip"},
                              {.radius = 0.01, .body = nullptr, .name = "ball"}});
    server_ = std::make_unique<Server>(testing::any_ports(), std::move(scenes),
                                       Security{test::identity(), {}, TokenFile(tokens_)});
    access_ = test::access(server_->control_port());
  }

  /// Returns the program's command line with a token of its own and these words.
  std::vector<std::string> words(const IssuedToken& token, std::vector<std::string> more) {
    const std::string file = folder_ / "token";
    replace_file(file, token.text.text(), kPrivate);
    more.insert(more.begin(),
                {"--connect", to_string(access_.endpoint), "--scene", "floor", "--token-file", file,
                 "--fingerprint", to_string(server_->fingerprint())});
    return more;
  }
  /// Runs a program with the server's fingerprint and this token in its environment.
  test::Outcome outcome_with_access(const IssuedToken& token, const char* program,
                                    const std::vector<std::string>& words) {
    const std::string file = folder_ / "token", print = folder_ / "fingerprint";
    replace_file(file, token.text.text(), kPrivate);
    std::ofstream(print) << to_string(server_->fingerprint());
    ::setenv("FELTWIRE_FINGERPRINT_FILE", print.c_str(), 1);
    ::setenv("FELTWIRE_TOKEN_FILE", file.c_str(), 1);
    const test::Outcome outcome = test::Program(program, words).finish();
    ::unsetenv("FELTWIRE_FINGERPRINT_FILE");
    ::unsetenv("FELTWIRE_TOKEN_FILE");
    return outcome;
  }
  nlohmann::json report() { return nlohmann::json::parse(text_of(folder_ / "report.json")); }

  testing::TemporaryFolder folder_;
  const std::filesystem::path tokens_ = folder_ / "tokens.json";
  IssuedToken anna_ = issue_token("anna", "*", Role::operator_, std::nullopt),
              eye_ = issue_token("eye", "*", Role::observer, std::nullopt);
  std::unique_ptr<Server> server_;
  ServerAccess access_;
};

/// This machine may pass or fail the check. The exit status must agree with the result.
TEST_F(ClientProgram, ChecksMachineAndNetworkWithAHandThatTouchesNothing) {
  const std::string report_file = folder_ / "report.json";
  const test::Outcome outcome =
      outcome_with_access(anna_, FELTWIRE_CLIENT_PROGRAM,
                          {"--connect", to_string(access_.endpoint), "--check", "--duration", "0.3",
                           "--report", report_file});
  const nlohmann::json said = report();
  EXPECT_EQ(said["scene"], "floor") << "the first there is";
  EXPECT_EQ(said["max_force_n"], 0.0);
  EXPECT_GT(said["no_force"]["samples"]["touches_nothing"], 0);
  std::vector<std::string> names;
  bool fails = false;
  for (const auto& finding : said["check"]) {
    names.push_back(finding["what"]);
    fails = fails || finding["verdict"] == "fail";
    EXPECT_EQ(finding["remedy"] == "", finding["verdict"] == "pass");
    EXPECT_THAT(outcome.out, HasSubstr(finding["figure"].get<std::string>()));
  }
  EXPECT_THAT(names, ::testing::ElementsAre("session", "rate", "late wake-ups", "permissions",
                                            "processors", "clock", "answers", "round trip",
                                            "jitter", "loss", "datagram size"));
  EXPECT_EQ(outcome.status, fails ? 1 : 0) << outcome.out;
}

TEST_F(ClientProgram, AnObserverSaysAndWritesDownWhatItSees) {
  testing::Client hand(access_, "t,x,y,z\n0,0.25,0,0.125\n1000,0.25,0,0.125\n", {}, "floor");
  hand.start();
  hand.next_tick("an answer", [](const TickRecord& row) { return row.age >= 0.0; });
  const std::string seen = folder_ / "seen.csv", report_file = folder_ / "report.json";
  test::Program program(FELTWIRE_CLIENT_PROGRAM,
                        words(eye_, {"--role", "observer", "--duration", "0.3", "--view", seen,
                                     "--report", report_file}));
  const test::Outcome outcome = program.finish();
  hand.stop.set();
  EXPECT_EQ(outcome.status, 0) << outcome.error;
  EXPECT_THAT(outcome.error, HasSubstr("  sees 1 hand, 0 bodies"));
  EXPECT_THAT(text_of(seen), AllOf(StartsWith("t,kind,id,x,y,z,qw,qx,qy,qz,fx,fy,fz\n"),
                                   HasSubstr(",hand,1,0.25,0,0.125,1,0,0,0,0,0,0\n")));
  EXPECT_EQ(report()["role"], "observer");
  EXPECT_EQ(report()["view"]["hands"], 1);
  EXPECT_GT(report()["view"]["views"], 1);
  EXPECT_EQ(report()["max_force_n"], 0.0);
}

/// examples/my_device.cpp is a class and one call.
TEST_F(ClientProgram, ADeviceMakersProgramFeelsTheFloor) {
  ::unsetenv("FELTWIRE_TOKEN_FILE");
  // Nobody holds this device. A busy machine must not end the run after the usual 5 ms without a
  // tick.
  const std::string let_go_after = std::to_string(SessionParameters{}.hold_time);
  const std::vector<std::string> words{to_string(access_.endpoint), "floor", "1", let_go_after};
  const test::Outcome lost = test::Program(FELTWIRE_MY_DEVICE, words).finish();
  EXPECT_EQ(lost.status, 1);
  EXPECT_THAT(lost.error, StartsWith("my_device: no option names the server to trust"));
  const test::Outcome felt = outcome_with_access(anna_, FELTWIRE_MY_DEVICE, words);
  EXPECT_EQ(felt.status, 0) << felt.error;
  double force = 0.0;
  const char* found = std::strstr(felt.out.c_str(), "largest force ");
  ASSERT_NE(found, nullptr) << felt.out;
  ASSERT_EQ(std::sscanf(found, "largest force %lf N", &force), 1);
  EXPECT_GT(force, 0.1);
  EXPECT_THAT(felt.out, HasSubstr("bound violations 0"));
}

/// examples/my_scene_viewer.cpp must show the hand at its position, on the map and in text.
TEST_F(ClientProgram, AViewersProgramSeesTheHand) {
  testing::Client hand(access_, "t,x,y,z\n0,0.1,0.05,0.125\n1000,0.1,0.05,0.125\n", {}, "floor");
  hand.start();
  hand.next_tick("an answer", [](const TickRecord& row) { return row.age >= 0.0; });
  const test::Outcome seen = outcome_with_access(eye_, FELTWIRE_MY_SCENE_VIEWER,
                                                 {to_string(access_.endpoint), "floor", "0.4"});
  hand.stop.set();
  EXPECT_EQ(seen.status, 0) << seen.error;
  EXPECT_THAT(seen.out, HasSubstr(" 1 hands, 0 bodies"));
  // (0.1 / 0.4 + 0.5) * 60 = column 45; (0.5 - 0.05 / 0.4) * 20 = row 7.5.
  const std::string empty(60, '.');
  std::string with = empty;
  with[45] = '1';
  EXPECT_THAT(seen.out, HasSubstr(empty + "\n" + with + "\n" + empty));
  EXPECT_THAT(seen.out, HasSubstr("hand 1: 0.00 N"));
}

TEST_F(ClientProgram, HoldsTheToolThatItAsksFor) {
  const std::string report_file = folder_ / "report.json", way = folder_ / "way.csv";
  std::ofstream(way) << "t,x,y,z\n0,0,0,0.02\n0.1,0,0,0.006\n0.2,0,0,0.006\n";
  const auto run = [&](std::vector<std::string> more) {
    more.insert(more.end(), {"--device", "replay:" + way, "--report", report_file});
    return test::Program(FELTWIRE_CLIENT_PROGRAM, words(anna_, std::move(more))).finish();
  };
  EXPECT_EQ(run({}).status, 0);
  EXPECT_EQ(report()["tool"], "tip");
  EXPECT_EQ(report()["max_force_n"], 0.0);  // The tool is above the floor.
  EXPECT_EQ(run({"--tool", "ball"}).status, 0);
  EXPECT_EQ(report()["tool"], "ball");
  EXPECT_GT(report()["max_force_n"], 0.1);
  const test::Outcome refused = run({"--tool", "key"});
  EXPECT_EQ(refused.status, 1);
  EXPECT_THAT(
      refused.error,
      HasSubstr(
          "refused: there is no tool 'key' in scene 'floor'; the existing ones are: tip, ball"));
}

TEST_F(ClientProgram, AnObserversTokenActsOnNothing) {
  test::Program program(FELTWIRE_CLIENT_PROGRAM, words(eye_, {}));
  const test::Outcome outcome = program.finish();
  EXPECT_EQ(outcome.status, 1);
  EXPECT_THAT(outcome.error, HasSubstr("this token is for an observer"));
}

/// The disk is full when the program writes the report. The program must name the file and the
/// error, and still print the last line of the run.
TEST_F(ClientProgram, AReportThatIsLostIsSaidAndTheRunSummedUp) {
  const test::Outcome outcome =
      test::Program(FELTWIRE_CLIENT_PROGRAM,
                    words(anna_, {"--duration", "0.05", "--report", "/dev/full"}))
          .finish();
  EXPECT_EQ(outcome.status, 1);
  EXPECT_THAT(outcome.error,
              HasSubstr("the report is lost: cannot write /dev/full: No space left"));
  EXPECT_THAT(outcome.out, AllOf(HasSubstr(" samples, "), Not(HasSubstr("report in"))));
}

/// The terminal must not execute control sequences from a server or a file.
TEST_F(ClientProgram, WhatOthersSayIsShownNotObeyed) {
  const std::string evil = "\x1b]0;owned\x07\u009b31m";
  const test::Outcome refused =
      test::Program(FELTWIRE_CLIENT_PROGRAM, words(anna_, {"--tool", evil})).finish();
  EXPECT_EQ(refused.status, 1);
  EXPECT_THAT(refused.error, HasSubstr("no tool '\\x1b]0;owned\\x07\\x9b31m'"));
  EXPECT_EQ(refused.error.find_first_of("\x1b\x07"), std::string::npos);
}

/// The program must not wait for the reconnect time, which is longer than the test.
TEST_F(ClientProgram, ATokenThatIsRevokedEndsItAtOnce) {
  const std::string report_file = folder_ / "report.json";
  test::Program program(FELTWIRE_CLIENT_PROGRAM,
                        words(anna_, {"--reconnect", "10000", "--report", report_file}));
  test::eventually("the session", [&] { return list_scenes(access_, kPatience)[0].sessions > 0; });
  change_tokens(tokens_, [](Tokens& tokens) { tokens = {test::admin_token().token}; });
  const test::Outcome outcome = program.finish();
  EXPECT_EQ(outcome.status, 1);
  EXPECT_THAT(outcome.error, AllOf(HasSubstr("refused: "), HasSubstr("token")));
  EXPECT_EQ(report()["end"], "refused");
  EXPECT_EQ(report()["disconnections"], 1);
}

/// The user did not request a flight record. The file must be in the state folder, and the error
/// and the report must name this file.
TEST_F(ClientProgram, AnEvictedSessionLeavesAFlightRecord) {
  const std::string report_file = folder_ / "report.json";
  ::setenv("XDG_STATE_HOME", (folder_ / "state").c_str(), 1);
  for (const bool off : {false, true}) {
    std::vector<std::string> more = {"--reconnect", "0", "--report", report_file};
    if (off) more.insert(more.end(), {"--flight-recorder", "off"});
    test::Program program(FELTWIRE_CLIENT_PROGRAM, words(anna_, more));
    test::ControlClient admin(server_->control_port());
    std::uint64_t session = 0;
    test::eventually("samples", [&] {
      for (const auto& one :
           admin.ask<control::SessionDescriptions>(control::DescribeSessions{"floor", 0}).sessions)
        if (one.samples > 10) session = one.session;
      return session != 0;
    });
    admin.ask<control::Evicted>(control::Evict{session});
    const test::Outcome outcome = program.finish();
    EXPECT_EQ(outcome.status, 1);
    EXPECT_THAT(outcome.error, HasSubstr("the server ended the session: it was evicted"));
    const std::filesystem::path flights =
        std::filesystem::path(folder_ / "state") / "feltwire/flights";
    if (off) {
      EXPECT_THAT(outcome.error, Not(HasSubstr("flight record")));
      EXPECT_EQ(report()["flight_records"], nlohmann::json::array());
      continue;
    }
    const auto files = test::files_in(flights);
    ASSERT_EQ(files.size(), 1u) << outcome.error;
    EXPECT_THAT(outcome.error, HasSubstr("; flight record: " + files[0].string()));
    ASSERT_EQ(report()["flight_records"].size(), 1u);
    EXPECT_EQ(report()["flight_records"][0]["file"], files[0].string());
    EXPECT_THAT(report()["flight_records"][0]["cause"].get<std::string>(),
                StartsWith("the server ended the session: it was evicted"));
    std::filesystem::remove_all(flights);
  }
  ::unsetenv("XDG_STATE_HOME");
}

// In earlier versions each of these parameters gave a hand 27 J at the device's full force.
TEST_F(ClientProgram, AServerThatTakesTheBoundOffGetsNoHand) {
  SessionParameters none, elsewhere, credited;
  none.mode = "none";
  elsewhere.side = BoundingSide::server;
  credited.operator_damping = 100.0;
  for (const SessionParameters& granted : {none, elsewhere, credited}) {
    control::JoinAccepted offered;
    offered.session = 77;
    offered.port_offset = 1;
    offered.silence_timeout = 2.0;
    offered.parameters = granted;
    testing::ControlPeer liar(control::encode(offered));
    access_ = liar.access();
    test::Program program(FELTWIRE_CLIENT_PROGRAM,
                          words(anna_, {"--duration", "0.3", "--mode", "contact_frame"}));
    const test::Outcome outcome = program.finish();
    EXPECT_EQ(outcome.status, 1);
    EXPECT_THAT(outcome.error, AllOf(HasSubstr("granted other parameters than a server may: "),
                                     HasSubstr(difference({}, granted).value())));
    EXPECT_EQ(outcome.out, "");  // The client made no sample.
  }
}

}  // namespace
}  // namespace feltwire::program_test
