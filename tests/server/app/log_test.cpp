// Tests the log and the counters of sessions: names, reasons and durations. Runs the complete
// program.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <regex>
#include <thread>

#include "core/base/pending_file.hpp"
#include "protocol/command_line/suggestion.hpp"
#include "server/app/health.hpp"
#include "server/app/server.hpp"
#include "server/app/summary.hpp"
#include "server/scene/parameter_changes.hpp"
#include "tests/client/temporary_folder.hpp"
#include "tests/protocol/sealed.hpp"
#include "tests/server/make.hpp"
#include "tests/server/raw_socket.hpp"
#include "tests/server/web/page_client.hpp"
#include "tests/support/program.hpp"

namespace feltwire::log_test {
namespace {

using test::ControlClient;
using test::RawSocket;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::TemporaryFolder;

std::vector<Scene> room() {
  std::vector<Scene> scenes;
  scenes.push_back(test::room());
  return scenes;
}

bool becomes(const std::function<bool()>& condition) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(test::kPatience);
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::yield();
  }
  return true;
}

/// Returns the next goodbye at a socket, or nothing if no datagram arrives.
std::optional<GoodbyeReason> goodbye(RawSocket& socket, const SessionKeys& keys) {
  for (;;) {
    const auto bytes = socket.receive();
    if (bytes.empty()) return std::nullopt;
    GoodbyeReason reason;
    if (bytes.size() > 3 && bytes[3] == static_cast<std::uint8_t>(DatagramKind::goodbye) &&
        decode(test::opened(bytes, test::Way::down, keys), reason) == DropReason::none)
      return reason;
  }
}

/// A flooding session must end soon, although the silence timeout is an hour.
TEST(SessionEnds, AFloodIsEndedWhateverTheSilenceTimeout) {
  ServerConfig config = test::any_port();
  config.silence_timeout = 3600.0;
  config.sample_rate_limit = 1.1;
  Server server(config, room(), test::security());
  ControlClient control(server.control_port());
  const auto joined = control.join(test::join_request());
  RawSocket datagrams(SOCK_DGRAM, joined.udp_port);
  test::SealedEncoder encoder(test::Way::up, joined.keys);
  // Each datagram has nine new samples. After a burst of 2200 samples, 2200 samples a second count
  // as a flood.
  constexpr std::uint64_t kEach = 9, kDatagrams = 5000;
  for (std::uint64_t n = 1; n <= kDatagrams; ++n) {
    datagrams.send(
        encoder.samples(joined.accepted.session, n, test::hand_batch(kEach * n, kEach - 1)));
    // Wait before the server's socket overflows.
    if (n % 100 != 0) continue;
    ASSERT_TRUE(becomes([&] { return server.summary()[0].counters.datagrams == n; })) << n;
  }
  EXPECT_EQ(goodbye(datagrams, joined.keys), GoodbyeReason::flooding);
  EXPECT_EQ(server.summary()[0].counters.flooded, 1u);
  const auto counted =
      nlohmann::json::parse(summary_json(server.summary(), server.control_summary()));
  EXPECT_EQ(counted["scenes"][0]["flooded"], 1);
  EXPECT_EQ(counted["scenes"][0]["forged"], 0);
  EXPECT_EQ(counted["scenes"][0]["evicted"], 0);
  EXPECT_EQ(counted["control"]["connections"], 1);
}

/// A client sends three goodbyes, because some may be lost. The server must count no drop.
TEST(SessionEnds, GoodbyesThatComeAgainAreNotDropped) {
  Server server(test::any_port(), room(), test::security());
  ControlClient control(server.control_port());
  const auto joined = control.join(test::join_request());
  RawSocket datagrams(SOCK_DGRAM, joined.udp_port);
  test::SealedEncoder encoder(test::Way::up, joined.keys);
  const std::uint64_t id = joined.accepted.session;
  for (std::uint64_t packet = 1; packet <= 3; ++packet)
    datagrams.send(encoder.goodbye(id, packet, GoodbyeReason::leaving));
  datagrams.send(encoder.goodbye(id ^ 0x100, 4, GoodbyeReason::leaving));  // an unknown session
  datagrams.send(encoder.samples(id, 5, test::hand_batch(1)));             // the ended session
  ASSERT_TRUE(becomes([&] { return server.summary()[0].counters.datagrams == 5; }));
  const SceneCounters counters = server.summary()[0].counters;
  EXPECT_EQ(counters.left, 1u);
  EXPECT_EQ(counters.late_goodbyes, 2u);
  EXPECT_EQ(counters.drops[static_cast<std::size_t>(DropReason::session)], 2u);
}

TEST(Health, LeavesNoTrace) {
  Server server(test::any_port(), room(), test::security());
  for (int i = 0; i < 5; ++i)
    check_health("127.0.0.1", server.control_port(), std::chrono::milliseconds(test::kPatience));
  server.stop();
  const ControlSummary summary = server.control_summary();
  EXPECT_EQ(summary.connections.accepted, 5u);
  EXPECT_EQ(summary.connections.failed, 0u);
  EXPECT_EQ(summary.connections.too_slow, 0u);
  EXPECT_EQ(summary.requests.unauthenticated, 0u);
}

TEST(ParameterChanges, NameFieldAndBothValues) {
  SessionParameters before, after;
  EXPECT_EQ(changes(before, after), "nothing changed");
  after.hold_time = 0.25;
  after.mode = "none";
  after.c1 = 100.0;
  EXPECT_EQ(changes(before, after),
            "mode contact_frame -> none, hold_time 0.1 -> 0.25, c1 usual -> 100");
}

constexpr const char* kScene =
    R"({"name": "room", "materials": [{"name": "wood", "stiffness": 1000}],
    "objects": [{"name": "floor", "plane": {}, "material": "wood"}]})";

TEST(Log, SaysWhoDidWhatAndHowEachSessionEnded) {
  const TemporaryFolder folder;
  const std::string scene = folder / "room.json", tokens = folder / "tokens.json";
  std::ofstream(scene) << kScene;
  const IssuedToken boss = issue_token("boss", "*", Role::admin, std::nullopt);
  const IssuedToken anna = issue_token("anna", "*", Role::operator_, std::nullopt);
  replace_file(tokens, json({boss.token, anna.token}), kPrivate);
  test::Program program(FELTWIRE_SERVER_PROGRAM,
                        {"--scene", scene, "--port", "0", "--state", folder / "state", "--tokens",
                         tokens, "--log-level", "info"});
  program.line();
  unsigned port = 0;
  ASSERT_EQ(std::sscanf(program.line().c_str(), "listening: control tcp %u", &port), 1);
  {
    const auto number = static_cast<std::uint16_t>(port);
    ControlClient admin(number, AF_INET, boss.text), client(number, AF_INET, anna.text);
    control::JoinRequest request = test::join_request();
    request.client = "left hand";
    const std::uint64_t first = client.join(request).accepted.session;
    SessionParameters parameters = request.parameters;
    parameters.velocity_cutoff = 50.0;
    admin.ask<control::ParametersSet>(control::SetParameters{first, parameters});
    admin.ask<control::ParametersSet>(control::SetParameters{first, parameters});
    control::JoinRequest careless = request;
    careless.client = anna.text.text();
    EXPECT_EQ(client.ask<control::Refused>(careless).code, control::RefusalCode::forbidden);
    careless = request;
    careless.scene = anna.text.text();
    EXPECT_EQ(client.ask<control::Refused>(careless).code, control::RefusalCode::unknown_scene);
    control::JoinRequest taker = request;
    taker.client = "right hand";
    taker.takes.laws = LawsTaken::any;
    taker.parameters.side = BoundingSide::client;
    taker.parameters.mode = "contact_frame";
    const std::uint64_t other = client.join(taker).accepted.session;
    taker.parameters.mode = "shaped";
    admin.ask<control::ParametersSet>(control::SetParameters{other, taker.parameters});
    client.ask<control::Left>(control::LeaveRequest{other});
    admin.ask<control::SceneChanged>(
        control::SetMaterial{"room", {.object = "floor", .stiffness = 500.0}});
    admin.ask<control::SceneReloaded>(control::ReloadScene{"room"});
    client.ask<control::Left>(control::LeaveRequest{first});
    const std::uint64_t second = client.join(request).accepted.session;
    admin.ask<control::Evicted>(control::Evict{second});
    client.join(request);
    // After this answer, earlier requests are in the log.
    admin.ask<control::SceneList>(control::ListScenes{});
  }
  program.signal(SIGTERM);
  const test::Outcome outcome = program.finish();
  EXPECT_EQ(outcome.status, 0);
  const std::string who = "left hand \\(test arm, client anna, token " + anna.token.id + "\\)";
  const std::string by = "client boss \\(token " + boss.token.id + "\\)";
  const auto logged = [&](const std::string& line) {
    EXPECT_TRUE(std::regex_search(outcome.error, std::regex(line))) << line << "\n"
                                                                    << outcome.error;
  };
  EXPECT_THAT(outcome.error, Not(HasSubstr(std::string(anna.text.text()))));
  logged("fw_[.]{3} .* could not join scene room: a name in the request is an access token");
  logged("could not join scene fw_[.]{3} there is no scene 'fw_[.]{3}'");
  logged(who + ": parameters set by " + by + ": velocity_cutoff 0 -> 50");
  logged(who + ": " + by + " asks for the parameters that it has");
  logged("right hand .*: its client is asked by " + by + " for another law");
  EXPECT_FALSE(std::regex_search(outcome.error, std::regex("left hand .* for another law")));
  EXPECT_FALSE(std::regex_search(outcome.error, std::regex("right hand .*: parameters set by")));
  logged("scene room: changed by " + by + ": object 'floor': stiffness 1000 -> 500 \\[N/m\\]");
  logged("scene room is reloaded by " + by);
  logged(who + ": ended by client anna");
  logged(who + " left scene room after [0-9.]+ s: a LeaveRequest ended it");
  logged("evicted by client boss");
  logged(who + " left scene room after [0-9.]+ s: it was evicted");
  logged(who + " left scene room after [0-9.]+ s: the server shut down");
}

/// The server must log changes on the live page as on the control port. The log must name the
/// source of each change.
TEST(Log, SaysWhatAnAdminDidOnThePage) {
  const TemporaryFolder folder;
  const std::string scene = folder / "room.json", tokens = folder / "tokens.json";
  std::ofstream(scene) << kScene;
  const IssuedToken boss = issue_token("boss", "*", Role::admin, std::nullopt);
  replace_file(tokens, json({boss.token}), kPrivate);
  test::Program program(FELTWIRE_SERVER_PROGRAM,
                        {"--scene", scene, "--port", "0", "--state", folder / "state", "--tokens",
                         tokens, "--log-level", "info", "--web", "0"});
  program.line();
  unsigned port = 0, web = 0;
  ASSERT_EQ(std::sscanf(program.line().c_str(), "listening: control tcp %u", &port), 1);
  program.line();
  const std::string live = program.line();
  ASSERT_EQ(std::sscanf(live.c_str(), "live page: http://127.0.0.1:%u/", &web), 1) << live;
  struct Site {
    unsigned port;
    std::string web_url() const { return "http://127.0.0.1:" + std::to_string(port) + "/"; }
  };
  std::string session;
  {
    ControlClient client(static_cast<std::uint16_t>(port), AF_INET, boss.text);
    session = std::to_string(client.join(test::join_request()).accepted.session);
    test::Page page(Site{web}, std::string(boss.text.text()));
    nlohmann::json listed;
    while (listed.empty()) {
      const nlohmann::json told = page.text("sessions");
      ASSERT_EQ(told["type"], "sessions");
      listed = told["sessions"];
    }
    page.say({{"set", {{"object", "floor"}, {"stiffness", 250}}}});
    page.text("changed");
    page.say({{"evict", session}});
    page.text("changed");
    page.say({{"reload", true}});
    page.text("log");
  }
  program.signal(SIGTERM);
  const std::string log = program.finish().error;
  const std::string by = "by client boss (token " + boss.token.id + ", live page)";
  EXPECT_THAT(log, HasSubstr("scene room: changed " + by +
                             ": object 'floor': stiffness 1000 -> 250 [N/m]\n"));
  EXPECT_THAT(log, HasSubstr("scene room: session " + session + " was evicted " + by + "\n"));
  EXPECT_THAT(log, HasSubstr("scene room is reloaded " + by + "\n"));
}

/// The printed join line must work in another terminal.
TEST(JoinLine, NamesAProgramThatIsThere) {
  const TemporaryFolder folder;
  const std::string scene = folder / "room.json";
  std::ofstream(scene) << kScene;
  // The installation has the client beside the server, in a folder outside of PATH.
  const auto bin = folder / "my bin";
  std::filesystem::create_directory(bin);
  std::filesystem::copy_file(FELTWIRE_SERVER_PROGRAM, bin / "feltwire-server");
  std::ofstream(bin / "feltwire-client") << "#!/bin/sh\n";
  std::filesystem::permissions(bin / "feltwire-client", std::filesystem::perms::owner_all);
  const auto join_line = [&] {
    test::Program program(bin / "feltwire-server",
                          {"--scene", scene, "--port", "0", "--state", folder / "state"});
    program.line();
    program.line();
    const std::string line = program.line();
    program.signal(SIGTERM);
    program.finish();
    return line;
  };
  const std::string line = join_line();
  EXPECT_THAT(
      line, HasSubstr("join: '" + (canonical(bin) / "feltwire-client").string() + "' --connect "));
  // A shell must accept the line.
  EXPECT_EQ(std::system((line.substr(std::string("join: ").size()) + " >/dev/null").c_str()), 0);

  const std::string path = std::getenv("PATH");
  ::setenv("PATH", (bin.string() + ":" + path).c_str(), 1);
  EXPECT_THAT(join_line(), HasSubstr("join: feltwire-client --connect "));
  ::setenv("PATH", path.c_str(), 1);
}

TEST(Suggestion, IsTheNearestWord) {
  EXPECT_EQ(edit_distance("", "abc"), 3u);
  EXPECT_EQ(edit_distance("abc", "abc"), 0u);
  EXPECT_EQ(edit_distance("abcd", "acbd"), 1u);  // Two letters are swapped.
  EXPECT_EQ(edit_distance("--duraton", "--duration"), 1u);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3u);
  const std::vector<std::string> words = {"--duration", "--device", "--rate"};
  EXPECT_EQ(nearest("--duraton", words), "--duration");
  EXPECT_EQ(nearest("--divice", words), "--device");
  EXPECT_EQ(nearest("--raet", words), "--rate");
  EXPECT_EQ(nearest("--something-else", words), "");
}

TEST(Suggestion, AUnitBehindANumberIsNamed) {
  EXPECT_EQ(unit_advice("Could not convert: --duration = 15ms"),
            "; write the number without unit: 15");
  EXPECT_EQ(unit_advice("Could not convert: --damping = 0.5Ns/m"),
            "; write the number without unit: 0.5");
  EXPECT_EQ(unit_advice("Could not convert: --rate = 1e3Hz"),
            "; write the number without unit: 1e3");
  EXPECT_EQ(unit_advice("Could not convert: --rate = 1kHz", "Hz"),
            "; write the number without unit, in Hz: 1000");
  EXPECT_EQ(unit_advice("Could not convert: --center = [0,0,5mm]", "m"),
            "; write the number without unit, in m: 0.005");
  EXPECT_EQ(unit_advice("Could not convert: --damping = 0.5Ns/m", "N s/m"),
            "; write the number without unit: 0.5");
  EXPECT_EQ(unit_advice("Could not convert: --duration = 2min", "s"),
            "; write the number without unit, in s");
  for (const char* other : {"Could not convert: --rate = fast", "Could not convert: --rate = 1x2",
                            "--rate: Missing", "Could not convert: --rate = 12", ""})
    EXPECT_EQ(unit_advice(other), "") << other;
  const auto said = [](std::vector<std::string> words) {
    return test::Program(FELTWIRE_SERVER_PROGRAM, std::move(words)).finish().error;
  };
  EXPECT_THAT(said({"--silence-timeout", "5s"}), HasSubstr("write the number without unit: 5"));
  EXPECT_THAT(said({"--silence-timeout", "500ms"}), HasSubstr("without unit, in s: 0.5"));
}

TEST(Suggestion, IsMadeByTheServer) {
  const auto said = [](std::vector<std::string> words) {
    return test::Program(FELTWIRE_SERVER_PROGRAM, std::move(words)).finish().error;
  };
  EXPECT_THAT(said({"--scen", "room.json"}), HasSubstr("did you mean --scene?"));
  EXPECT_THAT(said({"--prot=1"}), HasSubstr("did you mean --port?"));
  EXPECT_THAT(said({"--wholly-unknown"}), Not(HasSubstr("did you mean")));
  EXPECT_THAT(said({"token", "ad"}), HasSubstr("did you mean add?"));
  EXPECT_THAT(said({"token", "list", "--stat", "x"}), HasSubstr("did you mean --state?"));
}

}  // namespace
}  // namespace feltwire::log_test
